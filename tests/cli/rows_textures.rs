//! The table of failures, rows B2 and B4 to B10: textures through the program.

use super::universal::{Run, engines, tiny};
use super::{drt, folder};
use std::fs;
use std::path::Path;

/// A square with texture coordinates that fills the view from the front.
const SQUARE: &str = "mtllib m.mtl\nusemtl a\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n\
                      f 1/1 2/2 3/3 4/4\n";
const SCENE: &str = "[camera]\ntype = \"orthographic\"\nposition = [0.5, 0.5, 5]\nlook_at = [0.5, 0.5, 0]\nheight = 0.5\n\
                     [film]\nsize = [4, 4]\n[render]\nspp = 4\n[[mesh]]\nfile = \"m.obj\"\n[[light]]\ntype = \"environment\"\n";

fn png(color: [u8; 3]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 1, 1);
    encoder.set_color(png::ColorType::Rgb);
    encoder.write_header().unwrap().write_image_data(&color).unwrap();
    bytes
}

fn write(dir: &Path, mtl: &str) {
    fs::write(dir.join("m.obj"), SQUARE).unwrap();
    fs::write(dir.join("m.toml"), SCENE).unwrap();
    fs::write(dir.join("m.mtl"), format!("newmtl a\n{mtl}\n")).unwrap();
}

/// The first pixel of a render that ends well, and what was said.
fn seen(dir: &Path, more: &[&str]) -> ([f32; 3], String) {
    let words = [&["m.toml", "-o", "m.pfm", "--progress", "none"], more].concat();
    let ended = Run::new(dir, &words).limits("ulimit -v 4000000").check();
    ended.expect(0, &[]);
    let image = drt::load::picture::read(&dir.join("m.pfm")).unwrap().image;
    (image.rgb(0), ended.err)
}

fn warnings(said: &str) -> Vec<&str> {
    said.lines().filter(|line| line.starts_with("warning: ")).collect()
}

const RED: [f32; 3] = [1.0, 0.0, 0.0];

/// Backslashes, drives, doubled slashes, other case: the picture is found, and shown.
#[test]
fn b2_paths_of_other_systems() {
    let folder = folder();
    let dir = folder.path();
    fs::create_dir_all(dir.join("Tex/deep")).unwrap();
    for place in ["Tex/deep/A.PNG", "y.png", "Tex/b.png"] {
        fs::write(dir.join(place), png([255, 0, 0])).unwrap();
    }
    for engine in engines() {
        for (name, warned) in [
            (r"Tex\deep\A.PNG", 0),
            (r".\tex\deep\a.png", 1),
            (r"C:\x\y.png", 1),
            (r"D:/textures/y.png", 1),
            (r"\\server\share\y.png", 1),
            ("./Tex//b.png", 0),
            ("/no/such/folder/y.png", 1),
        ] {
            write(dir, &format!("Kd 1 1 1\nmap_Kd {name}"));
            let (pixel, said) = seen(dir, &engine);
            assert_eq!(pixel, RED, "{name}: {said}");
            assert_eq!(warnings(&said).len(), warned, "{name}: {said}");
        }
    }
}

/// Options before and behind the name, and blanks in it.
#[test]
fn b4_options_and_names_with_spaces() {
    let folder = folder();
    let dir = folder.path();
    fs::write(dir.join("name with space.png"), png([255, 0, 0])).unwrap();
    for statement in [
        "map_Kd -s 2 2 2 -o .1 0 0 -clamp on name with space.png",
        "map_Kd name with space.png -s 2 2 2 -clamp on",
        "map_Kd   name with space.png  ",
        "map_Kd -bm 1 -mm 0 1 -texres 512 -blendu off name with space.png",
    ] {
        write(dir, statement);
        let (pixel, said) = seen(dir, &[]);
        assert_eq!(pixel, RED, "{statement}: {said}");
        assert_eq!(said.lines().filter(|l| l.starts_with("warning")).count(), 0, "{said}");
    }
}

fn chunk(kind: &[u8; 4], data: &[u8]) -> Vec<u8> {
    let mut crc = !0u32;
    for byte in kind.iter().chain(data) {
        crc ^= u32::from(*byte);
        (0..8).for_each(|_| crc = if crc & 1 == 1 { crc >> 1 ^ 0xedb8_8320 } else { crc >> 1 });
    }
    [&(data.len() as u32).to_be_bytes(), kind.as_slice(), data, &(!crc).to_be_bytes()].concat()
}

