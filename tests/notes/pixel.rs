//! The pixel as an integral: 13.1, 13.4, eq. (5)–(14), under the box and under a Gaussian.

use crate::harness::{Stage, obj, on_every_backend, stage};
use drt::accel::Backend;
use drt::math::DVec3;

/// A black plane under an orthographic camera of one metre a pixel, 4×4 pixels, with white (emitting) rectangles
/// [x0, x1] × [y0, y1] in pixels from the upper left corner.
fn plane(white: &[[f64; 4]], backend: Backend, set: &[&str]) -> Stage {
    let toml = "[camera]\ntype = \"orthographic\"\nheight = 4\nposition = [0, 0, 5]\nlook_at = [0, 0, 0]\n\
                [film]\nsize = [4, 4]\n[render]\nspp = 1\nmax_depth = 0\n\
                [[mesh]]\nfile = \"white.obj\"\nmaterial = \"w\"\n[materials.w]\nemission = 1\n";
    let rectangle = |[x0, x1, y0, y1]: &[f64; 4]| {
        vec![
            [x0 - 2.0, 2.0 - y1, 0.0],
            [x1 - 2.0, 2.0 - y1, 0.0],
            [x1 - 2.0, 2.0 - y0, 0.0],
            [x0 - 2.0, 2.0 - y0, 0.0],
        ]
    };
    let polygons: Vec<Vec<[f64; 3]>> = white.iter().map(rectangle).collect();
    stage(toml, &[("white.obj", obj(&polygons))], backend, set)
}

/// White to the right of x = 1.3 px.
const EDGE: [[f64; 4]; 1] = [[1.3, 9.0, -5.0, 9.0]];

/// A checkerboard of squares of one pixel, shifted by 0.31 to the right and 0.17 down.
fn checkerboard() -> Vec<[f64; 4]> {
    let cells = (-4..8).flat_map(|i| (-4..8).map(move |j| (i, j))).filter(|(i, j)| (i + j) % 2 == 0);
    cells
        .map(|(i, j)| (f64::from(i) + 0.31, f64::from(j) + 0.17))
        .map(|(x, y)| [x, x + 1.0, y, y + 1.0])
        .collect()
}

const GAUSSIAN: &str = "film.filter={ type = \"gaussian\", sigma = 0.5, radius = 1.5 }";

/// ∫ of the truncated Gaussian from −1.5 to x, over all of it.
fn share(x: f64) -> f64 {
    let erf = |x: f64| libm::erf(x.clamp(-1.5, 1.5) / (0.5 * 2f64.sqrt()));
    (erf(x) + erf(1.5)) / (2.0 * erf(1.5))
}

fn boxed(x: f64) -> f64 {
    (x + 0.5).clamp(0.0, 1.0)
}

/// The filter's integral over the white rectangles, for pixel (column, row).
fn exact(white: &[[f64; 4]], [column, row]: [usize; 2], share: fn(f64) -> f64) -> f64 {
    let (cx, cy) = (column as f64 + 0.5, row as f64 + 0.5);
    let one =
        |[x0, x1, y0, y1]: &[f64; 4]| (share(x1 - cx) - share(x0 - cx)) * (share(y1 - cy) - share(y0 - cy));
    white.iter().map(one).sum()
}

