//! Meshes and rays for the differential tests, from fixed seeds.

use drt::accel::{LANES, Rays};
use drt::math::Vec3;
use drt::shape::Mesh;
use std::collections::HashMap;
use std::f32::consts::{PI, TAU};
use std::sync::Arc;

/// Steele, Lea and Flood's SplitMix64.
pub struct Random(pub u64);

impl Random {
    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Uniform in [0, 1).
    pub fn unit(&mut self) -> f32 {
        (self.bits() >> 40) as f32 / (1 << 24) as f32
    }

    /// Uniform in [-1, 1)³.
    pub fn cube(&mut self) -> Vec3 {
        Vec3::new(self.unit(), self.unit(), self.unit()) * 2.0 - 1.0
    }

    /// Uniform in the unit ball, never its very middle.
    pub fn ball(&mut self) -> Vec3 {
        loop {
            let p = self.cube();
            if (0.01..1.0).contains(&p.length()) {
                return p;
            }
        }
    }

    /// Below `n`.
    pub fn below(&mut self, n: usize) -> usize {
        (self.bits() % n as u64) as usize
    }
}

/// A ray: origin, direction, interval.
pub type Ray = (Vec3, Vec3, f32, f32);

/// From `o` towards `target`, without end.
pub fn towards(o: Vec3, target: Vec3) -> Ray {
    (o, (target - o).normalize_or(Vec3::X), 0.0, f32::INFINITY)
}

/// Rays in chunks; spare lanes of the last one hit nothing.
pub fn chunks(rays: &[Ray]) -> Vec<Rays> {
    rays.chunks(LANES)
        .map(|part| {
            let mut chunk = Rays::default();
            for (lane, &(o, d, tmin, tmax)) in part.iter().enumerate() {
                chunk.set(lane, o, d, tmin, tmax);
            }
            chunk
        })
        .collect()
}

/// `n` rays between random points in and around the mesh's box, some with directions of odd lengths and some
/// with bounded intervals.
pub fn random_rays(mesh: &Mesh, n: usize, seed: u64) -> Vec<Ray> {
    let mut random = Random(seed);
    let bounds = mesh.bounds();
    let (center, half) = (bounds.center(), bounds.extent() * 0.5);
    let half = half.max(Vec3::splat(half.max_element() * 0.1));
    (0..n)
        .map(|i| {
            let o = center + half * random.cube() * if i % 2 == 0 { 1.0 } else { 4.0 };
            let (o, mut d, tmin, mut tmax) = towards(o, center + half * random.cube());
            if i % 5 == 0 {
                d *= 10f32.powf(random.unit() * 6.0 - 3.0);
            }
            if i % 7 == 0 {
                tmax = half.max_element() * 2.0 * random.unit() / d.length();
            }
            (o, d, tmin, tmax)
        })
        .collect()
}

pub fn one(mesh: Mesh) -> Vec<Arc<Mesh>> {
    vec![Arc::new(mesh)]
}

/// The mesh with every position replaced.
pub fn mapped(mesh: &Mesh, f: impl Fn(Vec3) -> Vec3) -> Mesh {
    Mesh::new(mesh.positions.iter().map(|p| f(Vec3::from(*p)).to_array()).collect(), mesh.indices.clone())
}

/// The mesh with every vertex moved by up to `by` along each axis, as a scanner would.
pub fn rough(mesh: &Mesh, by: f32) -> Mesh {
    let mut random = Random(41);
    let moved = mesh.positions.iter().map(|p| (Vec3::from(*p) + random.cube() * by).to_array()).collect();
    Mesh::new(moved, mesh.indices.clone())
}