/// Files of some bytes whose headers promise more than there is memory for.
fn bombs() -> Vec<(&'static str, Vec<u8>)> {
    let mut header = [65_535u32.to_be_bytes(), 65_535u32.to_be_bytes()].concat();
    header.extend([8, 2, 0, 0, 0]);
    let png = [
        b"\x89PNG\r\n\x1a\n".as_slice(),
        &chunk(b"IHDR", &header),
        &chunk(b"IDAT", &[]),
        &chunk(b"IEND", &[]),
    ]
    .concat();
    let tiff = {
        let entry = |tag: u16, kind: u16, value: u32| {
            [tag.to_le_bytes().as_slice(), &kind.to_le_bytes(), &1u32.to_le_bytes(), &value.to_le_bytes()]
                .concat()
        };
        let entries = [
            (256, 1),
            (257, 1 << 31),
            (258, 8),
            (259, 1),
            (262, 1),
            (273, 8),
            (277, 1),
            (278, 1 << 31),
            (279, 1),
        ];
        let mut file =
            [b"II*\0".as_slice(), &8u32.to_le_bytes(), &(entries.len() as u16).to_le_bytes()].concat();
        entries.iter().for_each(|(tag, value)| file.extend(entry(*tag, 4, *value)));
        file.extend([0; 4]);
        file
    };
    let mut targa = [0u8; 18];
    (targa[2], targa[16]) = (2, 32);
    (targa[12], targa[13], targa[14], targa[15]) = (255, 255, 255, 255);
    let mut bmp = b"BM\0\0\0\0\0\0\0\0\x36\0\0\0\x28\0\0\0".to_vec();
    bmp.extend([0xff, 0xff, 0, 0, 0xff, 0xff, 0, 0, 1, 0, 24, 0]);
    bmp.extend([0; 24]);
    let gif = b"GIF89a\xff\xff\xff\xff\x80\0\0\0\0\0\xff\xff\xff,\0\0\0\0\xff\xff\xff\xff\0\x02\x02D\x01\0;"
        .to_vec();
    let exr = {
        let mut file = b"\x76\x2f\x31\x01\x02\0\0\0".to_vec();
        let mut attribute = |name: &str, kind: &str, data: &[u8]| {
            file.extend(
                [name.as_bytes(), b"\0", kind.as_bytes(), b"\0", &(data.len() as u32).to_le_bytes(), data]
                    .concat(),
            );
        };
        let window = [0i32, 0, 1 << 30, 1 << 30].map(i32::to_le_bytes).concat();
        let channel = |name: &[u8]| {
            [name, b"\0", &2u32.to_le_bytes(), &[0; 4], &1u32.to_le_bytes(), &1u32.to_le_bytes()].concat()
        };
        attribute("channels", "chlist", &[channel(b"B"), channel(b"G"), channel(b"R"), vec![0]].concat());
        attribute("compression", "compression", &[0]);
        attribute("dataWindow", "box2i", &window);
        attribute("displayWindow", "box2i", &window);
        attribute("lineOrder", "lineOrder", &[0]);
        attribute("pixelAspectRatio", "float", &1f32.to_le_bytes());
        attribute("screenWindowCenter", "v2f", &[0; 8]);
        attribute("screenWindowWidth", "float", &1f32.to_le_bytes());
        file.push(0);
        file
    };
    vec![
        ("png", png),
        ("tiff", tiff),
        ("hdr", b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 4294967295\n\x02\x02".to_vec()),
        ("hdr", b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 65535 +X 65535\n\x02\x02".to_vec()),
        ("exr", exr),
        ("tga", targa.to_vec()),
        ("bmp", bmp),
        ("gif", gif),
        ("pfm", b"PF\n100000 100000\n-1\n".to_vec()),
        ("jpg", {
            let mut jpeg =
                b"\xff\xd8\xff\xc0\0\x11\x08\xff\xff\xff\xff\x03\x01\x11\0\x02\x11\0\x03\x11\0".to_vec();
            jpeg.extend(b"\xff\xda\0\x0c\x03\x01\0\x02\0\x03\0\0\x3f\0\0\xff\xd9");
            jpeg
        }),
    ]
}

/// Bombs cost nothing but a warning: headers are believed before texels are.
#[test]
fn b6_bombs() {
    let folder = folder();
    let dir = folder.path();
    let used = |dir: &Path, more: &[&str]| -> (u64, [f32; 3], String) {
        let (pixel, said) = seen(dir, &[&["--stats", "s.json", "--threads", "2"], more].concat());
        let stats: serde_json::Value =
            serde_json::from_slice(&fs::read(dir.join("s.json")).unwrap()).unwrap();
        (stats["peak_rss_bytes"].as_u64().unwrap(), pixel, said)
    };
    write(dir, "Kd 0.5 0.5 0.5");
    let (base, ..) = used(dir, &[]);
    for (name, bytes) in bombs() {
        assert!(bytes.len() < 400, "{name} is no bomb: {} bytes", bytes.len());
        fs::write(dir.join(format!("bomb.{name}")), bytes).unwrap();
        write(dir, &format!("Kd 0.5 0.5 0.5\nmap_Kd bomb.{name}"));
        let (bytes, pixel, said) = used(dir, &[]);
        assert!(pixel.iter().all(|v| (v - 0.5).abs() < 1e-6), "{name}: {pixel:?}");
        assert_eq!(warnings(&said).len(), 1, "{name}: {said}");
        assert!(bytes < base + (32 << 20), "{name}: {bytes} bytes against {base}");
    }
    // The limit is for all together, in the order of the files.
    write(dir, "Kd 0.5 0.5 0.5\nmap_Kd small.png\nmap_Ke large.png");
    fs::write(dir.join("small.png"), png([255, 0, 0])).unwrap();
    let mut large = Vec::new();
    let mut encoder = png::Encoder::new(&mut large, 2000, 1000);
    encoder.set_color(png::ColorType::Rgb);
    encoder.write_header().unwrap().write_image_data(&vec![0; 6_000_000]).unwrap();
    fs::write(dir.join("large.png"), large).unwrap();
    let (_, pixel, said) = used(dir, &["--max-texture-bytes", "1M"]);
    assert_eq!(pixel, [0.5, 0.0, 0.0], "{said}");
    assert!(
        warnings(&said).len() == 1 && said.contains("2000x1000") && said.contains("--max-texture-bytes"),
        "{said}"
    );
    let (_, _, said) = used(dir, &["--max-texture-bytes", "6000003"]);
    assert!(warnings(&said).is_empty(), "{said}");
    for word in ["", "x", "-1", "1Q", "NaN", "1e99"] {
        let flag = format!("--max-texture-bytes={word}");
        drt(dir, &["m.toml", "-o", "m.pfm", &flag]).expect(2, &["--max-texture-bytes"]);
    }
}

/// Cut and flipped files, empty ones, folders and wrong names: a picture or a warning, never more.
#[test]
fn b7_damaged_pictures() {
    use image::{DynamicImage, ImageFormat, Rgb, Rgb32FImage, RgbImage};
    let folder = folder();
    let dir = folder.path();
    let rgb = DynamicImage::ImageRgb8(RgbImage::from_fn(9, 7, |x, y| Rgb([x as u8 * 20, y as u8 * 30, 99])));
    let deep = DynamicImage::ImageRgb32F(Rgb32FImage::from_fn(9, 7, |x, y| Rgb([x as f32, y as f32, 0.5])));
    let encode = |image: &DynamicImage, format| {
        let mut bytes = std::io::Cursor::new(Vec::new());
        image.write_to(&mut bytes, format).unwrap();
        bytes.into_inner()
    };
    let exr = {
        let pixels: Vec<[f32; 3]> = (0..63).map(|i| [i as f32, 0.5, 1.0]).collect();
        let image = drt::film::Image::from_rgb(9, 7, &pixels, "{}".into());
        drt::output::encode(&image, drt::output::Format::Exr, &drt::output::Options::default()).unwrap()
    };
    let whole = [
        encode(&rgb, ImageFormat::Png),
        encode(&rgb, ImageFormat::Jpeg),
        encode(&rgb, ImageFormat::Bmp),
        encode(&rgb, ImageFormat::Tga),
        encode(&rgb, ImageFormat::Gif),
        encode(&rgb, ImageFormat::Tiff),
        encode(&deep, ImageFormat::Hdr),
        exr,
    ];
    // Two hundred damaged files as the textures of one render.
    let (mut mtl, mut obj) = (String::new(), String::from(SQUARE));
    let mut count = 0;
    let mut add = |bytes: &[u8]| {
        fs::write(dir.join(format!("d{count}.png")), bytes).unwrap();
        mtl += &format!(
            "newmtl d{count}\nKd 0.5 0.5 0.5\nmap_Kd d{count}.png\nmap_d d{count}.png\nbump d{count}.png\n"
        );
        obj += &format!("usemtl d{count}\nf 1/1 2/2 3/3\n");
        count += 1;
    };
    for bytes in &whole {
        for i in 0..12 {
            add(&bytes[..bytes.len() * i / 12]);
            let mut flipped = bytes.clone();
            let at = (i * 7919 + 11) % bytes.len();
            flipped[at] ^= 1 << (i % 8);
            let other = (i * 104_729 + 5) % bytes.len().min(64);
            flipped[other] = flipped[other].wrapping_add((1 + i * 31) as u8);
            add(&flipped);
        }
    }
    write(dir, "Kd 1 1 1");
    fs::write(dir.join("m.mtl"), format!("newmtl a\nKd 1 1 1\n{mtl}")).unwrap();
    fs::write(dir.join("m.obj"), obj).unwrap();
    let (_, said) = seen(dir, &[]);
    assert!(
        said.contains("more of this kind") || warnings(&said).len() > 1 || said.contains("texture"),
        "{said}"
    );

    // One by one: what has no picture in it, and says so.
    fs::create_dir(dir.join("folder.png")).unwrap();
    fs::write(dir.join("empty.png"), "").unwrap();
    fs::write(dir.join("text.png"), "this is no picture, it is a text of some length\n").unwrap();
    for name in ["folder.png", "empty.png", "text.png", "d0.png"] {
        write(dir, &format!("Kd 0.25 0.25 0.25\nmap_Kd {name}"));
        let (pixel, said) = seen(dir, &[]);
        assert!(pixel.iter().all(|v| (v - 0.25).abs() < 1e-6), "{name}: {pixel:?}");
        let warned = warnings(&said);
        assert!(
            warned.len() == 1 && warned[0].contains("m.mtl:3") && warned[0].contains("map_Kd"),
            "{name}: {said}"
        );
    }
    // A CMYK JPEG (Adobe's, of one grey) and a grey picture with alpha are shown.
    let grey = DynamicImage::ImageLumaA8(image::GrayAlphaImage::from_pixel(2, 2, image::LumaA([188, 255])));
    fs::write(dir.join("grey.png"), encode(&grey, ImageFormat::Png)).unwrap();
    write(dir, "Kd 1 1 1\nmap_Kd grey.png");
    let (pixel, said) = seen(dir, &[]);
    assert!((pixel[0] - 0.502886).abs() < 1e-5 && warnings(&said).is_empty(), "{pixel:?} {said}");
}

/// Ten thousand materials with a picture each, and few file descriptors; ten thousand that are missing.
#[test]
fn b9_ten_thousand_textures() {
    let folder = folder();
    let dir = folder.path();
    let (mut mtl, mut obj) = (String::new(), String::from(SQUARE));
    let one = png([255, 0, 0]);
    for i in 0..10_000 {
        fs::write(dir.join(format!("t{i}.png")), &one).unwrap();
        mtl += &format!("newmtl t{i}\nKd 1 1 1\nmap_Kd t{i}.png\nmap_Ks gone{i}.png\n");
        obj += &format!("usemtl t{i}\nf 1/1 2/2 3/3\n");
    }
    write(dir, "Kd 1 1 1\nmap_Kd t1.png");
    fs::write(dir.join("m.obj"), obj).unwrap();
    let all = format!("newmtl a\nKd 1 1 1\nmap_Kd t1.png\n{mtl}");
    fs::write(dir.join("m.mtl"), all).unwrap();
    let words = ["m.toml", "-o", "m.pfm", "--progress", "none"];
    let ended = Run::new(dir, &words).limits("ulimit -n 64; ulimit -v 4000000").check();
    ended.expect(0, &[]);
    let image = drt::load::picture::read(&dir.join("m.pfm")).unwrap().image;
    assert_eq!(image.rgb(0), RED, "{}", ended.err);
    let warned = warnings(&ended.err);
    assert!(warned.len() <= 2, "missing ones are summed up: {}", ended.err);
}

/// What a texture statement names may be a pipe, a device, a folder or a secret: nothing blocks, and nothing is quoted.
#[test]
fn b10_textures_that_are_no_files() {
    let folder = folder();
    let dir = folder.path();
    fs::write(dir.join("secret"), "#?HUNTER2\nHUNTER2=1\n\n-Y HUNTER2 +X 4\n").unwrap();
    assert!(std::process::Command::new("mkfifo").arg(dir.join("pipe")).status().unwrap().success());
    std::os::unix::fs::symlink("loop", dir.join("loop")).unwrap();
    for i in 0..50 {
        let to = if i == 0 { "real.png".to_string() } else { format!("link{}", i - 1) };
        std::os::unix::fs::symlink(to, dir.join(format!("link{i}"))).unwrap();
    }
    fs::write(dir.join("real.png"), png([255, 0, 0])).unwrap();
    for (target, shown) in [
        ("pipe", false),
        ("/dev/zero", false),
        ("/dev/stdin", false),
        ("/proc/self/environ", false),
        ("../../../../../../../etc/passwd", false),
        ("secret", false),
        ("loop", false),
        ("link5", true),
        ("real.png", true),
    ] {
        write(dir, &format!("Kd 0.25 0.25 0.25\nmap_Kd {target}"));
        let (pixel, said) = seen(dir, &[]);
        assert_eq!(pixel[0] == pixel[1], !shown, "{target}: {pixel:?} {said}");
        assert!(!said.contains("HUNTER2") && !said.contains("root:"), "{target}: {said}");
        assert_eq!(warnings(&said).len(), usize::from(!shown), "{target}: {said}");
    }
    let ended = drt(dir, &tiny(&["m.toml", "-o", "t.exr"], &[]));
    ended.expect(0, &[]);
}
