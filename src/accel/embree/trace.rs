//! Chunks of rays through Embree: packets of the device's native width, or single rays.
//!
//! Measured on the rays that renders trace, in ns of CPU time a ray (`cargo bench --bench embree -- INPUT [ISA]`, two
//! shared cores, ±10 %); "bare" is a loop in C over `rtcIntersect1` or `rtcOccluded1`, "drt" all that the backend does:
//!
//! | rays | scene | bare | single | packet | coherent packet | chosen | drt |
//! |---|---|---|---|---|---|---|---|
//! | camera | dragon, AVX-512 | 137 | 158 | 146 | **102** | coherent | 125 |
//! | camera | dragon, AVX2 | 132 | 154 | 139 | **107** | coherent | 128 |
//! | camera | Cornell box | 56 | 87 | 51 | **14** | coherent | 17 |
//! | camera | 5 M triangles | 257 | 276 | 252 | **212** | coherent | 259 |
//! | bounce | dragon, AVX-512 | 509 | 559 | **550** | 810 | packet | 532 |
//! | bounce | dragon, AVX2 | 509 | 553 | **541** | 804 | packet | 566 |
//! | bounce | Cornell box | 111 | 135 | **118** | 169 | packet | 130 |
//! | bounce | 5 M triangles | 465 | 485 | **456** | 642 | packet | 472 |
//! | shadow | dragon, AVX-512 | 501 | 532 | **504** | 627 | packet | 488 |
//! | shadow | dragon, AVX2 | 501 | **523** | 524 | 620 | packet | 504 |
//! | shadow | Cornell box | 54 | 74 | **39** | 67 | packet | 39 |
//! | shadow | 5 M triangles | 550 | 570 | **518** | 668 | packet | 521 |
#![allow(unsafe_code)]

use super::device::Device;
use super::doubt::Areas;
use super::scene::Scene;
use crate::accel::{Checked, Coherence, Hits, LANES, MISS, Mask, Rays, lanes_of};
use embree_sys as sys;

/// How many rays Embree traces at once on this device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Width {
    Four,
    Eight,
    Sixteen,
}

/// How the lanes of a chunk go through Embree.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// One by one.
    Single,
    /// As packets of the device's native width.
    Packet,
    /// As packets with Embree's coherent flag: one frustum for all of its rays.
    CoherentPacket,
}

impl Way {
    /// Every way.
    pub const ALL: [Way; 3] = [Way::Single, Way::Packet, Way::CoherentPacket];

    /// The fastest way for closest hits (see the module's table).
    #[inline]
    pub(super) fn for_closest(active: Mask, coherence: Coherence) -> Way {
        match coherence {
            _ if active.count_ones() <= FEW => Way::Single,
            Coherence::Coherent => Way::CoherentPacket,
            Coherence::Incoherent => Way::Packet,
        }
    }

    /// The fastest way for shadow rays: never with the coherent flag, however coherent they are. It makes a render's
    /// shadow rays slower, and with it `rtcOccluded16` of 3.13.5 was seen to loop for ever on a packet of ordinary rays
    /// of several octants and one without direction.
    #[inline]
    pub(super) fn for_occluded(width: Width, active: Mask) -> Way {
        let single = active.count_ones() <= FEW || width == Width::Four;
        if single { Way::Single } else { Way::Packet }
    }
}

/// Up to this many active lanes go one by one. Measured on bounce rays over 0.9 M triangles, AVX2 and
/// AVX-512: no difference up to three lanes, packets lead by 3–10 % from four on.
const FEW: u32 = 3;

impl Width {
    /// The widest packet that the device has kernels for. A wider one is not only slower: Debian's build
    /// aborts in an assertion.
    pub(super) fn native(device: &Device) -> Width {
        if device.has(sys::RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED) {
            Width::Sixteen
        } else if device.has(sys::RTC_DEVICE_PROPERTY_NATIVE_RAY8_SUPPORTED) {
            Width::Eight
        } else {
            Width::Four
        }
    }
}

/// Closest hits of the active lanes, and the areas of what was hit.
#[inline(always)]
pub(super) fn closest(
    scene: &Scene,
    width: Width,
    rays: Checked<'_>,
    coherence: Coherence,
    hits: &mut Hits,
) -> Areas {
    closest_by(Way::for_closest(rays.active(), coherence), scene, width, rays, hits)
}

/// The active lanes that hit anything.
#[inline(always)]
pub(super) fn occluded(scene: &Scene, width: Width, rays: Checked<'_>) -> Mask {
    occluded_by(Way::for_occluded(width, rays.active()), scene, width, rays)
}

