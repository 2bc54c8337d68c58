//! From an MTL's statements to a scattering model.
//!
//! The classic model is Phong's: `Kd` diffuse, `Ks` with exponent `Ns` the highlight, unless `illum` asks for less
//! or for ray tracing. The PBR extension's `Pm` makes a metal of it.

use super::auto;
use super::materials::{MaterialSpec, Model};
use super::mtl::{At, MtlMaterial};
use crate::bsdf::fresnel::Reflectance;
use crate::math::Rgb;

/// The material that `m` describes:
///
/// | statement | model |
/// |---|---|
/// | `Pm` ≥ ½ | a metal that reflects `Kd`, GGX roughness `Pr` (½ where it is missing) |
/// | `illum` 4, 6, 7, 9 | clear glass with index `Ni` (1.5 where it is missing), tinted by `Tf` |
/// | `illum` 3, 5, 8 with `Ks` above `Kd` | a mirror that reflects `Ks` |
/// | `illum` 0, 1, or no `Ks` | diffuse by `Kd` |
/// | the rest | Phong's, energy-limited |
///
/// `Ke` is emission in every case.
pub(super) fn from_mtl(name: &str, m: &MtlMaterial) -> MaterialSpec {
    let color = |stated: &Option<At<[f32; 3]>>| stated.as_ref().map(|at| Rgb::from(at.value));
    let diffuse = color(&m.kd).unwrap_or(auto::CLAY);
    let specular = color(&m.ks).unwrap_or(Rgb::ZERO);
    let illum = m.illum.as_ref().map(|at| at.value);
    let mut spec = MaterialSpec::diffuse(name, diffuse);
    spec.emission = color(&m.ke).unwrap_or(Rgb::ZERO);
    if m.pm.as_ref().is_some_and(|pm| pm.value >= 0.5) {
        // The scene file's own rule: GGX α is roughness squared.
        let roughness = m.pr.as_ref().map_or(0.5, |pr| pr.value);
        let reflectance = Reflectance::Constant(diffuse);
        spec.model = Model::Conductor { reflectance, alpha: roughness * roughness, compensate: true };
    } else if matches!(illum, Some(4 | 6 | 7 | 9)) {
        // An index of 1 or less is an exporter's default, not a glass.
        let ior = m.ni.as_ref().map(|ni| ni.value).filter(|ni| *ni > 1.0).unwrap_or(1.5);
        spec.model = Model::Dielectric { ior, tint: color(&m.tf).unwrap_or(Rgb::ONE) };
    } else if matches!(illum, Some(3 | 5 | 8)) && specular.max_element() > diffuse.max_element() {
        spec.model = Model::Mirror { reflectance: specular };
    } else if specular != Rgb::ZERO && !matches!(illum, Some(0 | 1)) {
        let exponent = m.ns.as_ref().map_or(0.0, |ns| ns.value);
        spec.model = Model::Phong { diffuse, specular, exponent };
    }
    spec
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stated<T>(value: T) -> Option<At<T>> {
        Some(At { value, line: 1 })
    }

    #[test]
    fn an_mtl_says_diffuse_metal_and_emission() {
        let plain = from_mtl("", &MtlMaterial::default());
        assert_eq!(plain, MaterialSpec::diffuse("", auto::CLAY));
        let red = MtlMaterial { kd: stated([0.8, 0.1, 0.0]), ke: stated([2.0; 3]), ..MtlMaterial::default() };
        let spec = from_mtl("red", &red);
        assert_eq!(spec.model, Model::Diffuse { reflectance: Rgb::new(0.8, 0.1, 0.0) });
        assert_eq!((spec.emission, spec.two_sided), (Rgb::splat(2.0), true));
        let metal = MtlMaterial { pm: stated(1.0), pr: stated(0.5), ..red };
        let reflectance = Reflectance::Constant(Rgb::new(0.8, 0.1, 0.0));
        let expected = Model::Conductor { reflectance, alpha: 0.25, compensate: true };
        assert_eq!(from_mtl("metal", &metal).model, expected);
    }

    #[test]
    fn illum_chooses_the_classic_model() {
        let with = |illum: Option<u8>| {
            let m = MtlMaterial {
                kd: stated([0.1; 3]),
                ks: stated([0.6; 3]),
                ns: stated(30.0),
                ni: stated(1.33),
                illum: illum.and_then(stated),
                ..MtlMaterial::default()
            };
            from_mtl("m", &m).model
        };
        let phong = Model::Phong { diffuse: Rgb::splat(0.1), specular: Rgb::splat(0.6), exponent: 30.0 };
        for illum in [None, Some(2)] {
            assert_eq!(with(illum), phong);
        }
        for illum in [0, 1] {
            assert_eq!(with(Some(illum)), Model::Diffuse { reflectance: Rgb::splat(0.1) });
        }
        for illum in [3, 5, 8] {
            assert_eq!(with(Some(illum)), Model::Mirror { reflectance: Rgb::splat(0.6) });
        }
        for illum in [4, 6, 7, 9] {
            assert_eq!(with(Some(illum)), Model::Dielectric { ior: 1.33, tint: Rgb::ONE });
        }
    }
}
