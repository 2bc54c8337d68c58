//! A triangle seen edge-on: its plane says neither whether nor where the ray meets it, its outline does.

use super::Ray64;
use crate::math::DVec3;

/// The outline of a triangle, as a ray sees it.
#[derive(Clone, Copy, Debug)]
pub struct Outline {
    /// How far from the ray's line its nearest point is, across the ray. (Of a triangle with a visible inside, its
    /// border's.)
    pub away: f64,
    /// Where along the ray it begins, in multiples of the direction.
    pub first: f64,
    /// Where it ends.
    pub last: f64,
}

impl Outline {
    /// Looks along the ray; its direction is not zero.
    pub fn of(ray: &Ray64, corners: [DVec3; 3]) -> Outline {
        let along = corners.map(|p| (p - ray.o).dot(ray.d) / ray.d.length_squared());
        let across = [0, 1, 2].map(|i| corners[i] - ray.o - ray.d * along[i]);
        let away = |i: usize| distance(across[i], across[(i + 1) % 3]);
        Outline {
            away: away(0).min(away(1)).min(away(2)),
            first: along.into_iter().fold(f64::INFINITY, f64::min),
            last: along.into_iter().fold(f64::NEG_INFINITY, f64::max),
        }
    }
}

/// Of the origin from a segment.
fn distance(p: DVec3, q: DVec3) -> f64 {
    let way = q - p;
    let length = way.length_squared();
    let share = if length > 0.0 { (-p.dot(way) / length).clamp(0.0, 1.0) } else { 0.0 };
    (p + way * share).length()
}
