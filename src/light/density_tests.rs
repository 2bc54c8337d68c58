//! Samples of every light follow the density that it gives: χ² of 10⁶ samples over cells, no sample where the density is
//! zero, no density that integrates to more than 1, and none 2 % too high would pass.

use super::bounds::{Cone, LightBounds};
use super::distant::{Distant, Distants};
use super::panorama::Panorama;
use super::patch::Patch;
use super::tree::{LightTree, tests::lamps};
use super::{Directional, Environment, Light, Receiver, Sampled, Sphere, Sun};
use crate::math::chi_square::{judge, random};
use crate::math::{Aabb, Frame, Rgb, Vec3};
use crate::shape::Mesh;
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

const SAMPLES: u32 = 1_000_000;
const POWER: f64 = 1.02;

/// The index of `x` in [0, 1] among `n`.
fn index(x: f64, n: usize) -> usize {
    ((x * n as f64) as usize).min(n - 1)
}

fn map(size: [usize; 2], f: impl Fn(usize, usize) -> f32) -> Panorama {
    let texels = (0..size[0] * size[1]).map(|i| [f(i % size[0], i / size[0]); 3]).collect();
    Panorama::new(size, texels, [Vec3::X, Vec3::Y, Vec3::Z]).unwrap()
}

fn noise(x: usize, y: usize) -> f32 {
    let h = ((x * 73 + y * 151 + 7) as u32).wrapping_mul(0x9e37_79b9) >> 24;
    if h > 240 { 50.0 } else { h as f32 / 256.0 }
}

/// Counts and masses of a map in cells of half texels, in which a bilinear density is one polynomial and midpoints
/// integrate it exactly.
fn of_map(m: &Panorama, size: [usize; 2], compensated: bool) -> (Vec<u32>, Vec<f64>) {
    let [columns, rows] = size.map(|n| 2 * n);
    let fine = 3;
    let mut masses = vec![0.0; columns * rows];
    for (i, mass) in masses.iter_mut().enumerate() {
        for k in 0..fine * fine {
            let within = |k: usize| (k as f64 + 0.5) / fine as f64;
            let u = (within(k % fine) + (i % columns) as f64) / columns as f64;
            let v = (within(k / fine) + (i / columns) as f64) / rows as f64;
            let (sin, cos) = (PI * v).sin_cos();
            let d = Vec3::new((sin * (TAU * u).sin()) as f32, cos as f32, -(sin * (TAU * u).cos()) as f32);
            *mass += f64::from(m.pdf(compensated, d)) * sin;
        }
        *mass *= 2.0 * PI * PI / (fine * fine * columns * rows) as f64;
    }
    let mut counts = vec![0; columns * rows];
    for i in 0..SAMPLES {
        let (wi, pdf, _) = m.sample(compensated, random(i).0).unwrap();
        assert!(pdf > 0.0);
        let d = wi.as_dvec3();
        let u = (d.x.atan2(-d.z) / TAU).rem_euclid(1.0);
        let v = f64::hypot(d.x, d.z).atan2(d.y) / PI;
        counts[index(v, rows) * columns + index(u, columns)] += 1;
    }
    (counts, masses)
}

#[test]
fn image_environments() {
    let sun = |x: usize, y: usize| if (x, y) == (31, 2) { 1e3 } else { 1.0 };
    for (name, size, m) in [
        ("noise", [24, 12], map([24, 12], noise)),
        ("a small sun", [32, 16], map([32, 16], sun)),
        ("two columns", [2, 1], map([2, 1], |x, _| x as f32)),
        ("odd", [5, 3], map([5, 3], noise)),
    ] {
        for compensated in [false, true] {
            let (counts, masses) = of_map(&m, size, compensated);
            judge(&counts, &masses, SAMPLES, POWER).unwrap_or_else(|e| panic!("{name} {compensated}: {e}"));
        }
    }
}

/// Rings of equal solid angle times sectors around `axis`, in a cap of height `height` = 1 − cos, and one cell beyond.
struct Cap {
    frame: Frame,
    height: f64,
}

impl Cap {
    const N: usize = 24;

    fn new(axis: Vec3, height: f64) -> Cap {
        Cap { frame: Frame::new(axis), height }
    }

