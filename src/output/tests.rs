//! Judges: the `image` and `exr` crates' readers, closed forms of the transfer function, and the file system.

use std::fs;
use std::io::Cursor;
use std::os::unix::fs::{PermissionsExt, symlink};
use std::path::Path;

use super::display::ToneMap;
use super::*;
use crate::film::Channel;
use crate::math::srgb::{linear_to_srgb, srgb_to_linear};

fn gradient(width: u32, height: u32) -> Image {
    let pixels: Vec<[f32; 3]> = (0..width * height)
        .map(|i| {
            let (x, y) = ((i % width) as f32 / width as f32, (i / width) as f32 / height as f32);
            [x, y, 0.25 + 0.5 * x * y]
        })
        .collect();
    Image::from_rgb(width, height, &pixels, "{\"seed\":0}".into())
}

fn grey(value: f32) -> Image {
    Image::from_rgb(1, 1, &[[value; 3]], String::new())
}

fn with_layers() -> Image {
    let mut image = gradient(5, 3);
    image.offset = [2, 7];
    image.full_size = [20, 30];
    let mut layer = |name: &str, data| image.channels.push(Channel { name: name.into(), data });
    layer("normal.X", Data::F32((0..15).map(|i| i as f32 - 7.0).collect()));
    layer("depth.Z", Data::F32((0..15).map(|i| if i == 3 { f32::INFINITY } else { i as f32 }).collect()));
    layer("id.mesh", Data::U32((0..15).map(|i| u32::MAX - i).collect()));
    image
}

fn png_code(value: f32, options: &Options) -> u8 {
    let bytes = encode(&grey(value), Format::Png, options).unwrap();
    let picture = ::image::load_from_memory(&bytes).unwrap().to_rgb8();
    assert_eq!(picture.get_pixel(0, 0).0[0], picture.get_pixel(0, 0).0[2]);
    picture.get_pixel(0, 0).0[0]
}

/// Linear colours, row by row from the top, as an independent reader sees them.
fn decode(format: Format, bytes: &[u8]) -> (u32, u32, Vec<[f32; 3]>) {
    match format {
        Format::Exr => {
            use ::exr::prelude::*;
            type Grid = (Vec2<usize>, Vec<[f32; 3]>);
            let image = read()
                .no_deep_data()
                .largest_resolution_level()
                .rgb_channels(
                    |size, _| -> Grid { (size, vec![[0.0; 3]; size.area()]) },
                    |(size, out): &mut Grid, at, (r, g, b): (f32, f32, f32)| {
                        out[at.y() * size.width() + at.x()] = [r, g, b];
                    },
                )
                .first_valid_layer()
                .all_attributes()
                .non_parallel()
                .from_buffered(Cursor::new(bytes))
                .unwrap();
            let (size, pixels) = image.layer_data.channel_data.pixels;
            (size.width() as u32, size.height() as u32, pixels)
        }
        Format::Png | Format::Jpeg => {
            let picture = ::image::load_from_memory(bytes).unwrap().to_rgb8();
            let pixels = picture.pixels().map(|p| p.0.map(|c| srgb_to_linear(f64::from(c) / 255.0) as f32));
            (picture.width(), picture.height(), pixels.collect())
        }
        Format::Hdr => {
            let picture = ::image::load_from_memory(bytes).unwrap().to_rgb32f();
            (picture.width(), picture.height(), picture.pixels().map(|p| p.0).collect())
        }
        Format::Pfm => {
            let header = b"PF\n37 23\n-1.0\n";
            assert!(bytes.starts_with(header));
            let floats: Vec<f32> = bytes[header.len()..]
                .chunks_exact(4)
                .map(|b| f32::from_le_bytes(b.try_into().unwrap()))
                .collect();
            let rows = floats.chunks_exact(37 * 3).rev();
            (37, 23, rows.flat_map(|row| row.chunks_exact(3).map(|p| [p[0], p[1], p[2]])).collect())
        }
    }
}