/// Closest hits of the active lanes by the way that is named.
#[inline(always)]
pub(super) fn closest_by(way: Way, scene: &Scene, width: Width, rays: Checked<'_>, hits: &mut Hits) -> Areas {
    let (rays, active, coherent) = (rays.rays(), rays.active(), way == Way::CoherentPacket);
    let mut areas = [0.0; LANES];
    let to = &mut (hits, &mut areas);
    match width {
        _ if way == Way::Single => {
            for lane in lanes_of(active) {
                closest_one(scene, rays, lane, to);
            }
        }
        Width::Sixteen => closest16(scene, rays, active, 0, coherent, to),
        Width::Eight => {
            for at in parts::<8>(active) {
                closest8(scene, rays, active, at, coherent, to);
            }
        }
        Width::Four => {
            for at in parts::<4>(active) {
                closest4(scene, rays, active, at, coherent, to);
            }
        }
    }
    areas
}

/// The active lanes that hit anything, by the way that is named.
#[inline(always)]
pub(super) fn occluded_by(way: Way, scene: &Scene, width: Width, rays: Checked<'_>) -> Mask {
    let (rays, active, coherent) = (rays.rays(), rays.active(), way == Way::CoherentPacket);
    let mut hit = 0;
    match width {
        _ if way == Way::Single => {
            for lane in lanes_of(active) {
                hit |= occluded_one(scene, rays, lane);
            }
        }
        Width::Sixteen => hit = occluded16(scene, rays, active, 0, coherent),
        Width::Eight => {
            for at in parts::<8>(active) {
                hit |= occluded8(scene, rays, active, at, coherent);
            }
        }
        Width::Four => {
            for at in parts::<4>(active) {
                hit |= occluded4(scene, rays, active, at, coherent);
            }
        }
    }
    hit
}

/// The first lane of each group of `N` that has an active one.
#[inline(always)]
fn parts<const N: usize>(active: Mask) -> impl Iterator<Item = usize> {
    (0..LANES).step_by(N).filter(move |at| active >> at & (((1u32 << N) - 1) as Mask) != 0)
}

pub(super) fn ray(rays: &Rays, lane: usize) -> sys::RTCRay {
    sys::RTCRay {
        org_x: rays.ox[lane],
        org_y: rays.oy[lane],
        org_z: rays.oz[lane],
        tnear: rays.tmin[lane],
        dir_x: rays.dx[lane],
        dir_y: rays.dy[lane],
        dir_z: rays.dz[lane],
        time: 0.0,
        tfar: rays.tmax[lane],
        mask: u32::MAX,
        id: 0,
        flags: 0,
    }
}

/// Where closest hits go.
type To<'a> = (&'a mut Hits, &'a mut Areas);

/// A lane as Embree asks for it, with no hit yet.
pub(super) fn ray_hit(rays: &Rays, lane: usize) -> sys::RTCRayHit {
    let mut query = sys::RTCRayHit { ray: ray(rays, lane), hit: sys::RTCHit::default() };
    query.hit.geomID = sys::INVALID_ID;
    query.hit.instID = [sys::INVALID_ID];
    query
}

fn closest_one(scene: &Scene, rays: &Rays, lane: usize, (hits, areas): &mut To<'_>) {
    let mut query = ray_hit(rays, lane);
    // SAFETY: the scene is committed, the structure is Embree's own type, the ray passed the gate.
    unsafe { sys::drt_rtc_intersect1(scene.handle(), false, &mut query) }
    let hit = query.hit.geomID != MISS;
    hits.t[lane] = if hit { query.ray.tfar } else { f32::INFINITY };
    hits.u[lane] = query.hit.u;
    hits.v[lane] = query.hit.v;
    hits.mesh[lane] = query.hit.geomID;
    hits.triangle[lane] = if hit { query.hit.primID } else { MISS };
    let sys::RTCHit { Ng_x, Ng_y, Ng_z, .. } = query.hit;
    areas[lane] = (rays.dx[lane] * Ng_x + rays.dy[lane] * Ng_y + rays.dz[lane] * Ng_z).abs();
}

fn occluded_one(scene: &Scene, rays: &Rays, lane: usize) -> Mask {
    let mut query = ray(rays, lane);
    // SAFETY: as in `closest_one`.
    unsafe { sys::drt_rtc_occluded1(scene.handle(), false, &mut query) }
    Mask::from(query.tfar == f32::NEG_INFINITY) << lane
}

