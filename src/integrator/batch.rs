//! Vertices of several paths that met materials of one kind, lane beside lane.
//!
//! An integrator may take them one by one ([`Batch::each`]), or work on all lanes in loops that become vector
//! instructions (see [`crate::math::soa`]).

use super::wave::{BatchSink, PathSink};
use super::{Arrival, Facing, Vertex};
use crate::accel::{LANES, Mask, lanes_of};
use crate::bsdf::{Scatter, View};
use crate::math::{Frame, Vec3s};
use crate::sampler::{Keys, Part};
use crate::shape::Surfaces;

/// Up to [`LANES`] vertices of one depth. Lanes that are not in use repeat one that is.
#[derive(Clone, Debug)]
pub struct Batch<B> {
    /// The lanes in use.
    pub lanes: Mask,
    /// Scattering events so far.
    pub depth: u32,
    /// The paths of the sample of each.
    pub paths: Part,
    /// What scatters.
    pub bsdf: [B; LANES],
    /// See [`Vertex::surface`].
    pub surface: Surfaces<LANES>,
    /// See [`Vertex::frame`]: s, t and n.
    pub frame: [Vec3s<LANES>; 3],
    /// See [`Vertex::wo`].
    pub wo: Vec3s<LANES>,
    /// See [`View::wo`].
    pub view: Vec3s<LANES>,
    /// See [`View::outside`].
    pub outside: [bool; LANES],
    /// See [`Vertex::origin`].
    pub origin: Vec3s<LANES>,
    /// See [`Vertex::t`].
    pub t: [f32; LANES],
    /// See [`Vertex::ids`].
    pub ids: [[u32; 2]; LANES],
    /// See [`Vertex::material`].
    pub material: [u32; LANES],
    /// See [`Vertex::part`].
    pub part: [u32; LANES],
    /// See [`Arrival::beta`].
    pub beta: Vec3s<LANES>,
    /// See [`Arrival::pdf`].
    pub pdf: [f32; LANES],
    /// See [`Arrival::normal`].
    pub normal: [u32; LANES],
    /// See [`Arrival::branch`].
    pub branch: [u32; LANES],
    /// See [`Arrival::time`].
    pub time: [f32; LANES],
    /// See [`Arrival::key`].
    pub keys: Keys<LANES>,
    /// Which sample of the wave each is of.
    pub slot: [u32; LANES],
}

impl<B: Scatter> Batch<B> {
    /// See [`Scatter::is_small`].
    #[inline(always)]
    pub fn is_small(&self) -> bool {
        self.bsdf.iter().all(B::is_small)
    }
}

impl<B> Batch<B> {
    /// How a lane's surface faces the viewer.
    #[inline(always)]
    pub fn facing(&self, lane: usize) -> Facing {
        let [s, t, n] = &self.frame;
        Facing {
            frame: Frame { s: s.get(lane), t: t.get(lane), n: n.get(lane) },
            view: View { wo: self.view.get(lane), outside: self.outside[lane] },
            ng: self.surface.ng.get(lane),
            wo: self.wo.get(lane),
            beta: self.beta.get(lane),
        }
    }

    /// A vertex by itself.
    #[inline(always)]
    pub fn vertex(&self, lane: usize) -> Vertex {
        let Facing { frame, view, wo, .. } = self.facing(lane);
        Vertex {
            surface: self.surface.get(lane),
            frame,
            wo,
            view,
            origin: self.origin.get(lane),
            t: self.t[lane],
            ids: self.ids[lane],
            material: self.material[lane],
            part: self.part[lane],
            arrival: Arrival {
                beta: self.beta.get(lane),
                pdf: self.pdf[lane],
                normal: self.normal[lane],
                depth: self.depth,
                branch: self.branch[lane],
                time: self.time[lane],
                key: self.keys.get(lane),
            },
        }
    }

    /// Visits the vertices one by one.
    #[inline(always)]
    pub fn each(&self, out: &mut BatchSink<'_>, mut visit: impl FnMut(&Vertex, &B, &mut PathSink<'_>)) {
        for lane in lanes_of(self.lanes) {
            visit(&self.vertex(lane), &self.bsdf[lane], &mut out.path(self.slot[lane]))
        }
    }
}
