//! Whether a surface goes on beyond the edges at which a ray meets it.
//!
//! That rays to all sides of one meet something is not enough to call a miss a leak: two surfaces that have nothing to do
//! with each other may end on one line as the ray sees them, and each end is a border, at which either answer is right.

use crate::accel::brute::Ray64;
use crate::math::DVec3;
use crate::shape::Mesh;
use std::sync::Arc;

/// An edge that the ray passes within rounding, the way out of the triangle there (across the edge and the ray), and the
/// triangle's third corner.
#[derive(Clone, Copy)]
struct Way {
    ends: [DVec3; 2],
    out: DVec3,
    third: DVec3,
}

/// True when the surface of `first` goes on around the ray: beyond every edge that is passed within `reach`, of this
/// triangle and of those that are so found, lies another triangle with the same two ends. Of several, one is followed.
pub(super) fn goes_on(meshes: &[Arc<Mesh>], ray: &Ray64, first: [DVec3; 3], reach: f64) -> bool {
    let mut seen: Vec<[DVec3; 2]> = Vec::new();
    let Some(mut pending) = ways(ray, first, reach) else { return false };
    while let Some(way) = pending.pop() {
        let [p, q] = way.ends;
        if seen.contains(&[p, q]) || seen.contains(&[q, p]) {
            continue;
        }
        seen.push(way.ends);
        // How far out the third corners of the triangles at this edge are.
        let third = |corners: [DVec3; 3]| {
            let is_there = corners.contains(&p) && corners.contains(&q);
            corners.into_iter().find(|c| is_there && ![p, q, way.third].contains(c))
        };
        let corners = meshes.iter().flat_map(|mesh| (0..mesh.indices.len()).map(|i| mesh.triangle(i)));
        let thirds = corners.filter_map(|corners| third(corners.map(|p| p.as_dvec3())));
        let Some((r, far)) = thirds.map(|r| (r, (r - p).dot(way.out))).max_by(|x, y| x.1.total_cmp(&y.1))
        else {
            return false;
        };
        if far > reach {
            let Some(more) = ways(ray, [p, q, r], reach) else { return false };
            pending.extend(more);
        } else if far >= -reach {
            // Seen edge-on: out by its other edges, the same way. It is `reach` wide at most, and the ray as far from this
            // edge, so it passes one of them within twice that.
            for (corner, third) in [(p, q), (q, p)] {
                if distance(ray, corner, r) <= 2.0 * reach {
                    pending.push(Way { ends: [corner, r], third, ..way });
                }
            }
        } else {
            return false;
        }
    }
    true
}

/// The edges of a triangle that the ray passes within `reach`; `None` where one of those runs along the ray.
fn ways(ray: &Ray64, [a, b, c]: [DVec3; 3], reach: f64) -> Option<Vec<Way>> {
    let mut ways = Vec::new();
    for [p, q, r] in [[a, b, c], [b, c, a], [c, a, b]] {
        if distance(ray, p, q) <= reach {
            let out = (q - p).cross(ray.d).try_normalize()?;
            let out = if (r - p).dot(out) > 0.0 { -out } else { out };
            ways.push(Way { ends: [p, q], out, third: r });
        }
    }
    Some(ways)
}

