//! From an MTL's statements to a scattering model; `docs/mtl.md` says it to users.
//!
//! The classic model is Phong's: `Kd` diffuse, `Ks` with exponent `Ns` the highlight, unless `illum` asks for less
//! or for ray tracing. The statements of the PBR extension make a principled material.

use super::auto;
use super::materials::MaterialSpec;
use super::mtl::{At, MtlMaterial};
use crate::bsdf::principled::Look;
use crate::bsdf::{Bsdf, Dielectric, Mirror, Phong, Principled};
use crate::math::Rgb;

/// The material that `m` describes:
///
/// | statement | model |
/// |---|---|
/// | any of `Pr`, `Pm`, `Ps`, `Pc`, `Pcr`, `aniso` | principled, see [`look`] |
/// | `illum` 4, 6, 7, 9 | clear glass with index `Ni` (1.5 where it is missing), tinted by `Tf` |
/// | `illum` 3, 5, 8 with `Ks` above `Kd` | a mirror that reflects `Ks` |
/// | `illum` 0, 1, or no `Ks` | diffuse by `Kd` |
/// | the rest | Phong's, energy-limited |
///
/// `Ke` is emission in every case.
pub(super) fn from_mtl(name: &str, m: &MtlMaterial) -> MaterialSpec {
    let diffuse = color(&m.kd).unwrap_or(auto::CLAY);
    let specular = color(&m.ks).unwrap_or(Rgb::ZERO);
    let illum = m.illum.as_ref().map(|at| at.value);
    let mut spec = MaterialSpec::diffuse(name, diffuse);
    spec.rotation = 360.0 * number(&m.anisor).unwrap_or(0.0);
    spec.emission = color(&m.ke).unwrap_or(Rgb::ZERO);
    if is_physical(m) {
        spec.model = Bsdf::Principled(Principled::new(look(m)));
    } else if is_glass(m) {
        let tint = color(&m.tf).unwrap_or(Rgb::ONE);
        spec.model = Bsdf::Dielectric(Dielectric::new(index(m), tint));
    } else if matches!(illum, Some(3 | 5 | 8)) && specular.max_element() > diffuse.max_element() {
        spec.model = Bsdf::Mirror(Mirror { reflectance: specular });
    } else if specular != Rgb::ZERO && !matches!(illum, Some(0 | 1)) {
        let exponent = m.ns.as_ref().map_or(0.0, |ns| ns.value);
        spec.model = Bsdf::Phong(Phong::new(diffuse, specular, exponent));
    }
    spec
}

fn color(stated: &Option<At<[f32; 3]>>) -> Option<Rgb> {
    stated.as_ref().map(|at| Rgb::from(at.value))
}

fn number(stated: &Option<At<f32>>) -> Option<f32> {
    stated.as_ref().map(|at| at.value)
}

/// True where a statement of the PBR extension is there.
fn is_physical(m: &MtlMaterial) -> bool {
    [&m.pr, &m.pm, &m.ps, &m.pc, &m.pcr, &m.aniso].iter().any(|stated| stated.is_some())
}

/// The illumination models with refraction.
fn is_glass(m: &MtlMaterial) -> bool {
    matches!(m.illum.as_ref().map(|at| at.value), Some(4 | 6 | 7 | 9))
}

/// An index of 1 or less is an exporter's default, not a glass.
fn index(m: &MtlMaterial) -> f32 {
    number(&m.ni).filter(|ni| *ni > 1.0).unwrap_or(1.5)
}

