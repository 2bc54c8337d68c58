//! Surfaces with holes: a hit that is not there is no hit, and its ray goes on from it in the same direction.
//!
//! Backends know triangles only, so whole rays are asked for again behind each hole. Only scenes that have
//! such materials come here.

use super::{Context, Dimensions};
use crate::accel::{Checked, Coherence, Hits, Intersector, LANES, MISS, Mask, Rays, lanes_of};
use crate::light::sphere;
use crate::math::ray::leave;
use crate::sampler::{Key, scatter};
use crate::shape::Surface;

/// More surfaces than this along one ray are taken for a wall.
const MOST_HOLES: u32 = 1 << 14;

/// How much of the surface that `lane` hit is there; `None`: all of it.
fn opacity(cx: &Context<'_>, hits: &Hits, lane: usize) -> Option<f32> {
    let (id, triangle) = (hits.mesh[lane], hits.triangle[lane] as usize);
    if id & sphere::SPHERE != 0 {
        return None; // a lamp, or nothing at all
    }
    let (mesh, _) = cx.mesh(id);
    let maps = cx.materials[cx.material(id, triangle as u32) as usize].maps.as_ref()?;
    let opacity = maps.opacity.as_ref()?;
    Some(opacity.at(mesh.uv(triangle, hits.u[lane], hits.v[lane])))
}

/// Rays on their way through holes.
struct Onward {
    /// The rays from where they are now.
    rays: Rays,
    /// How far they have come, in multiples of their directions.
    gone: [f32; LANES],
}

impl Onward {
    fn new(rays: &Rays) -> Onward {
        Onward { rays: rays.clone(), gone: [0.0; LANES] }
    }

    /// Puts a lane behind its hit. The new start is as far from the surface as any ray that leaves one.
    fn step(&mut self, cx: &Context<'_>, start: Checked<'_>, hits: &Hits, lane: usize) {
        let (mesh, place) = cx.mesh(hits.mesh[lane]);
        let mut surface = Surface::faceted(mesh, hits.triangle[lane], hits.u[lane], hits.v[lane]);
        if let Some(place) = place {
            surface = surface.placed(&cx.transform(place, start.times()[lane]));
        }
        let start = start.rays();
        let d = start.d(lane);
        let o = leave(surface.p, surface.error, surface.ng, d);
        let gone = (o - start.o(lane)).dot(d) / d.length_squared();
        self.gone[lane] = gone;
        // Past the end the interval is empty, which is a clean miss.
        self.rays.set(lane, o, d, 0.0, start.tmax[lane] - gone);
    }
}

/// Lets the rays of a chunk pass what is not there: `hits` become those of the first surfaces that are. `stays` says
/// of a lane, its hit and an opacity whether the hit counts. Returns how many rays were traced.
pub(super) fn pass(
    cx: &Context<'_>,
    accel: &dyn Intersector,
    start: Checked<'_>,
    hits: &mut Hits,
    stays: impl Fn(usize, &Hits, f32) -> bool,
) -> u64 {
    let mut onward: Option<Onward> = None;
    let mut active = start.active();
    let mut traced = 0;
    for _ in 0..MOST_HOLES {
        let mut passing: Mask = 0;
        for lane in lanes_of(active) {
            let goes_on = opacity(cx, hits, lane).is_some_and(|opacity| !stays(lane, hits, opacity));
            passing |= Mask::from(goes_on) << lane;
        }
        if passing == 0 {
            break;
        }
        let onward = onward.get_or_insert_with(|| Onward::new(start.rays()));
        for lane in lanes_of(passing) {
            onward.step(cx, start, hits, lane);
        }
        let rays = onward.rays.check(passing).at(start.times());
        traced += u64::from(rays.active().count_ones());
        for lane in lanes_of(passing) {
            hits.mesh[lane] = MISS;
        }
        accel.closest(rays, Coherence::Incoherent, hits);
        if !cx.lights.spheres.is_empty() {
            sphere::closest(&cx.lights.spheres, rays, hits);
        }
        for lane in lanes_of(passing) {
            hits.t[lane] += onward.gone[lane];
        }
        active = rays.active();
    }
    traced
}

/// What of the light along the shadow rays `lanes` passes the surfaces in their way, and how many rays were traced.
pub(super) fn transmittance(
    cx: &Context<'_>,
    accel: &dyn Intersector,
    start: Checked<'_>,
    lanes: Mask,
) -> ([f32; LANES], u64) {
    let mut share = [1.0; LANES];
    let mut onward = Onward::new(start.rays());
    let mut active = lanes;
    let mut traced = 0;
    for _ in 0..MOST_HOLES {
        let mut hits = Hits::default();
        let rays = onward.rays.check(active).at(start.times());
        traced += u64::from(rays.active().count_ones());
        accel.closest(rays, Coherence::Incoherent, &mut hits);
        let mut passing: Mask = 0;
        for lane in lanes_of(active) {
            if hits.mesh[lane] == MISS {
                continue;
            }
            share[lane] *= 1.0 - opacity(cx, &hits, lane).unwrap_or(1.0);
            passing |= Mask::from(share[lane] > 0.0) << lane;
        }
        if passing == 0 {
            return (share, traced);
        }
        for lane in lanes_of(passing) {
            onward.step(cx, start, &hits, lane);
        }
        active = passing;
    }
    for lane in lanes_of(active) {
        share[lane] = 0.0;
    }
    (share, traced)
}

/// Whether a hit of a path's ray counts, decided by a number that belongs to the sample, the place on the path and
/// the triangle, and to nothing else, so that every backend decides alike.
#[inline]
pub(super) fn counts(
    cx: &Context<'_>,
    key: Key,
    [depth, branch]: [u32; 2],
    [mesh, triangle]: [u32; 2],
    opacity: f32,
) -> bool {
    if opacity >= 1.0 || opacity <= 0.0 {
        return opacity > 0.0;
    }
    let place = scatter(mesh ^ scatter(triangle ^ scatter(branch ^ scatter(depth))));
    cx.sampler.d1(key, Dimensions::CUTOUT | (place >> 2)) < opacity
}
