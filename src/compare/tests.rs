//! Judges: closed forms, and the FLIP authors' own program (flip-evaluator 1.7 from PyPI) on the same pictures.

use super::*;

const WIDTH: u32 = 24;
const HEIGHT: u32 = 20;

fn image(pixels: &[[f32; 3]]) -> Image {
    Image::from_rgb(WIDTH, HEIGHT, pixels, String::new())
}

fn coordinates() -> impl Iterator<Item = (u32, u32)> {
    (0..WIDTH * HEIGHT).map(|i| (i % WIDTH, i / WIDTH))
}

/// A pattern, and a copy whose channels are exchanged and darkened in some blocks.
fn patterns() -> (Vec<[f32; 3]>, Vec<[f32; 3]>) {
    let reference: Vec<[f32; 3]> = coordinates()
        .map(|(x, y)| {
            [((x * 7 + y * 3) % 32) as f32 / 32.0, (x * y % 16) as f32 / 16.0, ((x + y) % 8) as f32 / 8.0]
        })
        .collect();
    let test = coordinates().zip(&reference).map(|((x, y), p)| match (x / 4 + y / 5) % 2 {
        0 => [p[1] * 0.75, p[2] * 0.75, p[0] * 0.75],
        _ => *p,
    });
    (test.collect(), reference)
}

/// The same over a high dynamic range.
fn bright_patterns() -> (Vec<[f32; 3]>, Vec<[f32; 3]>) {
    let brighten = |pixels: Vec<[f32; 3]>| {
        coordinates().zip(pixels).map(|((x, _), p)| p.map(|v| v * ((x % 6) as f32 - 1.0).exp2())).collect()
    };
    let (test, reference) = patterns();
    (brighten(test), brighten(reference))
}

fn assert_near(got: f64, want: f64) {
    assert!((got - want).abs() < 2e-5, "{got} for {want}");
}

#[test]
fn ldr_flip_agrees_with_its_authors_program() {
    let (test, reference) = patterns();
    let c = compare(&image(&test), &image(&reference), Kind::Ldr).unwrap();
    assert_near(c.flip, 0.388_855_6);
    for ((x, y), want) in [((0, 0), 0.507_489_5), ((3, 7), 0.270_605_1), ((23, 19), 0.870_062_4)] {
        assert_near(c.flip_map[y * WIDTH as usize + x].into(), want);
    }
}

#[test]
fn hdr_flip_agrees_with_its_authors_program() {
    let (test, reference) = bright_patterns();
    let c = compare(&image(&test), &image(&reference), Kind::Hdr).unwrap();
    assert_near(c.flip, 0.412_627_2);
    for ((x, y), want) in [((0, 0), 0.654_484_9), ((3, 7), 0.284_494_3), ((23, 19), 0.838_851_4)] {
        assert_near(c.flip_map[y * WIDTH as usize + x].into(), want);
    }
    // Mostly black: no median to expose for.
    let dark: Vec<[f32; 3]> =
        coordinates().zip(reference).map(|((_, y), p)| if y < 5 { p } else { [0.0; 3] }).collect();
    assert_near(compare(&image(&test), &image(&dark), Kind::Hdr).unwrap().flip, 0.898_653_0);
}

#[test]
fn squared_errors_have_their_closed_forms() {
    let constant = |v: f32| image(&vec![[v; 3]; (WIDTH * HEIGHT) as usize]);
    let c = compare(&constant(0.75), &constant(0.5), Kind::Ldr).unwrap();
    assert_eq!((c.mse, c.max, c.mean), (0.0625, 0.25, 0.25));
    assert!((c.rel_mse - 0.0625 / 0.26).abs() < 1e-12);
    assert!((c.psnr.unwrap() - 12.041_199_826_559_248).abs() < 1e-9);

    let mut one = vec![[0.5; 3]; (WIDTH * HEIGHT) as usize];
    one[100][1] = 2.5;
    let c = compare(&image(&one), &constant(0.5), Kind::Ldr).unwrap();
    let count = f64::from(3 * WIDTH * HEIGHT);
    assert_eq!((c.mse, c.max, c.mean), (4.0 / count, 2.0, 2.0 / count));
}

#[test]
fn equal_pictures_have_no_difference_at_all() {
    for kind in [Kind::Ldr, Kind::Hdr] {
        let (pixels, _) = bright_patterns();
        let c = compare(&image(&pixels), &image(&pixels), kind).unwrap();
        assert_eq!((c.mse, c.rel_mse, c.max, c.mean, c.flip, c.psnr), (0.0, 0.0, 0.0, 0.0, 0.0, None));
        let black = image(&[[0.0; 3]; (WIDTH * HEIGHT) as usize]);
        assert_eq!(compare(&black, &black, kind).unwrap().flip, 0.0);
    }
}

#[test]
fn extreme_values_give_finite_figures() {
    let (pixels, _) = bright_patterns();
    for value in [f32::MAX, f32::MIN, f32::MIN_POSITIVE, -0.0] {
        let mut strange = pixels.clone();
        strange[0] = [value; 3];
        for kind in [Kind::Ldr, Kind::Hdr] {
            for (a, b) in [(&strange, &pixels), (&pixels, &strange)] {
                let c = compare(&image(a), &image(b), kind).unwrap();
                assert!(c.flip.is_finite() && c.mse.is_finite() && c.rel_mse.is_finite(), "{value} {c:?}");
            }
        }
    }
}

#[test]
fn pictures_that_cannot_be_compared_are_errors() {
    let (pixels, _) = patterns();
    let error = |a: &Image, b: &Image| compare(a, b, Kind::Ldr).unwrap_err().message;
    let whole = image(&pixels);
    let other = Image::from_rgb(20, 24, &pixels, String::new());
    assert!(error(&whole, &other).contains("24x20 and 20x24"));
    let mut colourless = whole.clone();
    colourless.channels.remove(1);
    assert!(error(&colourless, &whole).contains("first picture has no whole colour channel G"));
    let mut infinite = pixels.clone();
    infinite[25] = [0.0, f32::INFINITY, 0.0];
    assert!(
        error(&whole, &image(&infinite)).contains("second")
            && error(&image(&infinite), &whole).contains("(1, 1)")
    );
    let empty = Image::from_rgb(0, 0, &[], String::new());
    assert!(error(&empty, &empty).contains("no pixels"));
}

#[test]
fn the_difference_picture_holds_the_absolute_difference_and_flip() {
    let (test, reference) = patterns();
    let (a, b) = (image(&test), image(&reference));
    let c = compare(&a, &b, Kind::Ldr).unwrap();
    let picture = difference(&a, &b, &c);
    assert_eq!(picture.f32_channel("flip.Y"), Some(c.flip_map.as_slice()));
    let i = (7 * WIDTH + 3) as usize;
    assert_eq!(picture.rgb(i), [0, 1, 2].map(|k| (test[i][k] - reference[i][k]).abs()));
}
