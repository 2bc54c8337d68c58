//! One model for most things, by the names of Burley's (2012, 2015), layered as OpenPBR does (Andersson et al. 2024).
//!
//! From below: a mixture of metal ([`Conductor`] with Schlick's colours), clear body ([`Dielectric`]) and coated
//! diffuse base ([`Plastic`]) by `metallic` and `transmission`; over it the clear coat and the sheen. A layer that
//! sends back the share E(μ) of light leaves min(1 − E(μo), 1 − E(μi)) to what is below it, which is reciprocal and
//! makes no energy. Multiple scattering between facets is given back in each part.

use super::coat::Coat;
use super::fresnel::Reflectance;
use super::{Conductor, Delta, Dielectric, Parameter, Plastic, Sample, Scatter, View, reflect, sheen};
use crate::math::warp::{cosine_hemisphere, cosine_hemisphere_pdf};
use crate::math::{Rgb, Vec3, luminance};

/// The numbers of a principled material, each in [0, 1] unless said otherwise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Look {
    /// Colour of base, metal and transmitted light.
    pub base_color: Rgb,
    /// How much of it is metal.
    pub metallic: f32,
    /// Of base, metal and clear body; GGX α is its square.
    pub roughness: f32,
    /// Strength of the base's highlight: ½ is what `ior` says, 0 none, 1 twice as much at normal incidence.
    pub specular: f32,
    /// Index of refraction, 0.1 to 10.
    pub ior: f32,
    /// Of the metal, −1 to 1.
    pub anisotropy: f32,
    /// How much of what is no metal is clear.
    pub transmission: f32,
    /// Strength of the clear coat of index 1.5.
    pub coat: f32,
    /// Its roughness.
    pub coat_roughness: f32,
    /// Strength of the sheen.
    pub sheen: f32,
    /// How much it takes the base's hue.
    pub sheen_tint: f32,
    /// Its width.
    pub sheen_roughness: f32,
}

impl Default for Look {
    fn default() -> Look {
        Look {
            base_color: Rgb::splat(0.8),
            metallic: 0.0,
            roughness: 0.5,
            specular: 0.5,
            ior: 1.5,
            anisotropy: 0.0,
            transmission: 0.0,
            coat: 0.0,
            coat_roughness: 0.03,
            sheen: 0.0,
            sheen_tint: 0.0,
            sheen_roughness: 0.5,
        }
    }
}

/// A principled material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Principled {
    look: Look,
    metal: Conductor,
    clear: Dielectric,
    base: Plastic,
    coat: Coat,
    sheen: Rgb,
}

/// What a coat is made of.
const COAT_IOR: f32 = 1.5;

/// The parts, in the order in which samples choose among them.
const METAL: usize = 0;
const CLEAR: usize = 1;
const BASE: usize = 2;
const COAT: usize = 3;
const SHEEN: usize = 4;

impl Principled {
    /// The material with that look.
    pub fn new(look: Look) -> Principled {
        let alpha = look.roughness * look.roughness;
        let mut principled = Principled {
            look,
            metal: Conductor::new(Reflectance::Schlick(look.base_color), alpha, true),
            clear: Dielectric::new(look.ior, Rgb::ONE).rough(alpha, true),
            base: Plastic::new(look.base_color, look.ior, alpha),
            coat: Coat::new(COAT_IOR, 0.0),
            sheen: Rgb::ZERO,
        };
        principled.set_ior();
        principled.set_shape();
        principled.set_color();
        principled
    }

    /// Its numbers.
    pub fn look(&self) -> &Look {
        &self.look
    }

    /// The colour that is seen.
    pub fn albedo(&self) -> Rgb {
        self.look.base_color
    }

    /// The base's index of refraction after `specular`: F0 is scaled, and an index found that has it.
    fn set_ior(&mut self) {
        let r = (self.look.ior - 1.0) / (self.look.ior + 1.0);
        let root = (r * r * 2.0 * self.look.specular).sqrt().min(0.8);
        self.base.set(Parameter::Ior, Rgb::splat((1.0 + root) / (1.0 - root)));
        self.clear.set(Parameter::Ior, Rgb::splat(self.look.ior));
    }

    fn set_shape(&mut self) {
        for (parameter, value) in
            [(Parameter::Roughness, self.look.roughness), (Parameter::Anisotropy, self.look.anisotropy)]
        {
            let value = Rgb::splat(value);
            self.metal.set(parameter, value);
            if parameter == Parameter::Roughness {
                self.clear.set(parameter, value);
                self.base.set(parameter, value);
            }
        }
        self.coat.alpha = self.look.coat_roughness * self.look.coat_roughness;
    }

