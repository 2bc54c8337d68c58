//! Surfaces with holes: what of the light passes them is known exactly.

use crate::harness::{SKY, obj, on_every_backend, picture, stage_bytes};

/// Sheets across the view, one above the other, each an OBJ of its own with texture coordinates.
fn sheets(heights: &[f64]) -> Vec<(String, Vec<u8>)> {
    let file = |(i, z): (usize, &f64)| {
        let text = format!(
            "mtllib m.mtl\nusemtl m{i}\nv -9 -9 {z}\nv 9 -9 {z}\nv 9 9 {z}\nv -9 9 {z}\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n\
             f 1/1 2/2 3/3 4/4\n"
        );
        (format!("s{i}.obj"), text.into_bytes())
    };
    heights.iter().enumerate().map(file).collect()
}

fn scene(sheets: usize, depth: u32, spp: u32, rest: &str) -> String {
    let meshes: String = (0..sheets).map(|i| format!("[[mesh]]\nfile = \"s{i}.obj\"\n")).collect();
    format!(
        "[camera]\ntype = \"orthographic\"\nposition = [0, 0, 5]\nlook_at = [0, 0, 0]\nheight = 1\n\
         [film]\nsize = [8, 8]\n[render]\nspp = {spp}\nmax_depth = {depth}\n{meshes}{rest}"
    )
}

/// Black sheets before a white sky let through what they are not: .5, .75, and the products of several. A ray that
/// passes has not scattered, so depth 0 shows it.
#[test]
fn opacities_of_a_half_and_a_quarter() {
    on_every_backend(|backend| {
        for (opacities, way) in [
            (vec![0.5], "file"),
            (vec![0.25], "file"),
            (vec![0.5, 0.25], "file"),
            (vec![0.5, 0.5, 0.25], "file"),
            (vec![0.5, 0.25], "mtl"),
            (vec![0.5, 0.25], "picture"),
        ] {
            let mut materials = String::new();
            let mut mtl = String::new();
            let mut files = sheets(&(0..opacities.len()).map(|i| -(i as f64)).collect::<Vec<_>>());
            let mut exact = 1.0;
            for (i, opacity) in opacities.iter().enumerate() {
                match way {
                    "file" => {
                        mtl += &format!("newmtl m{i}\nKd 0 0 0\n");
                        materials += &format!("[materials.m{i}]\nopacity = {opacity}\n");
                        exact *= 1.0 - opacity;
                    }
                    "mtl" => {
                        mtl += &format!(
                            "newmtl m{i}\nKd 0 0 0\n{} {opacity}\n",
                            if i == 0 { "d" } else { "Tr" }
                        );
                        exact *= if i == 0 { 1.0 - opacity } else { *opacity };
                    }
                    _ => {
                        // Codes are shares: no transfer function.
                        let code = (opacity * 255.0) as u8;
                        mtl += &format!("newmtl m{i}\nKd 0 0 0\nmap_d o{i}.png\n");
                        files.push((format!("o{i}.png"), picture(1, &[[code; 3]])));
                        exact *= 1.0 - f64::from(code) / 255.0;
                    }
                }
            }
            files.push(("m.mtl".into(), mtl.into_bytes()));
            let files: Vec<(&str, Vec<u8>)> = files.iter().map(|(n, b)| (n.as_str(), b.clone())).collect();
            let toml = scene(opacities.len(), 0, 1024, &format!("{materials}{SKY}"));
            let what = format!("{backend:?}, {opacities:?} by {way}");
            stage_bytes(&toml, &files, backend, &[]).statistics().expect(&what, exact, 0.0);
        }
    });
}

/// A white floor under a sheet: parallel light reaches it through the sheet by 1 − α, and the camera sees it through
/// another. Both ways at once is the product: decisions along a path are independent.
#[test]
fn shadow_rays_pass_holes() {
    let light = "[[light]]\ntype = \"directional\"\ndirection = [0, 0.6, -0.8]\nirradiance = 1.0\n";
    on_every_backend(|backend| {
        for (opacity, depth) in [(0.5, 1), (0.25, 1), (0.25, 16), (1.0, 1), (0.0, 1)] {
            let mut files = sheets(&[-1.0, 0.0]);
            files.push(("m.mtl".into(), b"newmtl m0\nKd 0.5 0.5 0.5\nnewmtl m1\nKd 0 0 0\n".to_vec()));
            let files: Vec<(&str, Vec<u8>)> = files.iter().map(|(n, b)| (n.as_str(), b.clone())).collect();
            let rest = format!("[materials.m1]\nopacity = {opacity}\n{light}");
            // f·E·cos, twice through the sheet; the sheet itself is black.
            let exact = (1.0 - opacity) * (1.0 - opacity) * 0.5 / std::f64::consts::PI * 0.8;
            let toml = scene(2, depth, 64, &rest);
            if exact == 0.0 {
                let (image, _) = stage_bytes(&toml, &files, backend, &[]).render(|_| ());
                assert!(image.rgb_pixels().iter().all(|p| *p == [0.0; 3]), "{backend:?}: opaque is opaque");
            } else {
                let what = format!("{backend:?}, opacity {opacity}, depth {depth}");
                stage_bytes(&toml, &files, backend, &[]).statistics().expect(&what, exact, 0.0);
            }
        }
    });
}

