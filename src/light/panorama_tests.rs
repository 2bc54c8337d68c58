use super::*;
use crate::math::warp;

const WORLD: [Vec3; 3] = [Vec3::X, Vec3::Y, Vec3::Z];

fn map(size: [usize; 2], f: impl Fn(usize, usize) -> f32) -> Panorama {
    let texels = (0..size[0] * size[1]).map(|i| [f(i % size[0], i / size[0]); 3]).collect();
    Panorama::new(size, texels, WORLD).unwrap()
}

/// Evenly spread numbers that no grid of texels has anything in common with (Roberts' sequence).
fn numbers(i: u32) -> [f32; 2] {
    [0.754_877_666_246_692_7, 0.569_840_290_998_053_3]
        .map(|a: f64| (0.5 + a * f64::from(i)).fract() as f32)
        .map(|x| x.min(0.999_999_94))
}

fn noisy(size: [usize; 2]) -> Panorama {
    map(size, |x, y| {
        let h = ((x * 73 + y * 151 + 7) as u32).wrapping_mul(0x9e37_79b9) >> 24;
        if h > 240 { 50.0 } else { h as f32 / 256.0 }
    })
}

#[test]
fn directions_lie_where_the_convention_says() {
    let m = map([8, 4], |_, _| 1.0);
    let at = |d: Vec3| m.place(d);
    let close = |a: [f32; 2], b: [f32; 2]| (a[0] - b[0]).abs() < 1e-6 && (a[1] - b[1]).abs() < 1e-6;
    assert!(close(at(-Vec3::Z), [0.0, 0.5]) && close(at(Vec3::X), [0.25, 0.5]));
    assert!(close(at(Vec3::Z), [0.5, 0.5]) && close(at(-Vec3::X), [0.75, 0.5]));
    assert_eq!([at(Vec3::Y)[1], at(-Vec3::Y)[1]], [0.0, 1.0]);
    // A quarter turn counter-clockwise seen from above takes what came from +z to +x.
    let turned = axes(DVec3::Y, DVec3::Z, 90.0);
    assert!((turned[2] - Vec3::X).length() < 1e-6 && (turned[0] + Vec3::Z).length() < 1e-6);
    assert_eq!(axes(DVec3::Y, DVec3::Z, 0.0), WORLD);
}

/// Samples in cells of the sphere against the integral of the density over them (chi-square), for all kinds of maps,
/// compensated and not; the density is 0 nowhere where there is light, without compensation.
#[test]
fn samples_have_their_density() {
    for (name, m) in [
        ("noisy", noisy([16, 8])),
        ("one texel", map([32, 16], |x, y| if (x, y) == (31, 2) { 1e3 } else { 1.0 })),
        ("1×1", map([1, 1], |_, _| 3.0)),
        ("2×1", map([2, 1], |x, _| x as f32)),
        ("1×2", map([1, 2], |_, y| 1.0 + y as f32)),
        ("odd", noisy([5, 3])),
    ] {
        for compensated in [false, true] {
            if !m.has_density(compensated) {
                assert!(compensated && name == "1×1", "{name}");
                continue;
            }
            const CELLS: usize = 12;
            let cell = |d: Vec3| {
                let u = warp::sphere_inverse(d);
                let i = |x: f32| ((x * CELLS as f32) as usize).min(CELLS - 1);
                i(u[1]) * CELLS + i(u[0])
            };
            let n = 400u32;
            let mut expected = vec![0.0f64; CELLS * CELLS];
            let fine = 1200;
            for i in 0..fine * fine {
                let u = [(i % fine) as f32, (i / fine) as f32].map(|x| (x + 0.5) / fine as f32);
                let d = warp::sphere(u);
                expected[cell(d)] +=
                    f64::from(m.pdf(compensated, d) / warp::SPHERE_PDF) / (fine * fine) as f64;
            }
            let total: f64 = expected.iter().sum();
            assert!((total - 1.0).abs() < 5e-3, "{name} {compensated}: {total}");
            let mut counts = vec![0.0f64; CELLS * CELLS];
            for i in 0..n * n {
                let (wi, pdf, le) = m.sample(compensated, numbers(i)).unwrap();
                assert!(
                    (pdf / m.pdf(compensated, wi) - 1.0).abs() < 0.02,
                    "{name}: {pdf} {}",
                    m.pdf(compensated, wi)
                );
                assert!((le - m.le(wi)).abs().max_element() <= 1e-3 * le.max_element(), "{name}");
                counts[cell(wi)] += 1.0 / f64::from(n * n);
            }
            for (count, expected) in counts.iter().zip(&expected) {
                assert!(
                    (count - expected).abs() < 2e-3 + 0.02 * expected,
                    "{name} {compensated} {count} {expected}"
                );
            }
        }
    }
}

/// ∫L/p·p: the mean of L/pdf over the samples is the map's integral, whatever is in it.
#[test]
fn estimates_are_the_integral() {
    for m in [
        noisy([64, 32]),
        map([32, 16], |x, y| if (x, y) == (5, 9) { 1e12 } else { 1.0 }),
        map([1, 1], |_, _| 2.0),
    ] {
        let n = 400u32;
        let mut sum = 0.0;
        for i in 0..n * n {
            let (_, pdf, le) = m.sample(false, numbers(i)).unwrap();
            sum += f64::from(le.x / pdf) / f64::from(n * n);
        }
        // The reference: the bilinear map itself over the sphere.
        let fine = 1500;
        let exact: f64 = (0..fine * fine)
            .map(|i| {
                f64::from(
                    m.le(warp::sphere(
                        [(i % fine) as f32, (i / fine) as f32].map(|x| (x + 0.5) / fine as f32),
                    ))
                    .x,
                )
            })
            .sum::<f64>()
            / f64::from(fine * fine)
            * 4.0
            * std::f64::consts::PI;
        assert!((sum / exact - 1.0).abs() < 4e-3, "{sum} {exact}");
        assert!((f64::from(m.mean().x) * 4.0 * std::f64::consts::PI / exact - 1.0).abs() < 4e-2);
    }
}

#[test]
fn what_is_no_radiance_is_repaired_and_counted() {
    let mut texels = vec![[f32::NAN, 1.0, -2.0], [f32::INFINITY, 1e30, 7.0], [f32::NEG_INFINITY, -0.0, 0.5]];
    let repairs = repair(&mut texels);
    assert_eq!(repairs, Repairs { nan: 1, negative: 2, huge: 2 });
    assert_eq!(texels, [[0.0, 1.0, 0.0], [HIGHEST, HIGHEST, 7.0], [0.0, 0.0, 0.5]]);
    let mut bright = vec![[f32::INFINITY, 3.0, 4.0]];
    repair(&mut bright);
    assert_eq!(bright, [[4.0, 3.0, 4.0]], "an overflow is as bright as the brightest");
}

#[test]
fn constant_and_black_maps_need_no_samples() {
    let constant = map([37, 19], |_, _| 0.7);
    assert!(!constant.has_density(true) && constant.has_density(false));
    for i in 0..1000 {
        let d = warp::sphere([(i as f32 + 0.5) / 1000.0, (i as f32 * 0.618).fract()]);
        assert_eq!(constant.le(d), Rgb::splat(0.7));
    }
    let black = map([4, 2], |_, _| 0.0);
    assert!(!black.has_density(true) && !black.has_density(false) && black.sample(false, [0.5; 2]).is_none());
    assert!(
        Panorama::new([0, 0], Vec::new(), WORLD).is_none()
            && Panorama::new([2, 2], vec![[0.0; 3]], WORLD).is_none()
    );
}