/// `n` triangles of all sizes in the unit cube.
pub fn soup(n: usize, seed: u64) -> Mesh {
    let mut random = Random(seed);
    let mut positions = Vec::new();
    for _ in 0..n {
        let (at, size) = (random.cube(), 0.02f32.powf(random.unit()));
        positions.extend((0..3).map(|_| (at + random.cube() * size).to_array()));
    }
    Mesh::new(positions, (0..n as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect())
}

/// `n` triangles whose width is `aspect` times smaller than their length.
pub fn slivers(n: usize, aspect: f32, seed: u64) -> Mesh {
    let mut random = Random(seed);
    let mut positions = Vec::new();
    for _ in 0..n {
        let (a, along) = (random.cube(), random.cube());
        let across = along.cross(random.cube()).normalize_or(Vec3::Y) * along.length() / aspect;
        positions.extend([a, a + along, a + along * random.unit() + across].map(|p| p.to_array()));
    }
    Mesh::new(positions, (0..n as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect())
}

/// A surface of `rings` × `around` quads, closed around and, where `wrap`, along as well.
fn lathe(rings: u32, around: u32, wrap: bool, point: impl Fn(f32, f32) -> Vec3) -> Mesh {
    let last = if wrap { rings } else { rings + 1 };
    let mut positions = Vec::new();
    for i in 0..last {
        for j in 0..around {
            positions.push(point(i as f32 / rings as f32, j as f32 / around as f32).to_array());
        }
    }
    let at = |i: u32, j: u32| (i % last) * around + j % around;
    let mut indices = Vec::new();
    for i in 0..rings {
        for j in 0..around {
            indices.push([at(i, j), at(i + 1, j), at(i, j + 1)]);
            indices.push([at(i, j + 1), at(i + 1, j), at(i + 1, j + 1)]);
        }
    }
    Mesh::new(positions, indices)
}

/// Unit sphere by longitude and latitude: thin triangles at the poles, which are exact points.
pub fn uv_sphere(rings: u32) -> Mesh {
    lathe(rings, 2 * rings, false, |s, t| {
        let sin = if s == 0.0 || s == 1.0 { 0.0 } else { (PI * s).sin() };
        Vec3::new(sin * (TAU * t).cos(), (PI * s).cos(), sin * (TAU * t).sin())
    })
}

pub fn torus(rings: u32) -> Mesh {
    lathe(rings, rings, true, |s, t| {
        let r = 1.0 + 0.4 * (TAU * t).cos();
        Vec3::new(r * (TAU * s).cos(), 0.4 * (TAU * t).sin(), r * (TAU * s).sin())
    })
}

/// Unit sphere from an octahedron, each triangle cut into four `depth` times.
pub fn octasphere(depth: u32) -> Mesh {
    let mut points = vec![Vec3::X, Vec3::Y, Vec3::Z, -Vec3::X, -Vec3::Y, -Vec3::Z];
    let mut faces: Vec<[u32; 3]> =
        vec![[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]];
    for _ in 0..depth {
        let mut middles = HashMap::new();
        let mut middle = |a: u32, b: u32| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                points.push(((points[a as usize] + points[b as usize]) * 0.5).normalize());
                points.len() as u32 - 1
            })
        };
        faces = faces
            .iter()
            .flat_map(|&[a, b, c]| {
                let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
                [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]
            })
            .collect();
    }
    Mesh::new(points.iter().map(|p| p.to_array()).collect(), faces)
}

/// The surface of the cube [0, n]³ on an integer grid, vertices shared.
pub fn cube(n: i32) -> Mesh {
    let mut ids = HashMap::new();
    let (mut positions, mut indices) = (Vec::new(), Vec::new());
    for axis in 0..3 {
        for side in [0, n] {
            for i in 0..n {
                for j in 0..n {
                    let mut at = |i: i32, j: i32| {
                        let mut p = [0; 3];
                        (p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]) = (side, i, j);
                        *ids.entry(p).or_insert_with(|| {
                            positions.push(p.map(|x| x as f32));
                            positions.len() as u32 - 1
                        })
                    };
                    let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                    indices.extend([[a, b, c], [a, c, d]]);
                }
            }
        }
    }
    Mesh::new(positions, indices)
}

/// The square [0, n]² at z = 0 on an integer grid.
pub fn grid(n: u32) -> Mesh {
    let positions = (0..=n).flat_map(|i| (0..=n).map(move |j| [i as f32, j as f32, 0.0])).collect();
    let at = |i: u32, j: u32| i * (n + 1) + j;
    let quad =
        |i, j| [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]];
    Mesh::new(positions, (0..n).flat_map(|i| (0..n).flat_map(move |j| quad(i, j))).collect())
}
