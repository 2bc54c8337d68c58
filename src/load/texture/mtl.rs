//! Which of an MTL's texture statements changes what.

use super::{MapSpec, Slot, Source, Sources, Stated};
use crate::bsdf::{Bsdf, Parameter, Scatter};
use crate::error::{Finding, Findings, Severity, show_path};
use crate::load::auto;
use crate::load::materials::MaterialSpec;
use crate::load::mtl::{self, At, MtlMaterial, TextureOptions};
use crate::load::open::{Match, Reach};
use crate::math::Rgb;
use crate::texture::{Channel, Mapping, Transfer, Wrap};
use std::collections::HashSet;
use std::os::unix::ffi::OsStrExt;
use std::path::{Path, PathBuf};

/// How far white stands above black for `-bm 1`, in widths of the picture. MTL says only that multipliers from 0 to 1
/// look best; a hundredth makes the joints of a brick wall some 30 degrees steep at 1.
const BUMP: f32 = 0.01;

/// The search for the textures of one OBJ's materials. A library is a file that another file names, so a name that
/// stands in it and leads nowhere is not quoted.
pub(crate) struct Search {
    sources: Sources,
    told: HashSet<(PathBuf, PathBuf)>,
}

impl Search {
    /// One that reads what is within `reach`.
    pub fn new(reach: &Reach) -> Self {
        Search { sources: Sources::new(reach), told: HashSet::new() }
    }

    fn find(
        &mut self,
        key: &str,
        m: &MtlMaterial,
        texture: &At<mtl::Texture>,
        out: &mut Findings,
    ) -> Option<Source> {
        let folder = m.library.parent().unwrap_or(Path::new(""));
        let name = &texture.value.file;
        let found = self.sources.find(folder, name.as_os_str().as_bytes());
        let how = found.as_ref().map(|found| found.1);
        if how != Some(Match::Exact) && self.told.insert((folder.to_path_buf(), name.clone())) {
            let title = m.title();
            let (kind, message) = match how {
                None => {
                    let place = if folder == Path::new("") { Path::new(".") } else { folder };
                    let place = show_path(place);
                    (
                        "texture-missing",
                        format!(
                            "{title}: the file that this {key} names was not found (its name counts from the folder {place})"
                        ),
                    )
                }
                Some(Match::OtherCase) => (
                    "texture-other-case",
                    format!("{title}: the file of this {key} was found as a name that differs in case"),
                ),
                _ => (
                    "texture-other-folder",
                    format!("{title}: the file of this {key} was found in the library's own folder"),
                ),
            };
            let (file, line) = (m.library.clone(), texture.line);
            out.push(Finding { file, line, kind, message, severity: Severity::Warning });
        }
        found.map(|found| found.0)
    }
}

/// A texture that was found.
struct Use<'m> {
    key: &'static str,
    texture: &'m At<mtl::Texture>,
    source: Source,
}

/// The material that `m` describes, textures included; `model` makes the model of the numbers.
pub(crate) fn of_mtl(
    name: &str,
    m: &MtlMaterial,
    model: impl Fn(&str, &MtlMaterial) -> MaterialSpec,
    search: &mut Search,
    findings: &mut Findings,
) -> MaterialSpec {
    let mut uses = Vec::new();
    for (key, texture) in m.textures() {
        if let Some(source) = search.find(key, m, texture, findings) {
            uses.push(Use { key, texture, source });
        }
    }
    // A normal map says the same as a bump map, and better.
    if uses.iter().any(|one| one.key == "norm") {
        uses.retain(|one| one.key != "bump");
    }
    let full = completed(m, &uses);
    let mut spec = model(name, &full);
    let bsdf = spec.clone().build().bsdf;
    // Glass is seen through already; what `d` says beside it is an exporter's habit.
    let is_glass = bsdf.is_clear();
    spec.opacity = if is_glass { 1.0 } else { full.d.as_ref().map_or(1.0, |d| d.value) };
    for one in uses {
        let title = format!("{}: {}", m.title(), one.key);
        let stated = Stated { file: m.library.clone(), line: one.texture.line, title };
        let Some(meaning) =
            meaning(one.key, &full, &bsdf).filter(|meaning| !(is_glass && meaning.is_opacity()))
        else {
            let message = format!("{} is not shown: the material has nothing that it changes", stated.title);
            let (file, line, kind) = (stated.file, stated.line, "texture-not-shown");
            findings.push(Finding { file, line, kind, message, severity: Severity::Note });
            continue;
        };
        if one.key == "map_Kd" && full.map_d.is_none() && !is_glass {
            spec.maps.push(one.spec(&Meaning::opacity(Slot::Alpha, spec.opacity), stated.clone()));
        }
        spec.maps.push(one.spec(&meaning, stated));
    }
    spec
}

