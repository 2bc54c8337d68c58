//! What the backends cost: seconds of a build, millions of rays a second and core.
//!
//! `cargo bench --bench accel -- [TRIANGLES | FILE.obj] [BACKEND]`. Without a file, the mesh is a bumpy sphere.
//! Times are CPU seconds (of all threads for the build, of the one tracing thread for rays), since a
//! machine shared with others makes wall time meaningless.

use drt::accel::{Backend, BuildOptions, Coherence, Hits, Intersector, LANES, MISS, Mask, Quality, Rays};
use drt::math::{Aabb, Vec3};
use drt::shape::Mesh;
use rustix::time::{ClockId, clock_gettime};
use std::sync::Arc;

const RAYS: usize = 1 << 19;

fn main() {
    // `cargo bench` adds `--bench`, and `cargo test` runs benches without arguments worth obeying.
    let words: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with("--")).collect();
    let input = words.first().map_or("870000", |w| w.as_str());
    let mesh = match input.parse() {
        Ok(triangles) => bumpy_sphere(triangles),
        Err(_) => load(input),
    };
    let bounds = mesh.bounds();
    let triangles = mesh.indices.len();
    let meshes = [Arc::new(mesh)];
    println!("{triangles} triangles; Mrays/s: camera, first bounce, second bounce, shadow");
    for &backend in Backend::ALL.iter().filter(|b| words.get(1).is_none_or(|w| w == b.name())) {
        for quality in [Quality::Low, Quality::Medium] {
            let options = BuildOptions { quality, ..BuildOptions::default() };
            let start = cpu(ClockId::ProcessCPUTime);
            let built = backend.build(&meshes, &options).expect("builds");
            let seconds = cpu(ClockId::ProcessCPUTime) - start;
            let mib = built.bytes() >> 20;
            print!("{:8} {:6} build {seconds:6.2} s {mib:5} MiB ", backend.name(), quality.name());
            trace(&*built, bounds, &meshes[0]);
        }
    }
}

/// CPU seconds.
fn cpu(clock: ClockId) -> f64 {
    let t = clock_gettime(clock);
    t.tv_sec as f64 + t.tv_nsec as f64 * 1e-9
}

fn trace(built: &dyn Intersector, bounds: Aabb, mesh: &Mesh) {
    let camera = camera_rays(bounds);
    let (hits, speed) = closest(built, &camera, Coherence::Coherent);
    print!(" {speed:6.2}");
    let first = bounce(mesh, &camera, &hits);
    let (hits, speed) = closest(built, &first, Coherence::Incoherent);
    print!(" {speed:6.2}");
    let second = bounce(mesh, &first, &hits);
    let (_, speed) = closest(built, &second, Coherence::Incoherent);
    print!(" {speed:6.2}");
    let start = cpu(ClockId::ThreadCPUTime);
    let blocked: u32 =
        first.iter().map(|r| built.occluded(r.check(Mask::MAX), Coherence::Incoherent).count_ones()).sum();
    let seconds = cpu(ClockId::ThreadCPUTime) - start;
    println!(
        " {:6.2}   ({blocked} of {} blocked)",
        (first.len() * LANES) as f64 * 1e-6 / seconds,
        first.len() * LANES
    );
}

fn closest(built: &dyn Intersector, rays: &[Rays], coherence: Coherence) -> (Vec<Hits>, f64) {
    let mut hits = vec![Hits::default(); rays.len()];
    let start = cpu(ClockId::ThreadCPUTime);
    for (r, h) in rays.iter().zip(&mut hits) {
        built.closest(r.check(Mask::MAX), coherence, h);
    }
    let seconds = cpu(ClockId::ThreadCPUTime) - start;
    (hits, (rays.len() * LANES) as f64 * 1e-6 / seconds)
}

