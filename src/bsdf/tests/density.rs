//! Samples follow the density: χ² over the sphere, and over rings around lobes that are narrower than its cells.

use super::*;
use crate::math::chi_square::deviate;
use crate::math::{DVec3, Frame};
use rayon::prelude::*;
use std::f64::consts::{PI, TAU};

/// Rows of cos θ and columns of φ: cells of equal solid angle of the sphere.
const ROWS: usize = 48;
const COLUMNS: usize = 32;

fn cell(wi: Vec3) -> usize {
    let row = (((wi.z + 1.0) * 0.5 * ROWS as f32) as usize).min(ROWS - 1);
    let turn = (f64::from(wi.y).atan2(f64::from(wi.x)) / TAU).rem_euclid(1.0);
    row * COLUMNS + ((turn * COLUMNS as f64) as usize).min(COLUMNS - 1)
}

/// The density's mass in every cell, by a midpoint grid within it.
fn masses(model: &dyn Scatter, view: &View) -> Vec<f64> {
    let fine = 16;
    let mut masses = vec![0.0; ROWS * COLUMNS];
    for (i, mass) in masses.iter_mut().enumerate() {
        let (row, column) = (i / COLUMNS, i % COLUMNS);
        for a in 0..fine {
            for b in 0..fine {
                let z = 2.0 * (row as f64 + (a as f64 + 0.5) / f64::from(fine)) / ROWS as f64 - 1.0;
                let phi = TAU * (column as f64 + (b as f64 + 0.5) / f64::from(fine)) / COLUMNS as f64;
                let r = (1.0 - z * z).sqrt();
                let wi = Vec3::new((r * phi.cos()) as f32, (r * phi.sin()) as f32, z as f32);
                *mass += f64::from(model.eval(view, wi).1);
            }
        }
        *mass *= 2.0 * TAU / (ROWS * COLUMNS) as f64 / f64::from(fine * fine);
    }
    masses
}

/// Judges samples of the part that is no delta against masses of cells.
fn judge(
    model: &Model,
    view: &View,
    samples: u32,
    masses: &[f64],
    cell: impl Fn(Vec3) -> usize,
) -> Result<(), String> {
    let total: f64 = masses.iter().sum();
    if total > 1.003 {
        return Err(format!("the density integrates to {total}"));
    }
    let mut counts = vec![0u32; masses.len()];
    for i in 0..samples {
        let (u, lobe) = random(i);
        let Some(s) = model.bsdf.sample(view, u, lobe) else { continue };
        if s.pdf == f32::INFINITY {
            continue;
        }
        if s.pdf <= 0.0 || !(s.wi.z > 0.0 || model.bsdf.transmits()) {
            return Err("a sample where the density is zero".into());
        }
        counts[cell(s.wi)] += 1;
    }
    let z = deviate(&counts, masses, f64::from(samples));
    if z >= 6.0 {
        return Err(format!("χ² deviates by {z} σ"));
    }
    let wrong: Vec<f64> = masses.iter().map(|m| m * 1.05).collect();
    let power = deviate(&counts, &wrong, f64::from(samples));
    // Where most samples are deltas, few are left to see it.
    if power < 6.0 && total > 0.5 {
        return Err(format!("the test would accept a density 5 % too high ({power} σ)"));
    }
    Ok(())
}

