//! O19, O22, the furnaces of metals and glass, and opaque bodies that must not leak.

use crate::harness::{SKY, cube, obj, on_every_backend, sheet, sphere, square, stage, torus};

/// [`sheet`] under a white sky.
fn sheet_at(degrees: f64, spp: u32, depth: u32, rest: &str) -> String {
    sheet(degrees, spp, depth, &format!("{SKY}{rest}"))
}

/// Glass over a black sheet shows what it reflects.
#[test]
fn o19_fresnel() {
    let black = "[[mesh]]\nfile = \"black.obj\"\nmaterial = \"black\"\n[materials.black]\ntype = \"diffuse\"\nreflectance = 0.0\n\
                 [materials.m]\ntype = \"dielectric\"\nior = 1.5\n";
    let rows = [
        (0.0, 0.04),
        (30.0, 0.041_523),
        (45.0, 0.050_240),
        (60.0, 0.089_187),
        (75.0, 0.253_061),
        (85.0, 0.612_800),
    ];
    on_every_backend(|backend| {
        for (degrees, exact) in rows {
            let files = [("sheet.obj", square(2.0, 0.0)), ("black.obj", square(2.0, -0.1))];
            stage(&sheet_at(degrees, 256, 8, black), &files, backend, &[]).statistics().expect(
                &format!("{degrees}°"),
                exact,
                1e-5,
            );
        }
    });
}

#[test]
fn o22_phong() {
    on_every_backend(|backend| {
        for (n, row) in
            [(10, [1.0, 0.866_029, 0.504_736, 0.228_056]), (100, [1.0, 0.866_025, 0.5, 0.175_233])]
        {
            let phong =
                format!("[materials.m]\ntype = \"phong\"\ndiffuse = 0.0\nspecular = 1.0\nexponent = {n}\n");
            for (degrees, exact) in [0.0, 30.0, 60.0, 80.0].into_iter().zip(row) {
                stage(&sheet_at(degrees, 256, 1, &phong), &[("sheet.obj", square(2.0, 0.0))], backend, &[])
                    .statistics()
                    .expect(&format!("n {n} at {degrees}°"), exact, 0.0);
            }
        }
    });
}

/// A perfectly reflecting metal with compensation, and clear glass, vanish in a white furnace.
#[test]
fn perfect_metals_and_glass_vanish_on_average() {
    on_every_backend(|backend| {
        for (material, model) in [
            ("type = \"conductor\"\nreflectance = 1.0\nroughness = 0.6", 5e-3),
            ("type = \"conductor\"\nreflectance = 1.0\nroughness = 0.0", 0.0),
            ("type = \"mirror\"\nreflectance = 1.0", 0.0),
            ("type = \"dielectric\"\nior = 1.5", 0.0),
        ] {
            let toml = format!(
                "[camera]\nposition = [0, 0.2, 4]\nlook_at = [0, 0, 0]\nfov = 20\n[film]\nsize = [16, 16]\n\
                 [render]\nspp = 64\nmax_depth = 1000\n[[mesh]]\nfile = \"m.obj\"\nmaterial = \"m\"\n{SKY}[materials.m]\n{material}\n"
            );
            stage(&toml, &[("m.obj", sphere(40, 60))], backend, &[])
                .statistics()
                .expect(material, 1.0, model);
        }
    });
}

/// N5: a lamp inside a closed opaque body with interpolated, half of them flipped, normals: outside is dark.
#[test]
fn n5_opaque_bodies_do_not_leak() {
    let lamp = "[[light]]\ntype = \"point\"\nposition = [0, 0, 0]\nintensity = 100\n\
                [[light]]\ntype = \"sphere\"\ncenter = [0, 0, 0]\nradius = 0.05\nradiance = 100\n";
    let flipped: String = {
        // A cube with one shared normal a corner, pointing out or in by turns.
        let mut text = String::from("");
        for i in 0..8 {
            let c = [i & 1, i >> 1 & 1, i >> 2 & 1].map(|b| if b == 1 { 1.0 } else { -1.0 });
            let sign = if i % 2 == 0 { 1.0 } else { -1.0 };
            text += &format!(
                "v {} {} {}\nvn {} {} {}\n",
                c[0],
                c[1],
                c[2],
                c[0] * sign,
                c[1] * sign,
                c[2] * sign
            );
        }
        for f in ["1 3 4 2", "5 6 8 7", "1 2 6 5", "3 7 8 4", "1 5 7 3", "2 4 8 6"] {
            let corners: Vec<String> = f.split(' ').map(|v| format!("{v}//{v}")).collect();
            text += &format!("f {}\n", corners.join(" "));
        }
        text
    };
    on_every_backend(|backend| {
        for material in [
            "type = \"diffuse\"\nreflectance = 0.8",
            "type = \"conductor\"\nreflectance = 0.9\nroughness = 0.5",
            "type = \"phong\"\ndiffuse = 0.4\nspecular = 0.4\nexponent = 20",
            "type = \"mirror\"\nreflectance = 1.0",
        ] {
            for (mesh, normals) in [(flipped.clone(), "file"), (cube(), "smooth"), (sphere(20, 30), "smooth")]
            {
                let toml = format!(
                    "[camera]\nposition = [3, 2, 4]\nlook_at = [0, 0, 0]\nfov = 40\n[film]\nsize = [48, 48]\n[render]\nspp = 16\n\
                     [[mesh]]\nfile = \"m.obj\"\nmaterial = \"m\"\nnormals = \"{normals}\"\n[materials.m]\n{material}\n{lamp}"
                );
                let (image, stats) = stage(&toml, &[("m.obj", mesh)], backend, &[]).render(|_| ());
                assert!(stats.bounce_rays > 1000, "the camera misses the body");
                assert!(
                    image.rgb_pixels().iter().all(|p| *p == [0.0; 3]),
                    "{material} with {normals} normals leaks"
                );
            }
        }
    });
}

