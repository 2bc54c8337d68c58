//! `[materials.NAME]`: a material of its own, or changes to the one of that name in an MTL.

use super::reader::{Field, LIGHT, SHARE, Section};
use crate::bsdf::Bsdf;
use crate::bsdf::fresnel::{METALS, Reflectance};
use crate::error::{Error, Result, unknown_word_advice};
use crate::load::materials::{MaterialSpec, Model};
use crate::math::Rgb;
use std::collections::BTreeMap;

/// The keys of one `[materials.NAME]`.
#[derive(Clone)]
pub(crate) struct MaterialPatch<'t> {
    /// The table, for findings and errors.
    pub field: Field<'t>,
    /// The model that replaces another; without it the keys change what is there.
    model: Option<&'static str>,
    reflectance: Option<(Field<'t>, Rgb)>,
    index: Option<(Field<'t>, [Rgb; 2])>,
    alpha: Option<(Field<'t>, f32)>,
    compensate: Option<(Field<'t>, bool)>,
    emission: Option<Rgb>,
    two_sided: Option<bool>,
}

/// Reads every material by name.
pub(super) fn read_all<'t>(field: &Field<'t>) -> Result<BTreeMap<String, MaterialPatch<'t>>> {
    let materials = field.section()?.all();
    materials.into_iter().map(|(name, field)| Ok((name.to_string(), read(field)?))).collect()
}

fn read(field: Field<'_>) -> Result<MaterialPatch<'_>> {
    const LATER: &[&str] = &["phong", "dielectric", "principled", "translucent"];
    let mut table = field.section()?;
    let model = table.read("type", |f| f.word(LATER, model_name))?;
    table.not_yet(&["opacity", "normal_map", "bump"])?;
    let reflectance = with_field(&mut table, "reflectance", |f| f.color(SHARE))?;
    let index = index(&mut table)?;
    let alpha = alpha(&mut table)?;
    let compensate = with_field(&mut table, "compensate", |f| f.bool())?;
    let emission = table.read("emission", |f| f.color(LIGHT))?;
    let two_sided = table.read("two_sided", |f| f.bool())?;
    if model.is_none() {
        // Keys of models to come, given to a material whose model is not known here.
        table.not_yet(&["diffuse", "specular", "exponent", "ior", "tint", "base_color", "metallic"])?;
    }
    table.finish()?;
    if let (Some((reflectance, _)), Some((index, _))) = (&reflectance, &index) {
        let (a, b) = (reflectance.name(), index.name());
        return Err(index.error(format!("{a} and {b} exclude each other")).advise("give one of them"));
    }
    let patch = MaterialPatch { field, model, reflectance, index, alpha, compensate, emission, two_sided };
    if model.is_some() {
        // The model is known, so its keys are checked before any mesh is read.
        patch.apply(MaterialSpec::diffuse("", Rgb::ONE))?;
    }
    Ok(patch)
}

fn with_field<'t, T>(
    table: &mut Section<'t>,
    key: &'static str,
    how: impl FnOnce(&Field<'t>) -> Result<T>,
) -> Result<Option<(Field<'t>, T)>> {
    table.read(key, |f| how(&f).map(|value| (f, value)))
}

fn model_name(word: &str) -> Result<&'static str> {
    Bsdf::NAMES.iter().map(|n| n.0).find(|name| *name == word).ok_or_else(|| {
        let known: Vec<&str> = Bsdf::NAMES.iter().map(|n| n.0).collect();
        Error::new(format!("unknown material type \"{word}\"")).advise(unknown_word_advice(word, &known))
    })
}

/// `eta` and `k`, or `metal`.
fn index<'t>(table: &mut Section<'t>) -> Result<Option<(Field<'t>, [Rgb; 2])>> {
    let eta = with_field(table, "eta", |f| f.color(0.0..=100.0))?;
    let k = with_field(table, "k", |f| f.color(0.0..=100.0))?;
    let metal = with_field(table, "metal", |f| f.word(&[], metal))?;
    match (eta, k, metal) {
        (None, None, metal) => Ok(metal),
        (Some((field, eta)), Some((_, k)), None) => Ok(Some((field, [eta, k]))),
        (Some((field, _)), _, Some(_)) | (_, Some((field, _)), Some(_)) => Err(field
            .error(format!("{} and metal exclude each other", field.name()))
            .advise("give one of them")),
        (Some((field, _)), None, None) => Err(field.error(format!("{} needs k beside it", field.name()))),
        (None, Some((field, _)), None) => Err(field.error(format!("{} needs eta beside it", field.name()))),
    }
}