    fn set_color(&mut self) {
        let color = self.look.base_color;
        self.metal = self.metal.with_reflectance(Reflectance::Schlick(color));
        self.base.set(Parameter::Reflectance, color);
        // The square root, so that light that enters and leaves has the base's colour.
        self.clear.set(Parameter::Tint, Rgb::new(color.x.sqrt(), color.y.sqrt(), color.z.sqrt()));
        let hue = (color / luminance(color).max(1e-4)).min(Rgb::ONE);
        self.sheen = Rgb::ONE.lerp(hue, self.look.sheen_tint) * self.look.sheen;
    }

    /// How the layers' bottom is mixed: metal, clear, base.
    #[inline(always)]
    fn mixture(&self) -> [f32; 3] {
        let rest = 1.0 - self.look.metallic;
        [self.look.metallic, rest * self.look.transmission, rest * (1.0 - self.look.transmission)]
    }

    /// What the sheen leaves to all below it, and coat and sheen to what is below both.
    #[inline(always)]
    fn left(&self, mu: f32) -> (f32, f32) {
        let sheen = self.sheen.max_element();
        let sheen = if sheen > 0.0 { sheen * sheen::albedo(mu, self.look.sheen_roughness) } else { 0.0 };
        let coat = if self.look.coat > 0.0 { self.look.coat * self.coat.reflected(mu) } else { 0.0 };
        ((1.0 - sheen).max(0.0), (1.0 - sheen).max(0.0) * (1.0 - coat))
    }

    /// [`Principled::left`] between two directions.
    #[inline(always)]
    fn left_between(&self, wo: Vec3, wi: Vec3) -> (f32, f32) {
        if self.look.coat == 0.0 && self.look.sheen == 0.0 {
            return (1.0, 1.0);
        }
        let (a, b) = (self.left(wo.z), self.left(wi.z.abs()));
        (a.0.min(b.0), a.1.min(b.1))
    }

    /// The probabilities of the parts: what each sends back, about.
    #[inline(always)]
    fn shares(&self, wo: Vec3) -> [f32; 5] {
        let (under_sheen, under_coat) = self.left(wo.z);
        let [metal, clear, base] = self.mixture();
        let color = self.look.base_color.max_element().max(0.1);
        let shares = [
            metal * color * under_coat,
            clear * under_coat,
            base * color * under_coat,
            under_sheen - under_coat,
            1.0 - under_sheen,
        ];
        let sum: f32 = shares.iter().sum();
        shares.map(|share| share / sum.max(1e-6))
    }

    /// The part that the number `lobe` chooses, and the number that is left to it.
    #[inline(always)]
    fn choose(shares: &[f32; 5], mut lobe: f32) -> (usize, f32) {
        let mut last = (BASE, 0.0);
        for (part, &share) in shares.iter().enumerate().filter(|(_, share)| **share > 0.0) {
            // The largest f32 below 1 is what rounding may make of the end.
            last = (part, (lobe / share).min(1.0 - f32::EPSILON / 2.0));
            if lobe < share {
                break;
            }
            lobe -= share;
        }
        last
    }
}

impl Scatter for Principled {
    fn eval(&self, view: &View, wi: Vec3) -> (Rgb, f32) {
        let (shares, mixture) = (self.shares(view.wo), self.mixture());
        let (under_sheen, under_coat) = self.left_between(view.wo, wi);
        let (mut f, mut pdf) = (Rgb::ZERO, 0.0);
        let mut add = |part: usize, weight: f32, (part_f, part_pdf): (Rgb, f32)| {
            f += part_f * weight;
            pdf += shares[part] * part_pdf;
        };
        if mixture[METAL] > 0.0 {
            add(METAL, mixture[METAL] * under_coat, self.metal.eval(view, wi));
        }
        if mixture[CLEAR] > 0.0 {
            add(CLEAR, mixture[CLEAR] * under_coat, self.clear.eval(view, wi));
        }
        if mixture[BASE] > 0.0 {
            add(BASE, mixture[BASE] * under_coat, self.base.eval(view, wi));
        }
        if self.look.coat > 0.0 {
            let (coat, coat_pdf) = self.coat.eval(view.wo, wi);
            add(COAT, self.look.coat * under_sheen, (Rgb::splat(coat), coat_pdf));
        }
        if self.look.sheen > 0.0 && wi.z > 0.0 {
            let sheen = self.sheen * sheen::f_cos(view.wo, wi, self.look.sheen_roughness);
            add(SHEEN, 1.0, (sheen, cosine_hemisphere_pdf(wi.z)));
        }
        (f, pdf)
    }

