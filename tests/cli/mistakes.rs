//! Mistakes that people make: each gets one line that names the place (file, line and column, or the flag) and says
//! what to do.

use super::{drt, folder};
use std::fs;

/// A scene that is right; the mistakes are put in for parts of it.
const SCENE: &str = "[camera]\nposition = [0, 0, 4]\nlook_at = [0, 0, 0]\nfov = 40\n\
                     [film]\nsize = [16, 12]\n[render]\nspp = 1\n\
                     [[mesh]]\nfile = \"t.obj\"\nmaterial = \"clay\"\n\
                     [materials.clay]\ntype = \"diffuse\"\nreflectance = [0.5, 0.5, 0.5]\n\
                     [[light]]\ntype = \"environment\"\n";

/// What is right, what somebody writes instead, where the error is, and words of what to do.
const SLIPS: &[(&str, &str, &str, &[&str])] = &[
    ("spp = 1", "ssp = 1", "8:1:", &["unknown key \"ssp\" in render", "did you mean \"spp\"?"]),
    ("[film]", "[Film]", "5:2:", &["did you mean \"film\"?"]),
    ("[materials.clay]", "[material.clay]", "12:2:", &["did you mean \"materials\"?"]),
    ("spp = 1", "spp = \"many\"", "8:7:", &["render.spp", "a whole number from 1 to 1048576"]),
    ("spp = 1", "spp = many", "8:7:", &["\"text\" in quotes"]),
    ("spp = 1", "spp: 1", "8:6:", &["write key = value"]),
    ("spp = 1", "spp 1", "8:5:", &["write key = value"]),
    ("spp = 1", "spp = 1;", "8:7:", &["a value is a number"]),
    ("spp = 1", "// spp\nspp = 1", "8:4:", &["a comment begins with #"]),
    ("spp = 1", "spp = 1\nspp = 2", "9:1:", &["duplicate key", "only once"]),
    ("spp = 1", "spp = 1\nroulette = True", "9:12:", &["true, false"]),
    ("[16, 12]", "\"16x12\"", "6:8:", &["film.size", "a list of 2 whole numbers"]),
    ("[16, 12]", "16", "6:8:", &["film.size", "a list of 2 whole numbers"]),
    ("fov = 40", "fov = 360", "4:7:", &["camera.fov", "from 0.001 to 179.9"]),
    ("fov = 40", "fov = \"40\"", "4:7:", &["camera.fov must be a number"]),
    ("fov = 40", "fov = 40deg", "4:9:", &["no unit"]),
    ("fov = 40", "fov = 40,5", "4:9:", &["no comma"]),
    ("fov = 40", "fov = .5", "4:7:", &["digits on both sides of a point"]),
    ("[0, 0, 4]", "[0, 0, 4.]", "2:", &["digits on both sides of a point"]),
    ("[0, 0, 4]", "[0 0 4]", "2:", &["a list [1, 2, 3]"]),
    ("[0, 0, 4]", "[0, 0, 4", "3:1:", &["commas between its items"]),
    ("[0, 0, 4]", "\"0 0 4\"", "2:12:", &["a list of 3 numbers"]),
    ("[camera]", "[[camera]]", "1:1:", &["write [camera] in single brackets"]),
    ("[film]", "[camera]\nposition = [1, 0, 4]\n[film]", "5:", &["duplicate key", "only once"]),
    ("[[mesh]]", "[mesh]", "9:1:", &["a list of tables, [[mesh]]"]),
    ("[[light]]", "[light]", "15:1:", &["a list of tables, [[light]]"]),
    ("[materials.clay]", "[[materials.clay]]", "12:1:", &["write [materials.clay] in single brackets"]),
    ("\"t.obj\"", "\"tt.obj\"", "10:8:", &["tt.obj", "No such file", "the scene file's folder"]),
    ("\"t.obj\"", "\"/nowhere/t.obj\"", "10:8:", &["/nowhere/t.obj", "No such file"]),
    ("\"t.obj\"", "\".\"", "10:8:", &["is a directory", "name a file"]),
    ("\"t.obj\"", "\"t.fbx\"", "10:8:", &["\".fbx\"", "convert it to one of gltf, glb, ply, stl, obj"]),
    ("\"t.obj\"", "\"s.toml\"", "10:8:", &["\".toml\""]),
    ("\"t.obj\"", "\"\"", "10:8:", &["mesh.0.file is empty"]),
    ("\"t.obj\"", "\"t.obj", "10:14:", &["no closing quote"]),
    ("\"t.obj\"", "t.obj", "10:8:", &["\"text\" in quotes"]),
    ("\"t.obj\"", "\"models\\mesh.obj\"", "10:16:", &["write paths with /"]),
    ("\"clay\"", "\"clya\"", "11:12:", &["unknown material \"clya\"", "did you mean \"clay\"?"]),
    ("[0.5, 0.5, 0.5]", "[0.5, 0.5]", "14:15:", &["a colour [r, g, b]"]),
    ("[0.5, 0.5, 0.5]", "[255, 128, 0]", "14:16:", &["from 0 to 1, not 255"]),
    ("[0.5, 0.5, 0.5]", "\"#ff8000\"", "14:15:", &["a colour [r, g, b]"]),
    ("\"diffuse\"", "\"difuse\"", "13:8:", &["did you mean \"diffuse\"?"]),
    ("\"diffuse\"", "\"diffuse\"\nexponent = 3", "14:12:", &["exponent is no key of a diffuse material"]),
    ("\"diffuse\"", "\"principled\"", "14:15:", &["reflectance is no key of a principled material"]),
    ("\"diffuse\"", "\"conductor\"\nmetal = \"gould\"", "14:9:", &["did you mean \"gold\"?"]),
    ("\"diffuse\"", "\"diffuse\"\nroughness = 2", "14:13:", &["from 0 to 1"]),
    (
        "type = \"diffuse\"\nreflectance = [0.5, 0.5, 0.5]",
        "type = \"mix\"\nmaterials = [\"clay\", \"clay\"]",
        "12:",
        &["materials.clay is mixed of itself"],
    ),
    (
        "type = \"diffuse\"\nreflectance = [0.5, 0.5, 0.5]",
        "type = \"mix\"\nmaterials = [\"bark\", \"moss\"]\n[materials.brak]\ntype = \"mirror\"",
        "12:",
        &["mixes the unknown material \"bark\"", "did you mean \"brak\"?"],
    ),
    (
        "type = \"diffuse\"\nreflectance = [0.5, 0.5, 0.5]",
        "type = \"mix\"\nmaterials = \"bark\"",
        "14:13:",
        &["a list of the names of two materials"],
    ),
    ("\"environment\"", "\"enviroment\"", "16:8:", &["did you mean \"environment\"?"]),
    ("material = ", "transform = { rotate = [0, 90, 0] }\nmaterial = ", "11:24:", &["axis = [0, 1, 0]"]),
    ("material = ", "transform = { scale = [1, 2] }\nmaterial = ", "11:23:", &["a list of 3 numbers"]),
];

