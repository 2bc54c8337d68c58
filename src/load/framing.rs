//! The camera that frames a scene: what `[camera]` leaves open is chosen so that everything is in the picture.

use super::auto::{self, Bearings, View};
use super::object::FileCamera;
use crate::camera::{Aperture, CameraSpec, Projection, Window};
use crate::math::{DMat4, DVec3};
use crate::shape::{Mesh, Motion};
use rayon::prelude::*;
use std::sync::Arc;

/// A camera with gaps.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct CameraPlan {
    /// How points of the image become rays.
    pub projection: Projection,
    /// The eye; `None`: so that all is seen.
    pub position: Option<DVec3>,
    /// The point in the middle; `None`: the scene's.
    pub look_at: Option<DVec3>,
    /// Up; `None`: +y.
    pub up: Option<DVec3>,
    /// The picture's width and height.
    pub lens: Lens,
    /// The opening of the lens.
    pub aperture: Aperture,
    /// `None`: the distance to the point in the middle.
    pub focus_distance: Option<f64>,
    /// When the shutter opens and closes, in seconds.
    pub shutter: [f64; 2],
    /// Moves the whole camera.
    pub motion: Option<Arc<Motion>>,
    /// Pictures a second.
    pub fps: f64,
}

impl Default for CameraPlan {
    fn default() -> Self {
        CameraPlan {
            projection: Projection::Perspective,
            position: None,
            look_at: None,
            up: None,
            lens: Lens::Usual,
            aperture: Aperture::default(),
            focus_distance: None,
            shutter: [0.0; 2],
            motion: None,
            fps: auto::FPS,
        }
    }
}

/// How the window is given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Lens {
    /// Not at all.
    Usual,
    /// Vertical field of view in degrees.
    Fov(f64),
    /// The picture's height in metres.
    Height(f64),
    /// The window itself.
    Plane(Window),
}

/// Smallest and largest of a few linear functions over all corners of all triangles.
struct Extents {
    low: [f64; 6],
    high: [f64; 6],
}

impl Extents {
    const EMPTY: Extents = Extents { low: [f64::INFINITY; 6], high: [f64::NEG_INFINITY; 6] };

    fn add(mut self, values: [f64; 6]) -> Extents {
        for ((low, high), value) in self.low.iter_mut().zip(&mut self.high).zip(values) {
            *low = low.min(value);
            *high = high.max(value);
        }
        self
    }

    fn join(self, other: Extents) -> Extents {
        self.add(other.low).add(other.high)
    }

    fn of(meshes: &[Arc<Mesh>], values: impl Fn(DVec3) -> [f64; 6] + Sync) -> Extents {
        // Minimum and maximum do not depend on the order, so threads may share the work as they like.
        let extents = meshes.iter().map(|mesh| {
            let corner = |i: &u32| mesh.positions.get(*i as usize).map(|p| DVec3::from(p.map(f64::from)));
            let triangles = mesh.indices.par_iter().with_min_len(4096);
            triangles
                .fold(
                    || Extents::EMPTY,
                    |sum, t| t.iter().filter_map(corner).fold(sum, |sum, p| sum.add(values(p))),
                )
                .reduce(|| Extents::EMPTY, Extents::join)
        });
        extents.fold(Extents::EMPTY, Extents::join)
    }

    fn is_empty(&self) -> bool {
        self.low[0] > self.high[0]
    }
}

impl CameraPlan {
    /// Takes the place of a camera that a mesh file brings, unless the scene has one; of its lens, what is left open.
    /// `placed`: where the mesh stands.
    pub fn take(&mut self, camera: &FileCamera, placed: DMat4) {
        let position = placed.transform_point3(camera.position);
        let forward = placed.transform_vector3(camera.forward);
        let up = placed.transform_vector3(camera.up);
        let is_taken = self.position.is_some() || self.look_at.is_some() || !position.is_finite();
        if is_taken || forward.normalize_or_zero().cross(up.normalize_or_zero()).length() < 1e-6 {
            return;
        }
        let other_lens = self.projection != Projection::Perspective || self.lens != Lens::Usual;
        if let (false, Lens::Height(_)) = (other_lens, camera.lens) {
            self.projection = Projection::Orthographic;
        }
        if !other_lens {
            self.lens = camera.lens;
        }
        (self.position, self.look_at) = (Some(position), Some(position + forward));
        self.up.get_or_insert(up);
    }

