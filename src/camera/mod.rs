//! Cameras: from a point of the image to a ray. One file a kind.
//!
//! Camera coordinates: x (`right`) to the right of the picture, y (`up`) up, looking along `forward`. The
//! image plane is the notes' p(α, β) of 13.1 with α to the right and β up: a rectangle [left, right] ×
//! [bottom, top] at distance f in front of the eye, through which eq. (5)'s directions pass. Pixel (0, 0) is
//! the top left one.

mod lens;
mod orthographic;
mod panorama;
mod perspective;

pub use lens::Aperture;

use crate::error::{Error, Result};
use crate::math::{DVec3, Vec3, Vec3s};
use crate::shape::{Motion, rotation};
use glam::DAffine3;
use std::sync::Arc;

/// The rectangle of the image plane that the picture shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    /// L, the α of the left border.
    pub left: f64,
    /// R, the α of the right border.
    pub right: f64,
    /// T, the β of the upper border.
    pub top: f64,
    /// B, the β of the lower border.
    pub bottom: f64,
    /// f, the plane's distance from the eye; unused by the orthographic camera.
    pub distance: f64,
}

impl Window {
    /// |Δi·Δj|, the area of one of `size` pixels on the image plane.
    pub fn pixel_area(&self, size: [u32; 2]) -> f64 {
        let delta_i = (self.right - self.left) / f64::from(size[0]);
        let delta_j = (self.bottom - self.top) / f64::from(size[1]);
        (delta_i * delta_j).abs()
    }
}

/// How points of the image become rays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// Rays from one point (or lens) through the image plane.
    Perspective,
    /// Parallel rays; the window is in metres.
    Orthographic,
    /// All directions from one point; there is no window.
    Panorama,
}

impl Projection {
    /// Every projection's name in scene files, with what it is.
    pub const NAMES: &'static [(&'static str, &'static str)] = &[
        ("perspective", "rays from one point, or from a lens, through the image plane"),
        ("orthographic", "parallel rays; `height` is the picture's height in metres"),
        ("panorama", "all directions from one point, as an equirectangular map"),
    ];
}

/// A camera as a scene file describes it: plain data in the file's own coordinates.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraSpec {
    /// How points of the image become rays.
    pub projection: Projection,
    /// The eye.
    pub position: DVec3,
    /// The point in the middle of the view.
    pub look_at: DVec3,
    /// Roughly up; must not be parallel to the view.
    pub up: DVec3,
    /// The window for a picture of `size` pixels.
    pub window: Window,
    /// The opening of the lens.
    pub aperture: Aperture,
    /// Distance of the plane in focus along the viewing axis, in metres.
    pub focus_distance: f64,
    /// When the shutter opens and closes, in seconds.
    pub shutter: [f64; 2],
    /// Moves the whole camera, in the file's coordinates; `None`: it stands.
    pub motion: Option<Arc<Motion>>,
    /// Pictures a second, where a series of them is made.
    pub fps: f64,
}

impl CameraSpec {
    /// The window of a perspective camera with vertical field of view `fov` (degrees) at distance 1.
    pub fn fov_window(fov: f64, size: [u32; 2]) -> Window {
        Self::symmetric_window(libm::tan(fov.to_radians() * 0.5), size)
    }

    /// The window of an orthographic camera that shows `height` metres.
    pub fn height_window(height: f64, size: [u32; 2]) -> Window {
        Self::symmetric_window(0.5 * height, size)
    }

    /// The same camera gone around the point looked at by so many degrees, counter-clockwise seen from above.
    #[must_use]
    pub fn orbited(&self, degrees: f64) -> CameraSpec {
        let mut camera = self.clone();
        if degrees != 0.0 {
            let turn = rotation(self.up.normalize_or(DVec3::Y), degrees);
            camera.position = self.look_at + turn * (self.position - self.look_at);
        }
        camera
    }

    fn symmetric_window(top: f64, size: [u32; 2]) -> Window {
        let right = top * f64::from(size[0]) / f64::from(size[1]);
        Window { left: -right, right, top, bottom: -top, distance: 1.0 }
    }
}

/// A camera ready to make rays, in scene coordinates.
#[derive(Clone, Debug)]
pub struct Camera {
    projection: Projection,
    eye: Vec3,
    right: Vec3,
    up: Vec3,
    forward: Vec3,
    window: [f32; 4],
    distance: f32,
    aperture: Aperture,
    focus_distance: f32,
    moving: Option<Moving>,
}

/// A camera's motion, from and to scene coordinates.
#[derive(Clone, Debug)]
struct Moving {
    motion: Arc<Motion>,
    origin: DVec3,
    shutter: [f64; 2],
}

impl Moving {
    /// At a time between 0, when the shutter opens, and 1.
    fn at(&self, time: f32) -> DAffine3 {
        let [open, close] = self.shutter;
        let there = self.motion.at(open + (close - open) * f64::from(time));
        DAffine3::from_translation(-self.origin) * there * DAffine3::from_translation(self.origin)
    }
}

/// A ray leaving the camera; `d` is unit.
#[derive(Clone, Copy, Debug)]
pub struct CameraRay {
    /// Origin.
    pub o: Vec3,
    /// Unit direction.
    pub d: Vec3,
}

