//! Random paths before the picture, which learn where the sky is seen from ([`crate::light::Openings`]).
//!
//! They start at the camera and go on as if all surfaces were white: what matters is where light can come from, not how
//! much. Most scenes are not indoors, and a first round says so.

use super::Context;
use crate::accel::{Coherence, Hits, Intersector, LANES, MISS, Mask, Rays, lanes_of};
use crate::light::{Escape, Openings};
use crate::math::ray::leave;
use crate::math::{Frame, Vec3, warp};
use crate::shape::Surface;
use rayon::prelude::*;

/// Chunks of paths of a round: some 10 to 20 ms.
const ROUND: u32 = 1024;

/// Rounds at most.
const ROUNDS: u32 = 16;

/// So many rays to the sky are enough.
const ENOUGH: usize = 1 << 13;

/// Fewer after all rounds are leaks: shadow rays into them are not worth their time.
const FEWEST: usize = 64;

/// Rays of a path at most.
const DEPTH: u32 = 6;

/// Above this share of rays that find the sky by themselves, there is nothing to look for.
const OUTDOORS: f32 = 0.1;

/// Dimensions of a ray's direction; the first two are the place in the picture.
const NUMBERS: u32 = 2;

/// Where the sky is seen from, if the scene is indoors and there is a way out. Of the same scene, camera and seed it
/// is the same, whatever part of the picture is rendered and with how many samples. Ends early when `stop` says so.
pub fn explore(
    cx: &Context<'_>,
    accel: &dyn Intersector,
    stop: &(dyn Fn() -> bool + Sync),
) -> Option<Openings> {
    let (mut escapes, mut rays, mut error) = (Vec::new(), 0, 0.0f32);
    for round in 0..ROUNDS {
        if stop() {
            return None;
        }
        let chunks = (round * ROUND..(round + 1) * ROUND).into_par_iter();
        // In order, whoever traces them.
        let found: Vec<Found> = chunks.map(|chunk| trace(cx, accel, chunk)).collect();
        for some in found {
            escapes.extend(some.escapes);
            rays += u64::from(some.rays);
            error = error.max(some.error);
        }
        if escapes.is_empty() || escapes.len() as f32 > OUTDOORS * rays as f32 {
            return None;
        }
        if escapes.len() >= ENOUGH {
            break;
        }
    }
    if escapes.len() < FEWEST {
        return None;
    }
    let share = escapes.len() as f32 / rays as f32;
    Some(Openings::new(escapes, share, error))
}

/// What a chunk of paths found.
#[derive(Default)]
struct Found {
    escapes: Vec<Escape>,
    /// How many rays there were.
    rays: u32,
    /// The largest error of a point ([`Surface::error`]).
    error: f32,
}

/// One chunk of paths.
fn trace(cx: &Context<'_>, accel: &dyn Intersector, chunk: u32) -> Found {
    let mut found = Found::default();
    let (mut rays, mut hits) = (Rays::default(), Hits::default());
    let mut from = [Vec3::ZERO; LANES];
    let number = |lane: usize, dimension| {
        cx.random.d2(cx.random.key(chunk * LANES as u32 + lane as u32, u32::MAX), dimension)
    };
    let mut alive = Mask::MAX;
    for lane in 0..LANES {
        let [x, y] = number(lane, 0);
        let ray = cx.camera.ray(x, y, [0.5; 2], 0.0);
        rays.set(lane, ray.o, ray.d, 0.0, f32::INFINITY);
    }
    for depth in 0..DEPTH {
        let checked = rays.check(alive);
        alive = checked.active();
        accel.closest(checked, Coherence::Incoherent, &mut hits);
        for lane in lanes_of(alive) {
            found.rays += u32::from(depth > 0);
            if hits.mesh[lane] == MISS {
                alive &= !(1 << lane);
                if depth > 0 {
                    found.escapes.push((from[lane], rays.d(lane)));
                }
                continue;
            }
            let mesh = cx.mesh(hits.mesh[lane]).0;
            let s = Surface::faceted(mesh, hits.triangle[lane], hits.u[lane], hits.v[lane]);
            let n = if s.ng.dot(rays.d(lane)) < 0.0 { s.ng } else { -s.ng };
            let d = Frame::new(n).to_world(warp::cosine_hemisphere(number(lane, NUMBERS * (depth + 1))));
            from[lane] = s.p;
            found.error = found.error.max(s.error);
            rays.set(lane, leave(s.p, s.error, s.ng, d), d, 0.0, f32::INFINITY);
        }
        if alive == 0 {
            break;
        }
    }
    found
}