    /// Fills the gaps for a picture of `size` pixels of `meshes` (in coordinates relative to `origin`).
    pub fn frame(&self, view: View, size: [u32; 2], meshes: &[Arc<Mesh>], origin: DVec3) -> CameraSpec {
        let up = self.up.unwrap_or(DVec3::Y);
        let window = self.window(size);
        let mut spec = CameraSpec {
            projection: self.projection,
            position: DVec3::ZERO,
            look_at: DVec3::ZERO,
            up,
            window: window.unwrap_or(CameraSpec::height_window(1.0, size)),
            aperture: self.aperture,
            focus_distance: 1.0,
            shutter: self.shutter,
            motion: self.motion.clone(),
            fps: self.fps,
        };
        match (self.position, self.look_at) {
            (Some(position), Some(look_at)) => (spec.position, spec.look_at) = (position, look_at),
            (Some(position), None) => {
                spec.position = position;
                spec.look_at = middle(meshes).map_or(DVec3::ZERO, |m| m + origin);
                if spec.look_at == position {
                    spec.look_at = position - Bearings::new(up).front;
                }
                let forward = (spec.look_at - position).normalize_or(-DVec3::Z);
                if forward.cross(up).length() <= 1e-6 * up.length() {
                    spec.up = -Bearings::new(up).front;
                }
                if window.is_none() {
                    spec.window = self.height_of_all(&spec, size, meshes, origin);
                }
            }
            // In the middle of it all, looking to the front.
            (None, _) if self.projection == Projection::Panorama => {
                spec.position = middle(meshes).unwrap_or(DVec3::ZERO) + origin;
                spec.look_at = spec.position + Bearings::new(up).front;
            }
            (None, _) => {
                let (to_eye, up) = view.directions(&Bearings::new(up));
                spec.up = up;
                let right = up.cross(to_eye).normalize_or(DVec3::X);
                let axes = [right, to_eye.cross(right), -to_eye];
                fit(&mut spec, window, axes, size, meshes);
                spec.position += origin;
                spec.look_at += origin;
            }
        }
        spec.focus_distance = self.focus_distance.unwrap_or((spec.look_at - spec.position).length());
        spec
    }

    /// The window where the plan says it; `None` for an orthographic camera that says no height.
    fn window(&self, size: [u32; 2]) -> Option<Window> {
        match (self.lens, self.projection) {
            (Lens::Plane(window), _) => Some(window),
            (Lens::Fov(fov), _) => Some(CameraSpec::fov_window(fov, size)),
            (Lens::Height(height), _) => Some(CameraSpec::height_window(height, size)),
            (Lens::Usual, Projection::Perspective) => Some(CameraSpec::fov_window(auto::FOV, size)),
            (Lens::Usual, Projection::Orthographic) => None,
            (Lens::Usual, Projection::Panorama) => Some(CameraSpec::height_window(1.0, size)),
        }
    }

    /// The window of an orthographic camera that stands already.
    fn height_of_all(
        &self,
        spec: &CameraSpec,
        size: [u32; 2],
        meshes: &[Arc<Mesh>],
        origin: DVec3,
    ) -> Window {
        let forward = (spec.look_at - spec.position).normalize_or(-DVec3::Z);
        let right = forward.cross(spec.up).normalize_or(DVec3::X);
        let up = right.cross(forward);
        let eye = spec.position - origin;
        let e = Extents::of(meshes, |p| [(p - eye).dot(right), (p - eye).dot(up), 0.0, 0.0, 0.0, 0.0]);
        let half = |i: usize| if e.is_empty() { 0.0 } else { e.high[i].abs().max(e.low[i].abs()) };
        CameraSpec::height_window(height(2.0 * half(0), 2.0 * half(1), size), size)
    }
}

