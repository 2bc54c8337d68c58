//! What is traced: named scenes, or files.

use crate::record::Random;
use drt::camera::{Aperture, Camera, CameraSpec, Projection};
use drt::error::{Error, Result};
use drt::load;
use drt::math::{Aabb, DVec3, Vec3};
use drt::shape::Mesh;
use std::f32::consts::{PI, TAU};
use std::path::Path;
use std::sync::Arc;

/// Meshes, where they are seen from, and where the light hangs.
pub struct Scene {
    /// What the user called it.
    pub name: String,
    /// The geometry.
    pub meshes: Vec<Arc<Mesh>>,
    /// The view.
    pub camera: Camera,
    /// Where shadow rays go.
    pub lamp: Vec3,
    /// Generations of bounce rays.
    pub bounces: usize,
    /// From how many of them shadow rays are sent.
    pub shadow_depths: usize,
}

impl Scene {
    fn new(name: &str, meshes: Vec<Mesh>, eye: Vec3, look_at: Vec3, fov: f64, lamp: Vec3) -> Result<Scene> {
        let camera = CameraSpec {
            projection: Projection::Perspective,
            position: eye.as_dvec3(),
            look_at: look_at.as_dvec3(),
            up: DVec3::Y,
            window: CameraSpec::fov_window(fov, [1, 1]),
            aperture: Aperture::default(),
            focus_distance: 1.0,
            shutter: [0.0; 2],
            motion: None,
            fps: 24.0,
        };
        Ok(Scene {
            name: name.to_string(),
            meshes: meshes.into_iter().map(Arc::new).collect(),
            camera: Camera::new(&camera, DVec3::ZERO)?,
            lamp,
            bounces: 2,
            shadow_depths: 1,
        })
    }

    /// The box around all meshes.
    pub fn bounds(&self) -> Aabb {
        self.meshes.iter().fold(Aabb::EMPTY, |all, mesh| all.union(mesh.bounds()))
    }

    /// How many triangles.
    pub fn triangles(&self) -> usize {
        self.meshes.iter().map(|mesh| mesh.indices.len()).sum()
    }
}

/// The scene of that name, or of that file.
pub fn by_name(name: &str) -> Result<Scene> {
    match (name, name.strip_prefix("sphere:").map(str::parse)) {
        (_, Some(Ok(triangles))) => {
            let eye = Vec3::new(1.7, 1.4, 3.1);
            Scene::new(name, vec![bumpy_sphere(triangles)], eye, Vec3::ZERO, 43.0, Vec3::new(-4.0, 6.0, 3.0))
        }
        (_, Some(Err(_))) => Err(Error::usage("expected sphere:N, N the number of triangles")),
        ("hall", _) => {
            let (eye, look_at) = (Vec3::new(0.6, 1.7, 6.0), Vec3::new(40.0, 7.0, 15.0));
            Scene::new(name, vec![hall()], eye, look_at, 75.0, Vec3::new(25.0, 6.0, 12.0))
        }
        ("instanced", _) => {
            let (eye, look_at) = (Vec3::new(-4.0, 14.0, -6.0), Vec3::new(9.0, 6.0, 9.0));
            Scene::new(name, copies(), eye, look_at, 55.0, Vec3::new(-5.0, 30.0, 5.0))
        }
        ("cornell", _) => {
            let box_file = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/cornell-box.toml");
            // Just under its lamp; four bounces: what a path does in a small room.
            let lamp = Vec3::new(0.278, 0.548, 0.2795);
            Ok(Scene { lamp, bounces: 4, shadow_depths: 4, ..from_file(name, box_file)? })
        }
        _ => from_file(name, name),
    }
}

/// A mesh or scene file with its own camera; the lamp hangs above the eye.
fn from_file(name: &str, path: &str) -> Result<Scene> {
    let scene = load::scene(Path::new(path), load::Options::default())?.scene;
    let up = 0.3 * scene.bounds().extent().length();
    let lamp = (scene.camera.position - scene.origin).as_vec3() + Vec3::Y * up;
    let camera = Camera::new(&scene.camera, scene.origin)?;
    Ok(Scene { name: name.to_string(), meshes: scene.meshes, camera, lamp, bounces: 2, shadow_depths: 1 })
}

/// A sphere with bumps and dents, so that a bounce ray often hits.
fn bumpy_sphere(triangles: usize) -> Mesh {
    let rings = ((triangles as f64 / 4.0).sqrt() as usize).max(3);
    let around = 2 * rings;
    let point = |i: usize, j: usize| {
        let (theta, phi) = (PI * i as f32 / rings as f32, TAU * j as f32 / around as f32);
        let r = 1.0
            + 0.15 * (9.0 * theta).sin() * (8.0 * phi).sin()
            + 0.03 * (41.0 * theta + 31.0 * phi.sin()).sin();
        [r * theta.sin() * phi.cos(), r * theta.cos(), r * theta.sin() * phi.sin()]
    };
    let positions = (0..=rings).flat_map(|i| (0..around).map(move |j| point(i, j))).collect();
    let at = |i: usize, j: usize| (i * around + j % around) as u32;
    let cell = |i: usize, j: usize| {
        [[at(i, j), at(i, j + 1), at(i + 1, j)], [at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)]]
    };
    let indices = (0..rings).flat_map(|i| (0..around).flat_map(move |j| cell(i, j))).collect();
    Mesh::new(positions, indices)
}

