//! What a bare mesh gets so that one command makes a picture: a view, a sky, clay and perhaps a ground. All
//! constants of that look are here.

use crate::error::{Result, lookup};
use crate::light::Environment;
use crate::math::{Aabb, DVec3, Rgb, Vec3};
use crate::shape::Mesh;

/// The size of a bare mesh's picture.
pub const SIZE: [u32; 2] = [1024, 768];
/// Pictures a second of a series.
pub const FPS: f64 = 24.0;
/// Vertical field of view in degrees.
pub const FOV: f64 = 35.0;
/// The share of the picture that stays free at each border.
pub const MARGIN: f64 = 0.05;
/// Neutral clay, a warm grey.
pub const CLAY: Rgb = Rgb::new(0.62, 0.60, 0.57);
/// The ground's grey.
pub const GROUND: Rgb = Rgb::new(0.45, 0.45, 0.45);
/// The ground's side, in sizes of what stands on it.
pub const GROUND_SIDE: f64 = 50.0;
/// How far the ground lies below the lowest point, in sizes: enough that flat undersides and the ground
/// are not one plane.
pub const GROUND_GAP: f64 = 1e-4;

/// The axis that points up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Up {
    axis: usize,
    negative: bool,
}

impl Up {
    /// Name, meaning, value.
    pub const TABLE: &'static [(&'static str, &'static str, Up)] = &[
        ("y", "+y is up; the front looks to +z", Up { axis: 1, negative: false }),
        ("z", "+z is up; the front looks to −y (CAD, scans, printers)", Up { axis: 2, negative: false }),
        ("x", "+x is up; the front looks to +z", Up { axis: 0, negative: false }),
        ("-y", "−y is up; the front looks to +z", Up { axis: 1, negative: true }),
        ("-z", "−z is up; the front looks to +y", Up { axis: 2, negative: true }),
        ("-x", "−x is up; the front looks to +z", Up { axis: 0, negative: true }),
    ];

    /// The axis of that name.
    pub fn from_name(word: &str) -> Result<Up> {
        lookup("up axis", word, Self::TABLE)
    }

    /// The unit vector.
    pub fn vector(self) -> DVec3 {
        let axis = [DVec3::X, DVec3::Y, DVec3::Z][self.axis.min(2)];
        if self.negative { -axis } else { axis }
    }
}

/// Up, front and right of an object, orthonormal and right-handed (right = up × front). The front looks to
/// +z where it can; with z up it looks to −y, as CAD programs have it.
#[derive(Clone, Copy, Debug)]
pub struct Bearings {
    /// Away from the ground.
    pub up: DVec3,
    /// From the object to someone who looks at its front.
    pub front: DVec3,
    /// To the right of that person's picture.
    pub right: DVec3,
}

impl Bearings {
    /// The bearings for an up vector, which need not be unit or along an axis.
    pub fn new(up: DVec3) -> Bearings {
        let up = up.normalize_or(DVec3::Y);
        let front = if up.z.abs() < 0.9 { DVec3::Z } else { DVec3::new(0.0, -up.z.signum(), 0.0) };
        let front = (front - up * up.dot(front)).normalize_or(up.any_orthonormal_vector());
        Bearings { up, front, right: up.cross(front) }
    }
}

/// Where a bare mesh is seen from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Degrees from the front to the right.
    azimuth: f64,
    /// Degrees above the ground.
    elevation: f64,
}

impl View {
    /// Name, meaning, value; the first is the default.
    pub const TABLE: &'static [(&'static str, &'static str, View)] = &[
        ("three-quarter", "from the front, right and above", View { azimuth: 30.0, elevation: 20.0 }),
        ("front", "from the front", View { azimuth: 0.0, elevation: 0.0 }),
        ("back", "from behind", View { azimuth: 180.0, elevation: 0.0 }),
        ("left", "from the left", View { azimuth: -90.0, elevation: 0.0 }),
        ("right", "from the right", View { azimuth: 90.0, elevation: 0.0 }),
        ("top", "from above", View { azimuth: 0.0, elevation: 90.0 }),
        ("bottom", "from below", View { azimuth: 0.0, elevation: -90.0 }),
        // atan(1/√2): all three axes are shortened alike.
        (
            "iso",
            "isometric: all three axes shortened alike",
            View { azimuth: 45.0, elevation: 35.264_389_682_754_654 },
        ),
    ];

    /// The view of that name.
    pub fn from_name(word: &str) -> Result<View> {
        lookup("view", word, Self::TABLE)
    }

    /// The unit direction from the object to the eye, and the picture's up.
    pub fn directions(self, bearings: &Bearings) -> (DVec3, DVec3) {
        let Bearings { up, front, right } = *bearings;
        if self.elevation.abs() == 90.0 {
            let sign = self.elevation.signum();
            return (up * sign, -front * sign);
        }
        let (a, e) = (self.azimuth.to_radians(), self.elevation.to_radians());
        let level = front * libm::cos(a) + right * libm::sin(a);
        ((level * libm::cos(e) + up * libm::sin(e)).normalize(), up)
    }
}

impl Default for View {
    fn default() -> Self {
        Self::TABLE[0].2
    }
}

/// The built-in skies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sky {
    /// A soft key light from the upper left behind the camera, over a bright horizon.
    Studio,
    /// Radiance 1 from everywhere.
    White,
    /// A covered sky: brighter above, no direction.
    Overcast,
    /// No light.
    None,
}

