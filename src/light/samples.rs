//! Light samples of several points at once: [`Lights::sample`] of every lane, bit for bit.

use super::patch::{Patch, light_sample_if, sample_rectangle};
use super::{LightSample, Lights, Receiver};
use crate::math::Vec3s;
use crate::math::ray::Ray;
use crate::math::soa::mask;
use crate::shape::Surfaces;

/// `N` light samples; the fields are those of [`LightSample`].
#[derive(Clone, Copy, Debug)]
pub struct LightSamples<const N: usize> {
    /// Lanes that have one.
    pub lanes: u16,
    /// See [`LightSample::wi`].
    pub wi: Vec3s<N>,
    /// See [`LightSample::radiance_over_pdf`].
    pub radiance_over_pdf: Vec3s<N>,
    /// See [`LightSample::pdf`].
    pub pdf: [f32; N],
    /// Origins of [`LightSample::shadow`].
    pub o: Vec3s<N>,
    /// Its directions.
    pub d: Vec3s<N>,
    /// Its ends.
    pub tmax: [f32; N],
}

impl<const N: usize> LightSamples<N> {
    const NONE: LightSamples<N> = LightSamples {
        lanes: 0,
        wi: Vec3s::ZERO,
        radiance_over_pdf: Vec3s::ZERO,
        pdf: [0.0; N],
        o: Vec3s::ZERO,
        d: Vec3s::ZERO,
        tmax: [0.0; N],
    };

    #[inline(always)]
    fn set(&mut self, lane: usize, sample: &LightSample) {
        self.wi.set(lane, sample.wi);
        self.radiance_over_pdf.set(lane, sample.radiance_over_pdf);
        self.pdf[lane] = sample.pdf;
        self.o.set(lane, sample.shadow.o);
        self.d.set(lane, sample.shadow.d);
        self.tmax[lane] = sample.shadow.tmax;
    }

    /// The sample of a lane.
    #[inline(always)]
    pub fn get(&self, lane: usize) -> LightSample {
        LightSample {
            wi: self.wi.get(lane),
            radiance_over_pdf: self.radiance_over_pdf.get(lane),
            pdf: self.pdf[lane],
            shadow: Ray { o: self.o.get(lane), d: self.d.get(lane), tmax: self.tmax[lane] },
        }
    }
}

impl Lights {
    /// One light and one direction to it from each of `lanes` of `surfaces`; `normals`: their receivers' packed normals.
    /// `choices`, `times` and `u` as in [`Lights::sample`].
    #[inline(always)]
    pub fn sample_all<const N: usize>(
        &self,
        surfaces: &Surfaces<N>,
        normals: &[u32; N],
        choices: &[u32; N],
        times: &[f32; N],
        u: &[[f32; N]; 2],
        lanes: u16,
    ) -> LightSamples<N> {
        let mut all = LightSamples::NONE;
        if let Some((Patch::Rectangle(r), emission)) = self.only_patch() {
            let (radiance, area) = ((emission.radiance, emission.two_sided), r.lengths[0] * r.lengths[1]);
            let mut there = [false; N];
            for (lane, there) in there.iter_mut().enumerate() {
                let surface = surfaces.get(lane);
                let point = sample_rectangle::<true>(r, surface.p, [u[0][lane], u[1][lane]]);
                let (sample, arrives) = light_sample_if(&surface, &point, radiance, area, 1.0);
                all.set(lane, &sample);
                *there = arrives;
            }
            all.lanes = mask(&there) & lanes;
            return all;
        }
        for lane in (0..N).filter(|lane| lanes >> lane & 1 == 1) {
            let surface = surfaces.get(lane);
            let from = Receiver::new(surface.p, normals[lane]);
            if let Some(sample) =
                self.sample(&surface, &from, choices[lane], times[lane], [u[0][lane], u[1][lane]])
            {
                all.set(lane, &sample);
                all.lanes |= 1 << lane;
            }
        }
        all
    }
}
