//! The opening of a thin lens: a disk, or a regular polygon as blades make it.

use crate::math::approx::sin_cos_turn;
use crate::math::{Vec2, warp};

/// The opening of a lens.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Aperture {
    /// Radius in metres, a polygon's out to its corners; 0 is a pinhole.
    pub radius: f32,
    /// Corners of the polygon; fewer than 3: a disk.
    pub blades: u32,
    /// Turns by which the polygon is turned from its first corner on the right, counter-clockwise as the camera sees it.
    pub rotation: f32,
}

impl Aperture {
    /// A round one.
    pub fn disk(radius: f64) -> Aperture {
        Aperture { radius: radius as f32, ..Aperture::default() }
    }

    /// A point of the opening, uniform by area, in metres to the right and up.
    #[inline(always)]
    pub fn point(&self, u: [f32; 2]) -> Vec2 {
        if self.blades < 3 {
            return warp::disk(u) * self.radius;
        }
        // The first number chooses one of the triangles around the middle; what is left of it places the point there.
        let at = u[0] * self.blades as f32;
        let blade = (at as u32).min(self.blades - 1);
        let [b, c] = warp::triangle([(at - blade as f32).min(1.0 - 0.5 * f32::EPSILON), u[1]]);
        let corner = |i: u32| {
            let turn = i as f32 / self.blades as f32 + self.rotation;
            let (s, c) = sin_cos_turn(turn - turn.floor());
            Vec2::new(c, s) * self.radius
        };
        corner(blade) * b + corner(blade + 1) * c
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A grid of numbers falls evenly over the polygon: the second moment of a regular n-gon with corners at radius 1 is
    /// E[x²] = (2 + cos 2π/n)/12, the same along every axis, and no point lies outside.
    #[test]
    fn polygons_are_filled_evenly() {
        for (blades, rotation) in [(3, 0.0), (5, 0.1), (6, 0.25), (9, -3.3)] {
            let aperture = Aperture { radius: 2.0, blades, rotation };
            let n = 256;
            let mut moments = [0.0f64; 3];
            for i in 0..n * n {
                let u = [(i % n) as f32, (i / n) as f32].map(|x| (x + 0.5) / n as f32);
                let p = aperture.point(u) * 0.5;
                let inside = (0..blades).all(|k| {
                    let turn = f64::from(k as f32 + 0.5) / f64::from(blades) + f64::from(rotation);
                    let (s, c) = (turn * std::f64::consts::TAU).sin_cos();
                    f64::from(p.x) * c + f64::from(p.y) * s
                        < (std::f64::consts::PI / f64::from(blades)).cos() + 1e-5
                });
                assert!(inside, "{blades} {p}");
                for (m, v) in moments.iter_mut().zip([p.x * p.x, p.y * p.y, p.x * p.y]) {
                    *m += f64::from(v) / f64::from(n * n);
                }
            }
            let exact = (2.0 + (std::f64::consts::TAU / f64::from(blades)).cos()) / 12.0;
            assert!(
                (moments[0] - exact).abs() < 4e-3 && (moments[1] - exact).abs() < 4e-3,
                "{moments:?} {exact}"
            );
            assert!(moments[2].abs() < 1e-3);
        }
        let disk = Aperture::disk(0.5);
        assert_eq!(disk.point([0.3, 0.7]), warp::disk([0.3, 0.7]) * 0.5);
    }
}
