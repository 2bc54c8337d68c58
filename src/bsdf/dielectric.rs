//! A boundary between air and a clear dielectric, smooth or rough, of a body or of a thin sheet.
//!
//! Rough ones scatter at GGX facets that reflect and refract (Walter et al. 2007), sampled by visible normals. What
//! single scattering loses is given back to both sides by Kulla and Conty's lobes (2017), split so that the result
//! is reciprocal. Radiance is divided by η² where it enters the denser side (pbrt 4th ed., 9.5.2).

use super::energy::{Interface, energy};
use super::ggx::{self, SMOOTH};
use super::{Delta, Parameter, Sample, Scatter, View, fresnel, reflect};
use crate::math::warp::{cosine_hemisphere, cosine_hemisphere_pdf};
use crate::math::{Rgb, Vec2, Vec3};

/// Clear glass, water, diamond: reflects by Fresnel's formula and refracts the rest by Snell's law. The body
/// is on the side that `ng` points away from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dielectric {
    ior: f32,
    alpha: f32,
    tint: Rgb,
    thin: bool,
    compensate: bool,
    widths: Vec2,
    /// 1 minus the smooth boundary's average reflectance, from outside.
    passes: f32,
    /// Seen from outside and from inside; only a rough body has them.
    sides: Option<[Side; 2]>,
}

/// What compensation needs to know of one side of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Side {
    interface: Interface,
    /// 1 − E_avg.
    lost: f32,
    /// The share of what is given back that goes through.
    through: f32,
}

/// Closer to 1 than this an index bends light by less than f32 can resolve.
const SAME_INDEX: f32 = 1e-3;

/// A facet that light meets.
#[derive(Clone, Copy)]
struct Facet {
    m: Vec3,
    /// Fresnel's reflectance of the facet.
    f: f32,
}

impl Dielectric {
    /// A smooth body: `ior` is the index of refraction of the inside relative to the outside, > 0 (1.5 is window
    /// glass); `tint` what is left, per channel in [0, 1], of the light that passes the boundary (of a thin sheet:
    /// that crosses it once).
    pub fn new(ior: f32, tint: Rgb) -> Dielectric {
        Dielectric {
            ior,
            alpha: 0.0,
            tint,
            thin: false,
            compensate: true,
            widths: Vec2::ZERO,
            passes: 1.0 - fresnel::dielectric_average(ior),
            sides: None,
        }
    }

    /// The same with GGX width `alpha`; `compensate` gives back what single scattering loses.
    pub fn rough(mut self, alpha: f32, compensate: bool) -> Dielectric {
        (self.alpha, self.compensate) = (alpha, compensate);
        self.balance();
        self
    }

    /// The same as a sheet whose two boundaries are one surface (`true`), or as the boundary of a body.
    pub fn thin(mut self, thin: bool) -> Dielectric {
        self.thin = thin;
        self.balance();
        self
    }

    /// The same with or without compensation.
    pub fn with_compensation(self, compensate: bool) -> Dielectric {
        self.rough(self.alpha, compensate)
    }

    /// The light that passes.
    pub fn albedo(&self) -> Rgb {
        self.tint
    }

    /// True where light meets no facets but the plane.
    #[inline(always)]
    pub fn is_smooth(&self) -> bool {
        self.alpha < SMOOTH || (self.ior - 1.0).abs() < SAME_INDEX
    }

    /// Sets what depends on the other numbers.
    fn balance(&mut self) {
        self.widths = Vec2::splat(self.alpha);
        self.sides = None;
        if self.is_smooth() || self.thin || !self.compensate {
            return;
        }
        let [outside, inside] = [self.ior, 1.0 / self.ior].map(Interface::new);
        let lost = [outside, inside].map(|side| (1.0 - side.total_average(self.alpha)).max(1e-6));
        // Through a: x·(1 − F_a), through b: (1 − x)·(1 − F_b), and reciprocity says x = L_b/(L_a + L_b).
        let x = lost[1] / (lost[0] + lost[1]);
        // From inside, 1 − F_b = (1 − F_a)/η²: what passes is the same light.
        let passes = [self.passes, self.passes / (self.ior * self.ior)];
        self.sides = Some([
            Side { interface: outside, lost: lost[0], through: x * passes[0] },
            Side { interface: inside, lost: lost[1], through: (1.0 - x) * passes[1] },
        ]);
    }

    /// The other side's index relative to this one's.
    #[inline(always)]
    fn eta(&self, view: &View) -> f32 {
        if view.outside || self.thin { self.ior } else { 1.0 / self.ior }
    }