/// 8×8×8 turned copies of one mesh of 2000 triangles.
fn copies() -> Vec<Mesh> {
    let (one, mut random) = (bumpy_sphere(2000), Random(11));
    let copy = |i: usize| {
        let place = Vec3::new((i % 8) as f32, (i / 8 % 8) as f32, (i / 64) as f32) * 2.6;
        let (sin, cos) = (TAU * random.next()).sin_cos();
        let turn = |p: &[f32; 3]| {
            (Vec3::new(cos * p[0] - sin * p[1], sin * p[0] + cos * p[1], p[2]) + place).to_array()
        };
        Mesh::new(one.positions.iter().map(turn).collect(), one.indices.clone())
    };
    (0..512).map(copy).collect()
}

/// A hall of 50×14×24 m of 0.36 M long thin triangles: boards, fluted columns, and between them and under the roof
/// pipes, rods and braces. What trees of boxes like least: a triangle's box is mostly empty.
fn hall() -> Mesh {
    let mut hall = Strips { random: Random(13), ..Strips::default() };
    let [x, y, z] = [50.0, 14.0, 24.0];
    for i in 0..600 {
        let (near, far) = (z * i as f32 / 600.0, z * (i + 1) as f32 / 600.0);
        for level in [0.0, y] {
            hall.board([[0.0, level, near], [x, level, near], [x, level, far], [0.0, level, far]]);
        }
        let (near, far) = (x * i as f32 / 600.0, x * (i + 1) as f32 / 600.0);
        for side in [0.0, z] {
            hall.board([[near, 0.0, side], [near, y, side], [far, y, side], [far, 0.0, side]]);
        }
    }
    hall.board([[0.0, 0.0, 0.0], [0.0, y, 0.0], [0.0, y, z], [0.0, 0.0, z]]);
    hall.board([[x, 0.0, 0.0], [x, y, 0.0], [x, y, z], [x, 0.0, z]]);
    for i in 0..10 {
        for j in 0..4 {
            let foot = Vec3::new(5.0 * i as f32 + 2.5, 0.0, 6.0 * j as f32 + 3.0);
            hall.pipe(foot, foot + Vec3::Y * y, 0.45, 96);
        }
    }
    while hall.indices.len() < 360_000 {
        let at = hall.point(Vec3::new(0.0, 8.0, 0.0), Vec3::new(x, y, z));
        let low = hall.point(Vec3::new(0.0, 0.5, 0.0), Vec3::new(x, y, 1.5));
        hall.pipe(Vec3::new(0.0, at.y, at.z), Vec3::new(x, at.y, at.z), 0.04, 12);
        hall.pipe(Vec3::new(at.x, at.y, 0.0), Vec3::new(at.x, at.y, z), 0.03, 12);
        hall.pipe(Vec3::new(at.x, at.y, at.z), Vec3::new(at.x, y, at.z), 0.01, 8);
        hall.pipe(low, Vec3::new(low.x, y, low.z), 0.05, 12);
        hall.pipe(at, at + Vec3::new(5.0, 2.0, low.z - at.z * 0.2), 0.02, 8);
    }
    Mesh::new(hall.positions, hall.indices)
}

/// A mesh under construction.
#[derive(Default)]
struct Strips {
    positions: Vec<[f32; 3]>,
    indices: Vec<[u32; 3]>,
    random: Random,
}

impl Strips {
    /// Somewhere between two corners of a box.
    fn point(&mut self, from: Vec3, to: Vec3) -> Vec3 {
        let share = Vec3::new(self.random.next(), self.random.next(), self.random.next());
        from + (to - from) * share
    }

    fn board(&mut self, corners: [[f32; 3]; 4]) {
        let first = self.positions.len() as u32;
        self.positions.extend(corners);
        self.indices.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
    }

    /// Two triangles a side, as long as the pipe.
    fn pipe(&mut self, from: Vec3, to: Vec3, radius: f32, sides: u32) {
        let (right, up) = (to - from).normalize().any_orthonormal_pair();
        let first = self.positions.len() as u32;
        for i in 0..sides {
            let (sin, cos) = (TAU * i as f32 / sides as f32).sin_cos();
            let out = (right * cos + up * sin) * radius;
            self.positions.extend([(from + out).to_array(), (to + out).to_array()]);
            let [a, b] = [first + 2 * i, first + 2 * ((i + 1) % sides)];
            self.indices.extend([[a, b, a + 1], [b, b + 1, a + 1]]);
        }
    }
}
