//! Several hits become points on surfaces at once: [`Surface::new`] of every lane, bit for bit.

use super::surface::{geometric_normal_f64, place, plain_normal, shading_normal};
use super::{Mesh, Surface};
use crate::math::soa::mask;
use crate::math::{Vec2, Vec3, Vec3s};

/// What meshes hold about the triangles that `N` rays hit.
#[derive(Clone, Debug)]
pub struct Corners<const N: usize> {
    positions: [Vec3s<N>; 3],
    normals: [Vec3s<N>; 3],
    uvs: [[Vec2; 3]; N],
    /// Lanes with normals, and those with texture coordinates.
    with_normals: u16,
    with_uvs: u16,
    /// The hits' weights of the second and third corner.
    weights: [[f32; N]; 2],
}

impl<const N: usize> Corners<N> {
    /// Fetches the triangles of which the points with `weights` (of the second and third corner) were hit.
    ///
    /// All lanes' indices first, then all positions, then the rest: a processor waits for the memory of many lanes at once
    /// rather than for one load that hangs on another, lane by lane.
    #[inline(always)]
    pub fn fetch(meshes: &[&Mesh; N], triangles: &[u32; N], weights: [[f32; N]; 2]) -> Corners<N> {
        let zero = [Vec3s::ZERO; 3];
        let (uvs, with_normals, with_uvs) = ([[Vec2::ZERO; 3]; N], 0, 0);
        let mut all = Corners { positions: zero, normals: zero, uvs, with_normals, with_uvs, weights };
        let mut corners = [[0; 3]; N];
        for lane in 0..N {
            corners[lane] = meshes[lane].indices[triangles[lane] as usize];
        }
        for lane in 0..N {
            for (to, i) in all.positions.iter_mut().zip(corners[lane]) {
                to.set(lane, Vec3::from(meshes[lane].positions[i as usize]));
            }
        }
        for lane in 0..N {
            let (mesh, triangle) = (meshes[lane], triangles[lane] as usize);
            if let Some(n) = mesh.normals.as_ref().and_then(|n| n.corners(triangle, corners[lane])) {
                for (to, n) in all.normals.iter_mut().zip(n) {
                    to.set(lane, Vec3::from(n));
                }
                all.with_normals |= 1 << lane;
            }
            if let Some(uvs) = mesh.uvs.as_ref().and_then(|t| t.corners(triangle, corners[lane])) {
                all.uvs[lane] = uvs.map(Vec2::from);
                all.with_uvs |= 1 << lane;
            }
        }
        all
    }

    #[inline(always)]
    fn triangle(&self, lane: usize) -> [Vec3; 3] {
        [self.positions[0].get(lane), self.positions[1].get(lane), self.positions[2].get(lane)]
    }
}

/// `N` points on triangles; the fields are those of [`Surface`].
#[derive(Clone, Copy, Debug)]
pub struct Surfaces<const N: usize> {
    /// See [`Surface::p`].
    pub p: Vec3s<N>,
    /// See [`Surface::error`].
    pub error: [f32; N],
    /// See [`Surface::ng`].
    pub ng: Vec3s<N>,
    /// See [`Surface::ns`].
    pub ns: Vec3s<N>,
    /// See [`Surface::uv`].
    pub uv: [[f32; N]; 2],
}

