//! The upper tree: two children a node, one instance a leaf, sixteen rays at a time.

use super::bounds::MARGIN;
use crate::accel::{Checked, LANES, Mask, lanes_of};
use crate::math::{Aabb, Vec3};

/// In a child's index: it is an instance.
const LEAF: u32 = 1 << 31;

/// Instances are split by cost in so many bins an axis (I. Wald, "On fast Construction of SAH-based Bounding Volume
/// Hierarchies", 2007).
const BINS: usize = 16;

/// From this depth on they are halved, which bounds the depth whatever the boxes are.
const DEEP: usize = 48;

/// Nodes that wait at most: one a level, of which there are [`DEEP`] and 32 for halving 2³² instances.
const WAITING: usize = DEEP + 36;

/// Two boxes and what is in them.
#[derive(Clone, Copy, Debug)]
struct Node {
    boxes: [Aabb; 2],
    children: [u32; 2],
}

/// A tree over boxes.
#[derive(Debug, Default)]
pub struct Tree {
    nodes: Vec<Node>,
}

/// A box with its index, while the tree is built.
#[derive(Clone, Copy)]
struct Item {
    bounds: Aabb,
    center: Vec3,
    id: u32,
}

impl Tree {
    /// The tree over `boxes`, by their indices; empty ones are left out.
    pub fn new(boxes: &[Aabb]) -> Tree {
        let item = |(i, b): (usize, &Aabb)| Item { bounds: *b, center: b.center(), id: i as u32 };
        let mut items: Vec<Item> =
            boxes.iter().enumerate().filter(|(_, b)| !b.is_empty()).map(item).collect();
        let mut tree = Tree { nodes: Vec::with_capacity(items.len().max(1)) };
        match items.as_mut_slice() {
            [] => {}
            [only] => {
                tree.nodes.push(Node { boxes: [only.bounds, Aabb::EMPTY], children: [LEAF | only.id; 2] })
            }
            all => {
                tree.split(all, 0);
            }
        }
        tree
    }

    /// Adds the nodes over two or more items; says which is the uppermost.
    fn split(&mut self, items: &mut [Item], depth: usize) -> u32 {
        let at = self.nodes.len();
        self.nodes.push(Node { boxes: [Aabb::EMPTY; 2], children: [0; 2] });
        let middle = if depth < DEEP { by_cost(items) } else { None };
        let middle = middle.unwrap_or_else(|| halve(items));
        let (left, right) = items.split_at_mut(middle);
        for (side, part) in [left, right].into_iter().enumerate() {
            let bounds = part.iter().fold(Aabb::EMPTY, |b, item| b.union(item.bounds));
            let child = if let [only] = part { LEAF | only.id } else { self.split(part, depth + 1) };
            (self.nodes[at].boxes[side], self.nodes[at].children[side]) = (bounds, child);
        }
        at as u32
    }

    /// Bytes that it takes.
    pub fn bytes(&self) -> usize {
        self.nodes.len() * size_of::<Node>()
    }