/// The height of a picture that shows `across` × `upright` metres with the margin around.
fn height(across: f64, upright: f64, size: [u32; 2]) -> f64 {
    let aspect = f64::from(size[0]) / f64::from(size[1]);
    let height = upright.max(across / aspect) / (1.0 - 2.0 * auto::MARGIN);
    if height > 0.0 { height } else { 1.0 }
}

fn middle(meshes: &[Arc<Mesh>]) -> Option<DVec3> {
    let e = Extents::of(meshes, |p| [p.x, p.y, p.z, 0.0, 0.0, 0.0]);
    (!e.is_empty()).then(|| (DVec3::from_slice(&e.low) + DVec3::from_slice(&e.high)) * 0.5)
}

/// Places the camera with the given axes (right, up, forward) so that all corners are in the window but for
/// the margin, as near as can be.
fn fit(
    spec: &mut CameraSpec,
    window: Option<Window>,
    axes: [DVec3; 3],
    size: [u32; 2],
    meshes: &[Arc<Mesh>],
) {
    let [right, up, forward] = axes;
    let plain = |p: DVec3| [p.dot(right), p.dot(up), p.dot(forward), 0.0, 0.0, 0.0];
    let e = Extents::of(meshes, plain);
    let (low, high) = if e.is_empty() { ([0.0; 6], [1.0; 6]) } else { (e.low, e.high) };
    let extent = [0, 1, 2].map(|i| high[i] - low[i]);
    let largest = extent.iter().copied().fold(0.0, f64::max);
    let scale = if largest > 0.0 { largest } else { 1.0 };
    let mid = [0, 1, 2].map(|i| low[i] + 0.5 * extent[i]);
    let at = |x: f64, y: f64, z: f64| right * x + up * y + forward * z;
    if spec.projection == Projection::Orthographic {
        let w = window.unwrap_or(CameraSpec::height_window(height(extent[0], extent[1], size), size));
        spec.window = w;
        let (x, y) = (mid[0] - 0.5 * (w.left + w.right), mid[1] - 0.5 * (w.top + w.bottom));
        spec.position = at(x, y, low[2] - scale);
        spec.look_at = at(x, y, mid[2]);
        return;
    }
    let w = window.unwrap_or(spec.window);
    let ([x0, x1], [y0, y1]) = (slopes(w.left, w.right, w.distance), slopes(w.bottom, w.top, w.distance));
    // A point (x, y, z) is seen between the slopes a and b from the eye (ex, ez) when
    // x − ex ≥ a(z − ez) and x − ex ≤ b(z − ez): linear in the eye. The extremes over all points are
    // A = min(x − az) and B = max(x − bz); then ex lies in [B + b·ez, A + a·ez], which is not empty up to
    // ez = (A − B)/(b − a).
    let e = Extents::of(meshes, |p| {
        let [x, y, z, ..] = plain(p);
        [x - x0 * z, x - x1 * z, y - y0 * z, y - y1 * z, 0.0, 0.0]
    });
    let (low6, high6) = if e.is_empty() { ([0.0; 6], [1.0; 6]) } else { (e.low, e.high) };
    let nearest = |a: f64, b: f64, slopes: [f64; 2]| (a - b) / (slopes[1] - slopes[0]);
    let ez = nearest(low6[0], high6[1], [x0, x1])
        .min(nearest(low6[2], high6[3], [y0, y1]))
        // Never inside or on the object, as when it is a point or a line along the view.
        .min(low[2] - 0.01 * scale);
    let ex = 0.5 * (high6[1] + x1 * ez + low6[0] + x0 * ez);
    let ey = 0.5 * (high6[3] + y1 * ez + low6[2] + y0 * ez);
    spec.window = w;
    spec.position = at(ex, ey, ez);
    spec.look_at = at(ex, ey, mid[2]);
}

/// The slopes of a window's two borders, the margin taken off, in ascending order.
fn slopes(a: f64, b: f64, distance: f64) -> [f64; 2] {
    let (low, high) = (a.min(b) / distance, a.max(b) / distance);
    let inset = auto::MARGIN * (high - low);
    [low + inset, high - inset]
}

#[cfg(test)]
mod tests;