impl<const N: usize> Surfaces<N> {
    /// The points that were hit.
    #[inline(always)]
    pub fn new(corners: &Corners<N>) -> Surfaces<N> {
        let zero = Vec3s::ZERO;
        let mut s = Surfaces { p: zero, error: [0.0; N], ng: zero, ns: zero, uv: [[0.0; N]; 2] };
        let mut sound = [false; N];
        for (lane, sound) in sound.iter_mut().enumerate() {
            let triangle = corners.triangle(lane);
            let (p, error, uv) = place(triangle, corners.weights[0][lane], corners.weights[1][lane]);
            s.p.set(lane, p);
            s.error[lane] = error;
            (s.uv[0][lane], s.uv[1][lane]) = (uv.x, uv.y);
            let [a, b, c] = triangle;
            let (ng, in_range) = plain_normal(a, b, c);
            s.ng.set(lane, ng);
            *sound = in_range;
        }
        if mask(&sound).count_ones() != N as u32 {
            for lane in (0..N).filter(|lane| !sound[*lane]) {
                let [a, b, c] = corners.triangle(lane);
                s.ng.set(lane, geometric_normal_f64(a, b, c));
            }
        }
        s.ns = s.ng;
        if corners.with_normals != 0 {
            s.interpolate_normals(corners);
        }
        for lane in (0..N).filter(|lane| corners.with_uvs >> lane & 1 == 1) {
            let [a, b, c] = corners.uvs[lane];
            let (u, v) = (corners.weights[0][lane], corners.weights[1][lane]);
            let uv = a * (1.0 - u - v) + b * u + c * v;
            (s.uv[0][lane], s.uv[1][lane]) = (uv.x, uv.y);
        }
        s
    }

    #[inline(always)]
    fn interpolate_normals(&mut self, corners: &Corners<N>) {
        for lane in 0..N {
            let (u, v) = (corners.weights[0][lane], corners.weights[1][lane]);
            let ng = self.ng.get(lane);
            let n = [0, 1, 2].map(|k| corners.normals[k].get(lane));
            let ns = shading_normal(n, 1.0 - u - v, u, v, ng);
            self.ns.set(lane, if corners.with_normals >> lane & 1 == 1 { ns } else { ng });
        }
    }

    /// Sets one of them.
    #[inline(always)]
    pub fn set(&mut self, lane: usize, s: &Surface) {
        self.p.set(lane, s.p);
        self.error[lane] = s.error;
        self.ng.set(lane, s.ng);
        self.ns.set(lane, s.ns);
        (self.uv[0][lane], self.uv[1][lane]) = (s.uv.x, s.uv.y);
    }

    /// One of them.
    #[inline(always)]
    pub fn get(&self, lane: usize) -> Surface {
        Surface {
            p: self.p.get(lane),
            error: self.error[lane],
            ng: self.ng.get(lane),
            ns: self.ns.get(lane),
            uv: Vec2::new(self.uv[0][lane], self.uv[1][lane]),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::Attribute;

    /// All lanes at once are what each is by itself: with and without normals and texture coordinates, triangles beyond
    /// f32's range, weights outside of the triangle.
    #[test]
    fn surfaces_are_those_of_their_lanes() {
        let point = |i: u32| [0.3 * i as f32, (i * i % 7) as f32, 1.0 - 0.1 * i as f32];
        let tiny = |i: u32| point(i).map(|c| c * 1e-20);
        let indices: Vec<[u32; 3]> = (0..16).map(|t| [t, t + 1, t + 2]).collect();
        let mut plain = Mesh::new((0..18).map(|i| if i < 9 { point(i) } else { tiny(i) }).collect(), indices);
        let bare = plain.clone();
        let value = |i: u32| [1.0, 0.1 * i as f32, -0.3];
        plain.normals = Some(Attribute { values: (0..18).map(value).collect(), indices: None });
        plain.uvs = Some(Attribute { values: (0..18).map(|i| [i as f32, 2.0]).collect(), indices: None });
        let hit = |lane: usize| (lane as u32, 0.09 * lane as f32 - 0.1, 0.4);
        for every in [1, 3, 99] {
            let mesh = |lane: usize| if lane.is_multiple_of(every) { &plain } else { &bare };
            let hits: [(u32, f32, f32); 16] = std::array::from_fn(hit);
            let (triangles, weights) = (hits.map(|h| h.0), [hits.map(|h| h.1), hits.map(|h| h.2)]);
            let corners = Corners::fetch(&std::array::from_fn(mesh), &triangles, weights);
            let all = Surfaces::new(&corners);
            for lane in 0..16 {
                let (triangle, u, v) = hit(lane);
                let one = Surface::new(mesh(lane), triangle, u, v);
                assert_eq!(format!("{:?}", all.get(lane)), format!("{one:?}"), "lane {lane}");
            }
        }
    }
}