    /// Calls `leaf` with every instance whose box some of the lanes `active` enter, about the nearest first, and which
    /// lanes these are; it may shorten rays, and returns the lanes that are done.
    #[inline(always)]
    pub fn visit(
        &self,
        lanes: &mut Lanes<'_>,
        mut active: Mask,
        mut leaf: impl FnMut(&mut Lanes<'_>, usize, Mask) -> Mask,
    ) {
        if self.nodes.is_empty() {
            return;
        }
        // What waits: a child by its parent and side, and the lanes that entered its box.
        let mut waiting = [(0u32, 0u8, 0 as Mask); WAITING];
        let mut count = 0;
        let mut next = Some((0u32, active));
        loop {
            if let Some((node, inside)) = next.take() {
                let Node { boxes, children } = &self.nodes[node as usize];
                let a = lanes.enter(&boxes[0], inside);
                // One instance alone makes a node with one child.
                let b = if children[0] == children[1] { NOTHING } else { lanes.enter(&boxes[1], inside) };
                let first = usize::from(b.nearest < a.nearest);
                for (side, entered) in [(1 - first, [a, b][1 - first]), (first, [a, b][first])] {
                    if entered.lanes != 0 && count < WAITING {
                        // A child that is visited next anyway needs no second look.
                        if side == first && children[side] & LEAF == 0 {
                            next = Some((children[side], entered.lanes));
                        } else {
                            waiting[count] = (node, side as u8, entered.lanes);
                            count += 1;
                        }
                    }
                }
                continue;
            }
            if count == 0 || active == 0 {
                return;
            }
            count -= 1;
            let (node, side, entered) = waiting[count];
            let Node { boxes, children } = &self.nodes[node as usize];
            let (child, bounds) = (children[side as usize], &boxes[side as usize]);
            // Rays may have become shorter since.
            let inside = lanes.enter(bounds, entered & active).lanes;
            if inside == 0 {
                continue;
            }
            if child & LEAF == 0 {
                next = Some((child, inside));
            } else {
                active &= !leaf(lanes, (child & !LEAF) as usize, inside);
            }
        }
    }
}

/// Where to cut so that surface areas times counts are least; `None` where no cut separates anything.
fn by_cost(items: &mut [Item]) -> Option<usize> {
    let centers = items.iter().fold(Aabb::EMPTY, |b, item| b.grow(item.center));
    let extent = centers.extent();
    let bin = |item: &Item, axis: usize| {
        let at = (item.center[axis] - centers.min[axis]) / extent[axis];
        ((at * BINS as f32) as usize).min(BINS - 1)
    };
    let mut best: Option<(f32, usize, usize)> = None;
    for axis in (0..3).filter(|axis| extent[*axis] > 0.0) {
        let mut bins = [(Aabb::EMPTY, 0u32); BINS];
        for item in items.iter() {
            let (bounds, count) = &mut bins[bin(item, axis)];
            (*bounds, *count) = (bounds.union(item.bounds), *count + 1);
        }
        let cost = |bins: &[(Aabb, u32)]| {
            let whole = bins.iter().fold((Aabb::EMPTY, 0), |sum, b| (sum.0.union(b.0), sum.1 + b.1));
            (whole.0.half_area() * whole.1 as f32, whole.1)
        };
        for cut in 1..BINS {
            let (left, right) = (cost(&bins[..cut]), cost(&bins[cut..]));
            let sum = left.0 + right.0;
            if left.1 > 0 && right.1 > 0 && best.is_none_or(|(least, ..)| sum < least) {
                best = Some((sum, axis, cut));
            }
        }
    }
    let (_, axis, cut) = best?;
    items.sort_by_key(|item| bin(item, axis) >= cut);
    Some(items.partition_point(|item| bin(item, axis) < cut))
}

/// Halves along the longest extent of the middles.
fn halve(items: &mut [Item]) -> usize {
    let extent = items.iter().fold(Aabb::EMPTY, |b, item| b.grow(item.center)).extent();
    let axis = (0..3).fold(0, |best, axis| if extent[axis] > extent[best] { axis } else { best });
    items.sort_by(|a, b| a.center[axis].total_cmp(&b.center[axis]).then(a.id.cmp(&b.id)));
    items.len() / 2
}

/// A chunk of rays, prepared for boxes.
pub struct Lanes<'a> {
    origin: [&'a [f32; LANES]; 3],
    inverse: [[f32; LANES]; 3],
    near: &'a [f32; LANES],
    /// How far a ray from far away can be off.
    slack: [f32; LANES],
    /// How far each ray goes by now.
    pub far: [f32; LANES],
}

/// Which lanes enter a box, and how near the nearest of them does.
#[derive(Clone, Copy)]
struct Entered {
    lanes: Mask,
    nearest: f32,
}

/// No lane enters.
const NOTHING: Entered = Entered { lanes: 0, nearest: f32::INFINITY };

impl<'a> Lanes<'a> {
    /// Prepares all lanes; those that are not active may hold anything.
    #[inline(always)]
    pub fn new(rays: Checked<'a>) -> Self {
        let r = rays.rays();
        // Below 1e-20 a ray stays within a box's margin over every distance that matters.
        let invert = |d: &[f32; LANES]| d.map(|d| 1.0 / d.abs().max(1e-20).copysign(d));
        let reach = |i: usize| r.ox[i].abs().max(r.oy[i].abs()).max(r.oz[i].abs());
        Lanes {
            origin: [&r.ox, &r.oy, &r.oz],
            inverse: [invert(&r.dx), invert(&r.dy), invert(&r.dz)],
            near: &r.tmin,
            slack: std::array::from_fn(|i| MARGIN * reach(i)),
            far: r.tmax,
        }
    }

    /// Slabs (Kay and Kajiya 1986): the interval within each pair of planes, and what they have in common.
    #[inline(always)]
    fn enter(&self, bounds: &Aabb, active: Mask) -> Entered {
        let (low, high) = (bounds.min.to_array(), bounds.max.to_array());
        let (mut near, mut far) = (*self.near, self.far);
        for (k, (low, high)) in low.into_iter().zip(high).enumerate() {
            for (i, (near, far)) in near.iter_mut().zip(&mut far).enumerate() {
                let (o, inverse, slack) = (self.origin[k][i], self.inverse[k][i], self.slack[i]);
                let (a, b) = ((low - slack - o) * inverse, (high + slack - o) * inverse);
                *near = near.max(a.min(b));
                *far = far.min(a.max(b));
            }
        }
        let mut inside = 0;
        for (i, (near, far)) in near.iter().zip(&far).enumerate() {
            inside |= Mask::from(near <= far) << i;
        }
        let lanes = inside & active;
        let mut nearest = f32::INFINITY;
        for i in lanes_of(lanes) {
            nearest = nearest.min(near[i]);
        }
        Entered { lanes, nearest }
    }
}
