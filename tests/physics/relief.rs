//! Normal and bump maps: the cosine that they make is known, and no light passes where there is no way.

use crate::harness::{on_every_backend, picture, stage_bytes};

/// A square at z = 0 whose texture coordinates run from 0 to 1 over two metres.
const SQUARE: &str = "mtllib m.mtl\nusemtl m\nv -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n\
                      f 1/1 2/2 3/3 4/4\n";

fn lit_by(direction: [f64; 3], rest: &str) -> String {
    format!(
        "[camera]\ntype = \"orthographic\"\nposition = [0, 0, 5]\nlook_at = [0, 0, 0]\nheight = 0.5\n\
         [film]\nsize = [2, 2]\n[render]\nspp = 4\nmax_depth = 1\n[[mesh]]\nfile = \"m.obj\"\n\
         [[light]]\ntype = \"directional\"\ndirection = {direction:?}\nirradiance = 3.14159265\n{rest}"
    )
}

/// A white surface turned towards the light by a map shows the cosine to the turned normal: normals to both sides,
/// mirrored coordinates, a flat map, and ramps whose height is known.
#[test]
fn the_cosine_is_that_of_the_turned_normal() {
    // n = (0.6, 0, 0.8): code 128 + 127·n, of which the middle is zero.
    let to_the_right = picture(1, &[[128 + 76, 128, 128 + 101]]);
    let up = picture(1, &[[128, 128 + 76, 128 + 101]]);
    let flat = picture(1, &[[128, 128, 255]]);
    let n = |x: f64, z: f64| [x, z].map(|c| (c * 127.0f64).floor() / 127.0);
    let [nx, nz] = n(0.6, 0.8);
    let length = (nx * nx + nz * nz).sqrt();
    // A ramp of heights 0 to 1 over the width: with height 0.5 of two metres' width the slope is one half.
    let ramp = picture(256, &(0..=255u8).map(|c| [c; 3]).collect::<Vec<_>>());
    let slope = 0.5f64 * 256.0 / 255.0;
    let mirrored = SQUARE.replace("vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1", "vt 1 0\nvt 0 0\nvt 0 1\nvt 1 1");
    on_every_backend(|backend| {
        let key = |text: &str| format!("[materials.m]\n{text}\n");
        let (map, bump) =
            ("normal_map = { texture = \"a.png\" }", "bump = { texture = \"a.png\", height = 0.5 }");
        for (what, square, map_bytes, keys, mtl, light, want) in [
            ("flat, from above", SQUARE, &flat, key(map), "", [0.0, 0.0, -1.0], 1.0),
            ("flat, slanted", SQUARE, &flat, key(map), "", [-0.6, 0.0, -0.8], 0.8),
            ("right, from above", SQUARE, &to_the_right, key(map), "", [0.0, 0.0, -1.0], nz / length),
            (
                "right, from the right",
                SQUARE,
                &to_the_right,
                key(map),
                "",
                [-0.6, 0.0, -0.8],
                (0.6 * nx + 0.8 * nz) / length,
            ),
            (
                "right, from the left",
                SQUARE,
                &to_the_right,
                key(map),
                "",
                [0.6, 0.0, -0.8],
                (0.8 * nz - 0.6 * nx) / length,
            ),
            (
                "up, from above right",
                SQUARE,
                &up,
                key(map),
                "",
                [0.0, -0.6, -0.8],
                (0.6 * nx + 0.8 * nz) / length,
            ),
            (
                "mirrored, from the left",
                &mirrored,
                &to_the_right,
                key(map),
                "",
                [0.6, 0.0, -0.8],
                (0.6 * nx + 0.8 * nz) / length,
            ),
            (
                "mirrored, up, from above right",
                &mirrored,
                &up,
                key(map),
                "",
                [0.0, -0.6, -0.8],
                (0.6 * nx + 0.8 * nz) / length,
            ),
            (
                "no strength",
                SQUARE,
                &to_the_right,
                key("normal_map = { texture = \"a.png\", strength = 0 }"),
                "",
                [-0.6, 0.0, -0.8],
                0.8,
            ),
            (
                "norm of an MTL",
                SQUARE,
                &to_the_right,
                String::new(),
                "norm a.png",
                [-0.6, 0.0, -0.8],
                (0.6 * nx + 0.8 * nz) / length,
            ),
            (
                "normals named bump",
                SQUARE,
                &to_the_right,
                String::new(),
                "map_Bump a.png",
                [-0.6, 0.0, -0.8],
                (0.6 * nx + 0.8 * nz) / length,
            ),
            (
                "ramp, from above",
                SQUARE,
                &ramp,
                key(bump),
                "",
                [0.0, 0.0, -1.0],
                1.0 / (1.0 + slope * slope).sqrt(),
            ),
            (
                "ramp, from the left",
                SQUARE,
                &ramp,
                key(bump),
                "",
                [0.6, 0.0, -0.8],
                (0.8 + 0.6 * slope) / (1.0 + slope * slope).sqrt(),
            ),
            (
                "ramp, mirrored",
                &mirrored,
                &ramp,
                key(bump),
                "",
                [-0.6, 0.0, -0.8],
                (0.8 + 0.6 * slope) / (1.0 + slope * slope).sqrt(),
            ),
            (
                "ramp of an MTL",
                SQUARE,
                &ramp,
                String::new(),
                "map_Bump -bm 50 a.png",
                [0.6, 0.0, -0.8],
                (0.8 + 0.6 * slope) / (1.0 + slope * slope).sqrt(),
            ),
            (
                "hollow",
                SQUARE,
                &ramp,
                String::new(),
                "bump -bm -50 a.png",
                [-0.6, 0.0, -0.8],
                (0.8 + 0.6 * slope) / (1.0 + slope * slope).sqrt(),
            ),
        ] {
            let mtl = format!("newmtl m\nKd 1 1 1\n{mtl}\n").into_bytes();
            let files = [("m.obj", square.as_bytes().to_vec()), ("a.png", map_bytes.clone()), ("m.mtl", mtl)];
            let (image, _) = stage_bytes(&lit_by(light, &keys), &files, backend, &[]).render(|_| ());
            let got = f64::from(image.rgb(0)[1]);
            assert!((got - want).abs() < 2e-3, "{backend:?}, {what}: {got} for {want}");
        }
    });
}

