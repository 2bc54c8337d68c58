//! O25 and O27 through textures: where a picture lies on a surface, what its codes mean, what happens between and beyond
//! its texels. Under a white sky a diffuse surface shows its reflectance, without noise.

use crate::harness::{SKY, on_every_backend, picture, stage_bytes};
use drt::accel::Backend;

/// The square [0, `side`]² at z = 0, texture coordinates from 0 to `uv`.
fn square(side: f64, uv: f64) -> Vec<u8> {
    format!(
        "mtllib m.mtl\nusemtl m\nv 0 0 0\nv {side} 0 0\nv {side} {side} 0\nv 0 {side} 0\n\
         vt 0 0\nvt {uv} 0\nvt {uv} {uv}\nvt 0 {uv}\nf 1/1 2/2 3/3 4/4\n"
    )
    .into_bytes()
}

/// `pixels` × `pixels` of [0, `side`]², and a material's keys.
fn scene(side: f64, pixels: u32, spp: u32, material: &str) -> String {
    format!(
        "[camera]\ntype = \"orthographic\"\nposition = [{0}, {0}, 5]\nlook_at = [{0}, {0}, 0]\nheight = {side}\n\
         [film]\nsize = [{pixels}, {pixels}]\n[render]\nspp = {spp}\nmax_depth = 1\n[[mesh]]\nfile = \"m.obj\"\n{SKY}{material}",
        0.5 * side
    )
}

/// The colours of all pixels, row by row from the top.
fn shown(toml: &str, files: &[(&str, Vec<u8>)], backend: Backend) -> Vec<[f32; 3]> {
    stage_bytes(toml, files, backend, &[]).render(|_| ()).0.rgb_pixels()
}

fn green(toml: &str, files: &[(&str, Vec<u8>)], backend: Backend) -> Vec<f32> {
    shown(toml, files, backend).iter().map(|p| p[1]).collect()
}

fn near(got: f32, want: f32) -> bool {
    (got - want).abs() <= 2e-6
}

const BLACK: [u8; 3] = [0; 3];
const WHITE: [u8; 3] = [255; 3];

/// Red and green above, blue and white below; v = 0 is the picture's lower border.
#[test]
fn pictures_stand_upright() {
    let four = picture(2, &[[255, 0, 0], [0, 255, 0], [0, 0, 255], WHITE]);
    let want = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 1.0, 1.0]];
    let key = "[materials.m]\nreflectance = { texture = \"a.png\", filter = \"nearest\" }\n";
    on_every_backend(|backend| {
        let files = |mtl: &str| {
            vec![("m.obj", square(1.0, 1.0)), ("a.png", four.clone()), ("m.mtl", mtl.as_bytes().to_vec())]
        };
        let got = shown(&scene(1.0, 2, 16, key), &files("newmtl m\nKd 1 1 1\n"), backend);
        assert_eq!(got, want, "{backend:?}, scene file");
        // The middle of each texel, where filtering changes nothing: a corner of the picture seen at 1/64 of its size.
        for (i, want) in want.into_iter().enumerate() {
            let (x, y) = (0.25 + 0.5 * (i % 2) as f64, 0.75 - 0.5 * (i / 2) as f64);
            let toml = scene(1.0, 1, 16, "")
                .replace("position = [0.5, 0.5, 5]", &format!("position = [{x}, {y}, 5]"))
                .replace("look_at = [0.5, 0.5, 0]", &format!("look_at = [{x}, {y}, 0]"))
                .replace("height = 1", "height = 1e-4");
            let got = shown(&toml, &files("newmtl m\nKd 0 0 0\nmap_Kd a.png\n"), backend);
            for (got, want) in got[0].iter().zip(want) {
                assert!((got - want).abs() < 2e-4, "{backend:?}, MTL, texel {i}: {got} for {want}");
            }
        }
    });
}