/// A picture of the whole in tiles of 4×4 pixels, a chunk a tile.
fn camera_rays(bounds: Aabb) -> Vec<Rays> {
    let side = (RAYS as f64).sqrt() as usize / 4 * 4;
    let eye = bounds.center() + bounds.extent().length() * Vec3::new(0.5, 0.4, 0.9);
    let forward = (bounds.center() - eye).normalize();
    let right = forward.cross(Vec3::Y).normalize();
    let up = right.cross(forward);
    let mut all = Vec::new();
    for tile in 0..side * side / LANES {
        let mut rays = Rays::default();
        for lane in 0..LANES {
            let x = tile % (side / 4) * 4 + lane % 4;
            let y = tile / (side / 4) * 4 + lane / 4;
            let s = |i: usize| (i as f32 + 0.5) / side as f32 * 0.8 - 0.4;
            rays.set(lane, eye, (forward + right * s(x) + up * s(y)).normalize(), 0.0, f32::INFINITY);
        }
        all.push(rays);
    }
    all
}

/// A cosine-distributed ray from every hit.
fn bounce(mesh: &Mesh, rays: &[Rays], hits: &[Hits]) -> Vec<Rays> {
    let mut random = Random(7);
    let mut all = Vec::new();
    let (mut chunk, mut lane) = (Rays::default(), 0);
    for (r, h) in rays.iter().zip(hits) {
        for i in (0..LANES).filter(|&i| h.mesh[i] != MISS) {
            let [a, b, c] = mesh.triangle(h.triangle[i] as usize);
            let n = (b - a).cross(c - a).normalize_or_zero();
            let n = if n.dot(r.d(i)) > 0.0 { -n } else { n };
            let p = r.o(i) + r.d(i) * h.t[i];
            let z = 1.0 - 2.0 * random.next();
            let (sin, cos) = (std::f32::consts::TAU * random.next()).sin_cos();
            let s = (1.0 - z * z).max(0.0).sqrt();
            let d = (n * 1.0001 + Vec3::new(s * cos, s * sin, z)).normalize();
            chunk.set(lane, p + n * p.abs().max_element() * 1e-5, d, 0.0, f32::INFINITY);
            lane += 1;
            if lane == LANES {
                all.push(std::mem::take(&mut chunk));
                lane = 0;
            }
        }
    }
    all
}

struct Random(u64);

impl Random {
    /// In [0, 1): Marsaglia's xorshift.
    fn next(&mut self) -> f32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 40) as f32 * (1.0 / (1 << 24) as f32)
    }
}

/// A sphere with bumps and dents, so that a bounce ray often hits.
fn bumpy_sphere(triangles: usize) -> Mesh {
    let rings = ((triangles as f64 / 4.0).sqrt() as usize).max(3);
    let around = 2 * rings;
    let mut positions = Vec::new();
    for i in 0..=rings {
        for j in 0..around {
            let theta = std::f32::consts::PI * i as f32 / rings as f32;
            let phi = std::f32::consts::TAU * j as f32 / around as f32;
            let r = 1.0
                + 0.15 * (9.0 * theta).sin() * (8.0 * phi).sin()
                + 0.03 * (41.0 * theta + 31.0 * phi.sin()).sin();
            positions.push([r * theta.sin() * phi.cos(), r * theta.cos(), r * theta.sin() * phi.sin()]);
        }
    }
    let mut indices = Vec::new();
    for i in 0..rings {
        for j in 0..around {
            let at = |i: usize, j: usize| (i * around + j % around) as u32;
            indices.push([at(i, j), at(i, j + 1), at(i + 1, j)]);
            indices.push([at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)]);
        }
    }
    Mesh::new(positions, indices)
}

fn load(path: &str) -> Mesh {
    let options = tobj::LoadOptions { triangulate: true, ..Default::default() };
    let (models, _) = tobj::load_obj(path, &options).expect("a readable OBJ file");
    let (mut positions, mut indices) = (Vec::new(), Vec::new());
    for model in &models {
        let base = positions.len() as u32;
        positions.extend(model.mesh.positions.chunks(3).map(|p| [p[0], p[1], p[2]]));
        indices.extend(model.mesh.indices.chunks(3).map(|t| [t[0] + base, t[1] + base, t[2] + base]));
    }
    Mesh::new(positions, indices)
}
