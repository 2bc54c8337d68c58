//! A scene of a few triangles: all rays of a chunk against every triangle, without a tree.
//!
//! A room has some tens of triangles. A tree over them leaves out half, one ray at a time; sixteen lanes test all of
//! them in less. The test is a filter in f32: the triangle's plane gives t, and two affine functions the weights u, v
//! of the point there, each with a bound of its error ([`super::filter`]). What
//! may be hit is kept by its least possible distance, and the exact test of [`super::triangle`] decides: the
//! nearest candidate of all lanes at once, and the few others one by one where they may be as near. So the answers are
//! bit for bit the tree's.

use super::filter::{Filter, Passage, Plane, Scales, reach};
use super::meeting::Meetings;
use super::node::{enlarge, max, min};
use super::ray::Prepared;
use super::tree::{Found, Place, Tree, rank};
use super::triangle::Block;
use crate::accel::{LANES, Mask, Rays, lanes_of};
use crate::math::Aabb;
use crate::math::isa::{Set, fused};
use std::ops::Range;

/// Up to how many triangles this is faster than the tree.
pub const FEW: usize = 64;

/// The triangles of a small scene.
pub struct Few {
    filters: Vec<Filter>,
    /// The planes, each with its filters, which adjoin.
    planes: Vec<(Plane, Range<usize>)>,
    /// The planes of a block adjoin.
    groups: Vec<Group>,
    bounds: Aabb,
}

/// The planes of one block's triangles, and the box around these.
struct Group {
    members: Range<usize>,
    slabs: Slabs,
}

/// A box: axis, then lower and upper plane, enlarged as a node's.
#[derive(Clone, Copy, Debug)]
pub struct Slabs([[f32; 2]; 3]);

/// In the key of a candidate: the bits of its number.
const NUMBER: u32 = FEW as u32 - 1;

/// The two nearest candidates of each lane: bits of the least distance, rounded down, with the triangle's number in
/// [`NUMBER`]; all ones where there is none.
struct Nearest {
    first: [u32; LANES],
    second: [u32; LANES],
}

/// The lanes that certainly hit something, and those that may: 1, or 0.
struct Blocked {
    sure: [u32; LANES],
    maybe: [u32; LANES],
}

impl Few {
    /// `None` when there are too many, or one so thin that f32 cannot hold its filter.
    pub fn new(blocks: &[Block]) -> Option<Few> {
        let mut few =
            Few { filters: Vec::new(), planes: Vec::new(), groups: Vec::new(), bounds: Aabb::EMPTY };
        if blocks.len() > FEW {
            return None;
        }
        let mut seen = Vec::new();
        for (index, block) in blocks.iter().enumerate() {
            // The two halves of a rectangle have one plane.
            let mut planes: Vec<(Plane, Vec<Filter>)> = Vec::new();
            let mut bounds = Aabb::EMPTY;
            for lane in (0..block.mesh.len()).filter(|&lane| block.mesh[lane] != u32::MAX) {
                // A triangle that was split in space is in several leaves.
                if seen.contains(&block.ids(lane)) {
                    continue;
                }
                seen.push(block.ids(lane));
                let corners = block.triangle_at(lane);
                let (plane, filter) = (Plane::of(corners)?, Filter::new(corners, Place::new(index, lane))?);
                match planes.iter_mut().find(|(known, _)| known.holds(corners, &plane)) {
                    Some((_, filters)) => filters.push(filter),
                    None => planes.push((plane, vec![filter])),
                }
                bounds = corners.iter().fold(bounds, |b, p| b.grow(*p));
            }
            few.bounds = few.bounds.union(bounds);
            few.add(planes, &bounds);
        }
        let reach = reach(&few.bounds);
        // Beyond the first, nearly everything would be in doubt; beyond the second, products may leave the range.
        let sharp = few.filters.iter().all(|f| f.slope * reach < 1e4);
        (few.filters.len() <= FEW && sharp && reach < 1e12).then_some(few)
    }

    fn add(&mut self, planes: Vec<(Plane, Vec<Filter>)>, bounds: &Aabb) {
        let first = self.planes.len();
        for (plane, filters) in planes {
            let first = self.filters.len();
            self.filters.extend(filters);
            self.planes.push((plane, first..self.filters.len()));
        }
        self.groups.push(Group::new(first..self.planes.len(), bounds));
    }

    /// The closest hits of the live rays, as [`Tree::closest`], and where the triangles at their places are met.
    #[inline(always)]
    pub fn closest<S: Set>(&self, tree: &Tree<'_>, source: &Rays, rays: &Prepared) -> (Found, Meetings) {
        let none = [u32::MAX; LANES];
        let nearest = self.show::<S, _>(source, rays, Nearest { first: none, second: none });
        if nearest.first == none {
            return (Found { hit: 0, place: [Place::default(); LANES] }, Meetings::NONE);
        }
        let place = |key: u32| match key {
            u32::MAX => Place::default(),
            key => self.filters[(key & NUMBER) as usize].place,
        };
        let mut found = Found { hit: 0, place: nearest.first.map(place) };
        let meetings = Meetings::of::<S>(tree, &found.place, rays);
        let mut again = 0;
        for i in 0..LANES {
            let hit = (meetings.is[i] == 1) & (nearest.first[i] != u32::MAX);
            // Whatever else may be hit is farther. (Where the first is a miss, nothing else may be hit.)
            let second = nearest.second[i];
            let sure = second == u32::MAX || hit && second & !NUMBER > meetings.t[i].to_bits();
            found.hit |= (hit as Mask) << i;
            again |= (!sure as Mask) << i;
        }
        (found.hit, again) = (found.hit & rays.live, again & rays.live);
        if again == 0 {
            return (found, meetings);
        }
        for i in lanes_of(again) {
            let place = tree.closest_of_all::<S>(rays, i);
            found.hit = found.hit & !(1 << i) | (place.is_some() as Mask) << i;
            found.place[i] = place.unwrap_or_default();
        }
        let meetings = Meetings::of::<S>(tree, &found.place, rays);
        (found, meetings)
    }