/// O25: period 2 px aligned, shifted by half a pixel, period 1 px.
#[test]
fn o25_checkers_as_textures() {
    let board = picture(2, &[BLACK, WHITE, WHITE, BLACK]);
    on_every_backend(|backend| {
        let pixels = |uv: f64, offset: f64| {
            let key = format!(
                "[materials.m]\nreflectance = {{ texture = \"a.png\", filter = \"nearest\", offset = [{offset}, 0] }}\n"
            );
            let files =
                [("m.obj", square(8.0, uv)), ("a.png", board.clone()), ("m.mtl", b"newmtl m\n".to_vec())];
            green(&scene(8.0, 8, 256, &key), &files, backend)
        };
        for (i, v) in pixels(4.0, 0.0).iter().enumerate() {
            // White where column + row, counted from the lower left corner, is even.
            let on = (i % 8 + (7 - i / 8)) % 2 == 0;
            assert_eq!(*v, f32::from(u8::from(on)), "{backend:?}, pixel {i}");
        }
        for (uv, offset) in [(4.0, 0.25), (8.0, 0.0)] {
            let got = pixels(uv, offset);
            assert!(
                got.iter().all(|v| (v - 0.5).abs() < 0.02),
                "{backend:?}, {uv} periods, {offset}: {got:?}"
            );
        }
    });
}

/// O27: 8-bit codes are sRGB where they are colours, shares where they are data.
#[test]
fn o27_codes_as_reflectances() {
    on_every_backend(|backend| {
        for (code, linear) in [(128u8, 0.215861f32), (64, 0.0512695), (188, 0.502886)] {
            let files = |mtl: &str| {
                vec![
                    ("m.obj", square(1.0, 1.0)),
                    ("a.png", picture(1, &[[code; 3]])),
                    ("m.mtl", mtl.as_bytes().to_vec()),
                ]
            };
            let seen = |mtl: &str, keys: &str| green(&scene(1.0, 4, 16, keys), &files(mtl), backend);
            let share = f32::from(code) / 255.0;
            for (mtl, keys, want) in [
                ("newmtl m\nKd 1 1 1\nmap_Kd a.png\n", "", linear),
                ("newmtl m\nKd 0 0 0\nmap_Kd a.png\n", "", linear),
                ("newmtl m\nmap_Kd a.png\n", "", linear),
                ("newmtl m\nKd 0.5 0.5 0.5\nmap_Kd a.png\n", "", 0.5 * linear),
                ("newmtl m\nKd 1 1 1\nmap_Kd -mm 0.25 0.5 a.png\n", "", 0.25 + 0.5 * linear),
                ("newmtl m\n", "[materials.m]\nreflectance = { texture = \"a.png\", raw = true }\n", share),
                (
                    "newmtl m\n",
                    "[materials.m]\nreflectance = { texture = \"a.png\", gain = 0.5 }\n",
                    0.5 * linear,
                ),
                ("newmtl m\nKd 0.25 0.25 0.25\nmap_Kd a.png\n", "[materials.m]\nreflectance = 0.75\n", 0.75),
            ] {
                let got = seen(mtl, keys);
                assert!(
                    got.iter().all(|v| near(*v, want)),
                    "{backend:?}, {mtl:?} {keys:?}: {got:?} for {want}"
                );
            }
        }
    });
}

/// 16-bit, grey, paletted and 1-bit PNGs, and 8-bit BMP, TGA and TIFF, show the same code.
#[test]
fn formats_agree() {
    use image::{DynamicImage, GrayImage, ImageFormat, Luma, Rgb, RgbImage};
    let rgb = DynamicImage::ImageRgb8(RgbImage::from_pixel(3, 2, Rgb([188; 3])));
    let grey = DynamicImage::ImageLuma8(GrayImage::from_pixel(3, 2, Luma([188])));
    let deep = DynamicImage::ImageLuma16(image::ImageBuffer::from_pixel(3, 2, Luma([188 * 257])));
    let encode = |image: &DynamicImage, format: ImageFormat| {
        let mut bytes = std::io::Cursor::new(Vec::new());
        image.write_to(&mut bytes, format).unwrap();
        bytes.into_inner()
    };
    let indexed = |depth: png::BitDepth, data: &[u8]| {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, 3, 2);
        encoder.set_color(png::ColorType::Indexed);
        encoder.set_depth(depth);
        encoder.set_palette(vec![7, 7, 7, 188, 188, 188]);
        encoder.write_header().unwrap().write_image_data(data).unwrap();
        bytes
    };
    let all = [
        encode(&rgb, ImageFormat::Png),
        encode(&grey, ImageFormat::Png),
        encode(&deep, ImageFormat::Png),
        indexed(png::BitDepth::Eight, &[1; 6]),
        indexed(png::BitDepth::One, &[0b1110_0000; 2]),
        encode(&rgb, ImageFormat::Bmp),
        encode(&rgb, ImageFormat::Tga),
        encode(&grey, ImageFormat::Tga),
        encode(&rgb, ImageFormat::Tiff),
        encode(&rgb, ImageFormat::Gif),
    ];
    on_every_backend(|backend| {
        for (i, bytes) in all.iter().enumerate() {
            // The name says nothing: the content decides.
            let mtl = b"newmtl m\nKd 1 1 1\nmap_Kd a.jpg\n".to_vec();
            let files = [("m.obj", square(1.0, 1.0)), ("a.jpg", bytes.clone()), ("m.mtl", mtl)];
            let got = green(&scene(1.0, 2, 4, ""), &files, backend);
            assert!(got.iter().all(|v| near(*v, 0.502886)), "{backend:?}, file {i}: {got:?}");
        }
    });
}

