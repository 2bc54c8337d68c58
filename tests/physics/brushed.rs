//! Brushed metals: which way their highlights are long, against GGX's formula in the axes of the texture coordinates.

use crate::harness::{on_every_backend, sheet, stage};
use std::f64::consts::PI;

type Vector = [f64; 3];

fn dot(a: Vector, b: Vector) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// f·cos θi of a perfectly reflecting surface at z = 0 with width `alpha[0]` along `x` and `alpha[1]` along `y`, single
/// scattering with height-correlated shadowing (Heitz 2014).
fn reflected(wo: Vector, wi: Vector, [x, y]: [Vector; 2], alpha: [f64; 2]) -> f64 {
    let sum: Vector = [0, 1, 2].map(|i| wo[i] + wi[i]);
    let h = sum.map(|c| c / dot(sum, sum).sqrt());
    let stretch = |w: Vector, [a, b]: [f64; 2]| (dot(w, x) * a).powi(2) + (dot(w, y) * b).powi(2);
    let d = 1.0 / (PI * alpha[0] * alpha[1] * (stretch(h, alpha.map(|a| 1.0 / a)) + h[2] * h[2]).powi(2));
    let lambda = |w: Vector| 0.5 * ((1.0 + stretch(w, alpha) / (w[2] * w[2])).sqrt() - 1.0);
    d / (4.0 * wo[2].abs() * (1.0 + lambda(wo) + lambda(wi)))
}

/// A square at z = 0 whose u grows along `u`, and v along `v`.
fn square([u, v]: [Vector; 2]) -> String {
    let mut text = String::new();
    for corner in [[-2.0, -2.0, 0.0], [2.0, -2.0, 0.0], [2.0, 2.0, 0.0], [-2.0, 2.0, 0.0]] {
        let [x, y, z] = corner;
        text += &format!("v {x} {y} {z}\nvt {} {}\n", 0.1 * dot(corner, u), 0.3 * dot(corner, v));
    }
    text + "f 1/1 2/2 3/3\nf 1/1 3/3 4/4\n"
}

#[test]
fn highlights_lie_along_the_texture_coordinates() {
    let to_light: Vector = [0.36, 0.48, 0.8];
    // View, turn of u, mirrored v, the material's turn; from above and from below.
    for (view, turn, mirrored, rotation) in [
        (0.0, 0.0, false, 0.0),
        (40.0, 35.0, false, 0.0),
        (40.0, 35.0, true, 0.0),
        (40.0, 35.0, false, 50.0),
        (40.0, 35.0, true, 50.0),
        (140.0, 35.0, false, 50.0),
        (140.0, -70.0, true, 125.0),
    ] {
        let (s, c) = f64::to_radians(turn).sin_cos();
        let side = if mirrored { -1.0 } else { 1.0 };
        let [u, v] = [[c, s, 0.0], [-s * side, c * side, 0.0]];
        let (s, c) = f64::to_radians(rotation).sin_cos();
        let axes = [[0, 1, 2].map(|i| u[i] * c + v[i] * s), [0, 1, 2].map(|i| v[i] * c - u[i] * s)];
        let (s, c) = f64::to_radians(view).sin_cos();
        let wi = [to_light[0], to_light[1], to_light[2].copysign(c)];
        let exact = 2.0 * reflected([s, 0.0, c], wi, axes, [0.5, 0.15]);
        // Both ways to say it: 1 − 0.9·a = 0.3, and α² = 0.5·0.15.
        for width in ["alpha_x = 0.5\nalpha_y = 0.15", "alpha = 0.273861279\nanisotropy = 0.777777778"] {
            let rest = format!(
                "[[light]]\ntype = \"directional\"\ndirection = [{}, {}, {}]\nirradiance = 2.0\n\
                 [materials.m]\ntype = \"conductor\"\nreflectance = 1.0\ncompensate = false\n\
                 anisotropy_rotation = {rotation}\n{width}\n",
                -wi[0], -wi[1], -wi[2]
            );
            on_every_backend(|backend| {
                let stage = stage(&sheet(view, 1, 1, &rest), &[("sheet.obj", square([u, v]))], backend, &[]);
                let (image, _) = stage.render(|_| ());
                for value in image.f32_channel("G").unwrap() {
                    let off = (f64::from(*value) / exact - 1.0).abs();
                    assert!(
                        off < 1e-3,
                        "view {view}, u {turn}, {mirrored}, {rotation}: {value}, not {exact}"
                    );
                }
            });
        }
    }
}