    /// The live rays that hit anything.
    #[inline(always)]
    pub fn occluded<S: Set>(&self, tree: &Tree<'_>, source: &Rays, rays: &Prepared) -> Mask {
        let none = [0; LANES];
        let Blocked { sure, maybe } = self.show::<S, _>(source, rays, Blocked { sure: none, maybe: none });
        let bits = |lanes: [u32; LANES]| (0..LANES).fold(0, |mask, i| mask | (lanes[i] as Mask) << i);
        let mut hit = bits(sure) & rays.live;
        for i in lanes_of(bits(maybe) & !hit & rays.live) {
            hit |= (tree.closest_of_all::<S>(rays, i).is_some() as Mask) << i
        }
        hit
    }

    /// Shows `to` every triangle whose group's box a ray meets, with where the rays pass its plane.
    #[inline(always)]
    fn show<S: Set, T: Collect>(&self, source: &Rays, rays: &Prepared, mut to: T) -> T {
        let scales = Scales::of(&self.bounds, source, rays);
        for group in &self.groups {
            if group.slabs.met::<S>(rays, &rays.tmax) == 0 {
                continue;
            }
            for (plane, filters) in &self.planes[group.members.clone()] {
                let passage = plane.pass::<S>(source, rays, &scales);
                for number in filters.clone() {
                    to.collect::<S>(number, &self.filters[number], &passage);
                }
            }
        }
        to
    }
}

/// What is made of the triangles. (A closure could become a function of its own, without the instruction set.)
trait Collect {
    /// Of triangle `number`, whose plane the rays pass.
    fn collect<S: Set>(&mut self, number: usize, filter: &Filter, passage: &Passage);
}

impl Collect for Nearest {
    #[inline(always)]
    fn collect<S: Set>(&mut self, number: usize, filter: &Filter, passage: &Passage) {
        let Nearest { first, second } = self;
        for i in 0..LANES {
            // Not negative, so that its bits are in its order; the lowest give way to the triangle's number.
            let least = if passage.least[i] > 0.0 { passage.least[i] } else { 0.0 };
            let key = least.to_bits() & !NUMBER | number as u32;
            let key = if filter.measure::<S>(passage, i).may_be != 0 { key } else { u32::MAX };
            second[i] = second[i].min(first[i].max(key));
            first[i] = first[i].min(key);
        }
    }
}

impl Collect for Blocked {
    #[inline(always)]
    fn collect<S: Set>(&mut self, _: usize, filter: &Filter, passage: &Passage) {
        for i in 0..LANES {
            let m = filter.measure::<S>(passage, i);
            self.sure[i] |= m.is;
            self.maybe[i] |= m.may_be;
        }
    }
}

impl Group {
    fn new(members: Range<usize>, bounds: &Aabb) -> Group {
        Group { members, slabs: Slabs::around(bounds) }
    }
}

impl Slabs {
    /// The box.
    pub fn around(bounds: &Aabb) -> Slabs {
        let (lo, hi) = enlarge(bounds.min.to_array(), bounds.max.to_array());
        Slabs([0, 1, 2].map(|k| [lo[k], hi[k]]))
    }

    /// The live rays that meet it before their `ends`.
    #[inline(always)]
    pub fn met<S: Set>(&self, rays: &Prepared, ends: &[f32; LANES]) -> Mask {
        let mut met = [0u32; LANES];
        for i in 0..LANES {
            let (mut from, mut to) = (rays.tmin[i], ends[i]);
            for k in 0..3 {
                let [lo, hi] = self.0[k];
                let (first, last) = if rays.near_side[k][i] == 0 { (lo, hi) } else { (hi, lo) };
                from = max(fused::<S>(first, rays.inverse[k][i], -rays.near_start[k][i]), from);
                to = min(fused::<S>(last, rays.inverse[k][i], -rays.far_start[k][i]), to);
            }
            met[i] = (from <= to) as u32;
        }
        (0..LANES).fold(0, |mask, i| mask | (met[i] as Mask) << i) & rays.live
    }
}

impl Tree<'_> {
    /// The closest hit of one ray among all triangles, without the nodes.
    #[cold]
    fn closest_of_all<S: Set>(&self, rays: &Prepared, i: usize) -> Option<Place> {
        let mut best = (rays.tmax[i], u64::MAX, None);
        for (index, block) in self.blocks.iter().enumerate() {
            let (mut met, t) = block.meet::<S>(rays, i, best.0);
            while met != 0 {
                let lane = met.trailing_zeros() as usize;
                met &= met - 1;
                let id = rank(block.ids(lane));
                if (t[lane], id) < (best.0, best.1) {
                    best = (t[lane], id, Some(Place::new(index, lane)));
                }
            }
        }
        best.2
    }
}
