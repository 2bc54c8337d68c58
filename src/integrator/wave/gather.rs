//! From hits of a wave to [`Batch`]es of vertices.

use super::pushed::Slot;
use crate::accel::{Hits, LANES, Mask};
use crate::bsdf::{Grain, Material, Scatter};
use crate::integrator::Context;
use crate::integrator::batch::Batch;
use crate::integrator::lanes::Lanes;
use crate::math::Vec3s;
use crate::sampler::{Keys, Part};
use crate::shape::{Corners, Surfaces};

/// What a step of a wave has traced.
pub struct Traced<'a> {
    /// The rays.
    pub lanes: &'a Lanes,
    /// What they hit.
    pub hits: &'a [Hits],
    /// The samples they belong to.
    pub slots: &'a [Slot],
    /// The paths of each of these.
    pub part: Part,
}

/// The vertices of the rays numbered `of` (one to [`LANES`] of them), whose materials are of the kind that `bsdf` names.
#[inline(always)]
pub fn batch<B: Scatter + Clone>(
    cx: &Context<'_>,
    traced: &Traced<'_>,
    depth: u32,
    of: &[u32],
    bsdf: impl Fn(&Material) -> Option<&B>,
) -> Option<Batch<B>> {
    let first = *of.first()?;
    let mut numbers = [first as usize; LANES];
    for (number, i) in numbers.iter_mut().zip(of) {
        *number = *i as usize;
    }
    let (mut origin, mut wo, mut beta) = (Vec3s::ZERO, Vec3s::ZERO, Vec3s::ZERO);
    let [mut t, mut pdf, mut time] = [[0.0; LANES]; 3];
    let [mut material, mut part, mut normal, mut branch, mut slot] = [[0; LANES]; 5];
    let (mut ids, mut triangles, mut weights) = ([[0; 2]; LANES], [0; LANES], [[0.0; LANES]; 2]);
    let mut keys = Keys::ZERO;
    for lane in 0..LANES {
        let (chunk, at) = (numbers[lane] / LANES, numbers[lane] % LANES);
        let (hits, path, rays) = (&traced.hits[chunk], &traced.lanes.paths[chunk], &traced.lanes.rays[chunk]);
        let (id, triangle) = (hits.mesh[at], hits.triangle[at]);
        (weights[0][lane], weights[1][lane], triangles[lane]) = (hits.u[at], hits.v[at], triangle);
        origin.set(lane, rays.o(at));
        wo.set(lane, -rays.d(at));
        beta.set(lane, traced.lanes.beta(chunk, at));
        (t[lane], pdf[lane], normal[lane]) = (hits.t[at], path.pdf[at], path.normal[at]);
        (branch[lane], slot[lane], ids[lane]) = (path.branch[at], path.slot[at], [id, triangle]);
        let Slot { key, time: when, .. } = traced.slots[slot[lane] as usize];
        time[lane] = when;
        // Integrators that do not split number their branches by themselves.
        keys.set(lane, if cx.splits.most() > 1 { cx.branched(key, branch[lane]) } else { key });
        material[lane] = cx.material(id, triangle);
        part[lane] = cx.part(material[lane], key, depth, branch[lane]);
    }
    let meshes = std::array::from_fn(|lane| cx.mesh(ids[lane][0]).0);
    let mut surface = Surfaces::new(&Corners::fetch(&meshes, &triangles, weights));
    if cx.has_maps {
        for lane in 0..LANES {
            if let Some(maps) = &cx.materials[part[lane] as usize].maps {
                let [mesh, triangle] = ids[lane];
                let ns = maps.normal(&surface.get(lane), cx.mesh(mesh).0, triangle as usize);
                surface.ns.set(lane, ns);
            }
        }
    }
    if !cx.instances.places.is_empty() {
        for lane in 0..LANES {
            if let (_, Some(place)) = cx.mesh(ids[lane][0]) {
                surface.set(lane, &surface.get(lane).placed(&cx.transform(place, time[lane])));
            }
        }
    }
    let first = bsdf(&cx.materials[part[0] as usize])?;
    let bsdf: [B; LANES] = std::array::from_fn(|lane| {
        let material = &cx.materials[part[lane] as usize];
        let plain = bsdf(material).unwrap_or(first);
        match &material.maps {
            Some(maps) => maps.applied(plain, surface.get(lane).uv),
            None => plain.clone(),
        }
    });
    let (mut frame, mut view, mut outside) = ([Vec3s::ZERO; 3], Vec3s::ZERO, [false; LANES]);
    for (lane, outside) in outside.iter_mut().enumerate() {
        let (s, wo) = (surface.get(lane), wo.get(lane));
        let f = s.frame_towards(wo);
        frame[0].set(lane, f.s);
        frame[1].set(lane, f.t);
        frame[2].set(lane, f.n);
        view.set(lane, f.to_local(wo));
        *outside = s.ng.dot(wo) > 0.0;
    }
    if cx.has_maps {
        for lane in 0..LANES {
            let grain = grain(cx, ids[lane], part[lane], time[lane]);
            if let Some(f) = grain.and_then(|grain| grain.frame(frame[2].get(lane))) {
                frame[0].set(lane, f.s);
                frame[1].set(lane, f.t);
                view.set(lane, f.to_local(wo.get(lane)));
            }
        }
    }
    let lanes = (u32::from(Mask::MAX) >> (LANES - of.len().min(LANES))) as Mask;
    Some(Batch {
        lanes,
        depth,
        paths: traced.part,
        bsdf,
        surface,
        frame,
        wo,
        view,
        outside,
        origin,
        t,
        ids,
        material,
        part,
        beta,
        pdf,
        normal,
        branch,
        time,
        keys,
        slot,
    })
}

/// Which way the grain of material `part` lies on a triangle at a `time`.
fn grain(cx: &Context<'_>, [mesh, triangle]: [u32; 2], part: u32, time: f32) -> Option<Grain> {
    let maps = cx.materials[part as usize].maps.as_ref()?;
    let (mesh, place) = cx.mesh(mesh);
    let grain = maps.grain_at(mesh, triangle as usize)?;
    Some(place.map_or(grain, |place| grain.placed(&cx.transform(place, time))))
}
