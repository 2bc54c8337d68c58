//! Raw bindings to the Embree that Debian ships: 3.13 (Debian 12) or 4.x (Debian 13).
//!
//! The build script generates [`sys`] from the installed headers, so the declarations are those of the
//! library that is linked. The trace calls, which differ between the two versions, are bound through a C
//! shim with one interface for both: [`drt_rtc_intersect1`] and its siblings. Everything else that
//! drt uses (devices, scenes, geometries, buffers) is the same in both.
#![no_std]

/// Embree's own declarations, as bindgen reads them from `rtcore.h`.
///
/// Names and meaning are those of the Embree API manual.
#[allow(
    missing_docs,
    non_camel_case_types,
    non_snake_case,
    non_upper_case_globals,
    unsafe_op_in_unsafe_fn,
    clippy::all,
    clippy::undocumented_unsafe_blocks,
    rustdoc::all
)]
pub mod sys {
    include!(concat!(env!("OUT_DIR"), "/bindings.rs"));
}

use core::ffi::c_int;
pub use sys::*;

/// In a hit's `geomID`, `primID` and `instID`: nothing. (A macro with a cast in the header, which bindgen
/// does not evaluate.)
pub const INVALID_ID: u32 = u32::MAX;

// Contract of all of these: `scene` is committed and lives; `rays` points to a structure of the declared
// type with its alignment; in `valid` an element is -1 (trace) or 0 (leave alone); every traced ray is
// finite. They may be called by any number of threads at once.
unsafe extern "C" {
    /// Closest hit of one ray.
    pub fn drt_rtc_intersect1(scene: RTCScene, coherent: bool, rays: *mut RTCRayHit);
    /// Closest hits of 4 rays.
    pub fn drt_rtc_intersect4(scene: RTCScene, coherent: bool, valid: *const c_int, rays: *mut RTCRayHit4);
    /// Closest hits of 8 rays.
    pub fn drt_rtc_intersect8(scene: RTCScene, coherent: bool, valid: *const c_int, rays: *mut RTCRayHit8);
    /// Closest hits of 16 rays.
    pub fn drt_rtc_intersect16(scene: RTCScene, coherent: bool, valid: *const c_int, rays: *mut RTCRayHit16);
    /// Any hit of one ray: `tfar` becomes -∞ where there is one.
    pub fn drt_rtc_occluded1(scene: RTCScene, coherent: bool, rays: *mut RTCRay);
    /// Closest hits of `count` rays, one by one.
    pub fn drt_rtc_intersect_each(scene: RTCScene, rays: *mut RTCRayHit, count: usize);
    /// Any hits of `count` rays, one by one.
    pub fn drt_rtc_occluded_each(scene: RTCScene, rays: *mut RTCRay, count: usize);
    /// Any hit of 4 rays.
    pub fn drt_rtc_occluded4(scene: RTCScene, coherent: bool, valid: *const c_int, rays: *mut RTCRay4);
    /// Any hit of 8 rays.
    pub fn drt_rtc_occluded8(scene: RTCScene, coherent: bool, valid: *const c_int, rays: *mut RTCRay8);
    /// Any hit of 16 rays.
    pub fn drt_rtc_occluded16(scene: RTCScene, coherent: bool, valid: *const c_int, rays: *mut RTCRay16);
}

// What the C side assumes of these structures, checked where they are compiled. The manual asks for 16, 32
// and 64 bytes of alignment for packets of 4, 8 and 16; a structure that is aligned less faults in SSE moves.
// A hit of Embree 4 has a ninth word a ray, `instPrimID`.
const _: () = {
    use core::mem::{align_of, size_of};
    const HIT_WORDS: usize = if RTC_VERSION_MAJOR >= 4 { 9 } else { 8 };
    assert!(size_of::<RTCRay>() == 48 && align_of::<RTCRay>() == 16);
    assert!(size_of::<RTCHit>() == (HIT_WORDS * 4).next_multiple_of(16) && align_of::<RTCHit>() == 16);
    assert!(size_of::<RTCRayHit>() == 48 + size_of::<RTCHit>() && align_of::<RTCRayHit>() == 16);
    assert!(size_of::<RTCRay4>() == 12 * 16 && align_of::<RTCRay4>() == 16);
    assert!(size_of::<RTCRayHit4>() == (12 + HIT_WORDS) * 16 && align_of::<RTCRayHit4>() == 16);
    assert!(size_of::<RTCRay8>() == 12 * 32 && align_of::<RTCRay8>() == 32);
    assert!(size_of::<RTCRayHit8>() == (12 + HIT_WORDS) * 32 && align_of::<RTCRayHit8>() == 32);
    assert!(size_of::<RTCRay16>() == 12 * 64 && align_of::<RTCRay16>() == 64);
    assert!(size_of::<RTCRayHit16>() == (12 + HIT_WORDS) * 64 && align_of::<RTCRayHit16>() == 64);
    assert!(size_of::<RTCBounds>() == 32 && align_of::<RTCBounds>() == 16);
    assert!(size_of::<RTCError>() == 4 && size_of::<RTCFormat>() == 4);
};