/// The numbers of a principled material, as Blender's importer takes them (`obj_import_mtl.cc`): base colour `Kd`,
/// specular the mean of `Ks`, roughness `Pr` or else 1 − √(Ns/1000), metallic `Pm`, sheen `Ps`, coat `Pc` with
/// roughness `Pcr`, anisotropy `aniso`. Ours alone: an illumination model with refraction makes it clear, and
/// without `Ns` roughness is ½.
fn look(m: &MtlMaterial) -> Look {
    let usual = Look::default();
    let from_exponent = |ns: f32| 1.0 - (ns.clamp(0.0, 1000.0) / 1000.0).sqrt();
    let mean = |c: Rgb| (c.x + c.y + c.z) / 3.0;
    Look {
        base_color: color(&m.kd).unwrap_or(auto::CLAY),
        metallic: number(&m.pm).unwrap_or(usual.metallic),
        roughness: number(&m.pr).or(number(&m.ns).map(from_exponent)).unwrap_or(usual.roughness),
        specular: color(&m.ks).map_or(usual.specular, mean),
        ior: index(m),
        anisotropy: number(&m.aniso).unwrap_or(usual.anisotropy),
        transmission: if is_glass(m) { 1.0 } else { usual.transmission },
        coat: number(&m.pc).unwrap_or(usual.coat),
        coat_roughness: number(&m.pcr).unwrap_or(usual.coat_roughness),
        sheen: number(&m.ps).unwrap_or(usual.sheen),
        ..usual
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::Diffuse;

    fn stated<T>(value: T) -> Option<At<T>> {
        Some(At { value, line: 1 })
    }

    #[test]
    fn an_mtl_says_diffuse_metal_and_emission() {
        let plain = from_mtl("", &MtlMaterial::default());
        assert_eq!(plain, MaterialSpec::diffuse("", auto::CLAY));
        let red = MtlMaterial { kd: stated([0.8, 0.1, 0.0]), ke: stated([2.0; 3]), ..MtlMaterial::default() };
        let spec = from_mtl("red", &red);
        assert_eq!(spec.model, Bsdf::Diffuse(Diffuse { reflectance: Rgb::new(0.8, 0.1, 0.0) }));
        assert_eq!((spec.emission, spec.two_sided), (Rgb::splat(2.0), true));
        let metal = MtlMaterial { pm: stated(1.0), pr: stated(0.5), ..red };
        let Bsdf::Principled(metal) = from_mtl("metal", &metal).model else { panic!("not principled") };
        let expected =
            Look { base_color: Rgb::new(0.8, 0.1, 0.0), metallic: 1.0, roughness: 0.5, ..Look::default() };
        assert_eq!(*metal.look(), expected);
    }

    #[test]
    fn physical_statements_arrive() {
        let m = MtlMaterial {
            kd: stated([0.2; 3]),
            ks: stated([0.1, 0.2, 0.6]),
            ns: stated(250.0),
            ni: stated(1.33),
            ps: stated(0.1),
            pc: stated(0.2),
            pcr: stated(0.3),
            aniso: stated(-0.4),
            ..MtlMaterial::default()
        };
        let expected = Look {
            base_color: Rgb::splat(0.2),
            specular: 0.3,
            roughness: 0.5,
            ior: 1.33,
            sheen: 0.1,
            coat: 0.2,
            coat_roughness: 0.3,
            anisotropy: -0.4,
            ..Look::default()
        };
        let seen = look(&m);
        assert!((seen.specular - 0.3).abs() < 1e-6);
        assert_eq!(Look { specular: 0.3, ..seen }, expected);
        assert_eq!(look(&MtlMaterial { illum: stated(4), ..m }).transmission, 1.0);
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
        let phong = Bsdf::Phong(Phong::new(Rgb::splat(0.1), Rgb::splat(0.6), 30.0));
        for illum in [None, Some(2)] {
            assert_eq!(with(illum), phong);
        }
        for illum in [0, 1] {
            assert_eq!(with(Some(illum)), Bsdf::Diffuse(Diffuse { reflectance: Rgb::splat(0.1) }));
        }
        for illum in [3, 5, 8] {
            assert_eq!(with(Some(illum)), Bsdf::Mirror(Mirror { reflectance: Rgb::splat(0.6) }));
        }
        for illum in [4, 6, 7, 9] {
            assert_eq!(with(Some(illum)), Bsdf::Dielectric(Dielectric::new(1.33, Rgb::ONE)));
        }
    }
}