    /// What a facet that reflects `f` by itself sends back and lets through. For a sheet the two sums over the light
    /// that goes to and fro inside: F + (1−F)²τ²F/(1 − F²τ²) and (1−F)²τ/(1 − F²τ²), (1−F)/(1+F) where τ is 1.
    fn split(&self, f: f32) -> (Rgb, Rgb) {
        if !self.thin {
            return (Rgb::splat(f), self.tint * (1.0 - f));
        }
        let t = self.tint;
        // 1 − F²τ² vanishes only where F is 1, which nothing passes.
        let passes = t * ((1.0 - f) * (1.0 - f)) / (Rgb::ONE - t * t * (f * f)).max(Rgb::splat(1e-12));
        (Rgb::splat(f) + passes * t * f, passes)
    }

    /// The probability with which a facet that reflects `f` is sampled by reflection.
    #[inline(always)]
    fn reflection_share(&self, f: f32) -> f32 {
        if self.thin { 2.0 * f / (1.0 + f) } else { f }
    }

    /// Where light through a facet goes.
    fn refracted(&self, wo: Vec3, m: Vec3, eta: f32) -> Vec3 {
        if self.thin {
            // A sheet sends to the other side what its facets would reflect.
            let wi = m * (2.0 * wo.dot(m)) - wo;
            return Vec3::new(wi.x, wi.y, -wi.z);
        }
        let (_, cos_t) = fresnel::dielectric(wo.dot(m), eta);
        (m * (wo.dot(m) / eta - cos_t) - wo / eta).normalize()
    }

    /// The smooth boundary's reflection and refraction.
    fn smooth(&self, view: &View) -> (f32, Delta, Delta) {
        let (wo, eta) = (view.wo, self.eta(view));
        let (f, cos_t) = fresnel::dielectric(wo.z, eta);
        let (back, through) = self.split(f);
        let (wi, spread) = if self.thin {
            (-wo, 1.0)
        } else {
            (Vec3::new(-wo.x / eta, -wo.y / eta, -cos_t).normalize(), 1.0 / (eta * eta))
        };
        let reflected = Delta { wi: reflect(wo), weight: back };
        (self.reflection_share(f), reflected, Delta { wi, weight: through * spread })
    }

    /// (f_cos, pdf) of single scattering at the facets.
    fn single(&self, wo: Vec3, wi: Vec3, eta: f32) -> (Rgb, f32) {
        let lo = ggx::lambda(wo, self.widths);
        let li = ggx::lambda(wi, self.widths);
        if wi.z > 0.0 || self.thin {
            let h = wo + Vec3::new(wi.x, wi.y, wi.z.abs());
            let m = h.normalize_or(Vec3::Z);
            let (f, _) = fresnel::dielectric(wo.dot(m), eta);
            let ((back, through), share) = (self.split(f), self.reflection_share(f));
            let (weight, share) = if wi.z > 0.0 { (back, share) } else { (through, 1.0 - share) };
            // f·cos θi = F·D·G2/(4 cos θo); the visible-normal density of wi is D·G1/(4 cos θo).
            let common = ggx::d(m, self.widths) / (4.0 * wo.z);
            return (weight * (common / (1.0 + lo + li)), share * common / (1.0 + lo));
        }
        let Some(Facet { m, f }) = refracting_facet(wo, wi, eta) else { return (Rgb::ZERO, 0.0) };
        let (co, ci) = (wo.dot(m), wi.dot(m));
        // Walter's eq. 21 and 17 with this side's index 1: dωm/dωi = η²|wi·m|/(wo·m + η wi·m)².
        let d = co + eta * ci;
        let common = ggx::d(m, self.widths) * co * -ci / (wo.z * d * d);
        // Shadowing of the two sides is taken as independent, as Walter does.
        let shadowed = common * (1.0 - f) / ((1.0 + lo) * (1.0 + li));
        (self.tint * shadowed, common * (1.0 - f) * eta * eta / (1.0 + lo))
    }

    /// The share of samples that go to single scattering, the directional loss, and how the rest divides; `None`
    /// where nothing is given back.
    fn given_back(&self, view: &View) -> Option<(f32, f32, f32)> {
        if !self.compensate {
            return None;
        }
        let (e, through) = if self.thin {
            // Any constant is reciprocal here; a sheet's own average is the one that looks right.
            let through = self.passes / (2.0 - self.passes);
            (energy().directional(view.wo.z, self.alpha), through)
        } else {
            let side = &self.sides.as_ref()?[usize::from(!view.outside)];
            (side.interface.total(view.wo.z, self.alpha), side.through)
        };
        Some((e.clamp(0.1, 1.0), (1.0 - e).max(0.0), through))
    }

