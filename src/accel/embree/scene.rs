//! The scene: buffers in, commit once, then only queries.
#![allow(unsafe_code)]

use super::device::Device;
use crate::accel::{Quality, cancelled};
use crate::error::Result;
use crate::shape::Positions;
use embree_sys as sys;
use std::any::Any;
use std::ffi::c_void;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::ptr::null_mut;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

/// A committed scene. It reads the buffers it was given for as long as it lives; see [`Buffers`].
pub(super) struct Scene {
    handle: sys::RTCScene,
}

// SAFETY: a scene that is committed and never changed again may be queried by any number of threads and
// released by any one (Embree manual, "Thread safety").
unsafe impl Send for Scene {}
// SAFETY: as above; `&Scene` gives queries only.
unsafe impl Sync for Scene {}

impl Scene {
    #[inline]
    pub(super) fn handle(&self) -> sys::RTCScene {
        self.handle
    }
}

impl Drop for Scene {
    fn drop(&mut self) {
        // SAFETY: released once; the device lives at least as long, since a scene counts as its user.
        unsafe { sys::rtcReleaseScene(self.handle) }
    }
}

/// A geometry's buffers.
///
/// Embree reads them without a copy: triangles' corners are fetched by index at commit and, in a compact
/// scene, by every ray. Who passes them to a scene keeps the owner alive and unchanged while the scene
/// lives. [`super::Embree`] holds an `Arc` of each mesh: as long as it does, nobody can get a `&mut Mesh`,
/// and a mesh has no interior mutability. `Positions` has the readable bytes behind the last vertex that
/// Embree's 16-byte loads need. A triangle with an index out of range is left out
/// by Embree's own check at commit.
pub(super) struct Buffers<'a> {
    positions: &'a [[f32; 3]],
    indices: &'a [[u32; 3]],
}

impl<'a> Buffers<'a> {
    pub(super) fn new(positions: &'a Positions, indices: &'a [[u32; 3]]) -> Self {
        Buffers { positions, indices }
    }

    /// Buffers at a place of the test's choice.
    ///
    /// # Safety
    /// `Positions::PADDING` elements behind the last position are readable.
    #[cfg(test)]
    pub(super) unsafe fn padded(positions: &'a [[f32; 3]], indices: &'a [[u32; 3]]) -> Self {
        Buffers { positions, indices }
    }
}

/// A scene under construction.
pub(super) struct Uncommitted<'a> {
    scene: Scene,
    device: &'a Device,
    quality: sys::RTCBuildQuality,
}

impl<'a> Uncommitted<'a> {
    pub(super) fn new(device: &'a Device, quality: Quality, robust: bool, compact: bool) -> Result<Self> {
        // High builds the medium tree in a robust scene of 3.13; a version that does more on several
        // threads (spatial splits) would be a race.
        let quality = match quality {
            Quality::Low => sys::RTC_BUILD_QUALITY_LOW,
            Quality::High if !robust => sys::RTC_BUILD_QUALITY_HIGH,
            Quality::Medium | Quality::High => sys::RTC_BUILD_QUALITY_MEDIUM,
        };
        let flags = if robust { sys::RTC_SCENE_FLAG_ROBUST } else { 0 }
            | if compact { sys::RTC_SCENE_FLAG_COMPACT } else { 0 };
        // SAFETY: the device lives; a null scene is caught by `check` before it is used.
        let handle = unsafe { sys::rtcNewScene(device.handle()) };
        device.check("make a scene")?;
        // SAFETY: the scene was just made.
        unsafe {
            sys::rtcSetSceneFlags(handle, flags);
            sys::rtcSetSceneBuildQuality(handle, quality);
        }
        device.check("set up a scene")?;
        Ok(Uncommitted { scene: Scene { handle }, device, quality })
    }

    /// Adds a triangle geometry with the id `id`; without triangles the id stays unused.
    pub(super) fn attach(&mut self, id: u32, buffers: Buffers<'_>) -> Result<()> {
        let Buffers { positions, indices } = buffers;
        if indices.is_empty() || positions.is_empty() {
            return Ok(());
        }
        // SAFETY: the pointers cover the given numbers of items, with padding (see `Buffers`), and the caller
        // keeps them. The geometry is used until it is released here; the scene keeps a reference.
        unsafe {
            let geometry = sys::rtcNewGeometry(self.device.handle(), sys::RTC_GEOMETRY_TYPE_TRIANGLE);
            self.device.check("make a geometry")?;
            sys::rtcSetGeometryBuildQuality(geometry, self.quality);
            sys::rtcSetGeometryMask(geometry, u32::MAX);
            sys::rtcSetSharedGeometryBuffer(
                geometry,
                sys::RTC_BUFFER_TYPE_VERTEX,
                0,
                sys::RTC_FORMAT_FLOAT3,
                positions.as_ptr().cast(),
                0,
                size_of::<[f32; 3]>(),
                positions.len(),
            );
            sys::rtcSetSharedGeometryBuffer(
                geometry,
                sys::RTC_BUFFER_TYPE_INDEX,
                0,
                sys::RTC_FORMAT_UINT3,
                indices.as_ptr().cast(),
                0,
                size_of::<[u32; 3]>(),
                indices.len(),
            );
            sys::rtcCommitGeometry(geometry);
            sys::rtcAttachGeometryByID(self.scene.handle, geometry, id);
            sys::rtcReleaseGeometry(geometry);
        }
        self.device.check(&format!("take mesh {id}"))
    }

    /// Builds the tree. `progress` may be called by several threads; `false` cancels.
    pub(super) fn commit(self, progress: &(dyn Fn(f64) -> bool + Sync)) -> Result<Scene> {
        let watch = Progress { report: progress, stopped: AtomicBool::new(false), panic: Mutex::new(None) };
        let handle = self.scene.handle;
        // SAFETY: `watch` lives until the callback is taken away again, and is only used through `&`.
        unsafe {
            sys::rtcSetSceneProgressMonitorFunction(
                handle,
                Some(on_progress),
                &raw const watch as *mut c_void,
            );
            sys::rtcCommitScene(handle);
            sys::rtcSetSceneProgressMonitorFunction(handle, None, null_mut());
        }
        let outcome = self.device.check("build the acceleration structure");
        if let Some(payload) = watch.panic.into_inner().ok().flatten() {
            resume_unwind(payload);
        }
        outcome?;
        // Embree asks while it builds; a small scene may never ask.
        if watch.stopped.into_inner() || !progress(1.0) {
            return Err(cancelled());
        }
        Ok(self.scene)
    }
}

struct Progress<'a> {
    report: &'a (dyn Fn(f64) -> bool + Sync),
    stopped: AtomicBool,
    panic: Mutex<Option<Box<dyn Any + Send>>>,
}

/// Hands the share done on. A panic of the caller's function stops the build and goes on after it.
unsafe extern "C" fn on_progress(watch: *mut c_void, share: f64) -> bool {
    if watch.is_null() {
        return true;
    }
    // SAFETY: `commit` passed a `Progress` that lives until it has taken the callback away.
    let watch = unsafe { &*watch.cast::<Progress<'_>>() };
    if watch.stopped.load(Ordering::Relaxed) {
        return false;
    }
    let go_on =
        catch_unwind(AssertUnwindSafe(|| (watch.report)(share.clamp(0.0, 1.0)))).unwrap_or_else(|payload| {
            if let Ok(mut first) = watch.panic.lock() {
                first.get_or_insert(payload);
            }
            false
        });
    if !go_on {
        watch.stopped.store(true, Ordering::Relaxed);
    }
    go_on
}