/// A lamp of side 2 at height 1 over a floor.
const LAMP: &[u8] = b"mtllib m.mtl\nusemtl lamp\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1\n\
                      vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n";
const FLOOR: &[u8] = b"mtllib m.mtl\nusemtl floor\nv -9 -9 0\nv 9 -9 0\nv 9 9 0\nv -9 9 0\nf 1 2 3 4\n";

/// Looks at the floor below the lamp's middle.
fn under_the_lamp(rest: &str) -> String {
    let toml = scene(2, 1, 1024, rest).replace("height = 1\n", "height = 1e-4\n");
    toml.replace("position = [0, 0, 5]", "position = [0, 0, 0.5]")
}

/// The lamp's form factor from there: four unit squares at a corner.
fn lamp_over_floor() -> f64 {
    let a = 1.0f64 / 2.0f64.sqrt();
    4.0 / (2.0 * std::f64::consts::PI) * (2.0 * a * a.atan())
}

/// A lamp behind and a lamp that is itself full of holes: light sampling, BSDF sampling and both agree with the closed
/// form of a lamp over a floor, times the share that is there.
#[test]
fn lamps_with_holes() {
    on_every_backend(|backend| {
        for lights in ["mis", "light", "bsdf"] {
            let files = vec![
                ("s0.obj", FLOOR.to_vec()),
                ("s1.obj", LAMP.to_vec()),
                ("m.mtl", b"newmtl floor\nKd 1 1 1\nnewmtl lamp\nKd 0 0 0\nKe 2 2 2\nd 0.75\n".to_vec()),
            ];
            let toml = under_the_lamp("");
            let set = format!("render.lights={lights}");
            let exact = 0.75 * 2.0 * lamp_over_floor();
            let what = format!("{backend:?}, {lights}");
            stage_bytes(&toml, &files, backend, &[&set]).statistics().expect(&what, exact, 0.0);
        }
    });
}

/// A lamp whose halves shine differently, by a picture: what each adds under the lamp's middle is half the form factor.
/// The picture's mean is that of neither half, so a lamp chosen by it must be weighed by what is there.
#[test]
fn lamps_with_pictures() {
    on_every_backend(|backend| {
        for lights in ["mis", "light", "bsdf"] {
            let files = vec![
                ("s0.obj", FLOOR.to_vec()),
                ("s1.obj", LAMP.to_vec()),
                ("a.png", picture(2, &[[255; 3], [64; 3]])),
                ("m.mtl", b"newmtl floor\nKd 1 1 1\nnewmtl lamp\nKd 0 0 0\n".to_vec()),
            ];
            let rest =
                "[materials.lamp]\nemission = { texture = \"a.png\", filter = \"nearest\", gain = 3 }\n";
            let toml = under_the_lamp(rest);
            let set = format!("render.lights={lights}");
            let exact = 3.0 * lamp_over_floor() * 0.5 * (1.0 + 0.051_269_5);
            let what = format!("{backend:?}, {lights}");
            stage_bytes(&toml, &files, backend, &[&set]).statistics().expect(&what, exact, 1e-5);
        }
        // Seen: the codes, times the gain.
        let files = [
            ("s0.obj", sheets(&[0.0])[0].1.clone()),
            ("a.png", picture(1, &[[188; 3]])),
            ("m.mtl", b"newmtl m0\nKd 0 0 0\nKe 0 0 0\nmap_Ke a.png\n".to_vec()),
        ];
        let (image, _) = stage_bytes(&scene(1, 0, 4, ""), &files, backend, &[]).render(|_| ());
        assert!(image.rgb_pixels().iter().flatten().all(|v| (v - 0.502886).abs() < 2e-6), "{backend:?}");
    });
}

