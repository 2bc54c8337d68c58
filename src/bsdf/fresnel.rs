//! How much a smooth interface reflects.

use crate::math::Rgb;

/// Reflectance of a conductor with complex index `eta + i·k` (relative to air) for unpolarised light at
/// incidence `cos`, one channel (Born and Wolf, 14.2).
pub fn conductor(cos: f64, eta: f64, k: f64) -> f64 {
    let cos2 = (cos * cos).clamp(0.0, 1.0);
    let sin2 = 1.0 - cos2;
    let t0 = eta * eta - k * k - sin2;
    let a2b2 = (t0 * t0 + 4.0 * eta * eta * k * k).sqrt();
    let a = (0.5 * (a2b2 + t0)).max(0.0).sqrt();
    let t1 = a2b2 + cos2;
    let t2 = 2.0 * cos * a;
    let rs = (t1 - t2) / (t1 + t2);
    let t3 = cos2 * a2b2 + sin2 * sin2;
    let t4 = t2 * sin2;
    let rp = if t3 + t4 > 0.0 { rs * (t3 - t4) / (t3 + t4) } else { rs };
    (0.5 * (rs + rp)).clamp(0.0, 1.0)
}

/// Reflectance of a smooth boundary at incidence `cos` ≥ 0, and the cosine on the other side (0 at total
/// reflection); `eta` is the other side's index relative to this side's.
#[inline(always)]
pub fn dielectric(cos: f32, eta: f32) -> (f32, f32) {
    let sin2_t = (1.0 - cos * cos).max(0.0) / (eta * eta);
    if sin2_t >= 1.0 {
        return (1.0, 0.0);
    }
    let cos_t = (1.0 - sin2_t).sqrt();
    let parallel = (eta * cos - cos_t) / (eta * cos + cos_t);
    let perpendicular = (cos - eta * cos_t) / (cos + eta * cos_t);
    (0.5 * (parallel * parallel + perpendicular * perpendicular), cos_t)
}

/// The cosine-weighted average 2∫F(μ)μdμ of [`dielectric`].
pub fn dielectric_average(eta: f32) -> f32 {
    let n = 256;
    let term = |i: usize| f64::from(dielectric(((i as f32 + 0.5) / n as f32).sqrt(), eta).0);
    ((0..n).map(term).sum::<f64>() / n as f64) as f32
}

/// How a conductor reflects at normal incidence and beyond.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reflectance {
    /// The same at all angles.
    Constant(Rgb),
    /// Schlick's approximation (1994): this at normal incidence, 1 at grazing.
    Schlick(Rgb),
    /// A complex index of refraction per channel.
    Index {
        /// Real part.
        eta: Rgb,
        /// Imaginary part (absorption).
        k: Rgb,
    },
}

impl Reflectance {
    /// Reflectance at incidence `cos`.
    #[inline(always)]
    pub fn at(&self, cos: f32) -> Rgb {
        match self {
            Reflectance::Constant(r) => *r,
            Reflectance::Schlick(r) => {
                let m = (1.0 - cos).clamp(0.0, 1.0);
                *r + (Rgb::ONE - *r) * (m * m * m * m * m)
            }
            Reflectance::Index { eta, k } => {
                let channel = |i: usize| conductor(f64::from(cos), f64::from(eta[i]), f64::from(k[i])) as f32;
                Rgb::new(channel(0), channel(1), channel(2))
            }
        }
    }

    /// The cosine-weighted average over the hemisphere, 2∫F(μ)μdμ.
    pub fn average(&self) -> Rgb {
        match self {
            Reflectance::Constant(r) => *r,
            Reflectance::Schlick(r) => *r + (Rgb::ONE - *r) / 21.0,
            Reflectance::Index { .. } => {
                let n = 64;
                let mean = |i: usize| {
                    let mu = ((i as f32 + 0.5) / n as f32).sqrt();
                    self.at(mu)
                };
                (0..n).map(mean).sum::<Rgb>() / n as f32
            }
        }
    }
}