/// Random, importance, stratified, jittered and Sobol points: the mean of pixel (1, 1) is the integral.
#[test]
fn means_of_unbiased_rules_are_the_integral() {
    let rules = [
        "\"sampler\"",
        "\"random\"",
        "\"importance\"",
        "{ type = \"stratified\", grid = [5, 3], per_cell = 4 }",
        "{ type = \"stratified\", grid = [3, 2], per_cell = 8 }",
        "{ type = \"nonuniform\", grid = [4, 3], per_cell = 2 }",
    ];
    on_every_backend(|backend| {
        for (name, white) in [("edge", EDGE.to_vec()), ("checkerboard", checkerboard())] {
            for (filter, share) in
                [("film.filter=box", boxed as fn(f64) -> f64), (GAUSSIAN, share as fn(f64) -> f64)]
            {
                for rule in rules {
                    let rule = format!("film.rule={rule}");
                    // One pixel says little: the mean over 1600 seeds, by a stage that is built once.
                    let stage =
                        plane(&white, backend, &[filter, &rule, "render.spp=64", "film.crop=[1, 1, 1, 1]"]);
                    let mean = |seeds: std::ops::Range<u64>| {
                        let one =
                            |seed| f64::from(stage.render(|s| s.seed = seed).0.f32_channel("G").unwrap()[0]);
                        let n = (seeds.end - seeds.start) as f64;
                        seeds.map(one).sum::<f64>() / n
                    };
                    let blocks: Vec<f64> = (0..32).map(|b| mean(50 * b..50 * (b + 1))).collect();
                    let exact = exact(&white, [1, 1], share);
                    let found = crate::harness::Statistics::of(&blocks);
                    let off = (found.mean - exact).abs();
                    assert!(found.error < 0.004, "{name} {filter} {rule}: too noisy ({})", found.error);
                    assert!(
                        off <= 6.37 * found.error + 1e-4,
                        "{name} {filter} {rule}: {found:?} not {exact}"
                    );
                }
            }
        }
    });
}

/// A filter as the tests know it: its key, radius and unnormalised profile.
struct Known {
    key: &'static str,
    radius: f64,
    profile: fn(f64) -> f64,
}

const KNOWN: [Known; 2] = [
    Known { key: "film.filter=box", radius: 0.5, profile: |_| 1.0 },
    Known { key: GAUSSIAN, radius: 1.5, profile: |x| (-2.0 * x * x).exp() },
];

impl Known {
    /// h over its mean over the support, along one axis.
    fn density(&self, x: f64) -> f64 {
        let at = |i: i32| self.radius * (f64::from(i) / 1000.0 - 0.999_5);
        let mean = (0..2000).map(|i| (self.profile)(at(i))).sum::<f64>() / 2000.0;
        (self.profile)(x) / mean
    }

    /// Eq. (14) by hand for the pixel (column, row): M×N points weighted with h/∫h.
    fn sum_over_grid(&self, white: &[[f64; 4]], pixel: [i32; 2], [m, n]: [i32; 2], shift: f64) -> f64 {
        let at = |k: i32, cells: i32| self.radius * (2.0 * (f64::from(k) + shift) / f64::from(cells) - 1.0);
        let mut sum = 0.0;
        for (i, j) in (0..m).flat_map(|i| (0..n).map(move |j| (i, j))) {
            let (dx, dy) = (at(i, m), at(j, n));
            let (x, y) = (f64::from(pixel[0]) + 0.5 + dx, f64::from(pixel[1]) + 0.5 + dy);
            if white.iter().any(|[x0, x1, y0, y1]| (*x0..*x1).contains(&x) && (*y0..*y1).contains(&y)) {
                sum += self.density(dx) * self.density(dy);
            }
        }
        sum / f64::from(m * n)
    }
}

/// Deterministic grids show exactly the sum over their points.
#[test]
fn grids_are_the_sum_by_hand() {
    on_every_backend(|backend| {
        let white = checkerboard();
        for (m, n) in [(4, 4), (5, 3), (7, 16)] {
            for (name, shift) in [("uniform", 0.5), ("uniform-corner", 0.0)] {
                for filter in KNOWN {
                    let rule = format!("film.rule={{ type = \"{name}\", grid = [{m}, {n}] }}");
                    let (image, stats) = plane(&white, backend, &[filter.key, &rule]).render(|_| ());
                    assert_eq!(stats.camera_rays, 16 * (m * n) as u64, "{name} {m}×{n}");
                    for (i, shown) in image.f32_channel("G").unwrap().iter().enumerate() {
                        let pixel = [i as i32 % 4, i as i32 / 4];
                        let by_hand = filter.sum_over_grid(&white, pixel, [m, n], shift);
                        let off = (f64::from(*shown) - by_hand).abs();
                        assert!(
                            off < 2e-6,
                            "{name} {m}×{n} {}, {pixel:?}: {shown} not {by_hand}",
                            filter.key
                        );
                    }
                }
            }
        }
    });
}

