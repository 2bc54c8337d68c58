//! One chunk of rays: what Embree answers, joined with what is set aside. All of it but Embree itself is compiled for the
//! instruction set in use.

use super::aside::Aside;
use super::doubt::{self, Areas};
use super::{Embree, Geometry, trace};
use crate::accel::{Checked, Coherence, Hits, LANES, Mask};
use crate::math::isa::{self, Kernel, Set};
use crate::math::soa::mask;

impl Embree {
    /// The answers that are not settled, and which of them to look at again.
    pub(super) fn trace(&self, rays: Checked<'_>, coherence: Coherence, hits: &mut Hits) -> Mask {
        isa::run(self.set, Closest { embree: self, rays, coherence, hits })
    }

    /// The active lanes that hit anything.
    pub(super) fn any(&self, rays: Checked<'_>) -> Mask {
        let [hit, left] = self.aside.as_ref().map_or([0, !0], |aside| aside.occluded(rays));
        match rays.only(left) {
            rays if rays.active() == 0 => hit,
            rays => hit | isa::run(self.set, Occluded { embree: self, rays }),
        }
    }
}

struct Closest<'a> {
    embree: &'a Embree,
    rays: Checked<'a>,
    coherence: Coherence,
    hits: &'a mut Hits,
}

impl Kernel for Closest<'_> {
    type Output = Mask;

    #[inline(always)]
    fn run<S: Set>(self) -> Mask {
        let Closest { embree, rays, coherence, hits } = self;
        match &embree.aside {
            Some(aside) => embree.beside(aside, rays, coherence, hits),
            None => {
                let areas = embree.trace_scene(rays, coherence, hits);
                doubt::doubtful(rays.rays(), rays.active(), hits, &areas, &embree.longest)
            }
        }
    }
}

struct Occluded<'a> {
    embree: &'a Embree,
    rays: Checked<'a>,
}

impl Kernel for Occluded<'_> {
    type Output = Mask;

    #[inline(always)]
    fn run<S: Set>(self) -> Mask {
        trace::occluded(&self.embree.scene, self.embree.width, self.rays)
    }
}

impl Embree {
    /// Embree's own answers, with the meshes' names, and what Embree says of the triangles' areas.
    #[inline(always)]
    fn trace_scene(&self, rays: Checked<'_>, coherence: Coherence, hits: &mut Hits) -> Areas {
        let areas = trace::closest(&self.scene, self.width, rays, coherence, hits);
        if let Geometry::Merged(merged) = &self.geometry {
            merged.name_hits(rays.active(), hits);
        }
        areas
    }

    /// [`Embree::trace`] where triangles are set aside.
    #[inline(always)]
    fn beside(&self, aside: &Aside, rays: Checked<'_>, coherence: Coherence, hits: &mut Hits) -> Mask {
        let [in_doubt, left] = aside.closest(rays, hits);
        if left == 0 {
            return in_doubt;
        }
        let mut of_scene = Hits::default();
        let areas = self.trace_scene(rays.only(left), coherence, &mut of_scene);
        let mut nearer = [false; LANES];
        for (lane, nearer) in nearer.iter_mut().enumerate() {
            // A miss is at an infinite distance and has the highest of names, as has a lane that is not asked for.
            let (t, mesh) = (of_scene.t[lane], of_scene.mesh[lane]);
            let is = (t < hits.t[lane]) | ((t == hits.t[lane]) & (mesh < hits.mesh[lane]));
            *nearer = is;
            hits.t[lane] = if is { t } else { hits.t[lane] };
            hits.u[lane] = if is { of_scene.u[lane] } else { hits.u[lane] };
            hits.v[lane] = if is { of_scene.v[lane] } else { hits.v[lane] };
            hits.mesh[lane] = if is { mesh } else { hits.mesh[lane] };
            hits.triangle[lane] = if is { of_scene.triangle[lane] } else { hits.triangle[lane] };
        }
        let nearer = mask(&nearer);
        in_doubt & !nearer | doubt::doubtful(rays.rays(), nearer, hits, &areas, &self.longest)
    }
}
