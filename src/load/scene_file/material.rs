//! `[materials.NAME]`: a material of its own, or changes to the one of that name in an MTL.

use super::Home;
use super::reader::{Field, LIGHT, SHARE, Section};
use super::texture::Textures;
use crate::bsdf::fresnel::Reflectance;
use crate::bsdf::ggx::STRONGEST;
use crate::bsdf::metals::METALS;
use crate::bsdf::parameter::Channels;
use crate::bsdf::principled::Look;
use crate::bsdf::{
    Bsdf, Conductor, Dielectric, Diffuse, Mirror, Mix, OrenNayar, Parameter, Phong, Plastic, Principled,
    Scatter, Translucent,
};
use crate::error::{Error, Result, unknown_word_advice};
use crate::load::materials::{MaterialSpec, MixSpec};
use crate::load::texture::Sources;
use crate::math::Rgb;
use std::collections::BTreeMap;
use std::path::Path;

/// The keys of one `[materials.NAME]`.
#[derive(Clone)]
pub(crate) struct MaterialPatch<'t> {
    /// The table, for findings and errors.
    pub field: Field<'t>,
    /// The model that replaces another; without it the keys change what is there.
    model: Option<Bsdf>,
    /// The mixture that it is instead of a model.
    mix: Option<MixSpec>,
    changes: Vec<(Field<'t>, Change)>,
    emission: Option<Rgb>,
    two_sided: Option<bool>,
    rotation: Option<f32>,
    textures: Textures<'t>,
}

/// A key of a model with its value.
#[derive(Clone, Copy)]
enum Change {
    Set(Parameter, Rgb),
    Index {
        eta: Rgb,
        k: Rgb,
    },
    Compensate(bool),
    Thin(bool),
    Nonlinear(bool),
    /// GGX α along x and along y.
    Widths([f32; 2]),
}

/// Reads every material by name.
pub(super) fn read_all<'t>(
    field: &Field<'t>,
    home: &Home<'_>,
) -> Result<BTreeMap<String, MaterialPatch<'t>>> {
    let materials = field.section()?.all();
    let mut sources = Sources::new(home.reach);
    materials
        .into_iter()
        .map(|(name, field)| Ok((name.to_string(), read(field, home.folder, &mut sources)?)))
        .collect()
}

fn read<'t>(field: Field<'t>, folder: &Path, sources: &mut Sources) -> Result<MaterialPatch<'t>> {
    let mut table = field.section()?;
    let textures = Textures::take(&mut table, folder, sources)?;
    let kind = table.get("type");
    let is_mix = matches!(&kind, Some(f) if f.text()? == Mix::NAME.0);
    let model = match kind {
        Some(kind) if !is_mix => Some(kind.word(&[], usual)?),
        _ => None,
    };
    let mix = if is_mix { Some(mixture(&field, &mut table)?) } else { None };
    let changes = changes(&mut table)?;
    let emission = table.read("emission", |f| f.color(LIGHT))?;
    let two_sided = table.read("two_sided", |f| f.bool())?;
    let degrees = |f: Field<'t>| f.number(-360.0..=360.0).map(|x| x as f32);
    let rotation = table.read("anisotropy_rotation", degrees)?;
    table.finish()?;
    if let (true, Some((field, _))) = (is_mix, changes.first()) {
        return Err(field.error(format!("{} is no key of a mix", field.name())));
    }
    let patch = MaterialPatch { field, model, mix, changes, emission, two_sided, rotation, textures };
    if patch.model.is_some() {
        // The model is known, so its keys are checked before any mesh is read.
        patch.apply(MaterialSpec::diffuse("", Rgb::ONE))?;
    }
    Ok(patch)
}