/// A fine non-uniform grid has the integral as its limit.
#[test]
fn nonuniform_grids_converge() {
    on_every_backend(|backend| {
        let white = checkerboard();
        let rule = "film.rule={ type = \"nonuniform\", grid = [101, 97] }";
        let (image, _) = plane(&white, backend, &[GAUSSIAN, rule]).render(|_| ());
        for (pixel, shown) in image.f32_channel("G").unwrap().iter().enumerate() {
            let exact = exact(&white, [pixel % 4, pixel / 4], share);
            assert!((f64::from(*shown) - exact).abs() < 0.015, "pixel {pixel}: {shown} not {exact}");
        }
    });
}

/// Eq. (14) and eq. (11) agree on a constant, whatever M and N; the flux is the radiance times Δi·Δj.
#[test]
fn constants_are_exact_and_flux_is_radiance_times_area() {
    let sky = "[[light]]\ntype = \"environment\"\nradiance = 3.0\n";
    let cameras = [
        ("plane = { left = -1.5, right = 0.5, top = 0.75, bottom = -1.0, distance = 2 }", 2.0 * 1.75),
        ("fov = 60", (2.0 * (30f64).to_radians().tan()).powi(2) * 5.0 / 3.0),
        ("type = \"orthographic\"\nheight = 6", 36.0 * 5.0 / 3.0),
    ];
    on_every_backend(|backend| {
        for (camera, area) in cameras {
            let toml = format!(
                "[camera]\nposition = [0, 0, 5]\nlook_at = [0, 0, 0]\n{camera}\n[film]\nsize = [5, 3]\n[render]\nspp = 6\n{sky}"
            );
            for rule in
                ["sampler", "random", "importance", "uniform", "uniform-corner", "stratified", "nonuniform"]
            {
                let rule = format!("film.rule={rule}");
                let (radiance, _) = stage(&toml, &[], backend, &[&rule]).render(|_| ());
                let (flux, _) = stage(&toml, &[], backend, &[&rule, "film.quantity=flux"]).render(|_| ());
                let (radiance, flux) = (radiance.f32_channel("B").unwrap(), flux.f32_channel("B").unwrap());
                assert!(radiance.iter().all(|v| *v == 3.0), "{rule}");
                let pixel = area / 15.0;
                assert!(
                    flux.iter().all(|v| *v == (3.0 * pixel) as f32),
                    "{rule}: {} not {}",
                    flux[0],
                    3.0 * pixel
                );
                let sum: f64 = flux.iter().map(|v| f64::from(*v)).sum();
                assert!((sum - 3.0 * area).abs() < 1e-5, "{rule}: {sum}");
            }
        }
    });
}

/// Eq. (5) and 13.1: the ray through p(α, β) of `camera.plane`, by where it meets a wall.
#[test]
fn rays_pass_through_the_image_plane() {
    on_every_backend(|backend| {
        let toml = "[camera]\nposition = [0, 0, 5]\nlook_at = [0, 0, 0]\n\
                    plane = { left = -1, right = 3, top = 2, bottom = -1, distance = 2 }\n\
                    [film]\nsize = [4, 3]\nrule = \"uniform-corner\"\naov = [\"position\"]\n[render]\nspp = 1\n\
                    [[mesh]]\nfile = \"wall.obj\"\n[[light]]\ntype = \"environment\"\nradiance = 1\n";
        let wall =
            obj(&[vec![[-90.0, -90.0, 0.0], [90.0, -90.0, 0.0], [90.0, 90.0, 0.0], [-90.0, 90.0, 0.0]]]);
        let (image, _) = stage(toml, &[("wall.obj", wall)], backend, &[]).render(|_| ());
        let layer = |name: &str| image.f32_channel(name).unwrap().to_vec();
        let (x, y) = (layer("position.X"), layer("position.Y"));
        for pixel in 0..12 {
            // α_min and β_min (the upper border) of pixel (i, j); the wall is 5/2 as far as the plane.
            let (alpha, beta) = (-1.0 + (pixel % 4) as f64, 2.0 - (pixel / 4) as f64);
            let exact = DVec3::new(alpha, beta, 0.0) * 2.5;
            let shown = DVec3::new(f64::from(x[pixel]), f64::from(y[pixel]), 0.0);
            assert!((shown - exact).length() < 2e-5, "pixel {pixel}: {shown} not {exact}");
        }
    });
}
