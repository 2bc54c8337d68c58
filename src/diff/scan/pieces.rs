//! Boxes around triangles. A long thin triangle that lies askew fills next to nothing of its box, and in a hall of them
//! every ray would pass every box: such a triangle is cut across its longest edge, with a box around each piece.

use super::tree::Piece;
use crate::accel::brute::has_area;
use crate::math::{DVec3, Vec3};
use crate::shape::Mesh;
use rayon::prelude::*;
use std::sync::Arc;

/// Pieces of a triangle at most, and of all triangles together where these are fewer (32 bytes each).
const MOST: [usize; 2] = [32, 8_000_000];

/// Boxes that cover all triangles with area.
pub(super) fn of(meshes: &[Arc<Mesh>]) -> Vec<Piece> {
    let triangles: usize = meshes.iter().map(|mesh| mesh.indices.len()).sum();
    let most = (MOST[1] / triangles.max(1)).clamp(1, MOST[0]);
    let mut pieces = Vec::new();
    for (id, mesh) in meshes.iter().enumerate() {
        let of_triangle = |triangle: usize| {
            let corners = mesh.triangle(triangle);
            let ids = [id as u32, triangle as u32];
            let count = if has_area(corners) { wanted(corners).min(most) } else { 0 };
            (0..count).map(move |i| piece(corners, [i, i + 1].map(|n| n as f64 / count as f64), ids))
        };
        pieces.par_extend((0..mesh.indices.len()).into_par_iter().flat_map_iter(of_triangle));
    }
    pieces
}

/// As many that boxes are no wider than the triangle is high: the second longest side of its box says how askew it is.
fn wanted(corners: [Vec3; 3]) -> usize {
    let [low, high] = bounds(&corners.map(|p| p.as_dvec3()));
    let mut sides = (high - low).to_array();
    sides.sort_by(f64::total_cmp);
    let [a, b, c] = base_first(corners);
    let height = (b - a).cross(c - a).length() / (b - a).length();
    // As a cast does: what is no number is 0.
    ((sides[1] / height) as usize).max(1)
}

/// The corners as f64, turned so that the longest edge is the first.
fn base_first(corners: [Vec3; 3]) -> [DVec3; 3] {
    let [a, b, c] = corners.map(|p| p.as_dvec3());
    let turned = [[a, b, c], [b, c, a], [c, a, b]];
    let length = |p: &[DVec3; 3]| p[0].distance_squared(p[1]);
    turned.into_iter().max_by(|p, q| length(p).total_cmp(&length(q))).unwrap_or([a, b, c])
}

/// The box of the part of a triangle between two shares of its longest edge.
fn piece(corners: [Vec3; 3], [from, to]: [f64; 2], ids: [u32; 2]) -> Piece {
    let [a, b, c] = base_first(corners);
    let top = ((c - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
    // The other two edges above that share of the longest one.
    let above = |share: f64| match share {
        _ if share < top => a.lerp(c, share / top),
        _ if top < 1.0 => c.lerp(b, (share - top) / (1.0 - top)),
        _ => b,
    };
    let peak = above(top.clamp(from, to));
    let [low, high] = bounds(&[a.lerp(b, from), a.lerp(b, to), above(from), above(to), peak]);
    Piece { bounds: [low.as_vec3(), high.as_vec3()], ids }
}

fn bounds(points: &[DVec3]) -> [DVec3; 2] {
    let none = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    points.iter().fold(none, |(low, high), p| (low.min(*p), high.max(*p))).into()
}