/// The keys that change a model's numbers.
fn changes<'t>(table: &mut Section<'t>) -> Result<Vec<(Field<'t>, Change)>> {
    let mut changes = Vec::new();
    // They are the material's own.
    let own = |parameter| matches!(parameter, Parameter::Emission | Parameter::Opacity);
    for &(parameter, key, channels, [low, high]) in Parameter::NAMES.iter().filter(|row| !own(row.0)) {
        let value = |f: &Field<'t>| match channels {
            Channels::Color => f.color(low..=high),
            Channels::Number => f.number(low..=high).map(|x| Rgb::splat(x as f32)),
        };
        changes.extend(change(table, key, |f| value(f).map(|v| Change::Set(parameter, v)))?);
    }
    changes.extend(index(table)?);
    changes.extend(change(table, "compensate", |f| f.bool().map(Change::Compensate))?);
    changes.extend(change(table, "thin", |f| f.bool().map(Change::Thin))?);
    changes.extend(change(table, "nonlinear", |f| f.bool().map(Change::Nonlinear))?);
    changes.extend(widths(table, &changes)?);
    let of = |wanted: fn(&Change) -> bool| changes.iter().find(|(_, c)| wanted(c)).map(|(f, _)| f);
    if let (Some(a), Some(b)) = (
        of(|c| matches!(c, Change::Set(Parameter::Reflectance, _))),
        of(|c| matches!(c, Change::Index { .. })),
    ) {
        let message = format!("{} and {} exclude each other", a.name(), b.name());
        return Err(b.error(message).advise("give one of them"));
    }
    if let (Some(alpha), Some(_)) = (
        of(|c| matches!(c, Change::Set(Parameter::Alpha, _))),
        of(|c| matches!(c, Change::Set(Parameter::Roughness, _))),
    ) {
        return Err(alpha
            .error(format!("{} and roughness both set the width", alpha.name()))
            .advise("alpha is roughness squared; give one of them"));
    }
    Ok(changes)
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

/// `materials = ["a", "b"]` and `amount`.
fn mixture<'t>(field: &Field<'t>, table: &mut Section<'t>) -> Result<MixSpec> {
    let Some(parts) = table.get("materials") else { return Err(table.missing(field, "materials")) };
    let what = "a list of the names of two materials";
    let items = parts.list(what)?;
    let [a, b] = items.as_slice() else { return Err(parts.must_be(what)) };
    let names = [a.text()?.to_string(), b.text()?.to_string()];
    let amount = table.read("amount", |f| f.number(SHARE))?.unwrap_or(0.5) as f32;
    Ok(MixSpec { names, amount, ids: [0; 2] })
}