impl Camera {
    /// Places the camera of `spec` in the scene whose coordinates are the file's minus `origin`.
    ///
    /// # Errors
    /// The eye on the point looked at, `up` parallel to the view, numbers that are not finite, or an empty window.
    pub fn new(spec: &CameraSpec, origin: DVec3) -> Result<Camera> {
        let view = spec.look_at - spec.position;
        if !(spec.position.is_finite() && spec.look_at.is_finite() && spec.up.is_finite()) {
            return Err(Error::new("camera: position, look_at and up must be finite"));
        }
        let forward = view.try_normalize().ok_or_else(|| {
            Error::new("camera: position and look_at are the same point").advise("move one of them")
        })?;
        let right = forward
            .cross(spec.up)
            .try_normalize()
            .filter(|_| forward.cross(spec.up).length() > 1e-6 * spec.up.length());
        let right = right.ok_or_else(|| {
            Error::new("camera: up is parallel to the view").advise("choose another up, e.g. [0, 0, 1]")
        })?;
        let up = right.cross(forward);
        let w = &spec.window;
        let sound = |x: f64| x.is_finite() && x.abs() < 1e18;
        if ![w.left, w.right, w.top, w.bottom].into_iter().all(sound)
            || w.left == w.right
            || w.top == w.bottom
            || !(w.distance > 0.0 && sound(w.distance))
        {
            return Err(Error::new("camera: the image plane is empty or not finite"));
        }
        Ok(Camera {
            projection: spec.projection,
            eye: (spec.position - origin).as_vec3(),
            right: right.as_vec3(),
            up: up.as_vec3(),
            forward: forward.as_vec3(),
            window: [w.left as f32, w.right as f32, w.top as f32, w.bottom as f32],
            distance: w.distance as f32,
            aperture: spec.aperture,
            focus_distance: spec.focus_distance as f32,
            moving: spec.motion.clone().map(|motion| Moving { motion, origin, shutter: spec.shutter }),
        })
    }

    /// The ray through image point (`x`, `y`), where (0, 0) is the top left and (1, 1) the bottom right
    /// corner of the picture; `lens` is uniform in the unit square. `time`: 0 when the shutter opens, 1 when it closes.
    #[inline(always)]
    pub fn ray(&self, x: f32, y: f32, lens: [f32; 2], time: f32) -> CameraRay {
        let ray = self.standing_ray(x, y, lens);
        match &self.moving {
            None => ray,
            Some(moving) => moved(&ray, &moving.at(time)),
        }
    }

    /// [`Camera::ray`] of several: origins, and directions.
    #[inline(always)]
    pub fn rays<const N: usize>(
        &self,
        [x, y]: [&[f32; N]; 2],
        lens: &[[f32; N]; 2],
        time: &[f32; N],
    ) -> [Vec3s<N>; 2] {
        let [mut o, mut d] = [Vec3s::ZERO; 2];
        // By itself, so that the usual case is a loop without branches.
        if matches!(self.projection, Projection::Perspective) && !self.has_lens() && self.moving.is_none() {
            for lane in 0..N {
                let (alpha, beta) = self.on_window(x[lane], y[lane]);
                o.set(lane, self.eye);
                d.set(lane, self.through(alpha, beta).normalize());
            }
            return [o, d];
        }
        for lane in 0..N {
            let ray = self.ray(x[lane], y[lane], [lens[0][lane], lens[1][lane]], time[lane]);
            o.set(lane, ray.o);
            d.set(lane, ray.d);
        }
        [o, d]
    }

    /// The window's α and β at image point (`x`, `y`).
    #[inline(always)]
    fn on_window(&self, x: f32, y: f32) -> (f32, f32) {
        let [l, r, t, b] = self.window;
        (l + x * (r - l), t + y * (b - t))
    }

    #[inline(always)]
    fn standing_ray(&self, x: f32, y: f32, lens: [f32; 2]) -> CameraRay {
        let (alpha, beta) = self.on_window(x, y);
        match self.projection {
            Projection::Perspective => self.perspective_ray(alpha, beta, lens),
            Projection::Orthographic => self.orthographic_ray(alpha, beta),
            Projection::Panorama => self.panorama_ray(x, y),
        }
    }

    /// The distance along the viewing axis of what lies at `t` on a ray along the unit direction `d`, as the shutter opens.
    pub fn depth(&self, d: Vec3, t: f32) -> f64 {
        let forward = self.forward.as_dvec3();
        let forward =
            self.moving.as_ref().map_or(forward, |moving| moving.at(0.0).transform_vector3(forward));
        f64::from(t) * d.as_dvec3().dot(forward)
    }

    /// The same camera as a pinhole.
    #[must_use]
    pub fn pinhole(mut self) -> Camera {
        self.aperture.radius = 0.0;
        self
    }

    /// True when rays depend on the lens sample.
    pub fn has_lens(&self) -> bool {
        self.aperture.radius > 0.0 && self.projection == Projection::Perspective
    }
}

/// The ray from a camera that has moved.
fn moved(ray: &CameraRay, there: &DAffine3) -> CameraRay {
    let (o, d) = (there.transform_point3(ray.o.as_dvec3()), there.transform_vector3(ray.d.as_dvec3()));
    CameraRay { o: o.as_vec3(), d: d.as_vec3().normalize() }
}

#[cfg(test)]
mod tests;