/// How far the ray's line passes from the part of a line between two points, measured across the ray.
fn distance(ray: &Ray64, p: DVec3, q: DVec3) -> f64 {
    let across = |v: DVec3| v - ray.d * (v.dot(ray.d) / ray.d.length_squared());
    let (from, along) = (across(p - ray.o), across(q - p));
    let at = -from.dot(along) / along.length_squared();
    // NaN for an edge along the ray, all of which is as far away.
    (from + along * if at.is_nan() { 0.0 } else { at.clamp(0.0, 1.0) }).length()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::Rays;
    use crate::accel::judge::{Answer, Judge, Verdict};
    use crate::math::Vec3;

    const O: [f32; 3] = [0.0, 0.0, 0.0];
    const A: [f32; 3] = [4.0, 0.0, 0.0];
    const LEFT: [f32; 3] = [0.0, 0.0, 4.0];
    const RIGHT: [f32; 3] = [0.0, 0.0, -4.0];

    /// Rays straight down at the edge from `O` to `A`, and at its first end.
    fn answers(positions: &[[f32; 3]], indices: &[[u32; 3]]) -> [bool; 2] {
        let mesh = Arc::new(Mesh::new(positions.to_vec(), indices.to_vec()));
        let first = mesh.triangle(0).map(|p| p.as_dvec3());
        [2.0, 0.0].map(|x| {
            let ray = Ray64 { o: DVec3::new(x, 5.0, 0.0), d: DVec3::NEG_Y, tmin: 0.0, tmax: f64::INFINITY };
            goes_on(std::slice::from_ref(&mesh), &ray, first, 1e-6)
        })
    }

    #[test]
    fn a_common_edge_is_no_border_but_its_end_may_be_one() {
        assert_eq!(answers(&[O, A, LEFT, RIGHT], &[[0, 1, 2], [1, 0, 3]]), [true, false]);
        // The same places under other numbers, as files have them that name each triangle's own corners.
        assert_eq!(answers(&[O, A, LEFT, A, O, RIGHT], &[[0, 1, 2], [3, 4, 5]]), [true, false]);
    }

    #[test]
    fn a_fan_all_around_a_point_goes_on_there() {
        let back = [-4.0, 0.0, 0.0];
        let fan = [[0, 1, 2], [0, 2, 4], [0, 4, 3], [0, 3, 1]];
        assert_eq!(answers(&[O, A, LEFT, RIGHT, back], &fan), [true, true]);
        assert_eq!(answers(&[O, A, LEFT, RIGHT, back], &fan[..3]), [false, false]);
    }

    #[test]
    fn surfaces_that_end_on_one_line_of_sight_have_a_border_each() {
        let (below, farther) = ([0.0, -1.0, 0.0], [4.0, -1.0, 0.0]);
        assert_eq!(answers(&[O, A, LEFT, below, farther, RIGHT], &[[0, 1, 2], [4, 3, 5]]), [false, false]);
        // Two that meet at a silhouette.
        assert_eq!(answers(&[O, A, LEFT, [0.0, -1.0, 4.0]], &[[0, 1, 2], [1, 0, 3]]), [false, false]);
    }

    #[test]
    fn a_triangle_seen_edge_on_in_between_is_part_of_the_surface() {
        // A step: down along the ray, and on from there.
        let (o, a) = ([0.0, -1.0, 0.0], [4.0, -1.0, 0.0]);
        let step = [[0, 1, 2], [1, 0, 3], [1, 3, 4], [4, 3, 5]];
        assert!(answers(&[O, A, LEFT, o, a, RIGHT], &step)[0]);
        assert!(!answers(&[O, A, LEFT, o, a, RIGHT], &step[..3])[0]);
        // Nothing is behind a sliver, though the ray passes on this side of its common edge and all of it lies beyond.
        let (o, a, left) = ([0.0, 0.0, -9e-7], [4.0, 0.0, -9e-7], [0.0, 0.0, 4.0]);
        assert!(!answers(&[o, a, left, [2.0, -1.0, -18e-7]], &[[0, 1, 2], [1, 0, 3]])[0]);
    }

    /// A hit of the edge from `O` to `A`, which another does not see: wrong where the surface goes on.
    #[test]
    fn a_miss_where_the_surface_goes_on_is_wrong() {
        let mut rays = Rays::default();
        rays.set(0, Vec3::new(2.0, 5.0, 0.0), Vec3::NEG_Y, 0.0, f32::INFINITY);
        let hit = Answer { t: 5.0, u: 0.5, v: 0.0, mesh: 0, triangle: 0 };
        let (below, farther) = ([0.0, -1.0, 0.0], [4.0, -1.0, 0.0]);
        let verdict = |indices: &[[u32; 3]]| {
            let mesh = Mesh::new(vec![O, A, LEFT, RIGHT, below, farther], indices.to_vec());
            Judge::thorough(&[Arc::new(mesh)]).verdict(&rays, 0, Some(hit), None)
        };
        assert_eq!(verdict(&[[0, 1, 2], [1, 0, 3]]), Verdict::Real);
        assert_eq!(verdict(&[[0, 1, 2]]), Verdict::Edge);
        assert_eq!(verdict(&[[0, 1, 2], [5, 4, 3]]), Verdict::Edge);
    }
}
