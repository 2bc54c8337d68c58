//! `[materials.NAME]`: a material of its own, or changes to the one of that name in an MTL.

use super::reader::{Field, LIGHT, SHARE, Section};
use super::texture::Textures;
use crate::bsdf::Bsdf;
use crate::bsdf::fresnel::Reflectance;
use crate::bsdf::metals::METALS;
use crate::error::{Error, Result, unknown_word_advice};
use crate::load::materials::{MaterialSpec, Model};
use crate::math::Rgb;
use std::collections::BTreeMap;
use std::path::Path;

/// The keys of one `[materials.NAME]`.
#[derive(Clone)]
pub(crate) struct MaterialPatch<'t> {
    /// The table, for findings and errors.
    pub field: Field<'t>,
    /// The model that replaces another; without it the keys change what is there.
    model: Option<Model>,
    changes: Vec<(Field<'t>, Change)>,
    emission: Option<Rgb>,
    two_sided: Option<bool>,
    textures: Textures<'t>,
}

/// A key of a model with its value.
#[derive(Clone, Copy)]
enum Change {
    Reflectance(Rgb),
    Index { eta: Rgb, k: Rgb },
    Alpha(f32),
    Compensate(bool),
    Diffuse(Rgb),
    Specular(Rgb),
    Exponent(f32),
    Ior(f32),
    Tint(Rgb),
    Transmittance(Rgb),
}

/// Reads every material by name.
pub(super) fn read_all<'t>(field: &Field<'t>, folder: &Path) -> Result<BTreeMap<String, MaterialPatch<'t>>> {
    let materials = field.section()?.all();
    materials.into_iter().map(|(name, field)| Ok((name.to_string(), read(field, folder)?))).collect()
}

fn read<'t>(field: Field<'t>, folder: &Path) -> Result<MaterialPatch<'t>> {
    const LATER: &[&str] = &["principled"];
    let mut table = field.section()?;
    let textures = Textures::take(&mut table, folder)?;
    let model = table.read("type", |f| f.word(LATER, usual))?;
    table.not_yet(&["base_color", "metallic"])?;
    let changes = [
        change(&mut table, "reflectance", |f| f.color(SHARE).map(Change::Reflectance))?,
        index(&mut table)?,
        alpha(&mut table)?,
        change(&mut table, "compensate", |f| f.bool().map(Change::Compensate))?,
        change(&mut table, "diffuse", |f| f.color(SHARE).map(Change::Diffuse))?,
        change(&mut table, "specular", |f| f.color(SHARE).map(Change::Specular))?,
        change(&mut table, "exponent", |f| f.number(0.0..=1e6).map(|n| Change::Exponent(n as f32)))?,
        change(&mut table, "ior", |f| f.number(0.1..=10.0).map(|n| Change::Ior(n as f32)))?,
        change(&mut table, "tint", |f| f.color(SHARE).map(Change::Tint))?,
        change(&mut table, "transmittance", |f| f.color(SHARE).map(Change::Transmittance))?,
    ];
    let emission = table.read("emission", |f| f.color(LIGHT))?;
    let two_sided = table.read("two_sided", |f| f.bool())?;
    table.finish()?;
    let changes: Vec<(Field<'_>, Change)> = changes.into_iter().flatten().collect();
    let of = |wanted: fn(&Change) -> bool| changes.iter().find(|(_, c)| wanted(c)).map(|(f, _)| f);
    if let (Some(a), Some(b)) =
        (of(|c| matches!(c, Change::Reflectance(_))), of(|c| matches!(c, Change::Index { .. })))
    {
        let names = (a.name(), b.name());
        return Err(b
            .error(format!("{} and {} exclude each other", names.0, names.1))
            .advise("give one of them"));
    }
    let patch = MaterialPatch { field, model, changes, emission, two_sided, textures };
    if patch.model.is_some() {
        // The model is known, so its keys are checked before any mesh is read.
        patch.apply(MaterialSpec::diffuse("", Rgb::ONE))?;
    }
    Ok(patch)
}

/// The key `key` of a model, where it is there.
fn change<'t>(
    table: &mut Section<'t>,
    key: &'static str,
    how: impl FnOnce(&Field<'t>) -> Result<Change>,
) -> Result<Option<(Field<'t>, Change)>> {
    with_field(table, key, how)
}

fn with_field<'t, T>(
    table: &mut Section<'t>,
    key: &'static str,
    how: impl FnOnce(&Field<'t>) -> Result<T>,
) -> Result<Option<(Field<'t>, T)>> {
    table.read(key, |f| how(&f).map(|value| (f, value)))
}