    fn sample(&self, view: &View, u: [f32; 2], lobe: f32) -> Option<Sample> {
        let shares = self.shares(view.wo);
        let (part, lobe) = Self::choose(&shares, lobe);
        let wi = match part {
            SHEEN => cosine_hemisphere(u),
            COAT if self.coat.is_smooth() => {
                let wi = reflect(view.wo);
                let weight = self.look.coat * self.left(wi.z).0 * self.coat.reflected(wi.z) / shares[COAT];
                return Some(Sample { wi, weight: Rgb::splat(weight), pdf: f32::INFINITY });
            }
            COAT => Some(self.coat.sample(view.wo, u)).filter(|wi| wi.z > 0.0)?,
            _ => {
                let sample = match part {
                    METAL => self.metal.sample(view, u, lobe),
                    CLEAR => self.clear.sample(view, u, lobe),
                    _ => self.base.sample(view, u, lobe),
                }?;
                if sample.pdf == f32::INFINITY {
                    let (_, under_coat) = self.left_between(view.wo, sample.wi);
                    let scale = self.mixture()[part] * under_coat / shares[part];
                    return Some(Sample { weight: sample.weight * scale, ..sample });
                }
                sample.wi
            }
        };
        self.towards(view, wi)
    }

    fn is_delta(&self) -> bool {
        let [metal, clear, base] = self.mixture();
        (metal == 0.0 || self.metal.is_delta())
            && (clear == 0.0 || self.clear.is_delta())
            && (base == 0.0 || self.base.is_delta())
            && (self.look.coat == 0.0 || self.coat.is_smooth())
            && self.look.sheen == 0.0
    }

    fn deltas(&self, view: &View) -> [Option<Delta>; 2] {
        let mut sides = [None::<Delta>; 2];
        let mixture = self.mixture();
        let parts = [self.metal.deltas(view), self.clear.deltas(view), self.base.deltas(view)];
        for (deltas, share) in parts.into_iter().zip(mixture).filter(|(_, share)| *share > 0.0) {
            for delta in deltas.into_iter().flatten() {
                let scale = share * self.left_between(view.wo, delta.wi).1;
                let side = &mut sides[usize::from(delta.wi.z < 0.0)];
                let before = side.map_or(Rgb::ZERO, |d| d.weight);
                *side = Some(Delta { weight: before + delta.weight * scale, ..delta });
            }
        }
        if self.look.coat > 0.0 && self.coat.is_smooth() {
            let wi = reflect(view.wo);
            let weight = self.look.coat * self.left(wi.z).0 * self.coat.reflected(wi.z);
            let before = sides[0].map_or(Rgb::ZERO, |d| d.weight);
            sides[0] = Some(Delta { wi, weight: before + weight });
        }
        sides
    }

    fn transmits(&self) -> bool {
        self.mixture()[CLEAR] > 0.0 && self.clear.transmits()
    }

    fn set(&mut self, parameter: Parameter, value: Rgb) -> bool {
        let value = parameter.clamp(value);
        let look = &mut self.look;
        match parameter {
            Parameter::BaseColor => look.base_color = value,
            Parameter::Metallic => look.metallic = value.x,
            Parameter::Roughness => look.roughness = value.x,
            Parameter::Specular => look.specular = value.x,
            Parameter::Ior => look.ior = value.x,
            Parameter::Anisotropy => look.anisotropy = value.x,
            Parameter::Transmission => look.transmission = value.x,
            Parameter::Coat => look.coat = value.x,
            Parameter::CoatRoughness => look.coat_roughness = value.x,
            Parameter::Sheen => look.sheen = value.x,
            Parameter::SheenTint => look.sheen_tint = value.x,
            Parameter::SheenRoughness => look.sheen_roughness = value.x,
            _ => return false,
        }
        match parameter {
            Parameter::BaseColor | Parameter::Sheen | Parameter::SheenTint => self.set_color(),
            Parameter::Specular | Parameter::Ior => self.set_ior(),
            Parameter::Roughness | Parameter::Anisotropy | Parameter::CoatRoughness => self.set_shape(),
            _ => {}
        }
        true
    }
}