impl Sky {
    /// Name, meaning, value; the first is the default.
    pub const TABLE: &'static [(&'static str, &'static str, Sky)] = &[
        ("studio", "a soft key light from the upper left over a bright horizon", Sky::Studio),
        ("white", "radiance 1 from everywhere", Sky::White),
        ("overcast", "a covered sky, three times as bright above as at the horizon", Sky::Overcast),
        ("none", "no light but what the mesh emits", Sky::None),
    ];

    /// The sky of that name.
    pub fn from_name(word: &str) -> Result<Sky> {
        lookup("sky", word, Self::TABLE)
    }

    /// The light, for a camera that looks along `forward`.
    pub fn environment(self, up: DVec3, forward: DVec3) -> Option<Environment> {
        let up = up.normalize_or(DVec3::Y);
        match self {
            Sky::Studio => Some(Environment::Studio {
                below: Rgb::new(0.13, 0.125, 0.12),
                horizon: Rgb::new(0.45, 0.45, 0.45),
                zenith: Rgb::new(0.28, 0.32, 0.38),
                up: up.as_vec3(),
                direction: key_direction(up, forward),
                key: Rgb::new(7.2, 6.8, 6.3),
                sharpness: 20.0,
            }),
            Sky::White => Some(Environment::Constant(Rgb::ONE)),
            Sky::Overcast => Some(Environment::Studio {
                below: Rgb::splat(0.2),
                horizon: Rgb::splat(0.4),
                zenith: Rgb::splat(1.2),
                up: up.as_vec3(),
                direction: up.as_vec3(),
                key: Rgb::ZERO,
                sharpness: 1.0,
            }),
            Sky::None => None,
        }
    }
}

/// From the upper left behind the camera, wherever it stands: level directions are those of the picture.
fn key_direction(up: DVec3, forward: DVec3) -> Vec3 {
    let level = forward - up * up.dot(forward);
    let away = level.try_normalize().unwrap_or_else(|| Bearings::new(up).front * -1.0);
    let left = up.cross(away);
    (up * 1.0 - away * 0.5 + left * 0.8).normalize().as_vec3()
}

/// A square below `bounds` (scene coordinates), its upper side to `up`, with material `material`.
pub fn ground(bounds: &Aabb, up: DVec3, material: u32) -> Mesh {
    let Bearings { up, front, right } = Bearings::new(up);
    let (center, half) = (bounds.center().as_dvec3(), bounds.extent().as_dvec3() * 0.5);
    let size = (2.0 * half.max_element()).max(1e-18);
    let drop = half.dot(up.abs()) + GROUND_GAP * size;
    let middle = center - up * drop;
    let (a, b) = (right * (0.5 * GROUND_SIDE * size), front * (0.5 * GROUND_SIDE * size));
    let corners = [middle - a + b, middle + a + b, middle + a - b, middle - a - b];
    let positions: Vec<[f32; 3]> = corners.iter().map(|p| p.as_vec3().to_array()).collect();
    let mut mesh = Mesh::new(positions, vec![[0, 1, 2], [0, 2, 3]]);
    mesh.materials = crate::shape::FaceMaterials::Uniform(material);
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bearings_are_right_handed_for_every_axis() {
        for (name, _, up) in Up::TABLE {
            let b = Bearings::new(up.vector());
            assert!((b.right.cross(b.up) - b.front).length() < 1e-15, "{name}");
            assert_eq!(b.up, up.vector(), "{name}");
        }
        let z = Bearings::new(DVec3::Z);
        assert_eq!((z.front, z.right), (-DVec3::Y, DVec3::X));
    }

    #[test]
    fn views_look_from_where_they_say() {
        let b = Bearings::new(DVec3::Y);
        let from = |name: &str| View::from_name(name).unwrap().directions(&b).0;
        assert!((from("front") - DVec3::Z).length() < 1e-15);
        assert!((from("back") + DVec3::Z).length() < 1e-15);
        assert!((from("right") - DVec3::X).length() < 1e-15);
        assert!((from("left") + DVec3::X).length() < 1e-15);
        assert_eq!(from("top"), DVec3::Y);
        assert!((from("iso") - DVec3::ONE.normalize()).length() < 1e-15);
        for (name, _, view) in View::TABLE {
            let (eye, up) = view.directions(&b);
            assert!(eye.cross(up).length() > 0.5, "{name}");
        }
    }

    #[test]
    fn the_key_light_comes_from_the_upper_left_front_of_the_picture() {
        for (up, forward) in
            [(DVec3::Y, -DVec3::Z), (DVec3::Z, DVec3::Y), (DVec3::Y, DVec3::new(1.0, -0.4, 0.3))]
        {
            let key = key_direction(up, forward).as_dvec3();
            let right = forward.cross(up);
            assert!(key.dot(up) > 0.3 && key.dot(forward) < 0.0 && key.dot(right) < -0.1, "{up} {forward}");
        }
        // Straight down, there still is a key light.
        assert!(key_direction(DVec3::Y, -DVec3::Y).is_normalized());
    }

    #[test]
    fn the_ground_lies_below_and_faces_up() {
        for (name, _, up) in Up::TABLE {
            let bounds = Aabb { min: Vec3::new(-1.0, 2.0, 3.0), max: Vec3::new(4.0, 5.0, 6.0) };
            let ground = ground(&bounds, up.vector(), 7);
            let up = up.vector().as_vec3();
            let lowest = bounds.min.dot(up).min(bounds.max.dot(up));
            for t in 0..2 {
                let [a, b, c] = ground.triangle(t);
                assert!(crate::shape::geometric_normal(a, b, c).dot(up) > 0.999, "{name}");
                for p in [a, b, c] {
                    let gap = lowest - p.dot(up);
                    assert!(gap > 0.0 && gap < 0.01, "{name}: {gap}");
                }
            }
            assert_eq!(ground.materials.get(0), 7);
        }
    }
}