#[test]
fn mistakes_in_scene_files_name_line_and_column_and_say_what_to_do() {
    let folder = folder();
    let dir = folder.path();
    let mut wrong = Vec::new();
    for (right, slip, place, words) in SLIPS {
        assert!(SCENE.contains(right), "{right}");
        fs::write(dir.join("s.toml"), SCENE.replacen(right, slip, 1)).unwrap();
        let ended = drt(dir, &["s.toml", "-o", "x.png"]);
        let place = format!("error: s.toml:{place}");
        let one_line = ended.err.lines().count() == 1 && ended.err.starts_with(&place);
        if ended.code != Some(1) || !one_line || !words.iter().all(|word| ended.err.contains(word)) {
            wrong.push(format!("{slip:?}: {:?} {} (not {place} {words:?})", ended.code, ended.err));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// What editors do to a file without being asked, and TOML's other spellings, are no mistakes.
#[test]
fn harmless_spellings_are_read() {
    let folder = folder();
    let dir = folder.path();
    for text in [
        SCENE.to_string(),
        SCENE.replace('\n', "\r\n"),
        SCENE.replace(" = ", "\t=\t"),
        format!("\u{feff}{SCENE}"),
        SCENE.replace('"', "'"),
        SCENE.replace("spp = 1", "spp = \"1\""),
        SCENE.replace("[0, 0, 4]", "[\n 0, # x\n 0,\n 4,\n]"),
    ] {
        fs::write(dir.join("s.toml"), text).unwrap();
        drt(dir, &["s.toml", "-o", "x.png"]).expect(0, &[]);
    }
}

/// Files of other kinds that get the name of a scene.
#[test]
fn other_formats_are_told_from_scenes() {
    let folder = folder();
    let dir = folder.path();
    let wide: Vec<u8> = SCENE.encode_utf16().flat_map(u16::to_le_bytes).collect();
    let kinds: [(&[u8], &str); 5] = [
        (b"{\"film\": {\"size\": [1, 1]}}", "write key = value"),
        (b"<scene version=\"3.0.0\"/>", "write key = value"),
        (b"film:\n  size: [1, 1]\n", "write key = value"),
        (b"v 0 0 0\nv 1 0 0\nf 1 2 3\n", "write key = value"),
        (&wide, ""),
    ];
    for (bytes, word) in kinds {
        fs::write(dir.join("s.toml"), bytes).unwrap();
        drt(dir, &["s.toml", "-o", "x.png"]).expect(1, &["s.toml:1:", word]);
    }
}

#[test]
fn mistakes_on_the_command_line_say_what_to_do() {
    let folder = folder();
    let dir = folder.path();
    let table: &[(&[&str], i32, &[&str])] = &[
        (&["t.obj", "x.png"], 2, &["'x.png'", "-o before the picture's name"]),
        (&["rendr", "t.obj"], 2, &["'t.obj'", "one input at a time"]),
        (&["t.obj", "--set", "render.spp", "4"], 2, &["'4'", "the flags' values right behind them"]),
        (&["t.obj", "--size", "640", "480"], 2, &["'480'", "the flags' values right behind them"]),
        (&["t.obj", "-spp", "4"], 2, &["'-spp'", "did you mean --spp?", "two dashes"]),
        (&["t.obj", "-max-depth=4"], 2, &["did you mean --max-depth?"]),
        (&["t.obj", "-x"], 2, &["'-x'", "drt --help"]),
        (
            &["t.obj", "--aov", "depth", "--strict", "-o", "x.png"],
            2,
            &["film.aov", ".exr", "add -o NAME.exr"],
        ),
        (&["t.obj", "--aov", "depht", "-o", "x.exr"], 2, &["did you mean \"depth\"?"]),
        (&["t.obj", "--view", "tpo"], 2, &["--view", "did you mean \"top\"?"]),
        (&["t.obj", "--set", "spp=4"], 2, &["--set spp", "known:"]),
        (&["t.obj", "--size", "640"], 2, &["--size", "1920x1080"]),
        (&["t.obj", "--size", "640,480"], 2, &["--size", "1920x1080"]),
        (&["t.obj", "--spp", "1k"], 2, &["--spp", "whole number", "\"1k\""]),
        (&["t.obj", "--sampels", "4"], 2, &["'--sampels'", "similar", "drt --help"]),
        (&["t.obj", "--backend", "Embre"], 2, &["--backend", "known:"]),
        (&["t.obj", "--up", "Z"], 2, &["--up", "did you mean \"z\"?"]),
        (&["t.obj", "--view", "side"], 2, &["--view", "known: three-quarter"]),
        (&["t.obj", "--threads", "all"], 2, &["--threads", "from 1 to 1024"]),
        (&["t.obj", "-o", "x.tiff"], 1, &["x.tiff", "known: exr"]),
        (&["t.obj", "-o", "x"], 1, &["x:", "no extension"]),
        (&["t"], 1, &["t:", "No such file"]),
        (&["t.ob"], 1, &["t.ob:", "No such file"]),
    ];
    for (line, code, words) in table {
        drt(dir, line).expect(*code, words);
    }
}

/// What is no error and still probably not meant.
#[test]
fn what_would_be_lost_is_said() {
    let folder = folder();
    let dir = folder.path();
    let tiny = ["--size", "8x6", "--spp", "1"];
    let layers = drt(dir, &[&["t.obj", "--aov", "depth", "-o", "x.png"], &tiny[..]].concat());
    layers.expect(0, &[]);
    assert!(layers.err.starts_with("warning: layers were asked for"), "{}", layers.err);
    let both = drt(dir, &[&["t.obj", "--aov", "depth", "-o", "x.png", "-o", "x.EXR"], &tiny[..]].concat());
    both.expect(0, &[]);
    assert!(both.err.starts_with("wrote"), "{}", both.err);
    fs::write(dir.join("s.toml"), SCENE).unwrap();
    let name = drt(dir, &["s.toml", "--set", "materials.clya.type=mirror", "-o", "x.png"]);
    name.expect(0, &[]);
    assert!(name.err.contains("\"clya\"; did you mean \"clay\"?"), "{}", name.err);
}

/// Mixtures of mixtures of mixtures: some are fine, and ten thousand are an error at the material that is too deep.
#[test]
fn mixtures_within_each_other_have_an_end() {
    let folder = folder();
    let dir = folder.path();
    for (deep, code, words) in [(90, 0, [].as_slice()), (10_000, 1, &["too many other mixtures", "s.toml:"])]
    {
        let mut scene = SCENE.replace("material = \"clay\"", &format!("material = \"m{deep}\""));
        scene += "[materials.m0]\ntype = \"mirror\"\n";
        for i in 1..=deep {
            scene += &format!("[materials.m{i}]\ntype = \"mix\"\nmaterials = [\"clay\", \"m{}\"]\n", i - 1);
        }
        fs::write(dir.join("s.toml"), scene).unwrap();
        drt(dir, &["s.toml", "-o", "x.png"]).expect(code, words);
    }
}