/// The model of that name with its usual numbers.
fn usual(name: &str) -> Result<Bsdf> {
    let gray = Rgb::splat(0.5);
    Ok(match name {
        "diffuse" => Bsdf::Diffuse(Diffuse { reflectance: gray }),
        "oren-nayar" => Bsdf::OrenNayar(OrenNayar::new(gray, 0.5)),
        "mirror" => Bsdf::Mirror(Mirror { reflectance: Rgb::ONE }),
        "conductor" => Bsdf::Conductor(Conductor::new(Reflectance::Constant(Rgb::ONE), 0.0, true)),
        "phong" => Bsdf::Phong(Phong::new(gray, Rgb::splat(0.25), 32.0)),
        "dielectric" => Bsdf::Dielectric(Dielectric::new(1.5, Rgb::ONE)),
        "plastic" => Bsdf::Plastic(Plastic::new(gray, 1.5, 0.0)),
        "translucent" => Bsdf::Translucent(Translucent::new(Rgb::splat(0.4), Rgb::splat(0.4))),
        "principled" => Bsdf::Principled(Principled::new(Look::default())),
        _ => {
            let known: Vec<&str> = Bsdf::NAMES.iter().map(|n| n.0).chain([Mix::NAME.0]).collect();
            return Err(Error::new(format!("unknown material type \"{name}\""))
                .advise(unknown_word_advice(name, &known)));
        }
    })
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

/// `alpha_x` and `alpha_y`, in place of the `others` that set the width.
fn widths<'t>(
    table: &mut Section<'t>,
    others: &[(Field<'t>, Change)],
) -> Result<Option<(Field<'t>, Change)>> {
    let alpha = |f: &Field<'t>| f.number(0.0..=1.0).map(|x| x as f32);
    let (x, y) = match (with_field(table, "alpha_x", alpha)?, with_field(table, "alpha_y", alpha)?) {
        (Some(x), Some(y)) => (x, y),
        (None, None) => return Ok(None),
        (Some((field, _)), None) => return Err(field.error("alpha_x needs alpha_y beside it")),
        (None, Some((field, _))) => return Err(field.error("alpha_y needs alpha_x beside it")),
    };
    let width = |c: &Change| match c {
        Change::Set(p, _) => matches!(p, Parameter::Roughness | Parameter::Alpha | Parameter::Anisotropy),
        _ => false,
    };
    if let Some((other, _)) = others.iter().find(|(_, change)| width(change)) {
        let message = format!("{} and alpha_x both set the width", other.name());
        return Err(other.error(message).advise("give one of them"));
    }
    let (field, widths) = (x.0, [x.1, y.1]);
    if widths[0].min(widths[1]) < (1.0 - STRONGEST) * widths[0].max(widths[1]) {
        return Err(field
            .error("alpha_x and alpha_y differ by more than a factor of 10")
            .advise("raise the smaller one"));
    }
    Ok(Some((field, Change::Widths(widths))))
}

fn metal(word: &str) -> Result<Change> {
    let found = METALS.iter().find(|m| m.0 == word);
    found.map(|m| Change::Index { eta: Rgb::from(m.1), k: Rgb::from(m.2) }).ok_or_else(|| {
        let known: Vec<&str> = METALS.iter().map(|m| m.0).collect();
        Error::new(format!("unknown metal \"{word}\"")).advise(unknown_word_advice(word, &known))
    })
}

impl MaterialPatch<'_> {
    /// True when it says all that a material needs, so that no library has to define it.
    pub fn is_whole(&self) -> bool {
        self.model.is_some() || self.mix.is_some()
    }

    /// The error of a mixture whose part `name` is not there.
    pub fn missing_part(&self, name: &str, known: &[&str]) -> Error {
        let error = self.field.error(format!("{} mixes the unknown material \"{name}\"", self.field.name()));
        error.advise(unknown_word_advice(name, known))
    }

    /// The error of a mixture that is a part of itself.
    pub fn own_part(&self) -> Error {
        self.field.error(format!("{} is mixed of itself", self.field.name()))
    }

    /// The error of a mixture within too many others.
    pub fn too_deep(&self) -> Error {
        let name = self.field.name();
        self.field
            .error(format!("{name} is mixed within too many other mixtures"))
            .advise("mix fewer materials of mixtures; a hundred within each other are the most")
    }

    /// The material `base` with these changes.
    ///
    /// # Errors
    /// A key that the model has not.
    pub fn apply(&self, mut base: MaterialSpec) -> Result<MaterialSpec> {
        if let Some(model) = &self.model {
            base.model = model.clone();
        }
        if let Some(mix) = &self.mix {
            base.mix = Some(mix.clone());
        }
        for (field, change) in &self.changes {
            if !set(&mut base.model, change) {
                let (key, model) = (field.name(), base.model.name());
                return Err(field.error(format!("{key} is no key of a {model} material")));
            }
        }
        base.emission = self.emission.unwrap_or(base.emission);
        base.two_sided = self.two_sided.unwrap_or(base.two_sided);
        base.rotation = self.rotation.unwrap_or(base.rotation);
        self.textures.apply(&mut base, self.is_whole())?;
        Ok(base)
    }
}

/// Changes one number of a model; false where the model has no such number.
fn set(model: &mut Bsdf, change: &Change) -> bool {
    match (*change, &mut *model) {
        // Lambert's law has no roughness: with one it is another law.
        (Change::Set(Parameter::Roughness, r), Bsdf::Diffuse(m)) => {
            *model = Bsdf::OrenNayar(OrenNayar::new(m.reflectance, r.x));
        }
        (Change::Set(parameter, value), model) => return model.set(parameter, value),
        (Change::Index { eta, k }, Bsdf::Conductor(m)) => {
            *m = m.with_reflectance(Reflectance::Index { eta, k });
        }
        (Change::Compensate(c), Bsdf::Conductor(m)) => *m = m.with_compensation(c),
        (Change::Compensate(c), Bsdf::Dielectric(m)) => *m = m.with_compensation(c),
        (Change::Widths([x, y]), model) => {
            // Burley's aspect, solved for what makes it: see `ggx::widths`.
            let ratio = if x == y { 1.0 } else { x.min(y) / x.max(y) };
            let anisotropy = ((1.0 - ratio) / STRONGEST).copysign(x - y);
            let alpha = (x * y).sqrt();
            return model.set(Parameter::Anisotropy, Rgb::splat(anisotropy))
                && (model.set(Parameter::Alpha, Rgb::splat(alpha))
                    || model.set(Parameter::Roughness, Rgb::splat(alpha.sqrt())));
        }
        (Change::Thin(thin), Bsdf::Dielectric(m)) => *m = m.thin(thin),
        (Change::Nonlinear(nonlinear), Bsdf::Plastic(m)) => *m = m.with_nonlinear(nonlinear),
        _ => return false,
    }
    true
}