/// Runs `judge` on every model that `chosen` takes, from every side and several angles, and reports all that fail.
fn judge_all(
    chosen: impl Fn(&Model) -> bool + Sync,
    masses: impl Fn(&Model, &View) -> (Vec<f64>, Box<dyn Fn(Vec3) -> usize>) + Sync,
) {
    let all = models();
    let one = |model: &Model| {
        let mut wrong = Vec::new();
        for &outside in sides(model) {
            for degrees in [0.0, 40.0, 75.0] {
                let view = View { outside, ..view(degrees) };
                let (masses, cell) = masses(model, &view);
                if let Err(why) = judge(model, &view, 300_000, &masses, cell) {
                    wrong.push(format!("{} at {degrees}°, outside {outside}: {why}", model.what));
                }
            }
        }
        wrong
    };
    let tested = |m: &&Model| !m.bsdf.is_delta() && chosen(m);
    let wrong: Vec<String> = all.par_iter().filter(tested).flat_map(one).collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Models with lobes narrower than the cells of the sphere.
fn narrow(model: &Model) -> bool {
    [" 0.05", " 0.3"].iter().any(|end| model.what.ends_with(end))
}

#[test]
fn samples_follow_the_density() {
    judge_all(|m| !narrow(m), |m, view| (masses(m.bsdf.as_ref(), view), Box::new(cell)));
}

/// Rings and sectors around the lobe of either hemisphere.
const RINGS: usize = 56;
const SECTORS: usize = 16;
const FIRST: f64 = 1e-4;

/// The outer angle of ring `i`, which may be a fraction.
fn ring(i: f64) -> f64 {
    if i <= 0.0 { 0.0 } else { FIRST * (PI / FIRST).powf((i - 1.0).max(0.0) / (RINGS - 1) as f64) }
}

/// Around the lobe in front, and around the one behind.
fn axes(model: &Model, view: &View) -> [Frame; 2] {
    let eta = if view.outside { model.ior } else { 1.0 / model.ior };
    let (_, cos_t) = fresnel::dielectric(view.wo.z, eta);
    let refracted = Vec3::new(-view.wo.x / eta, -view.wo.y / eta, -cos_t).normalize();
    [Frame::new(reflect(view.wo)), Frame::new(refracted)]
}

fn ring_cell(axes: &[Frame; 2], wi: Vec3) -> usize {
    let side = usize::from(wi.z < 0.0);
    let local = axes[side].to_local(wi).as_dvec3();
    let angle = f64::hypot(local.x, local.y).atan2(local.z);
    let i =
        if angle < FIRST { 0.0 } else { 1.0 + (angle / FIRST).ln() / (PI / FIRST).ln() * (RINGS - 1) as f64 };
    let turn = (local.y.atan2(local.x) / TAU).rem_euclid(1.0);
    let sector = ((turn * SECTORS as f64) as usize).min(SECTORS - 1);
    (side * RINGS + (i as usize).min(RINGS - 1)) * SECTORS + sector
}

fn ring_masses(model: &Model, axes: &[Frame; 2], view: &View) -> Vec<f64> {
    let (fine, across) = (12, 8);
    let mut masses = vec![0.0; 2 * RINGS * SECTORS];
    for (cell, mass) in masses.iter_mut().enumerate() {
        let (side, i, sector) = (cell / SECTORS / RINGS, cell / SECTORS % RINGS, cell % SECTORS);
        let (low, high) = (ring(i as f64), ring(i as f64 + 1.0));
        for a in 0..fine {
            let angle = low + (high - low) * (f64::from(a) + 0.5) / f64::from(fine);
            for b in 0..across {
                let phi = TAU * (sector as f64 + (f64::from(b) + 0.5) / f64::from(across)) / SECTORS as f64;
                let (s, c) = angle.sin_cos();
                let wi = axes[side].to_world(DVec3::new(s * phi.cos(), s * phi.sin(), c).as_vec3());
                if (wi.z < 0.0) == (side == 1) {
                    *mass += f64::from(model.bsdf.eval(view, wi).1) * s;
                }
            }
        }
        *mass *= (high - low) * TAU / SECTORS as f64 / f64::from(fine * across);
    }
    masses
}

#[test]
fn samples_of_narrow_lobes_follow_the_density() {
    judge_all(narrow, |m, view| {
        let axes = axes(m, view);
        (ring_masses(m, &axes, view), Box::new(move |wi| ring_cell(&axes, wi)))
    });
}

#[test]
fn weights_are_f_cos_over_pdf() {
    for Model { what, bsdf: model, .. } in models().iter().filter(|m| !m.bsdf.is_delta()) {
        for degrees in [0.0, 30.0, 85.0, 89.9] {
            let view = view(degrees);
            for i in 0..2000 {
                let (u, lobe) = point(i);
                let Some(s) = model.sample(&view, u, lobe) else { continue };
                assert!((s.wi.length() - 1.0).abs() < 1e-5, "{what}");
                assert!(s.weight.is_finite() && s.weight.min_element() >= 0.0, "{what}: {}", s.weight);
                if s.pdf == f32::INFINITY {
                    continue;
                }
                let (f_cos, pdf) = model.eval(&view, s.wi);
                assert!((pdf / s.pdf - 1.0).abs() < 1e-3, "{what}: {pdf} and {}", s.pdf);
                assert!((s.weight * s.pdf - f_cos).length() <= 1e-3 * f_cos.length() + 1e-6, "{what}");
            }
        }
    }
}