    fn cell(&self, wi: Vec3) -> usize {
        let d = self.frame.to_local(wi).as_dvec3();
        let sin2 = d.x * d.x + d.y * d.y;
        let height = if d.z > 0.0 { sin2 / (1.0 + (1.0 - sin2).max(0.0).sqrt()) } else { 1.0 - d.z };
        // What rounding puts on the rim belongs to the cap: f32 knows directions to 1e-6.
        if height > self.height * 1.0001 + 1e-6 * (2.0 * self.height).sqrt() {
            return Cap::N * Cap::N;
        }
        let turn = (d.y.atan2(d.x) / TAU).rem_euclid(1.0);
        index(height / self.height, Cap::N) * Cap::N + index(turn, Cap::N)
    }

    /// Masses of a density that is `pdf` in the cap and nothing beyond.
    fn masses(&self, pdf: f64) -> Vec<f64> {
        let cells = Cap::N * Cap::N;
        let mut masses = vec![pdf * TAU * self.height / cells as f64; cells];
        masses.push(0.0);
        masses
    }

    fn judge(&self, pdf: f64, sample: impl Fn([f32; 2]) -> Vec3) -> Result<(), String> {
        let mut counts = vec![0; Cap::N * Cap::N + 1];
        (0..SAMPLES).for_each(|i| counts[self.cell(sample(random(i).0))] += 1);
        judge(&counts, &self.masses(pdf), SAMPLES, POWER)
    }
}

#[test]
fn the_sun() {
    for sin_radius in [4.65e-3f32, 0.3, 0.9] {
        let sun = Sun { direction: Vec3::new(0.48, 0.6, -0.64), radiance: Rgb::ONE, sin_radius };
        let sin2 = f64::from(sin_radius).powi(2);
        let cap = Cap::new(sun.direction, sin2 / (1.0 + (1.0 - sin2).sqrt()));
        let pdf = 1.0 / f64::from(sun.solid_angle());
        cap.judge(pdf, |u| sun.sample(u)).unwrap_or_else(|e| panic!("{sin_radius}: {e}"));
    }
}

#[test]
fn spheres() {
    let ball = Sphere { center: Vec3::new(1.0, 2.0, 3.0), radius: 0.5, radiance: Rgb::ONE };
    for distance in [0.51f32, 0.8, 3.0, 100.0] {
        let from = ball.center - Vec3::new(0.6, 0.0, 0.8) * distance;
        let sin2 = (f64::from(ball.radius) / f64::from((ball.center - from).length())).powi(2);
        let cap = Cap::new((ball.center - from).normalize(), sin2 / (1.0 + (1.0 - sin2).sqrt()));
        let sample = |u| ball.sample(from, u).unwrap().0;
        cap.judge(ball.pdf(from).into(), sample).unwrap_or_else(|e| panic!("{distance}: {e}"));
    }
}

/// Rectangle and triangle, near (by solid angle) and far (by area): the density times cos θ/d² over cells of the lamp,
/// x = 2a, and y = b or, of the triangle, y = a·b.
#[test]
fn rectangles_and_triangles() {
    let points = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    let mesh = Mesh::new(points.to_vec(), vec![[0, 1, 2], [0, 2, 3]]);
    const N: usize = 20;
    for (rectangle, from) in [true, false].into_iter().flat_map(|rectangle| {
        [[0.3, 0.4, 0.3], [1.0, 0.5, 1.5], [-1.0, 3.0, 0.7], [4.0, 4.0, -3.0], [9.0, -9.0, 20.0]]
            .map(|from| (rectangle, Vec3::from(from)))
    }) {
        let patch = Patch::new(&mesh, 0, rectangle).unwrap();
        let height = |a: f64| if rectangle { 1.0 } else { a };
        // (density per solid angle, cos θ/d²) at a point.
        let at = |p: Vec3| {
            let to = p - from;
            let (d2, cos) = (to.length_squared(), to.z.abs() / to.length());
            (patch.pdf(from, d2, cos), f64::from(cos / d2))
        };
        let fine = 16;
        let mut masses = vec![0.0; N * N];
        for (i, mass) in masses.iter_mut().enumerate() {
            for k in 0..fine * fine {
                let place = |i: usize, k: usize| (i as f64 + (k as f64 + 0.5) / fine as f64) / N as f64;
                let (a, b) = (place(i % N, k % fine), place(i / N, k / fine));
                let (pdf, share) = at(Vec3::new(2.0 * a as f32, (b * height(a)) as f32, 0.0));
                *mass += f64::from(pdf) * share * 2.0 * height(a);
            }
            *mass /= (fine * fine * N * N) as f64;
        }
        let mut counts = vec![0; N * N];
        for i in 0..SAMPLES {
            let point = patch.sample(from, random(i).0);
            if let Some(pdf) = point.by_solid_angle {
                assert_eq!(pdf, at(point.p).0, "asked of the other end");
            }
            let a = f64::from(point.p.x) / 2.0;
            counts[index(f64::from(point.p.y) / height(a).max(1e-9), N) * N + index(a, N)] += 1;
        }
        judge(&counts, &masses, SAMPLES, POWER)
            .unwrap_or_else(|e| panic!("rectangle {rectangle} from {from}: {e}"));
    }
}