#[test]
fn every_format_round_trips() {
    let image = gradient(37, 23);
    for entry in &FORMATS {
        let bytes = encode(&image, entry.format, &Options::default()).unwrap();
        let (width, height, pixels) = decode(entry.format, &bytes);
        assert_eq!((width, height), (37, 23), "{:?}", entry.format);
        // RGBE: half a step of a mantissa of at least 128. 8-bit: half a code times the steepest slope, 2.4/1.055.
        let tolerance = |brightest: f32| match entry.format {
            Format::Exr | Format::Pfm => 0.0,
            Format::Hdr => brightest / 256.0,
            Format::Png => 0.5 / 255.0 * 2.4 / 1.055 + 1e-5,
            Format::Jpeg => 0.04,
        };
        for (got, want) in pixels.iter().zip(image.rgb_pixels()) {
            let brightest = want[0].max(want[1]).max(want[2]);
            for c in 0..3 {
                let difference = (got[c] - want[c]).abs();
                assert!(difference <= tolerance(brightest), "{:?}: {got:?} for {want:?}", entry.format);
            }
        }
    }
}

#[test]
fn every_format_gives_the_same_bytes_twice_and_survives_every_float() {
    let strange = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -1.0, 0.0, 1e-40, 1e-33, f32::MAX, 1.0];
    let pixels: Vec<[f32; 3]> = strange.iter().flat_map(|&a| strange.map(|b| [a, b, 0.5])).collect();
    let image = Image::from_rgb(9, 9, &pixels, String::new());
    for entry in &FORMATS {
        for (_, tone_map) in ToneMap::NAMES {
            let options = Options { exposure: 1.0, tone_map };
            let bytes = encode(&image, entry.format, &options).unwrap();
            assert_eq!(bytes, encode(&image, entry.format, &options).unwrap());
        }
    }
}

#[test]
fn every_registered_extension_names_its_format_in_any_case() {
    for entry in &FORMATS {
        for extension in entry.extensions {
            let name = format!("a.{}", extension.to_uppercase());
            assert_eq!(Format::of_path(Path::new(&name)).unwrap(), entry.format);
        }
    }
    assert_eq!(Format::of_path(Path::new("-")).unwrap(), Format::Png);
    assert_eq!(Format::of_path(Path::new("/dev/null")).unwrap(), Format::Png);
    let error = Format::of_path(Path::new("a.jpge")).unwrap_err().to_string();
    assert!(
        error.contains("a.jpge") && error.contains("did you mean \"jp") && error.contains("exr"),
        "{error}"
    );
    assert!(Format::of_path(Path::new("a")).unwrap_err().to_string().contains("exr, png, jpg"));
}

#[test]
fn png_codes_are_the_nearest_of_the_piecewise_transfer_function() {
    let plain = Options::default();
    assert_eq!(png_code(0.18, &plain), 118);
    assert_eq!(png_code(0.5, &plain), 188);
    assert_eq!(
        [png_code(f32::NAN, &plain), png_code(-3.0, &plain), png_code(f32::NEG_INFINITY, &plain)],
        [0; 3]
    );
    assert_eq!([png_code(1.0, &plain), png_code(7.0, &plain), png_code(f32::INFINITY, &plain)], [255; 3]);
    assert_eq!(png_code(0.25, &Options { exposure: 1.0, ..plain }), 188);
    let quantizer = super::display::Quantizer::new();
    for i in 0..=100_000 {
        let linear = i as f32 / 100_000.0;
        let exact = 255.0 * linear_to_srgb(f64::from(linear));
        assert!((f64::from(quantizer.code(linear)) - exact).abs() < 0.5 + 1e-4, "{linear}");
    }
}

#[test]
fn tone_maps_rise_from_zero_and_stay_below_one() {
    for (name, curve) in ToneMap::NAMES {
        assert_eq!(ToneMap::from_name(name), Some(curve));
        assert_eq!([curve.apply(0.0), curve.apply(f32::NAN), curve.apply(-1.0)], [0.0; 3]);
        assert!(curve.apply(f32::INFINITY) > 0.99 && curve.apply(f32::INFINITY) <= 1.0);
        let values: Vec<f32> = (0..2000).map(|i| curve.apply(i as f32 / 100.0)).collect();
        assert!(values.windows(2).all(|w| w[0] <= w[1]), "{name}");
    }
    assert_eq!(ToneMap::Reinhard.apply(1.0), 0.5);
    assert_eq!(ToneMap::None.apply(0.3), 0.3);
}

