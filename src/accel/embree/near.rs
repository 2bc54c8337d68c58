//! The triangles around a point.
#![allow(unsafe_code)]

use super::scene::Scene;
use crate::math::Vec3;
use embree_sys as sys;
use std::ffi::c_void;

/// What is called with the ids of geometry and triangle.
type Each<'a> = &'a mut dyn FnMut(u32, u32);

/// Calls `each` for every triangle in a leaf whose box comes within `radius` of `point`: more than the
/// triangles that do, never fewer. `each` must not panic: there is C++ below it.
pub(super) fn around(scene: &Scene, point: Vec3, radius: f32, mut each: Each<'_>) {
    let mut query = sys::RTCPointQuery { x: point.x, y: point.y, z: point.z, time: 0.0, radius };
    // As rtcInitPointQueryContext, an inline function: no instance on the stack.
    let mut context = sys::RTCPointQueryContext::default();
    context.instID[0] = sys::INVALID_ID;
    // SAFETY: the scene is committed; query and context are Embree's own types with their alignment and live
    // for the call, as does `each`, which `on_triangle` gets back as the pointer it is here.
    unsafe {
        sys::rtcPointQuery(
            scene.handle(),
            &mut query,
            &mut context,
            Some(on_triangle),
            (&raw mut each).cast::<c_void>(),
        );
    }
}

/// Passes one triangle on; `false`: the query stays as large as it is.
unsafe extern "C" fn on_triangle(arguments: *mut sys::RTCPointQueryFunctionArguments) -> bool {
    // SAFETY: Embree passes a structure that lives for the call, with the pointer `around` gave it: to an
    // `Each` that nothing else uses while the query runs, on the thread that asked.
    unsafe {
        let arguments = &*arguments;
        let each = &mut *arguments.userPtr.cast::<Each<'_>>();
        each(arguments.geomID, arguments.primID);
    }
    false
}
