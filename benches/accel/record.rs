//! Rays as a renderer sends them, recorded once for all contestants.

use crate::scenes::Scene;
use drt::accel::{Backend, BuildOptions, Coherence, Hits, Intersector, LANES, MISS, Mask, Rays};
use drt::math::Vec3;

/// Rays of one kind, in full chunks.
pub struct RaySet {
    /// The kind's name.
    pub name: String,
    /// Only asks whether anything is hit.
    pub any_hit: bool,
    /// What a renderer would say of them.
    pub coherence: Coherence,
    /// The rays; every lane is one.
    pub chunks: Vec<Rays>,
}

impl RaySet {
    fn closest(name: String, coherence: Coherence, chunks: Vec<Rays>) -> Self {
        RaySet { name, any_hit: false, coherence, chunks }
    }

    fn any_hit(name: String, chunks: Vec<Rays>) -> Self {
        RaySet { name, any_hit: true, coherence: Coherence::Incoherent, chunks }
    }

    /// How many rays.
    pub fn len(&self) -> usize {
        self.chunks.len() * LANES
    }
}

/// Ambient occlusion looks this share of the scene's diagonal far.
const OCCLUSION_REACH: f32 = 0.05;

/// So many times the picture is traced at most, to get enough rays of the later generations.
const PASSES: usize = 16;

/// About `rays` rays of each kind: camera rays in tiles, diffuse bounces, ambient occlusion around the first hits, and
/// shadow rays to the lamp from where bounces start. Fewer where few hit anything.
pub fn record(scene: &Scene, rays: usize) -> Vec<RaySet> {
    let built = Backend::ALL[0].build(&scene.meshes, &BuildOptions::default()).expect("builds");
    let mut random = Random(7);
    let mut sets = pass(scene, &*built, &mut random, rays);
    let enough = sets[0].chunks.len();
    for _ in 1..PASSES {
        if sets.iter().all(|set| set.chunks.len() >= enough) {
            break;
        }
        for (set, more) in sets.iter_mut().zip(pass(scene, &*built, &mut random, rays)) {
            set.chunks.extend(more.chunks);
            set.chunks.truncate(enough);
        }
    }
    sets.retain(|set| !set.chunks.is_empty());
    sets
}

/// One picture.
fn pass(scene: &Scene, built: &dyn Intersector, random: &mut Random, rays: usize) -> Vec<RaySet> {
    let mut last = camera_rays(scene, random, rays);
    let mut closest = vec![RaySet::closest("camera".to_string(), Coherence::Coherent, last.clone())];
    let mut any_hit = Vec::new();
    for depth in 1..=scene.bounces {
        let points = points(scene, built, &last);
        if depth == 1 {
            let reach = OCCLUSION_REACH * scene.bounds().extent().length();
            let chunks = bounce_rays(&points, random, reach);
            any_hit.push(RaySet::any_hit("occlusion".to_string(), chunks));
        }
        if depth <= scene.shadow_depths {
            any_hit.push(RaySet::any_hit(format!("shadow {depth}"), shadow_rays(&points, scene.lamp)));
        }
        last = bounce_rays(&points, random, f32::INFINITY);
        closest.push(RaySet::closest(format!("bounce {depth}"), Coherence::Incoherent, last.clone()));
    }
    closest.into_iter().chain(any_hit).collect()
}

/// A point on a surface, just off it on the ray's side.
struct Point {
    position: Vec3,
    normal: Vec3,
}

/// Where rays hit, in their order.
fn points(scene: &Scene, built: &dyn Intersector, chunks: &[Rays]) -> Vec<Point> {
    let mut points = Vec::new();
    let mut hits = Hits::default();
    for rays in chunks {
        built.closest(rays.check(Mask::MAX), Coherence::Incoherent, &mut hits);
        for lane in (0..LANES).filter(|&lane| hits.mesh[lane] != MISS) {
            let [a, b, c] = scene.meshes[hits.mesh[lane] as usize].triangle(hits.triangle[lane] as usize);
            let normal = (b - a).cross(c - a).normalize_or_zero();
            let normal = if normal.dot(rays.d(lane)) > 0.0 { -normal } else { normal };
            let position = rays.o(lane) + rays.d(lane) * hits.t[lane];
            let offset = position.abs().max_element().max(hits.t[lane]) * 1e-5;
            points.push(Point { position: position + normal * offset, normal });
        }
    }
    points
}

/// A square picture in tiles of 4×4 pixels, a chunk a tile, a ray somewhere in each pixel.
fn camera_rays(scene: &Scene, random: &mut Random, rays: usize) -> Vec<Rays> {
    let tiles = (((rays / LANES) as f64).sqrt() as usize).max(1);
    let side = (4 * tiles) as f32;
    let mut tile = |tile: usize| {
        let mut chunk = Rays::default();
        for lane in 0..LANES {
            let (x, y) = (tile % tiles * 4 + lane % 4, tile / tiles * 4 + lane / 4);
            let (x, y) = (x as f32 + random.next(), y as f32 + random.next());
            let ray = scene.camera.ray(x / side, y / side, [0.5; 2], 0.0);
            chunk.set(lane, ray.o, ray.d, 0.0, f32::INFINITY);
        }
        chunk
    };
    (0..tiles * tiles).map(&mut tile).collect()
}

/// A cosine-distributed ray from every point.
fn bounce_rays(points: &[Point], random: &mut Random, tmax: f32) -> Vec<Rays> {
    chunks(points.iter().map(|point| {
        let z = 1.0 - 2.0 * random.next();
        let (sin, cos) = (std::f32::consts::TAU * random.next()).sin_cos();
        let s = (1.0 - z * z).max(0.0).sqrt();
        // Normal plus a point of the unit sphere: Lambert's cosine; slightly longer, so that it is never zero.
        let d = (point.normal * 1.0001 + Vec3::new(s * cos, s * sin, z)).normalize();
        (point.position, d, tmax)
    }))
}

/// From every point that faces the lamp, nearly to the lamp.
fn shadow_rays(points: &[Point], lamp: Vec3) -> Vec<Rays> {
    let facing = points.iter().filter(|point| point.normal.dot(lamp - point.position) > 0.0);
    chunks(facing.map(|point| {
        let way = lamp - point.position;
        (point.position, way.normalize(), way.length() * 0.9999)
    }))
}

/// Origins, directions and ends as full chunks; a last one that is not full is dropped.
fn chunks(rays: impl Iterator<Item = (Vec3, Vec3, f32)>) -> Vec<Rays> {
    let (mut all, mut chunk, mut lane) = (Vec::new(), Rays::default(), 0);
    for (o, d, tmax) in rays {
        chunk.set(lane, o, d, 0.0, tmax);
        lane += 1;
        if lane == LANES {
            all.push(std::mem::take(&mut chunk));
            lane = 0;
        }
    }
    all
}

/// Marsaglia's xorshift; the seed must not be zero.
#[derive(Default)]
pub struct Random(pub u64);

impl Random {
    /// In [0, 1).
    pub fn next(&mut self) -> f32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 40) as f32 * (1.0 / (1 << 24) as f32)
    }
}