/// The model of that name with its usual numbers.
fn usual(name: &str) -> Result<Model> {
    match name {
        "diffuse" => Ok(Model::Diffuse { reflectance: Rgb::splat(0.5) }),
        "mirror" => Ok(Model::Mirror { reflectance: Rgb::ONE }),
        "conductor" => Ok(Model::Conductor {
            reflectance: Reflectance::Constant(Rgb::ONE),
            alpha: 0.0,
            compensate: true,
        }),
        "phong" => Ok(Model::Phong { diffuse: Rgb::splat(0.5), specular: Rgb::splat(0.25), exponent: 32.0 }),
        "dielectric" => Ok(Model::Dielectric { ior: 1.5, tint: Rgb::ONE }),
        "translucent" => {
            Ok(Model::Translucent { reflectance: Rgb::splat(0.4), transmittance: Rgb::splat(0.4) })
        }
        _ => {
            let known: Vec<&str> = Bsdf::NAMES.iter().map(|n| n.0).collect();
            Err(Error::new(format!("unknown material type \"{name}\""))
                .advise(unknown_word_advice(name, &known)))
        }
    }
}

/// `eta` and `k`, or `metal`.
fn index<'t>(table: &mut Section<'t>) -> Result<Option<(Field<'t>, Change)>> {
    let eta = with_field(table, "eta", |f| f.color(0.0..=100.0))?;
    let k = with_field(table, "k", |f| f.color(0.0..=100.0))?;
    let metal = with_field(table, "metal", |f| f.word(&[], metal))?;
    match (eta, k, metal) {
        (None, None, metal) => Ok(metal),
        (Some((field, eta)), Some((_, k)), None) => Ok(Some((field, Change::Index { eta, k }))),
        (Some((field, _)), _, Some(_)) | (_, Some((field, _)), Some(_)) => Err(field
            .error(format!("{} and metal exclude each other", field.name()))
            .advise("give one of them")),
        (Some((field, _)), None, None) => Err(field.error(format!("{} needs k beside it", field.name()))),
        (None, Some((field, _)), None) => Err(field.error(format!("{} needs eta beside it", field.name()))),
    }
}

fn metal(word: &str) -> Result<Change> {
    let found = METALS.iter().find(|m| m.0 == word);
    found.map(|m| Change::Index { eta: Rgb::from(m.1), k: Rgb::from(m.2) }).ok_or_else(|| {
        let known: Vec<&str> = METALS.iter().map(|m| m.0).collect();
        Error::new(format!("unknown metal \"{word}\"")).advise(unknown_word_advice(word, &known))
    })
}

/// GGX α: as it is, or as the square of `roughness`.
fn alpha<'t>(table: &mut Section<'t>) -> Result<Option<(Field<'t>, Change)>> {
    let square = |f: &Field<'t>| f.number(SHARE).map(|r| Change::Alpha((r * r) as f32));
    let roughness = change(table, "roughness", square)?;
    let alpha = change(table, "alpha", |f| f.number(SHARE).map(|a| Change::Alpha(a as f32)))?;
    match (roughness, alpha) {
        (Some(_), Some((alpha, _))) => Err(alpha
            .error(format!("{} and roughness both set the width", alpha.name()))
            .advise("alpha is roughness squared; give one of them")),
        (roughness, alpha) => Ok(roughness.or(alpha)),
    }
}

impl MaterialPatch<'_> {
    /// True when it says all that a material needs, so that no library has to define it.
    pub fn is_whole(&self) -> bool {
        self.model.is_some()
    }

    /// The material `base` with these changes.
    ///
    /// # Errors
    /// A key that the model has not.
    pub fn apply(&self, mut base: MaterialSpec) -> Result<MaterialSpec> {
        base.model = self.model.unwrap_or(base.model);
        for (field, change) in &self.changes {
            if !set(&mut base.model, change) {
                let (key, model) = (field.name(), base.model.name());
                return Err(field.error(format!("{key} is no key of a {model} material")));
            }
        }
        base.emission = self.emission.unwrap_or(base.emission);
        base.two_sided = self.two_sided.unwrap_or(base.two_sided);
        self.textures.apply(&mut base, self.model.is_some())?;
        Ok(base)
    }
}

/// Changes one number of a model; false where the model has no such number.
fn set(model: &mut Model, change: &Change) -> bool {
    match (change, model) {
        (
            Change::Reflectance(r),
            Model::Diffuse { reflectance }
            | Model::Mirror { reflectance }
            | Model::Translucent { reflectance, .. },
        ) => *reflectance = *r,
        (Change::Transmittance(t), Model::Translucent { transmittance, .. }) => *transmittance = *t,
        (Change::Reflectance(r), Model::Conductor { reflectance, .. }) => {
            *reflectance = Reflectance::Constant(*r);
        }
        (Change::Index { eta, k }, Model::Conductor { reflectance, .. }) => {
            *reflectance = Reflectance::Index { eta: *eta, k: *k };
        }
        (Change::Alpha(a), Model::Conductor { alpha, .. }) => *alpha = *a,
        (Change::Compensate(c), Model::Conductor { compensate, .. }) => *compensate = *c,
        (Change::Diffuse(d), Model::Phong { diffuse, .. }) => *diffuse = *d,
        (Change::Specular(s), Model::Phong { specular, .. }) => *specular = *s,
        (Change::Exponent(n), Model::Phong { exponent, .. }) => *exponent = *n,
        (Change::Ior(n), Model::Dielectric { ior, .. }) => *ior = *n,
        (Change::Tint(t), Model::Dielectric { tint, .. }) => *tint = *t,
        _ => return false,
    }
    true
}