fn metal(word: &str) -> Result<[Rgb; 2]> {
    let found = METALS.iter().find(|m| m.0 == word);
    found.map(|m| [Rgb::from(m.1), Rgb::from(m.2)]).ok_or_else(|| {
        let known: Vec<&str> = METALS.iter().map(|m| m.0).collect();
        Error::new(format!("unknown metal \"{word}\"")).advise(unknown_word_advice(word, &known))
    })
}

/// GGX α: as it is, or as the square of `roughness`.
fn alpha<'t>(table: &mut Section<'t>) -> Result<Option<(Field<'t>, f32)>> {
    let roughness = with_field(table, "roughness", |f| f.number(SHARE).map(|r| (r * r) as f32))?;
    let alpha = with_field(table, "alpha", |f| f.number(SHARE).map(|a| a as f32))?;
    match (roughness, alpha) {
        (Some(_), Some((alpha, _))) => Err(alpha
            .error(format!("{} and roughness both set the width", alpha.name()))
            .advise("alpha is roughness squared; give one of them")),
        (roughness, alpha) => Ok(roughness.or(alpha)),
    }
}

impl MaterialPatch<'_> {
    /// The material `base` with these changes.
    ///
    /// # Errors
    /// A key that the model has not.
    pub fn apply(&self, mut base: MaterialSpec) -> Result<MaterialSpec> {
        if let Some(name) = self.model {
            base.model = self.usual(name)?;
        }
        let not_for = |field: &Field<'_>, model: &Model| {
            let what = field.name().to_string();
            Err(field.error(format!("{what} is no key of a {} material", model.name())))
        };
        if let Some((_, value)) = &self.reflectance {
            match &mut base.model {
                Model::Diffuse { reflectance } | Model::Mirror { reflectance } => *reflectance = *value,
                Model::Conductor { reflectance, .. } => *reflectance = Reflectance::Constant(*value),
            }
        }
        if let Some((field, [eta, k])) = &self.index {
            match &mut base.model {
                Model::Conductor { reflectance, .. } => {
                    *reflectance = Reflectance::Index { eta: *eta, k: *k }
                }
                other => return not_for(field, other),
            }
        }
        if let Some((field, value)) = &self.alpha {
            match &mut base.model {
                Model::Conductor { alpha, .. } => *alpha = *value,
                other => return not_for(field, other),
            }
        }
        if let Some((field, value)) = &self.compensate {
            match &mut base.model {
                Model::Conductor { compensate, .. } => *compensate = *value,
                other => return not_for(field, other),
            }
        }
        base.emission = self.emission.unwrap_or(base.emission);
        base.two_sided = self.two_sided.unwrap_or(base.two_sided);
        Ok(base)
    }

    /// The model `name` with its usual numbers.
    fn usual(&self, name: &str) -> Result<Model> {
        match name {
            "diffuse" => Ok(Model::Diffuse { reflectance: Rgb::splat(0.5) }),
            "mirror" => Ok(Model::Mirror { reflectance: Rgb::ONE }),
            "conductor" => Ok(Model::Conductor {
                reflectance: Reflectance::Constant(Rgb::ONE),
                alpha: 0.0,
                compensate: true,
            }),
            _ => Err(self.field.error(format!("material type \"{name}\" is not supported by this version"))),
        }
    }
}
