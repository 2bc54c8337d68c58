//! Mistakes in scene files, each with its place.

use super::*;

/// Text, line, column, and words that the message must hold.
#[test]
fn every_error_has_its_line_and_column_and_says_what_is_possible() {
    let table: &[(&str, u64, u64, &[&str])] = &[
        ("[film]\nsiez = [1, 1]", 2, 1, &["unknown key \"siez\" in film", "did you mean \"size\"?"]),
        ("[flim]\n", 1, 2, &["unknown key \"flim\"", "did you mean \"film\"?"]),
        ("[render]\nspp = 0", 2, 7, &["render.spp", "from 1 to 1048576", "not 0"]),
        ("[render]\nspp = 1.5", 2, 7, &["whole number", "not 1.5"]),
        ("[render]\n  max_depth = 65536", 2, 15, &["from 0 to 65535"]),
        ("[render]\nseed = -1", 2, 8, &["not -1"]),
        ("[render]\nseed = 18446744073709551616", 2, 8, &["render.seed"]),
        ("[render]\nroulette = 1", 2, 12, &["true or false"]),
        ("[render]\nsplit = 65", 2, 9, &["from 1 to 64", "not 65"]),
        ("[render]\nsplit = \"two\"", 2, 9, &["from 1 to 64 or \"auto\""]),
        ("[render]\nsampler = \"sobel\"", 2, 11, &["did you mean \"sobol\"?"]),
        ("[render]\nsampler = \"halten\"", 2, 11, &["did you mean \"halton\"?"]),
        ("[render]\nintegrator = { type = \"path\", distance = 1 }", 2, 31, &["unknown key \"distance\""]),
        ("[film]\nsize = [0, 10]", 2, 9, &["film.size.0", "from 1 to"]),
        ("[film]\nsize = [1000000, 1000000]", 2, 8, &["1000000000000 pixels", "limit of 268435456"]),
        ("[film]\nsize = [1, 2, 3]", 2, 8, &["a list of 2 whole numbers", "not a list of 3"]),
        ("[film]\nfilter = \"gaus\"", 2, 10, &["did you mean \"gaussian\"?"]),
        ("[film]\nfilter = { type = \"tent\", sigma = 1 }", 2, 27, &["unknown key \"sigma\" in film.filter"]),
        ("[film]\nfilter = 3", 2, 10, &["a name or a table"]),
        ("[film]\nrule = \"unifrm\"", 2, 8, &["unknown pixel rule", "did you mean \"uniform\""]),
        ("[film]\nrule = { type = \"random\", grid = [2, 2] }", 2, 27, &["unknown key \"grid\""]),
        ("[film]\nrule = { type = \"uniform\", grid = [0, 2] }", 2, 36, &["from 1 to"]),
        ("[film]\nrule = { type = \"uniform\", grid = [3000, 3000] }", 2, 8, &["9000000 points"]),
        (
            "[film]\nrule = { type = \"stratified\", per_cell = 3 }\n[render]\nspp = 16",
            2,
            8,
            &["whole cells of 3", "grid = [M, N]"],
        ),
        (
            "[render]\nintegrator = { type = \"distribution\", directions = [0] }",
            2,
            53,
            &["from 1 to 65536", "[M, N]"],
        ),
        (
            "[render]\nintegrator = { type = \"distribution\", directions = [[8]] }",
            2,
            53,
            &["a list of 2 whole numbers"],
        ),
        (
            "[render]\nintegrator = { type = \"distribution\", rule = \"random\", per_cell = 2 }",
            2,
            56,
            &["unknown key \"per_cell\""],
        ),
        (
            "[render]\nintegrator = { type = \"distribution\", rule = \"random\", directions = [[8, 8]] }",
            2,
            14,
            &["1e9 rays", "end with 1"],
        ),
        (
            "[[light]]\ntype = \"sphere\"\ncenter = [0, 0, 0]\nraduis = 1\nradiance = 1",
            1,
            1,
            &["has no radius", "it has \"raduis\""],
        ),
        ("[[mesh]]\nflie = \"a.obj\"", 1, 1, &["has no file", "it has \"flie\""]),
        ("[film]\nquantity = \"flx\"", 2, 12, &["unknown quantity", "did you mean \"flux\""]),
        ("[film]\nsize = [8, 8]\ncrop = [4, 4, 5, 1]", 3, 8, &["inside the 8x8 picture"]),
        ("[camera]\nfov = 0", 2, 7, &["from 0.001 to 179.9"]),
        ("[camera]\nfov = nan", 2, 7, &["not NaN"]),
        ("[camera]\nheight = 1", 2, 10, &["orthographic"]),
        ("[camera]\nshutter = [1, 0]", 2, 11, &["closes before it opens"]),
        ("[camera]\nmotion = []", 2, 10, &["a list of poses by time"]),
        ("[camera]\nmotion = [{ time = 0 }, { time = 1, scale = 2 }]", 2, 10, &["keep the camera's size"]),
        ("[[mesh]]\nfile = \"a.obj\"\nmotion = [{ translate = [1, 0, 0] }]", 3, 11, &["has no time"]),
        (
            "[[mesh]]\nfile = \"a.obj\"\nmotion = [{ time = 1 }, { time = 1 }]",
            3,
            25,
            &["does not come after 1"],
        ),
        (
            "[[mesh]]\nfile = \"a.obj\"\nmotion = [{ time = 0 }, { time = 1, scale = [1, -1, 1] }]",
            3,
            25,
            &["passes 0 between"],
        ),
        ("[[mesh]]\nfile = \"a.obj\"\ninstances = []", 3, 13, &["would be nowhere"]),
        (
            "[[mesh]]\nfile = \"a.obj\"\ninstances = [{ trnslate = [1, 0, 0] }]",
            3,
            16,
            &["did you mean \"translate\""],
        ),
        (
            "[[groups.tree]]\nfile = \"a.obj\"\n[[mesh]]\ngroup = \"tre\"",
            4,
            9,
            &["unknown group", "\"tree\""],
        ),
        ("[[mesh]]\ngroup = \"tree\"", 2, 9, &["add [[groups.tree]]"]),
        ("[[groups.a]]\ngroup = \"a\"", 2, 9, &["groups do not stand in groups"]),
        (
            "[[groups.a]]\nfile = \"a.obj\"\n[[mesh]]\ngroup = \"a\"\nfile = \"b.obj\"",
            5,
            1,
            &["unknown key \"file\""],
        ),
        ("[camera]\ntype = \"panorama\"\nfov = 40", 3, 7, &["not for the panorama"]),
        ("[camera]\nblades = 2", 2, 10, &["3 to 64 blades"]),
        ("[camera]\nposition = [1, 1, 1]\nlook_at = [1, 1, 1]", 2, 12, &["same point"]),
        ("[camera]\nup = [0, 0, 2]\nposition = [0, 0, 1]\nlook_at = [0, 0, 0]", 2, 6, &["parallel"]),
        ("[camera]\nlook_at = [0, 0, 0]", 2, 11, &["without camera.position"]),
        ("[camera]\nplane = { left = -1, right = 1, top = 1 }", 2, 9, &["no bottom"]),
        ("[camera]\nposition = [1, 2]", 2, 12, &["a list of 3 numbers"]),
        ("[[mesh]]\nfiel = \"a\"", 1, 1, &["no file"]),
        ("[[mesh]]\nfile = \"a\"\ntransform = { scale = 0 }", 3, 23, &["must not be 0"]),
        (
            "[[mesh]]\nfile = \"a\"\ntransform = { rotate = { axis = [0,0,0], angle = 1 } }",
            3,
            33,
            &["no direction"],
        ),
        ("[[mesh]]\nfile = \"a\"\nnormals = \"round\"", 3, 11, &["known: file, flat, smooth"]),
        ("[[mesh]]\nfile = \"a\"\ncrease = 60", 3, 10, &["goes with normals"]),
        ("[materials.x]\ntype = \"difuse\"", 2, 8, &["did you mean \"diffuse\"?"]),
        ("[materials.x]\nreflectance = 1.5", 2, 15, &["from 0 to 1"]),
        ("[materials.x]\nreflectance = [0.5, -0.1, 0]", 2, 21, &["from 0 to 1", "not -0.1"]),
        (
            "[materials.x]\nreflectance = { texture = \"a.png\", filtre = 1 }",
            2,
            36,
            &["filtre", "\"filter\""],
        ),
        ("[materials.x]\nreflectance = { texture = \"a.png\", filter = \"nearst\" }", 2, 45, &["nearest"]),
        ("[materials.x]\nreflectance = { texture = 7 }", 2, 27, &["text"]),
        ("[materials.x]\nnormal_map = { textur = \"a.png\" }", 2, 14, &["textur"]),
        ("[materials.x]\ntwo_sided = { texture = \"a.png\" }", 2, 13, &["takes no texture"]),
        ("[materials.x]\ntype = \"diffuse\"\nior = { texture = \"a.png\" }", 3, 7, &["no key of a diffuse"]),
        ("[materials.x]\nopacity = 1.5", 2, 11, &["0 to 1"]),
        ("[materials.x]\ntype = \"diffuse\"\nexponent = 5", 3, 12, &["no key of a diffuse material"]),
        (
            "[materials.x]\ntype = \"principled\"\nreflectance = 1",
            3,
            15,
            &["no key of a principled material"],
        ),
        ("[materials.x]\ntype = \"conductor\"\neta = 1", 3, 7, &["needs k"]),
        ("[materials.x]\ntype = \"conductor\"\nmetal = \"gould\"", 3, 9, &["did you mean \"gold\"?"]),
        ("[[light]]\ntype = \"spot\"", 1, 1, &["no position"]),
        ("[[light]]\ntype = \"sun-sky\"\nturbidity = 1", 3, 13, &["from 2 to 10"]),
        ("[[light]]\ntype = \"sun-sky\"\nazimuth = 1\ndirection = [0, 1, 0]", 4, 13, &["both place the sun"]),
        ("[[light]]\ntype = \"environment\"\nfile = \"no.exr\"", 3, 8, &["no.exr", "No such file"]),
        ("[[light]]\ntype = \"environment\"\nsky = \"a.hdr\"", 3, 7, &["given by file"]),
        ("[[light]]\ntype = \"environment\"\nrotate = 9", 3, 10, &["goes with file"]),
        ("[[light]]\ntype = \"point\"\nposition = [0, 0, 0]", 1, 1, &["no intensity"]),
        (
            "[[light]]\ntype = \"environment\"\n[[light]]\ntype = \"environment\"",
            3,
            1,
            &["second environment"],
        ),
        ("[[light]]\ntype = \"environment\"\nradiance = -1", 3, 12, &["from 0 to 1e12"]),
        ("# ä\n[film]\n\"ä\" = 1", 3, 1, &["unknown key"]),
        ("[film\nsize = 1", 1, 6, &[]),
        ("[film]\nsize = [1, 1]\nsize = [2, 2]", 3, 1, &["duplicate"]),
    ];
    let mut wrong = Vec::new();
    for (text, line, column, words) in table {
        let e = error(text, &[]);
        let shown = e.to_string();
        assert_eq!((e.blame, e.file.as_deref()), (Blame::Work, Some(Path::new(FILE))), "{text}");
        if (e.line, e.column) != (Some(*line), Some(*column)) || !words.iter().all(|w| shown.contains(w)) {
            wrong.push(format!("{text}\n-> {shown}\nnot at {line}:{column} with {words:?}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n\n"));
}

#[test]
fn errors_from_the_command_line_blame_the_flag() {
    let table: &[(&str, &[&str])] = &[
        ("render.spp=0", &["--set render.spp: ", "from 1 to 1048576", "not 0"]),
        ("render.spp=many", &["not \"many\""]),
        ("render.ssp=4", &["--set render.ssp", "did you mean \"spp\"?"]),
        ("rendr.spp=4", &["did you mean \"render\"?"]),
        ("film.size.0=x", &["film.size.0"]),
        ("film.size.7=3", &["a list of 2", "no \"7\""]),
        ("film.size.x=3", &["no \"x\""]),
        ("render.spp.deep=3", &["has no keys"]),
        ("spp", &["KEY=VALUE"]),
        ("=3", &["KEY=VALUE"]),
        ("a..b=3", &["KEY=VALUE"]),
        ("film.size=[1, 2", &["--set film.size"]),
        ("camera.up=[0,0,1]", &["parallel"]),
        ("camera.position=[0,0,0]", &["same point"]),
    ];
    let text =
        "[film]\nsize = [8, 8]\n[render]\nspp = 4\n[camera]\nposition = [0, 0, 1]\nlook_at = [0, 0, 0]";
    for (change, words) in table {
        let e = error(text, &[change]);
        let shown = e.to_string();
        assert_eq!((e.blame, e.line), (Blame::Usage, None), "{change}: {shown}");
        assert!(words.iter().all(|word| shown.contains(word)), "{change}: {shown}");
        assert!(!shown.contains('\n'));
    }
}