/// Along one row of two texels, black and white: what is seen at u, under every filter and wrap.
#[test]
fn filters_and_wraps() {
    let row = picture(2, &[BLACK, WHITE]);
    let at = |u: f64, keys: &str, backend| {
        let toml =
            scene(1.0, 1, 4, &format!("[materials.m]\nreflectance = {{ texture = \"a.png\", {keys} }}\n"))
                .replace("position = [0.5, 0.5, 5]", &format!("position = [{u}, 4, 5]"))
                .replace("look_at = [0.5, 0.5, 0]", &format!("look_at = [{u}, 4, 0]"))
                .replace("height = 1", "height = 1e-6");
        let files = [("m.obj", square(8.0, 8.0)), ("a.png", row.clone()), ("m.mtl", b"newmtl m\n".to_vec())];
        green(&toml, &files, backend)[0]
    };
    on_every_backend(|backend| {
        for (u, keys, want) in [
            (0.3, "filter = \"nearest\"", 0.0),
            (0.7, "filter = \"nearest\"", 1.0),
            (1.3, "filter = \"nearest\"", 0.0),
            (1.3, "filter = \"nearest\", wrap = \"mirror\"", 1.0),
            (1.7, "filter = \"nearest\", wrap = \"mirror\"", 0.0),
            (2.3, "filter = \"nearest\", wrap = \"mirror\"", 0.0),
            (5.3, "filter = \"nearest\", wrap = \"clamp\"", 1.0),
            (0.3, "filter = \"nearest\", wrap = \"clamp\", offset = [-3, 0]", 0.0),
            (0.5, "filter = \"bilinear\"", 0.5),
            (0.4, "wrap = \"repeat\"", 0.3),
            (1.0, "wrap = \"repeat\"", 0.5),
            (1.0, "wrap = \"mirror\"", 1.0),
            (1.1, "wrap = \"mirror\"", 1.0),
            (1.5, "wrap = \"mirror\"", 0.5),
            (1.0, "wrap = \"clamp\"", 1.0),
            (0.1, "wrap = \"clamp\"", 0.0),
            (0.1, "wrap = \"repeat\"", 0.3),
            (0.35, "filter = \"nearest\", scale = [2, 1]", 1.0),
            (0.35, "filter = \"nearest\", offset = [0.25, 0]", 1.0),
            (0.35, "filter = \"nearest\", scale = [-1, 1]", 1.0),
            (0.35, "filter = \"nearest\", scale = [2, 1], offset = [0.5, 0]", 0.0),
        ] {
            let got = at(u, keys, backend);
            assert!((got - want).abs() < 2e-5, "{backend:?}, u {u}, {keys}: {got} for {want}");
        }
    });
}