/// N1: the white furnace stays white far from the origin and at any scale.
#[test]
fn n1_far_small_and_large_bodies_have_no_speckle() {
    on_every_backend(|backend| {
        for (offset, scale) in [(1e6, 1.0), (0.0, 1e-6), (0.0, 1e6), (-3e7, 50.0)] {
            let toml = format!(
                "[camera]\nposition = [{}, {}, {}]\nlook_at = [{offset}, {offset}, {offset}]\nfov = 40\n[film]\nsize = [64, 48]\n\
                 [render]\nspp = 16\nmax_depth = 1000\n[[mesh]]\nfile = \"m.obj\"\nmaterial = \"m\"\n\
                 transform = {{ scale = {scale}, translate = [{offset}, {offset}, {offset}] }}\n\
                 [materials.m]\ntype = \"diffuse\"\nreflectance = 1.0\n{SKY}",
                offset + 2.1 * scale,
                offset + 1.7 * scale,
                offset + 4.0 * scale
            );
            let (image, stats) = stage(&toml, &[("m.obj", torus(80, 50))], backend, &[]).render(|_| ());
            assert!(stats.bounce_rays > 5_000, "offset {offset}, scale {scale}: the camera misses the body");
            let dark = image.rgb_pixels().iter().filter(|p| **p != [1.0; 3]).count();
            assert_eq!(dark, 0, "offset {offset}, scale {scale}: {dark} pixels leak");
        }
    });
}

/// O25: a checkerboard of one-pixel squares aligned with the pixels, shifted by half, and of half the size.
#[test]
fn o25_checkerboards_under_the_box_filter() {
    let board = |size: f64, shift: f64| {
        let mut squares = Vec::new();
        for i in -8i32..24 {
            for j in -8i32..24 {
                if (i + j).rem_euclid(2) == 0 {
                    let (x, y) = (f64::from(i) * size + shift, f64::from(j) * size);
                    squares.push(vec![
                        [x, y, 0.0],
                        [x + size, y, 0.0],
                        [x + size, y + size, 0.0],
                        [x, y + size, 0.0],
                    ]);
                }
            }
        }
        obj(&squares)
    };
    let toml = "[camera]\ntype = \"orthographic\"\nposition = [4, 4, 5]\nlook_at = [4, 4, 0]\nheight = 8\n\
                [film]\nsize = [8, 8]\n[render]\nspp = 256\nmax_depth = 0\n[[mesh]]\nfile = \"m.obj\"\nmaterial = \"m\"\n\
                [materials.m]\ntype = \"diffuse\"\nreflectance = 0.0\nemission = 1.0\n";
    on_every_backend(|backend| {
        let pixels = |size, shift| {
            let (image, _) = stage(toml, &[("m.obj", board(size, shift))], backend, &[]).render(|_| ());
            image.f32_channel("G").unwrap().to_vec()
        };
        let aligned = pixels(1.0, 0.0);
        for (i, v) in aligned.iter().enumerate() {
            // Row 0 is the top one, y from 7 to 8.
            let on = (i % 8 + (7 - i / 8)) % 2 == 0;
            assert_eq!(*v, f32::from(u8::from(on)), "pixel {i}");
        }
        for (size, shift) in [(1.0, 0.5), (0.5, 0.0)] {
            assert!(pixels(size, shift).iter().all(|v| (v - 0.5).abs() < 0.02), "size {size}, shift {shift}");
        }
    });
}