/// The alpha of a colour's picture cuts out where it varies, and is ignored where it is the same everywhere.
#[test]
fn alpha_of_a_picture() {
    let rgba = |alphas: [u8; 2]| {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, 2, 1);
        encoder.set_color(png::ColorType::Rgba);
        let data: Vec<u8> = alphas.iter().flat_map(|a| [0, 0, 0, *a]).collect();
        encoder.write_header().unwrap().write_image_data(&data).unwrap();
        bytes
    };
    on_every_backend(|backend| {
        for (alphas, mtl, want) in [
            ([0, 255], "map_Kd a.png\n", [1.0, 0.0]),
            ([0, 0], "map_Kd a.png\n", [0.0, 0.0]),
            ([0, 255], "map_Kd a.png\nmap_d a.png\n", [1.0, 0.0]),
            ([255, 0], "map_d -imfchan m a.png\n", [0.0, 1.0]),
        ] {
            let mut files: Vec<(String, Vec<u8>)> = sheets(&[0.0]);
            files.push(("a.png".into(), rgba(alphas)));
            files.push(("m.mtl".into(), format!("newmtl m0\nKd 0 0 0\n{mtl}").into_bytes()));
            let files: Vec<(&str, Vec<u8>)> = files.iter().map(|(n, b)| (n.as_str(), b.clone())).collect();
            let toml = scene(1, 0, 4, SKY).replace("height = 1\n", "height = 18\n");
            let (image, _) = stage_bytes(&toml, &files, backend, &[]).render(|_| ());
            // At a quarter and at three quarters, where the two texels have their middles.
            let got = [image.rgb(4 * 8)[1], image.rgb(4 * 8 + 7)[1]];
            let near = got.iter().zip(want).all(|(g, w)| (g - w).abs() < 0.51);
            assert!(
                near && (got[0] - want[0]).abs() + (got[1] - want[1]).abs() < 0.9,
                "{backend:?} {mtl:?}: {got:?}"
            );
            let middle = [image.rgb(4 * 8 + 2)[1], image.rgb(4 * 8 + 5)[1]];
            let close = middle.iter().zip(want).all(|(g, w): (&f32, f32)| (g - w).abs() < 0.3);
            assert!(close, "{backend:?} {alphas:?} {mtl:?}: {middle:?}");
        }
    });
}

/// Holes do not depend on threads or crops, and a scene without any is what it was.
#[test]
fn a_fence_throws_a_shadow_of_stripes() {
    // A fence of bars before the light: parallel light from the left behind it, seen on the floor.
    let bars = picture(2, &[[0; 3], [255; 3]]);
    let obj_floor = obj(&[vec![[-2.0, -2.0, 0.0], [2.0, -2.0, 0.0], [2.0, 2.0, 0.0], [-2.0, 2.0, 0.0]]]);
    let fence = "mtllib m.mtl\nusemtl fence\nv -2 -2 1\nv 2 -2 1\nv 2 2 1\nv -2 2 1\nvt 0 0\nvt 4 0\nvt 4 1\nvt 0 1\n\
                 f 1/1 2/2 3/3 4/4\n";
    let toml = "[camera]\ntype = \"orthographic\"\nposition = [0, 0, 0.9]\nlook_at = [0, 0, 0]\nheight = 2\n[film]\nsize = [4, 4]\n\
                [render]\nspp = 16\nmax_depth = 1\n[[mesh]]\nfile = \"floor.obj\"\nmaterial = \"w\"\n[[mesh]]\nfile = \"fence.obj\"\n\
                [materials.w]\ntype = \"diffuse\"\nreflectance = 1.0\n[materials.fence]\n\
                opacity = { texture = \"bars.png\", filter = \"nearest\" }\n\
                [[light]]\ntype = \"directional\"\ndirection = [0, 0, -1]\nirradiance = 3.1415927\n";
    on_every_backend(|backend| {
        let files = [
            ("floor.obj", obj_floor.clone().into_bytes()),
            ("fence.obj", fence.as_bytes().to_vec()),
            ("m.mtl", b"newmtl fence\nKd 0 0 0\n".to_vec()),
            ("bars.png", bars.clone()),
        ];
        let (image, _) = stage_bytes(toml, &files, backend, &[]).render(|_| ());
        // One texel is half a metre, which is a pixel: open, closed, open, closed.
        for (i, pixel) in image.rgb_pixels().iter().enumerate() {
            let want = if i % 2 == 0 { 1.0 } else { 0.0 };
            assert!((pixel[1] - want).abs() < 1e-5, "{backend:?}, pixel {i}: {pixel:?}");
        }
    });
}