#[test]
fn the_float_formats_ignore_exposure_and_tone_map() {
    let options = Options { exposure: 3.0, tone_map: ToneMap::Reinhard };
    for format in [Format::Exr, Format::Hdr, Format::Pfm] {
        let plain = encode(&gradient(9, 4), format, &Options::default()).unwrap();
        assert_eq!(encode(&gradient(9, 4), format, &options).unwrap(), plain);
    }
}

#[test]
fn an_exr_has_windows_layers_exact_ids_and_the_settings() {
    use ::exr::prelude::*;
    let image = with_layers();
    let bytes = encode(&image, Format::Exr, &Options::default()).unwrap();
    let read = read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .all_layers()
        .all_attributes()
        .non_parallel()
        .from_buffered(Cursor::new(bytes))
        .unwrap();
    assert_eq!(read.attributes.display_window, IntegerBounds::new((0, 0), (20, 30)));
    assert_eq!(read.layer_data.len(), 1);
    let layer = &read.layer_data[0];
    assert_eq!((layer.attributes.layer_position, layer.size), (Vec2(2, 7), Vec2(5, 3)));
    assert_eq!(layer.encoding.line_order, LineOrder::Increasing);
    let settings = layer.attributes.other.get(&Text::from("drt"));
    assert_eq!(settings, Some(&AttributeValue::Text(Text::from("{\"seed\":0}"))));
    let names: Vec<String> = layer.channel_data.list.iter().map(|c| c.name.to_string()).collect();
    assert_eq!(names, ["B", "G", "R", "depth.Z", "id.mesh", "normal.X"]);
    for channel in &layer.channel_data.list {
        let ours = image.channels.iter().find(|c| channel.name.eq(&c.name)).unwrap();
        match (&ours.data, &channel.sample_data) {
            (Data::F32(a), FlatSamples::F32(b)) => assert_eq!(a, b),
            (Data::U32(a), FlatSamples::U32(b)) => assert_eq!(a, b),
            other => panic!("{other:?}"),
        }
    }
}

#[test]
fn a_png_says_that_it_is_srgb_and_what_made_it() {
    let bytes = encode(&gradient(3, 3), Format::Png, &Options::default()).unwrap();
    let reader = ::png::Decoder::new(Cursor::new(&bytes)).read_info().unwrap();
    let info = reader.info();
    assert!(info.srgb.is_some());
    assert_eq!(info.utf8_text[0].keyword, "drt");
    assert_eq!(info.utf8_text[0].get_text().unwrap(), "{\"seed\":0}");
}

#[test]
fn rgbe_holds_half_a_mantissa_step_over_its_whole_range_and_at_any_width() {
    for width in [1, 7, 8, 300] {
        let pixels: Vec<[f32; 3]> = (0..width)
            // Repeats make runs, the others literals longer than one count.
            .map(|i| {
                if i % 10 < 5 { [0.5; 3] } else { [(i as f32 * 0.37 - 30.0).exp2(), 1e-9, 0.9999 * i as f32] }
            })
            .collect();
        let bytes =
            encode(&Image::from_rgb(width, 1, &pixels, String::new()), Format::Hdr, &Options::default());
        let (_, _, got) = decode(Format::Hdr, &bytes.unwrap());
        for (got, want) in got.iter().zip(&pixels) {
            let brightest = want[0].max(want[1]).max(want[2]);
            assert!((0..3).all(|c| (got[c] - want[c]).abs() <= brightest / 256.0), "{got:?} for {want:?}");
        }
    }
}

#[test]
fn pictures_that_no_file_can_hold_are_errors() {
    let mut short = gradient(4, 4);
    short.channels[1].data = Data::F32(vec![0.0; 15]);
    let mut twice = gradient(4, 4);
    twice.channels[1].name = "R".into();
    let mut far = gradient(4, 4);
    far.offset = [u32::MAX, 0];
    let empty = Image::from_rgb(0, 4, &[], String::new());
    for image in [&short, &empty] {
        assert!(FORMATS.iter().all(|f| encode(image, f.format, &Options::default()).is_err()));
    }
    assert!(encode(&twice, Format::Exr, &Options::default()).unwrap_err().message.contains("\"R\""));
    assert!(encode(&far, Format::Exr, &Options::default()).is_err());
    let wide = Image::from_rgb(65536, 1, &[[0.0; 3]; 65536], String::new());
    assert!(encode(&wide, Format::Jpeg, &Options::default()).unwrap_err().message.contains("65535"));
}

