//! Judges: the encoders of `output` (tested against other readers), bytes written by hand, the `exr` crate's writer.

use super::*;
use crate::memory::Limit;
use crate::output::{self, FORMATS, Format};
use ::exr::prelude::f16;
use std::io::Cursor;
use std::path::PathBuf;

fn gradient(width: u32, height: u32) -> Image {
    let pixels: Vec<[f32; 3]> = (0..width * height)
        .map(|i| [(i % width) as f32 / width as f32, (i / width) as f32 / height as f32, 0.5])
        .collect();
    Image::from_rgb(width, height, &pixels, "{}".into())
}

fn encoded(image: &Image, format: Format) -> Vec<u8> {
    output::encode(image, format, &output::Options::default()).unwrap()
}

#[test]
fn every_written_format_is_read_back() {
    let image = gradient(31, 17);
    for entry in &FORMATS {
        let picture = decode(&encoded(&image, entry.format)).unwrap();
        assert_eq!((picture.image.width, picture.image.height), (31, 17));
        let display = matches!(entry.format, Format::Png | Format::Jpeg);
        assert_eq!(picture.encoding == Encoding::Display, display, "{:?}", entry.format);
        let tolerance = match entry.format {
            Format::Exr | Format::Pfm => 0.0,
            Format::Hdr | Format::Png => 0.005,
            Format::Jpeg => 0.06,
        };
        for (got, want) in
            picture.image.rgb_pixels().iter().flatten().zip(image.rgb_pixels().iter().flatten())
        {
            assert!((got - want).abs() <= tolerance, "{:?}: {got} for {want}", entry.format);
        }
    }
}

#[test]
fn eight_bit_codes_become_linear() {
    let mut bytes = Vec::new();
    let mut encoder = ::png::Encoder::new(&mut bytes, 3, 1);
    encoder.set_color(::png::ColorType::Grayscale);
    encoder.write_header().unwrap().write_image_data(&[128, 64, 188]).unwrap();
    let image = decode(&bytes).unwrap().image;
    for (i, want) in [0.215861, 0.0512695, 0.502886].into_iter().enumerate() {
        assert!(image.rgb(i).iter().all(|v| (v - want).abs() < 1e-6), "{:?}", image.rgb(i));
    }
}

#[test]
fn an_exr_keeps_its_windows_and_settings() {
    let mut image = gradient(5, 4);
    (image.offset, image.full_size) = ([3, 2], [10, 9]);
    assert_eq!(decode(&encoded(&image, Format::Exr)).unwrap().image, image);
}

fn exr_with(channels: Vec<(&str, ::exr::prelude::FlatSamples)>) -> Vec<u8> {
    use ::exr::prelude::*;
    let list = channels.into_iter().map(|(name, samples)| AnyChannel::new(name, samples)).collect();
    let mut bytes = Cursor::new(Vec::new());
    let image = ::exr::prelude::Image::from_channels((2, 1), AnyChannels::sort(list));
    image.write().non_parallel().to_buffered(&mut bytes).unwrap();
    bytes.into_inner()
}

#[test]
fn exr_channels_of_any_type_and_layer_are_found() {
    use ::exr::prelude::FlatSamples;
    let f32s = |a: f32, b: f32| FlatSamples::F32(vec![a, b]);
    let halves = FlatSamples::F16(vec![f16::from_f32(0.25), f16::from_f32(2.0)]);
    let mixed = exr_with(vec![("R", halves), ("G", f32s(1.5, 2.5)), ("B", FlatSamples::U32(vec![7, 8]))]);
    assert_eq!(decode(&mixed).unwrap().image.rgb_pixels(), [[0.25, 1.5, 7.0], [2.0, 2.5, 8.0]]);
    let layered = exr_with(vec![("a.R", f32s(1.0, 2.0)), ("a.G", f32s(3.0, 4.0)), ("a.B", f32s(5.0, 6.0))]);
    assert_eq!(decode(&layered).unwrap().image.rgb_pixels(), [[1.0, 3.0, 5.0], [2.0, 4.0, 6.0]]);
    let grey = exr_with(vec![("Y", f32s(1.0, 2.0))]);
    assert_eq!(decode(&grey).unwrap().image.rgb_pixels(), [[1.0; 3], [2.0; 3]]);
    let depth = exr_with(vec![("Z", f32s(1.0, 2.0))]);
    assert!(decode(&depth).unwrap_err().message.contains("no colour channels"));
}

#[test]
fn pfm_has_rows_from_the_bottom_and_two_byte_orders() {
    let mut big = b"Pf\n1 2\n1.0\n".to_vec();
    big.extend([3.0_f32, 4.0].iter().flat_map(|v| v.to_be_bytes()));
    assert_eq!(decode(&big).unwrap().image.rgb_pixels(), [[4.0; 3], [3.0; 3]]);
    for damaged in ["PF", "PF\n", "PF\n1 1\n", "PFx\n1 1\n-1\n", "PF\n1 -1\n-1\n", "PF\n1 1\nx\n"] {
        assert!(decode(damaged.as_bytes()).unwrap_err().message.contains("header"), "{damaged}");
    }
    for (header, reason) in [
        ("PF\n0 1\n-1\n", "0x1"),
        ("PF\n99999999999 1\n-1\n", "cannot be read"),
        ("PF\n4294967295 4294967295\n-1\n", "cannot be read"),
        ("PF\n16384 16384\n-1\n", "ends early"),
    ] {
        assert!(decode(header.as_bytes()).unwrap_err().message.contains(reason), "{header}");
    }
}

#[test]
fn a_radiance_header_that_promises_too_much_is_refused() {
    let header = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4000000 +X 4000000\n";
    assert!(decode(header).unwrap_err().message.contains("cannot be read"));
}

#[test]
fn a_picture_that_does_not_fit_into_memory_is_refused() {
    let little = || Some(Left { bytes: 16 << 20, limit: Limit::Machine });
    for entry in &FORMATS {
        assert!(decode_in(little, &encoded(&gradient(10, 10), entry.format)).is_ok(), "{:?}", entry.format);
        let large = encoded(&gradient(1000, 700), entry.format);
        let error = decode_in(little, &large).unwrap_err().to_string();
        assert!(error.contains("about 20 MB are needed (a picture of 1000x700 pixels)"), "{error}");
    }
    // Nothing is read but the header.
    let header = decode_in(little, b"PF\n9999 9999\n-1\n").unwrap_err().to_string();
    assert!(header.contains("not enough memory"), "{header}");
}

#[test]
fn damaged_files_are_errors_and_never_panics() {
    let image = gradient(20, 18);
    for entry in &FORMATS {
        let whole = encoded(&image, entry.format);
        for length in (0..whole.len()).step_by(1 + whole.len() / 60) {
            // Some decoders give what there is; none may panic.
            let _ = decode(&whole[..length]);
            let mut flipped = whole.clone();
            flipped[length] ^= 0xff;
            let _ = decode(&flipped);
        }
        assert!(decode(&whole[..20]).is_err(), "{:?}", entry.format);
    }
    assert!(decode(b"").unwrap_err().message.contains("empty"));
    assert!(decode(b"RIFF....WEBP").unwrap_err().to_string().contains(".exr"));
}

#[test]
fn errors_name_the_file() {
    for path in ["/nonexistent/a.png", "/dev/zero", "/tmp"] {
        let error = read(Path::new(path)).unwrap_err();
        assert_eq!(error.file, Some(PathBuf::from(path)), "{error}");
    }
}
