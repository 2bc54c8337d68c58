//! Renders through the library: a sphere of triangles on a floor under a lamp and a dim sky.
//!
//! `cargo run --release --example library -- picture.png`

use drt::accel::Intersector;
use drt::bsdf::fresnel::Reflectance;
use drt::bsdf::{Bsdf, Conductor, Material};
use drt::camera::{Aperture, CameraSpec, Projection};
use drt::error::Result;
use drt::light::{Environment, Light};
use drt::math::{DVec3, Rgb};
use drt::output;
use drt::render::{Hooks, build, render};
use drt::scene::{Scene, Settings};
use drt::shape::{FaceMaterials, Instances, Mesh};
use std::f32::consts::{PI, TAU};
use std::path::PathBuf;
use std::sync::Arc;

fn main() -> Result<()> {
    let path = std::env::args_os().nth(1).map_or_else(|| PathBuf::from("library.png"), PathBuf::from);
    output::check_path(&path)?;
    let settings = Settings { size: [480, 320], spp: 64, ..Settings::default() };
    let scene = scene(settings.size);
    let accel: Box<dyn Intersector> = build(&scene, &settings, None, &Hooks::NONE)?;
    let rendering = render(&scene, &settings, accel.as_ref(), None, &Hooks::NONE)?;
    output::write(&path, &rendering.image, &output::Options::default())?;
    println!("{} bounce rays; wrote {}", rendering.stats.bounce_rays, path.display());
    Ok(())
}

/// Plain data: meshes name materials by index.
fn scene(size: [u32; 2]) -> Scene {
    let mut lamp = Material::diffuse("lamp", Rgb::ZERO);
    lamp.emission = Rgb::splat(12.0);
    let gold = Reflectance::Constant(Rgb::new(1.0, 0.71, 0.29));
    let ball = Material {
        bsdf: Bsdf::Conductor(Conductor::new(gold, 0.15, true)),
        ..Material::diffuse("gold", Rgb::ZERO)
    };
    Scene {
        origin: DVec3::ZERO,
        meshes: vec![
            Arc::new(quad([[-6.0, 0.0, 6.0], [6.0, 0.0, 6.0], [6.0, 0.0, -6.0], [-6.0, 0.0, -6.0]], 0)),
            Arc::new(quad([[-1.0, 4.0, -1.0], [1.0, 4.0, -1.0], [1.0, 4.0, 1.0], [-1.0, 4.0, 1.0]], 1)),
            Arc::new(sphere([0.0, 1.0, 0.0], 1.0, 2)),
        ],
        instances: Instances::default(),
        materials: vec![Material::diffuse("floor", Rgb::splat(0.6)), lamp, ball],
        lights: vec![Light::Environment(Environment::Constant(Rgb::splat(0.25)))],
        camera: CameraSpec {
            projection: Projection::Perspective,
            position: DVec3::new(0.0, 2.2, 6.0),
            look_at: DVec3::new(0.0, 0.9, 0.0),
            up: DVec3::Y,
            window: CameraSpec::fov_window(36.0, size),
            aperture: Aperture::default(),
            focus_distance: 6.0,
            shutter: [0.0; 2],
            motion: None,
            fps: 24.0,
        },
    }
}

fn quad(corners: [[f32; 3]; 4], material: u32) -> Mesh {
    let mut mesh = Mesh::new(corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]]);
    mesh.materials = FaceMaterials::Uniform(material);
    mesh
}

fn sphere(center: [f32; 3], radius: f32, material: u32) -> Mesh {
    let (rows, columns) = (64u32, 128u32);
    let at = |row: u32, column: u32| {
        let (theta, phi) = (PI * row as f32 / rows as f32, TAU * column as f32 / columns as f32);
        let direction = [theta.sin() * phi.sin(), theta.cos(), theta.sin() * phi.cos()];
        [0, 1, 2].map(|i| center[i] + radius * direction[i])
    };
    let positions = (0..=rows).flat_map(|r| (0..columns).map(move |c| at(r, c))).collect();
    let cell = |r: u32, c: u32| {
        let (a, b) = (r * columns + c, r * columns + (c + 1) % columns);
        [[a, a + columns, b], [b, a + columns, b + columns]]
    };
    let indices = (0..rows).flat_map(|r| (0..columns).flat_map(move |c| cell(r, c))).collect();
    let mut mesh = Mesh::new(positions, indices);
    mesh.materials = FaceMaterials::Uniform(material);
    mesh
}