fn names_in(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> =
        fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn a_file_is_replaced_with_its_mode_kept_and_nothing_left_behind() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.png");
    fs::write(&file, "old").unwrap();
    fs::set_permissions(&file, fs::Permissions::from_mode(0o640)).unwrap();
    check_path(&file).unwrap();
    assert_eq!(fs::read(&file).unwrap(), b"old");
    write(&file, &gradient(8, 8), &Options::default()).unwrap();
    assert_eq!(fs::read(&file).unwrap(), encode(&gradient(8, 8), Format::Png, &Options::default()).unwrap());
    assert_eq!(fs::metadata(&file).unwrap().permissions().mode() & 0o777, 0o640);
    assert_eq!(names_in(folder.path()), ["a.png"]);
}

#[test]
fn a_new_file_has_the_mode_that_any_new_file_has() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("plain"), "").unwrap();
    write_bytes(&folder.path().join("a.png"), b"x").unwrap();
    let mode = |name: &str| fs::metadata(folder.path().join(name)).unwrap().permissions().mode();
    assert_eq!(mode("a.png"), mode("plain"));
}

#[test]
fn a_link_stays_and_its_target_is_replaced() {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("there")).unwrap();
    let (link, chain) = (folder.path().join("link.png"), folder.path().join("chain.png"));
    symlink("there/real.png", &link).unwrap();
    symlink("link.png", &chain).unwrap();
    let target = folder.path().join("there/real.png");
    for content in ["first, while the link dangles", "second"] {
        check_path(&chain).unwrap();
        write_bytes(&chain, content.as_bytes()).unwrap();
        assert_eq!(fs::read_to_string(&target).unwrap(), content);
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert!(fs::symlink_metadata(&chain).unwrap().is_symlink());
    }
    assert_eq!(names_in(&folder.path().join("there")), ["real.png"]);
    symlink("loop.png", folder.path().join("loop.png")).unwrap();
    assert!(check_path(&folder.path().join("loop.png")).is_err());
}

#[test]
fn a_failed_write_leaves_the_old_file_and_no_other() {
    let folder = tempfile::tempdir().unwrap();
    // A folder cannot be renamed over by a file: everything up to the rename has then been done.
    let occupied = folder.path().join("a.png");
    fs::create_dir_all(occupied.join("full")).unwrap();
    assert!(super::file::replace(&occupied, b"new").is_err());
    assert_eq!(names_in(folder.path()), ["a.png"]);
    assert!(occupied.join("full").is_dir());
}

#[test]
fn a_full_device_is_named_with_the_systems_reason() {
    let error = write(Path::new("/dev/full"), &gradient(4, 4), &Options::default()).unwrap_err().to_string();
    assert_eq!(error, "/dev/full: cannot write: No space left on device");
    check_path(Path::new("/dev/null")).unwrap();
    write(Path::new("/dev/null"), &gradient(4, 4), &Options::default()).unwrap();
}

#[test]
fn paths_that_cannot_be_written_are_found_before_any_work() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::write(at("file"), "").unwrap();
    fs::create_dir(at("folder.png")).unwrap();
    for (path, reason) in [
        ("missing/a.png", "does not exist"),
        ("file/a.png", "Not a directory"),
        ("folder.png", "folder"),
        ("folder.png/", "folder"),
        ("new.png/", "folder"),
        ("a.bmp", "known: exr, png"),
        ("a", "no extension"),
        (&format!("{}.png", "x".repeat(300)), "name too long"),
    ] {
        let error = check_path(&at(path)).unwrap_err().to_string();
        assert!(error.to_lowercase().contains(&reason.to_lowercase()), "{path}: {error}");
        assert!(error.starts_with(&*folder.path().to_string_lossy()), "{error}");
    }
    assert!(check_path(Path::new("")).is_err());
    check_path(Path::new("-")).unwrap();
    assert_eq!(names_in(folder.path()), ["file", "folder.png"]);
}

#[test]
fn whoever_reads_the_old_file_keeps_it_whole() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.pfm");
    fs::write(&file, "old").unwrap();
    let mut reader = fs::File::open(&file).unwrap();
    write_bytes(&file, b"new").unwrap();
    let mut seen = String::new();
    std::io::Read::read_to_string(&mut reader, &mut seen).unwrap();
    assert_eq!(seen, "old");
    assert_eq!(fs::read(&file).unwrap(), b"new");
}