/// Writes the functions for packets of `$n`: Embree has a type and a function a width.
macro_rules! packets {
    ($n:literal, $RayN:ident, $RayHitN:ident, $intersect:ident, $occluded:ident,
     $rays:ident, $closest:ident, $any:ident) => {
        /// Lanes `at ..` as a packet with its validity words. Lanes that are not active may hold NaN and
        /// get a harmless ray instead: some of Embree's assertions look at all lanes of a packet.
        #[inline(always)]
        fn $rays(rays: &Rays, active: Mask, at: usize, packet: &mut sys::$RayN) -> [i32; $n] {
            const FULL: Mask = ((1u32 << $n) - 1) as Mask;
            packet.mask = [u32::MAX; $n];
            if active >> at & FULL == FULL {
                let lanes = at..at + $n;
                packet.org_x.copy_from_slice(&rays.ox[lanes.clone()]);
                packet.org_y.copy_from_slice(&rays.oy[lanes.clone()]);
                packet.org_z.copy_from_slice(&rays.oz[lanes.clone()]);
                packet.tnear.copy_from_slice(&rays.tmin[lanes.clone()]);
                packet.dir_x.copy_from_slice(&rays.dx[lanes.clone()]);
                packet.dir_y.copy_from_slice(&rays.dy[lanes.clone()]);
                packet.dir_z.copy_from_slice(&rays.dz[lanes.clone()]);
                packet.tfar.copy_from_slice(&rays.tmax[lanes]);
                return [-1; $n];
            }
            let mut valid = [0; $n];
            for i in 0..$n {
                let lane = at + i;
                let on = active >> lane & 1 == 1;
                valid[i] = -(on as i32);
                packet.org_x[i] = if on { rays.ox[lane] } else { 0.0 };
                packet.org_y[i] = if on { rays.oy[lane] } else { 0.0 };
                packet.org_z[i] = if on { rays.oz[lane] } else { 0.0 };
                packet.tnear[i] = if on { rays.tmin[lane] } else { 0.0 };
                packet.dir_x[i] = if on { rays.dx[lane] } else { 1.0 };
                packet.dir_y[i] = if on { rays.dy[lane] } else { 1.0 };
                packet.dir_z[i] = if on { rays.dz[lane] } else { 1.0 };
                packet.tfar[i] = if on { rays.tmax[lane] } else { 0.0 };
            }
            valid
        }

        #[inline(always)]
        fn $closest(scene: &Scene, rays: &Rays, active: Mask, at: usize, coherent: bool, to: &mut To<'_>) {
            let (hits, areas) = to;
            let mut packet = sys::$RayHitN::default();
            let valid = Valid($rays(rays, active, at, &mut packet.ray));
            packet.hit.geomID = [sys::INVALID_ID; $n];
            packet.hit.instID = [[sys::INVALID_ID; $n]];
            // SAFETY: the scene is committed; types and alignment are Embree's own; active rays passed the
            // gate, the others were replaced.
            unsafe { sys::$intersect(scene.handle(), coherent, valid.0.as_ptr(), &mut packet) }
            for i in 0..$n {
                let (lane, on, hit) = (at + i, valid.0[i] != 0, packet.hit.geomID[i] != MISS);
                let t = if hit { packet.ray.tfar[i] } else { f32::INFINITY };
                let triangle = if hit { packet.hit.primID[i] } else { MISS };
                hits.t[lane] = if on { t } else { hits.t[lane] };
                hits.u[lane] = if on { packet.hit.u[i] } else { hits.u[lane] };
                hits.v[lane] = if on { packet.hit.v[i] } else { hits.v[lane] };
                hits.mesh[lane] = if on { packet.hit.geomID[i] } else { hits.mesh[lane] };
                hits.triangle[lane] = if on { triangle } else { hits.triangle[lane] };
                let (ray, hit) = (&packet.ray, &packet.hit);
                let across =
                    ray.dir_x[i] * hit.Ng_x[i] + ray.dir_y[i] * hit.Ng_y[i] + ray.dir_z[i] * hit.Ng_z[i];
                areas[lane] = across.abs();
            }
        }

        #[inline(always)]
        fn $any(scene: &Scene, rays: &Rays, active: Mask, at: usize, coherent: bool) -> Mask {
            let mut packet = sys::$RayN::default();
            let valid = Valid($rays(rays, active, at, &mut packet));
            // SAFETY: as in the closest-hit function.
            unsafe { sys::$occluded(scene.handle(), coherent, valid.0.as_ptr(), &mut packet) }
            let mut hit = 0;
            for i in 0..$n {
                hit |= Mask::from(valid.0[i] != 0 && packet.tfar[i] == f32::NEG_INFINITY) << (at + i);
            }
            hit
        }
    };
}

/// Validity words with the alignment that the manual asks for.
#[repr(C, align(64))]
struct Valid<const N: usize>([i32; N]);

packets!(4, RTCRay4, RTCRayHit4, drt_rtc_intersect4, drt_rtc_occluded4, rays4, closest4, occluded4);
packets!(8, RTCRay8, RTCRayHit8, drt_rtc_intersect8, drt_rtc_occluded8, rays8, closest8, occluded8);
packets!(16, RTCRay16, RTCRayHit16, drt_rtc_intersect16, drt_rtc_occluded16, rays16, closest16, occluded16);