    /// (1 − E(i))/(1 − E_avg) of the side that `wi` is on.
    fn arriving(&self, view: &View, wi: Vec3) -> f32 {
        if self.thin {
            let table = energy();
            return (1.0 - table.directional(wi.z.abs(), self.alpha))
                / (1.0 - table.average(self.alpha)).max(1e-6);
        }
        let outside = view.outside == (wi.z > 0.0);
        let Some(sides) = &self.sides else { return 0.0 };
        let side = &sides[usize::from(!outside)];
        (1.0 - side.interface.total(wi.z.abs(), self.alpha)).max(0.0) / side.lost
    }
}

/// The facet that refracts between `wo` and `wi` on different sides.
fn refracting_facet(wo: Vec3, wi: Vec3, eta: f32) -> Option<Facet> {
    let h = (wo + wi * eta).try_normalize()?;
    let m = if h.z < 0.0 { -h } else { h };
    if wo.dot(m) <= 0.0 || wi.dot(m) >= 0.0 {
        return None;
    }
    Some(Facet { m, f: fresnel::dielectric(wo.dot(m), eta).0 })
}

impl Scatter for Dielectric {
    fn eval(&self, view: &View, wi: Vec3) -> (Rgb, f32) {
        if self.is_smooth() || wi.z == 0.0 {
            return (Rgb::ZERO, 0.0);
        }
        let eta = self.eta(view);
        let (single, pdf) = self.single(view.wo, wi, eta);
        let Some((share, lost, through)) = self.given_back(view) else { return (single, pdf) };
        let cos_pdf = cosine_hemisphere_pdf(wi.z.abs());
        let (side, color) = if wi.z > 0.0 {
            (1.0 - through, Rgb::ONE)
        } else {
            (through, if self.thin { self.tint } else { self.tint / (eta * eta) })
        };
        let multiple = color * (side * lost * self.arriving(view, wi) * cos_pdf);
        (single + multiple, share * pdf + (1.0 - share) * side * cos_pdf)
    }

    fn sample(&self, view: &View, u: [f32; 2], lobe: f32) -> Option<Sample> {
        if self.is_smooth() {
            let (share, reflected, refracted) = self.smooth(view);
            let (delta, chance) = if lobe < share { (reflected, share) } else { (refracted, 1.0 - share) };
            return Some(Sample { wi: delta.wi, weight: delta.weight / chance, pdf: f32::INFINITY });
        }
        let (wo, eta) = (view.wo, self.eta(view));
        let (share, through) = self.given_back(view).map_or((1.0, 0.0), |(share, _, t)| (share, t));
        let wi = if lobe < share {
            let m = ggx::sample_visible_normal(wo, self.widths, u);
            let (f, _) = fresnel::dielectric(wo.dot(m), eta);
            if lobe < share * self.reflection_share(f) {
                Some(m * (2.0 * wo.dot(m)) - wo).filter(|wi| wi.z > 0.0)?
            } else {
                Some(self.refracted(wo, m, eta)).filter(|wi| wi.z < 0.0)?
            }
        } else {
            let wi = cosine_hemisphere(u);
            let passes = lobe - share < (1.0 - share) * through;
            if passes { Vec3::new(wi.x, wi.y, -wi.z) } else { wi }
        };
        self.towards(view, wi)
    }

    #[inline(always)]
    fn is_delta(&self) -> bool {
        self.is_smooth()
    }

    fn deltas(&self, view: &View) -> [Option<Delta>; 2] {
        if !self.is_smooth() {
            return [None; 2];
        }
        let (share, reflected, refracted) = self.smooth(view);
        [Some(reflected), (share < 1.0).then_some(refracted)]
    }

    #[inline(always)]
    fn transmits(&self) -> bool {
        !self.is_smooth()
    }

    fn set(&mut self, parameter: Parameter, value: Rgb) -> bool {
        let value = parameter.clamp(value);
        match parameter {
            Parameter::Tint => {
                self.tint = value;
                return true; // nothing else depends on it
            }
            Parameter::Ior => {
                self.ior = value.x;
                self.passes = 1.0 - fresnel::dielectric_average(value.x);
            }
            Parameter::Roughness => self.alpha = value.x * value.x,
            Parameter::Alpha => self.alpha = value.x,
            _ => return false,
        }
        self.balance();
        true
    }
}