/// N5 with relief: a lamp in a closed box whose normals a map turns in all directions; outside is dark.
#[test]
fn reliefs_do_not_leak() {
    let mut state = 1u32;
    let mut code = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 24) as u8
    };
    let wild = picture(16, &(0..256).map(|_| [code(), code(), code()]).collect::<Vec<_>>());
    let mut cube = String::from("vt 0 0\nvt 3 0\nvt 3 3\nvt 0 3\n");
    for i in 0..8 {
        let c = [i & 1, i >> 1 & 1, i >> 2 & 1].map(|b| 2 * b - 1);
        cube += &format!("v {} {} {}\n", c[0], c[1], c[2]);
    }
    for f in ["1 3 4 2", "5 6 8 7", "1 2 6 5", "3 7 8 4", "1 5 7 3", "2 4 8 6"] {
        let corners: Vec<String> = f.split(' ').enumerate().map(|(i, v)| format!("{v}/{}", i + 1)).collect();
        cube += &format!("f {}\n", corners.join(" "));
    }
    let lamp = "[[light]]\ntype = \"point\"\nposition = [0, 0, 0]\nintensity = 100\n\
                [[light]]\ntype = \"sphere\"\ncenter = [0, 0, 0]\nradius = 0.05\nradiance = 100\n";
    on_every_backend(|backend| {
        for relief in [
            "normal_map = { texture = \"a.png\", strength = 3 }",
            "bump = { texture = \"a.png\", height = 1 }",
        ] {
            for model in ["\"diffuse\"\nreflectance = 0.8", "\"conductor\"\nroughness = 0.5", "\"mirror\""] {
                for eye in ["[3, 2, 4]", "[0.7, 0.5, -0.6]"] {
                    let toml = format!(
                        "[camera]\nposition = {eye}\nlook_at = [0, 0, 0.1]\nfov = 60\n[film]\nsize = [32, 32]\n[render]\nspp = 16\n\
                         [[mesh]]\nfile = \"m.obj\"\nmaterial = \"m\"\n[materials.m]\ntype = {model}\n{relief}\n{lamp}"
                    );
                    let files = [("m.obj", cube.clone().into_bytes()), ("a.png", wild.clone())];
                    let (image, stats) = stage_bytes(&toml, &files, backend, &[]).render(|_| ());
                    assert!(stats.bounce_rays > 100, "{backend:?}: the camera misses the body");
                    let lit = image.rgb_pixels().iter().filter(|p| **p != [0.0; 3]).count();
                    if eye.starts_with("[3") {
                        assert_eq!(lit, 0, "{backend:?}, {relief}, {model} leaks");
                    } else {
                        assert!(lit > 0, "{backend:?}, {relief}, {model}: inside it is dark");
                    }
                }
            }
        }
    });
}
