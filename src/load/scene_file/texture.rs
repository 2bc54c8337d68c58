//! Pictures where a material of the scene file takes a colour or a number:
//! `{ texture = "wood.png", filter = "nearest", wrap = "clamp", scale = [2, 2], offset = [0, 0.5] }`.

use super::reader::{COORDINATE, Field, SHARE, Section};
use crate::bsdf::{Bsdf, Parameter, Scatter, parameter::Channels};
use crate::error::{Result, lookup};
use crate::load::materials::MaterialSpec;
use crate::load::texture::{MapSpec, Place, Slot, Source, Sources, Stated};
use crate::math::Rgb;
use crate::texture::{Channel, Filter, Mapping, Transfer, Wrap};
use std::path::Path;

/// Channel names in scene files.
const CHANNELS: &[(&str, &str, Channel)] = &[
    ("r", "red, or the grey of a picture without colours", Channel::Red),
    ("g", "green", Channel::Green),
    ("b", "blue", Channel::Blue),
    ("a", "alpha", Channel::Alpha),
    ("luminance", "Rec.709 luminance", Channel::Luminance),
];

/// What a `[materials.NAME]` says of pictures, opacity and relief.
#[derive(Clone)]
pub(super) struct Textures<'t> {
    maps: Vec<(Field<'t>, MapSpec)>,
    opacity: Option<f32>,
    /// Keys with constants: what pictures an MTL has for them is gone.
    constants: Vec<&'t str>,
}

impl<'t> Textures<'t> {
    /// Takes them out of `table`, whose other keys are then those of constants. Files are looked for from `folder`.
    ///
    /// # Errors
    /// A key that takes no picture; a wrong value.
    pub fn take(table: &mut Section<'t>, folder: &Path, sources: &mut Sources) -> Result<Textures<'t>> {
        let mut maps = Vec::new();
        for key in ["normal_map", "bump"] {
            if let Some(field) = table.get(key) {
                let spec = read(&field, key, folder, sources)?;
                maps.push((field, spec));
            }
        }
        for (key, field) in table.take(Field::is_texture) {
            let spec = read(&field, key, folder, sources)?;
            maps.push((field, spec));
        }
        let opacity = table.read("opacity", |f| f.number(SHARE))?.map(|share| share as f32);
        let taken: Vec<&str> = maps.iter().map(|(_, map)| map.slot.key()).collect();
        let constants = table.all().into_iter().map(|(key, _)| key).filter(|key| !taken.contains(key));
        Ok(Textures { maps, opacity, constants: constants.collect() })
    }

    /// Puts the pictures on `spec`, which has its other keys already. `is_new`: its model is not the one that its
    /// pictures were meant for.
    ///
    /// # Errors
    /// A picture for what the model has not.
    pub fn apply(&self, spec: &mut MaterialSpec, is_new: bool) -> Result<()> {
        if let Some(opacity) = self.opacity {
            spec.opacity = opacity;
        }
        spec.maps.retain(|map| {
            let key = map.slot.key();
            let is_of_model = matches!(map.slot, Slot::Parameter(p) if !matches!(p, Parameter::Emission | Parameter::Opacity));
            let is_width = |key: &str| matches!(key, "alpha" | "roughness");
            let replaced = |other: &str| other == key || is_width(other) && is_width(key);
            let relief = |other: &MapSpec| other.slot.is_relief() && map.slot.is_relief();
            !(is_new && is_of_model
                || self.constants.iter().any(|other| replaced(other))
                || self.maps.iter().any(|(_, other)| replaced(other.slot.key()) || relief(other)))
        });
        let bsdf = spec.clone().build().bsdf;
        for (field, map) in &self.maps {
            if !suits(map.slot, &bsdf) {
                let (key, model) = (field.name(), spec.model.name());
                return Err(field.error(format!("{key} is no key of a {model} material")));
            }
            spec.maps.push(map.clone());
        }
        Ok(())
    }
}

fn suits(slot: Slot, bsdf: &Bsdf) -> bool {
    match slot {
        Slot::Parameter(Parameter::Emission | Parameter::Opacity) => true,
        Slot::Parameter(parameter) => bsdf.clone().set(parameter, Rgb::splat(0.5)),
        Slot::Normal(_) | Slot::Height { .. } | Slot::Alpha => true,
    }
}

/// The picture that `field`, the material's `key`, states.
fn read(field: &Field<'_>, key: &str, folder: &Path, sources: &mut Sources) -> Result<MapSpec> {
    let mut table = field.section()?;
    let Some(file) = table.get("texture") else { return Err(table.missing(field, "texture")) };
    let name = file.text()?;
    let (slot, data) = match key {
        "normal_map" => {
            let strength = table.read("strength", |f| f.number(-100.0..=100.0))?.unwrap_or(1.0);
            (Slot::Normal(strength as f32), true)
        }
        "bump" => {
            let height = table.read("height", |f| f.number(-100.0..=100.0))?.unwrap_or(0.01);
            (Slot::Height { height: height as f32, normals: false }, true)
        }
        _ => match Parameter::named(key) {
            Some(parameter) => (Slot::Parameter(parameter), parameter.channels() == Channels::Number),
            None => return Err(field.error(format!("{} takes no texture", field.name()))),
        },
    };
    let raw = table.read("raw", |f| f.bool())?.unwrap_or(data);
    let mapping = mapping(&mut table, if raw { Transfer::Linear } else { Transfer::Srgb })?;
    table.finish()?;
    let found = sources.find(folder, name.as_bytes());
    let source = found.map_or_else(|| Source::One(Place::File(folder.join(name))), |found| found.0);
    let stated =
        Stated { file: field.file().to_path_buf(), line: file.line(), title: field.name().to_string() };
    Ok(MapSpec { slot, source, mapping, fallback: None, stated })
}

fn mapping(table: &mut Section<'_>, transfer: Transfer) -> Result<Mapping> {
    let plain = Mapping::plain(transfer);
    let pair = |f: Field<'_>| f.numbers::<2>(COORDINATE).map(|pair| pair.map(|x| x as f32));
    let channel = |word: &str| lookup("channel", word, CHANNELS);
    Ok(Mapping {
        filter: table.read("filter", |f| f.word(&[], Filter::from_name))?.unwrap_or(plain.filter),
        wrap: table.read("wrap", |f| f.word(&[], Wrap::from_name))?.unwrap_or(plain.wrap),
        scale: table.read("scale", pair)?.unwrap_or(plain.scale),
        offset: table.read("offset", pair)?.unwrap_or(plain.offset),
        channel: table.read("channel", |f| f.word(&[], channel))?,
        gain: table.read("gain", |f| f.color(-1e12..=1e12))?.unwrap_or(plain.gain),
        base: table.read("base", |f| f.color(-1e12..=1e12))?.unwrap_or(plain.base),
        transfer,
    })
}