/// `m` with what its pictures mean for its numbers. A colour that is multiplied with a picture counts as white where
/// it is black or not stated, and a factor as 1 where it is not stated: exporters write `Kd 0 0 0` beside a picture and
/// mean the picture. A picture that is not there is not stated, nor is a black that was meant to be multiplied with it.
fn completed(m: &MtlMaterial, uses: &[Use<'_>]) -> MtlMaterial {
    let mut full = m.clone();
    let is_there = |key: &str| uses.iter().any(|one| one.key == key);
    let color = |key: &str, color: &mut Option<At<[f32; 3]>>, map: &mut Option<At<mtl::Texture>>| {
        let Some(line) = map.as_ref().map(|map| map.line) else { return };
        let is_black = color.as_ref().is_none_or(|color| color.value == [0.0; 3]);
        if is_there(key) {
            if is_black {
                *color = Some(At { value: [1.0; 3], line });
            }
        } else {
            *map = None;
            if is_black {
                *color = None;
            }
        }
    };
    color("map_Kd", &mut full.kd, &mut full.map_kd);
    color("map_Ks", &mut full.ks, &mut full.map_ks);
    color("map_Ke", &mut full.ke, &mut full.map_ke);
    let number = |key: &str, number: &mut Option<At<f32>>, map: &mut Option<At<mtl::Texture>>| {
        let Some(line) = map.as_ref().map(|map| map.line) else { return };
        if is_there(key) {
            number.get_or_insert(At { value: 1.0, line });
        } else {
            *map = None;
        }
    };
    number("map_Pr", &mut full.pr, &mut full.map_pr);
    number("map_Pm", &mut full.pm, &mut full.map_pm);
    number("map_Ps", &mut full.ps, &mut full.map_ps);
    number("map_d", &mut full.d, &mut full.map_d);
    full
}

/// What a picture does.
struct Meaning {
    slot: Slot,
    transfer: Transfer,
    /// What the picture is multiplied with.
    factor: Rgb,
    /// What holds where it cannot be decoded.
    fallback: Option<Rgb>,
}

impl Meaning {
    fn opacity(slot: Slot, factor: f32) -> Meaning {
        Meaning { slot, transfer: Transfer::Linear, factor: Rgb::splat(factor), fallback: None }
    }

    fn is_opacity(&self) -> bool {
        self.slot == Slot::Parameter(Parameter::Opacity)
    }
}

/// What the statement `key` of `m` changes of its model; `None`: nothing.
fn meaning(key: &str, m: &MtlMaterial, bsdf: &Bsdf) -> Option<Meaning> {
    let has = |parameter: &Parameter| bsdf.clone().set(*parameter, Rgb::splat(0.5));
    let color = |parameters: &[Parameter], stated: &Option<At<[f32; 3]>>, fallback: Rgb| {
        let slot = Slot::Parameter(parameters.iter().copied().find(has)?);
        let factor = stated.as_ref().map_or(Rgb::ONE, |at| Rgb::from(at.value));
        // White may be the stand-in of a black that nobody meant.
        let fallback = Some(if factor == Rgb::ONE { fallback } else { factor });
        Some(Meaning { slot, transfer: Transfer::Srgb, factor, fallback })
    };
    let number = |parameter: Parameter, stated: &Option<At<f32>>, fallback: f32| {
        let factor = Rgb::splat(stated.as_ref().map_or(1.0, |at| at.value));
        let meaning =
            Meaning { slot: Slot::Parameter(parameter), transfer: Transfer::Linear, factor, fallback: None };
        has(&parameter).then_some(Meaning { fallback: Some(Rgb::splat(fallback)), ..meaning })
    };
    let relief = |slot| Some(Meaning { slot, transfer: Transfer::Linear, factor: Rgb::ONE, fallback: None });
    let is_mirror = matches!(bsdf, Bsdf::Mirror(_));
    match key {
        "map_Kd" if is_mirror => None,
        "map_Kd" => {
            color(&[Parameter::Reflectance, Parameter::Diffuse, Parameter::BaseColor], &m.kd, auto::CLAY)
        }
        "map_Ks" if is_mirror => color(&[Parameter::Reflectance], &m.ks, Rgb::splat(0.5)),
        "map_Ks" => color(&[Parameter::Specular], &m.ks, Rgb::ZERO),
        "map_Ke" => {
            let factor = m.ke.as_ref().map_or(Rgb::ONE, |at| Rgb::from(at.value));
            let slot = Slot::Parameter(Parameter::Emission);
            Some(Meaning { slot, transfer: Transfer::Srgb, factor, fallback: Some(Rgb::ZERO) })
        }
        "map_Ns" => number(Parameter::Exponent, &m.ns, m.ns.as_ref().map_or(0.0, |at| at.value)),
        "map_Pr" => number(Parameter::Roughness, &m.pr, 0.5),
        "map_Pm" => number(Parameter::Metallic, &m.pm, 0.0),
        "map_Ps" => number(Parameter::Sheen, &m.ps, 0.0),
        "map_d" => {
            let opacity = m.d.as_ref().map_or(1.0, |d| d.value);
            Some(Meaning::opacity(Slot::Parameter(Parameter::Opacity), opacity))
        }
        "bump" => relief(Slot::Height { height: BUMP, normals: true }),
        "norm" => relief(Slot::Normal(1.0)),
        _ => None,
    }
}

impl Use<'_> {
    fn spec(&self, meaning: &Meaning, stated: Stated) -> MapSpec {
        let TextureOptions {
            scale, offset, bump_multiplier, clamp, base_gain: [base, gain], channel, ..
        } = &self.texture.value.options;
        let (mut slot, mut channel) = (meaning.slot, channel.map(part));
        // What is said of the colour is not said of its alpha.
        let (base, gain) = if slot == Slot::Alpha { (0.0, 1.0) } else { (*base, *gain) };
        match &mut slot {
            Slot::Height { height, .. } => *height *= bump_multiplier,
            Slot::Normal(strength) => *strength *= bump_multiplier,
            Slot::Alpha => channel = Some(Channel::Alpha),
            Slot::Parameter(_) => {}
        }
        // MTL's own default for numbers. Opacity may be the alpha, which is seen later.
        if meaning.transfer == Transfer::Linear && !slot.is_relief() && !meaning.is_opacity() {
            channel.get_or_insert(Channel::Luminance);
        }
        let mapping = Mapping {
            wrap: if *clamp { Wrap::Clamp } else { Wrap::Repeat },
            scale: [scale[0], scale[1]],
            offset: [offset[0], offset[1]],
            channel,
            gain: meaning.factor * gain,
            base: meaning.factor * base,
            ..Mapping::plain(meaning.transfer)
        };
        MapSpec { slot, source: self.source.clone(), mapping, fallback: meaning.fallback, stated }
    }
}

/// `-imfchan`'s letter. Pictures have no depth: it is taken for luminance.
fn part(channel: mtl::Channel) -> Channel {
    match channel {
        mtl::Channel::Red => Channel::Red,
        mtl::Channel::Green => Channel::Green,
        mtl::Channel::Blue => Channel::Blue,
        mtl::Channel::Matte => Channel::Alpha,
        mtl::Channel::Luminance | mtl::Channel::Depth => Channel::Luminance,
    }
}