/// `-s`, `-o`, `-clamp` and `-imfchan` of an MTL; `-t` and the rest are read and change nothing.
#[test]
fn options_of_an_mtl() {
    let four = picture(2, &[[255, 0, 0], [0, 255, 0], [0, 0, 255], WHITE]);
    let at = |[u, v]: [f64; 2], options: &str, backend| {
        let toml = scene(1.0, 1, 4, "")
            .replace("position = [0.5, 0.5, 5]", &format!("position = [{u}, {v}, 5]"))
            .replace("look_at = [0.5, 0.5, 0]", &format!("look_at = [{u}, {v}, 0]"))
            .replace("height = 1", "height = 1e-6");
        let mtl = format!("newmtl m\nKd 1 1 1\nmap_Kd {options} a b.png\n").into_bytes();
        let files = [("m.obj", square(8.0, 8.0)), ("a b.png", four.clone()), ("m.mtl", mtl)];
        shown(&toml, &files, backend)[0]
    };
    let (red, green, blue, white) = ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0; 3]);
    on_every_backend(|backend| {
        for (uv, options, want) in [
            ([0.25, 0.75], "", red),
            ([0.25, 0.25], "", blue),
            ([0.125, 0.375], "-s 2 2 2", red),
            ([0.375, 0.375], "-s 2 2", green),
            ([0.25, 0.25], "-o 0.5 0 0", white),
            ([0.25, 0.25], "-o 0 0.5 0", red),
            ([0.25, 0.125], "-s 1 2 1 -o 0.5 0.5", green),
            ([3.75, 3.75], "-clamp on", green),
            ([3.25, 3.75], "", red),
            ([0.25, 0.75], "-imfchan r", white),
            ([0.25, 0.75], "-imfchan g", [0.0; 3]),
            (
                [0.25, 0.75],
                "-t 0.5 0.5 0.5 -blendu off -blendv off -cc on -texres 64 -boost 2 -type sphere",
                red,
            ),
        ] {
            let got = at(uv, options, backend);
            for (got, want) in got.iter().zip(want) {
                assert!((got - want).abs() < 2e-5, "{backend:?}, {uv:?} {options:?}: {got} for {want}");
            }
        }
    });
}

/// Tiles by their numbers: the first to the right of it, the one above; a tile that is not there shows Kd.
#[test]
fn udim_tiles() {
    let mtl = b"newmtl m\nKd 0.5 0.5 0.5\nmap_Kd tex.<UDIM>.png\n".to_vec();
    let files = [
        ("m.obj", square(2.0, 2.0)),
        ("m.mtl", mtl),
        ("tex.1001.png", picture(1, &[[255, 0, 0]])),
        ("tex.1002.png", picture(1, &[[0, 255, 0]])),
        ("tex.1011.png", picture(1, &[[0, 0, 255]])),
    ];
    on_every_backend(|backend| {
        let got = shown(&scene(2.0, 2, 16, ""), &files, backend);
        let want = [[0.0, 0.0, 0.5], [0.5; 3], [0.5, 0.0, 0.0], [0.0, 0.5, 0.0]];
        for (got, want) in got.iter().flatten().zip(want.iter().flatten()) {
            assert!(near(*got, *want), "{backend:?}: {got} for {want}");
        }
    });
}

/// Triangles without texture coordinates show the constant, and one warning says so.
#[test]
fn no_coordinates_no_picture() {
    let folder = tempfile::tempdir().unwrap();
    let obj = "mtllib m.mtl\nusemtl m\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\n\
               f 1/1 2/2 3/3\nf 1 3 4\n";
    std::fs::write(folder.path().join("m.obj"), obj).unwrap();
    std::fs::write(folder.path().join("m.mtl"), "newmtl m\nKd 0.5 0.5 0.5\nmap_Kd a.png\n").unwrap();
    std::fs::write(folder.path().join("a.png"), picture(1, &[[255, 0, 0]])).unwrap();
    let path = folder.path().join("scene.toml");
    std::fs::write(&path, scene(1.0, 2, 4, "")).unwrap();
    let loaded = drt::load::scene(&path, drt::load::Options::default()).unwrap();
    assert_eq!(loaded.findings.count("texture-without-coordinates"), 1);
    let settings = drt::scene::Settings { size: [8, 8], ..loaded.settings };
    let hooks = drt::render::Hooks::NONE;
    let accel = drt::render::build(&loaded.scene, &settings, None, &hooks).unwrap();
    let image = drt::render::render(&loaded.scene, &settings, accel.as_ref(), None, &hooks).unwrap().image;
    // Upper left and lower right.
    assert!(image.rgb(8 + 1).iter().all(|v| near(*v, 0.5)), "{:?}", image.rgb(9));
    assert!(near(image.rgb(6 * 8 + 6)[0], 0.5) && image.rgb(6 * 8 + 6)[1] == 0.0, "{:?}", image.rgb(54));
}
