//! Rays at what goes wrong most easily: vertices, edges, axis-parallel directions, triangles seen edge-on.

use super::rays::{Chunk, Kind, RaySet};
use crate::accel::{LANES, Mask, Rays};
use crate::math::Vec3;
use crate::quadrature::numbers;
use crate::scene::Scene;

/// The kinds made here.
pub const KINDS: [Kind; 4] = [Kind::Vertex, Kind::Edge, Kind::Axis, Kind::Graze];

/// `count` rays of `kind` at triangles of `scene`, from inside its box and from around it. Every fifth direction is
/// not of unit length and every seventh interval ends, on the target now and then. None where there is no triangle.
pub fn rays(scene: &Scene, kind: Kind, count: u64, seed: u64) -> RaySet {
    let mut random = Random(Box::new(numbers(seed, kind as u64)));
    let bounds = scene.bounds();
    let half = bounds.extent() * 0.5;
    let place = Place { center: bounds.center(), half: half.max(Vec3::splat(half.max_element() * 0.1)) };
    let triangles = scene.triangles();
    let rays = (0..if triangles == 0 { 0 } else { count }).map(|i| {
        let corners = triangle(scene, random.below(triangles));
        let (o, d, t) = aim(kind, corners, &place, &mut random);
        let scale = if i % 5 == 0 { libm::exp2f(random.unit() * 20.0 - 10.0) } else { 1.0 };
        let t = t / scale;
        let tmax = match i % 14 {
            0 => t,
            7 => t * 2.0 * random.unit(),
            _ => f32::INFINITY,
        };
        (o, d * scale, 0.0, tmax)
    });
    RaySet { kind, chunks: chunks(rays) }
}

/// Rays (origin, direction, interval) in chunks.
pub fn chunks(rays: impl Iterator<Item = (Vec3, Vec3, f32, f32)>) -> Vec<Chunk> {
    let mut all: Vec<Chunk> = Vec::new();
    for (i, (o, d, tmin, tmax)) in rays.enumerate() {
        if i % LANES == 0 {
            all.push(Chunk { rays: Rays::default(), mask: 0 });
        }
        if let Some(chunk) = all.last_mut() {
            chunk.rays.set(i % LANES, o, d, tmin, tmax);
            chunk.mask |= 1 << (i % LANES) as Mask;
        }
    }
    // What no backend may be asked is no question.
    for chunk in &mut all {
        chunk.mask = chunk.rays.check(chunk.mask).active();
    }
    all
}

/// Origin, direction, and where the target is.
fn aim(kind: Kind, corners: [Vec3; 3], place: &Place, random: &mut Random) -> (Vec3, Vec3, f32) {
    let [a, b, c] = corners;
    let inner = a + (b - a) * (random.unit() * 0.5) + (c - a) * (random.unit() * 0.5);
    let from_around = place.origin(random);
    match kind {
        Kind::Vertex => towards(from_around, a),
        Kind::Edge => towards(from_around, b.lerp(c, random.unit())),
        Kind::Axis => {
            let target = [a, (b + c) * 0.5, inner][random.below(3) as usize];
            let axis = random.below(3) as usize;
            let sign = if random.below(2) == 0 { 1.0 } else { -1.0 };
            let mut d = Vec3::splat(if random.below(2) == 0 { 0.0 } else { -0.0 });
            d[axis] = sign;
            let mut o = target;
            o[axis] = from_around[axis];
            (o, d, (target[axis] - o[axis]) * sign)
        }
        _ => {
            let (along, normal) = (inner - b, (b - a).cross(c - a));
            let lean = libm::exp2f(-random.unit() * 30.0) * if random.below(2) == 0 { 1.0 } else { -1.0 };
            let d = along.normalize_or(Vec3::X) + normal.normalize_or(Vec3::Y) * lean;
            let t = place.half.max_element() * 2.0 * random.unit();
            (inner - d * t, d, t)
        }
    }
}

fn towards(o: Vec3, target: Vec3) -> (Vec3, Vec3, f32) {
    let way = target - o;
    (o, way.normalize_or(Vec3::X), way.length())
}

fn triangle(scene: &Scene, mut index: u64) -> [Vec3; 3] {
    for mesh in &scene.meshes {
        let count = mesh.indices.len() as u64;
        if index < count {
            return mesh.triangle(index as usize);
        }
        index -= count;
    }
    [Vec3::ZERO; 3]
}

/// Where rays start.
struct Place {
    center: Vec3,
    half: Vec3,
}

impl Place {
    /// In the box, or in one three times its size.
    fn origin(&self, random: &mut Random) -> Vec3 {
        let size = if random.below(2) == 0 { 1.0 } else { 3.0 };
        self.center + self.half * random.cube() * size
    }
}

/// Independent numbers in the forms that are needed here.
struct Random(Box<dyn FnMut() -> f64>);

impl Random {
    /// Uniform in [0, 1].
    fn unit(&mut self) -> f32 {
        (self.0)() as f32
    }

    /// Uniform in [-1, 1]³.
    fn cube(&mut self) -> Vec3 {
        Vec3::new(self.unit(), self.unit(), self.unit()) * 2.0 - 1.0
    }

    /// Below `n`, which is not 0.
    fn below(&mut self, n: u64) -> u64 {
        ((self.0)() * n as f64) as u64
    }
}