/// The tree's choices among lamps of all strengths, sizes and directions.
#[test]
fn choices_of_the_light_tree() {
    let lamps = lamps(300);
    let tree = LightTree::new(&lamps);
    for (p, normal) in [
        (Vec3::splat(5.0), Receiver::ALL_AROUND),
        (Vec3::splat(5.0), Receiver::pack(Vec3::new(0.6, 0.0, 0.8))),
        (Vec3::new(-9.0, 3.0, 14.0), Receiver::pack(Vec3::X)),
    ] {
        let to = Receiver::new(p, normal);
        let masses: Vec<f64> = (0..300).map(|i| f64::from(tree.probability(i, &to))).collect();
        let mut counts = vec![0; 300];
        for i in 0..SAMPLES {
            let ([a, b], _) = random(i);
            let Some((light, chance)) = tree.sample(&to, f64::from(a) + f64::from(b) / 16_777_216.0) else {
                continue;
            };
            assert!((f64::from(chance) / masses[light as usize] - 1.0).abs() < 1e-5);
            counts[light as usize] += 1;
        }
        judge(&counts, &masses, SAMPLES, POWER).unwrap_or_else(|e| panic!("at {p}: {e}"));
    }
}

/// The choice between what shines from infinity, and between that and the lamps with a place.
#[test]
fn choices_at_infinity() {
    let sun =
        |direction, radiance| Light::Sun(Sun { direction, radiance: Rgb::splat(radiance), sin_radius: 0.1 });
    let sky = Environment::Panorama(Arc::new(map([8, 4], noise)));
    let parallel = Directional { direction: -Vec3::Y, irradiance: Rgb::splat(2.0) };
    let lights = [
        sun(Vec3::Y, 100.0),
        sun(Vec3::X, 30.0),
        sun(-Vec3::Y, 500.0),
        Light::Environment(sky),
        Light::Directional(parallel),
    ];
    let all = Distants::new(&lights, Sampled { alone: false, deltas: true });
    let lamp = LightBounds {
        bounds: Aabb::EMPTY.grow(Vec3::ONE).grow(Vec3::splat(1.1)),
        cone: Cone::ALL,
        two_sided: false,
        strength: 3.0,
    };
    let tree = LightTree::new(&[lamp]);
    for packed in [Receiver::pack(Vec3::new(0.6, 0.8, 0.0)), Receiver::ALL_AROUND] {
        let to = Receiver::new(Vec3::ZERO, packed);
        let places = [
            Distant::Sun(0),
            Distant::Sun(1),
            Distant::Sun(2),
            Distant::Environment,
            Distant::Directional(0),
        ];
        let mut masses: Vec<f64> = places.iter().map(|d| f64::from(all.chance(*d, &tree, &to))).collect();
        masses.push(all.share_of_others(&tree, &to).into());
        let mut counts = vec![0; masses.len()];
        for i in 0..SAMPLES {
            let (light, chance, _) = all.choose(&tree, &to, random(i).1.into()).unwrap();
            let place = light.and_then(|l| places.iter().position(|p| *p == l)).unwrap_or(places.len());
            assert!((f64::from(chance) / masses[place] - 1.0).abs() < 1e-5);
            counts[place] += 1;
        }
        judge(&counts, &masses, SAMPLES, POWER).unwrap();
    }
}
