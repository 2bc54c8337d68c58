//! Materials: metallic-roughness and the extensions whose parameters the principled material has.

use super::item::Item;
use super::pictures::{Images, Laid, laid, scale_and_offset};
use super::{Document, finding};
use crate::bsdf::principled::Look;
use crate::bsdf::{Bsdf, Diffuse, Parameter, Principled};
use crate::error::{Findings, Result, Severity};
use crate::load::auto;
use crate::load::materials::MaterialSpec;
use crate::load::open::Reach;
use crate::load::texture::{MapSpec, Slot, Stated};
use crate::math::Rgb;
use crate::texture::{Channel, Transfer};
use glam::DAffine2;

/// How steep opacity is where an alpha of the mode MASK passes its cutoff.
const STEEP: f32 = 1e4;

/// The materials of a document.
pub(super) struct Materials {
    entries: Vec<Entry>,
}

struct Entry {
    spec: MaterialSpec,
    /// Which texture coordinates its pictures use, and what is done to them for all of these.
    uv_set: usize,
    uv_transform: DAffine2,
}

impl Materials {
    /// Reads every material.
    ///
    /// # Errors
    /// Wrong values, references that lead nowhere.
    pub fn of(document: &Document<'_>, reach: &Reach, findings: &mut Findings) -> Result<Materials> {
        let mut images = Images::new(reach);
        let items = document.root.list("materials").enumerate();
        let entries: Result<Vec<Entry>> = items
            .map(|(i, item)| {
                Reader { item, document, images: &mut images, findings, maps: Vec::new() }.read(i)
            })
            .collect();
        Ok(Materials { entries: entries? })
    }

    /// What stands for a material while the mesh is built: names may repeat.
    pub fn key(index: Option<usize>) -> Vec<u8> {
        index.map(|index| index.to_string().into_bytes()).unwrap_or_default()
    }

    fn entry(&self, key: &[u8]) -> Option<&Entry> {
        let index: usize = std::str::from_utf8(key).ok()?.parse().ok()?;
        self.entries.get(index)
    }

    /// The material of that key; clay where there is none.
    pub fn spec(&self, key: &[u8]) -> MaterialSpec {
        self.entry(key).map_or_else(|| MaterialSpec::diffuse("", auto::CLAY), |entry| entry.spec.clone())
    }

    /// Which texture coordinates a material wants, and what is done to them.
    pub fn coordinates(&self, index: Option<usize>) -> (usize, DAffine2) {
        let entry = self.entry(&Materials::key(index));
        entry.map_or((0, DAffine2::IDENTITY), |entry| (entry.uv_set, entry.uv_transform))
    }
}

/// A texture and what it is for.
struct Use {
    laid: Laid,
    slot: Slot,
    channel: Option<Channel>,
    gain: Rgb,
    base: Rgb,
    way: String,
}

struct Reader<'r, 'd> {
    item: Item<'d>,
    document: &'r Document<'d>,
    images: &'r mut Images,
    findings: &'r mut Findings,
    maps: Vec<Use>,
}

impl Reader<'_, '_> {
    fn read(mut self, number: usize) -> Result<Entry> {
        let item = self.item.clone();
        let name = item.text("name").filter(|name| !name.is_empty()).map(str::to_string);
        let name = name.unwrap_or_else(|| format!("material {number}"));
        let look = self.look()?;
        let mut spec = MaterialSpec::diffuse(name, look.base_color);
        spec.model = if item.extension("KHR_materials_unlit").is_some() {
            Bsdf::Diffuse(Diffuse { reflectance: look.base_color })
        } else {
            Bsdf::Principled(Principled::new(look))
        };
        self.emission(&mut spec)?;
        self.opacity(&mut spec)?;
        if let Some(info) = item.get("normalTexture") {
            let strength = info.number("scale", 1.0)? as f32;
            self.map(&info, Slot::Normal(strength), None, Rgb::ONE)?;
        }
        let (uv_set, uv_transform) = self.coordinates();
        for used in std::mem::take(&mut self.maps) {
            if let Some(map) = self.spec(used, uv_set, &uv_transform) {
                spec.maps.push(map);
            }
        }
        Ok(Entry { spec, uv_set, uv_transform })
    }

    /// The principled material's numbers, and the pictures for them.
    fn look(&mut self) -> Result<Look> {
        let item = self.item.clone();
        let usual = Look::default();
        let extension = |name: &str| item.extension(name);
        let number = |from: &Option<Item<'_>>, key: &str, usual: f64| -> Result<f32> {
            let value = from.as_ref().map_or(Ok(usual), |from| from.number(key, usual))?;
            Ok(value.clamp(0.0, 1.0) as f32)
        };
        let old = extension("KHR_materials_pbrSpecularGlossiness")
            .filter(|_| item.get("pbrMetallicRoughness").is_none());
        let pbr = item.get("pbrMetallicRoughness");
        let (base, base_map) = match &old {
            Some(old) => (old.numbers("diffuseFactor", [1.0; 4])?, old.get("diffuseTexture")),
            None => (base_factor(&item)?, pbr.as_ref().and_then(|pbr| pbr.get("baseColorTexture"))),
        };
        let base_color = color([base[0], base[1], base[2]]);
        let is_unlit = extension("KHR_materials_unlit").is_some();
        if let Some(info) = base_map {
            let parameter = if is_unlit { Parameter::Reflectance } else { Parameter::BaseColor };
            self.map(&info, Slot::Parameter(parameter), None, base_color)?;
        }
        let (metallic, roughness) = match &old {
            Some(_) => (0.0, 1.0 - number(&old, "glossinessFactor", 1.0)?),
            None => (number(&pbr, "metallicFactor", 1.0)?, number(&pbr, "roughnessFactor", 1.0)?),
        };
        if is_unlit {
            return Ok(Look { base_color, ..usual });
        }
        if let Some(info) = pbr.as_ref().and_then(|pbr| pbr.get("metallicRoughnessTexture")) {
            self.number_map(&info, Parameter::Metallic, Channel::Blue, metallic)?;
            self.number_map(&info, Parameter::Roughness, Channel::Green, roughness)?;
        }
        let ior = extension("KHR_materials_ior").map_or(Ok(1.5), |ior| ior.number("ior", 1.5))?;
        let (clear, coat) = (extension("KHR_materials_transmission"), extension("KHR_materials_clearcoat"));
        let sheen = extension("KHR_materials_sheen");
        let sheen_color = sheen.as_ref().map_or(Ok([0.0; 3]), |s| s.numbers("sheenColorFactor", [0.0; 3]))?;
        let look = Look {
            base_color,
            metallic,
            roughness,
            // A half is what the index says here.
            specular: 0.5 * number(&extension("KHR_materials_specular"), "specularFactor", 1.0)?,
            // An index of 0 means that everything is reflected, as in specular-glossiness.
            ior: if ior < 1.0 { 1.5 } else { ior.min(10.0) as f32 },
            anisotropy: number(&extension("KHR_materials_anisotropy"), "anisotropyStrength", 0.0)?,
            transmission: number(&clear, "transmissionFactor", 0.0)?,
            coat: number(&coat, "clearcoatFactor", 0.0)?,
            coat_roughness: number(&coat, "clearcoatRoughnessFactor", 0.0)?,
            sheen: color(sheen_color).max_element(),
            sheen_roughness: number(&sheen, "sheenRoughnessFactor", 0.0)?,
            ..usual
        };
        for (from, key, parameter, channel, factor) in [
            (&clear, "transmissionTexture", Parameter::Transmission, Channel::Red, look.transmission),
            (&coat, "clearcoatTexture", Parameter::Coat, Channel::Red, look.coat),
            (
                &coat,
                "clearcoatRoughnessTexture",
                Parameter::CoatRoughness,
                Channel::Green,
                look.coat_roughness,
            ),
        ] {
            if let Some(info) = from.as_ref().and_then(|from| from.get(key)).filter(|_| factor > 0.0) {
                self.number_map(&info, parameter, channel, factor)?;
            }
        }
        Ok(look)
    }

    fn emission(&mut self, spec: &mut MaterialSpec) -> Result<()> {
        let strength = self.item.extension("KHR_materials_emissive_strength");
        let strength = strength.map_or(Ok(1.0), |s| s.number("emissiveStrength", 1.0))?;
        let factor = self.item.numbers("emissiveFactor", [0.0; 3])?;
        spec.emission = Rgb::from(factor.map(|c| (c * strength).clamp(0.0, 1e12) as f32));
        match self.item.get("emissiveTexture").filter(|_| spec.emission != Rgb::ZERO) {
            Some(info) => self.map(&info, Slot::Parameter(Parameter::Emission), None, spec.emission),
            None => Ok(()),
        }
    }

    /// MASK is a steep ramp at the cutoff, BLEND the share of hits that count.
    fn opacity(&mut self, spec: &mut MaterialSpec) -> Result<()> {
        let item = self.item.clone();
        let mode = item.text("alphaMode").unwrap_or("OPAQUE");
        let pbr = item.get("pbrMetallicRoughness");
        let info = pbr.and_then(|pbr| pbr.get("baseColorTexture"));
        let factor = base_factor(&item)?[3].clamp(0.0, 1.0) as f32;
        let (gain, base) = match mode {
            "BLEND" => (factor, 0.0),
            "MASK" => (STEEP * factor, 1.0 - STEEP * item.number("alphaCutoff", 0.5)? as f32),
            _ => return Ok(()),
        };
        spec.opacity = (gain + base).clamp(0.0, 1.0);
        let Some(info) = info else { return Ok(()) };
        self.map(&info, Slot::Alpha, Some(Channel::Alpha), Rgb::splat(gain))?;
        if let Some(last) = self.maps.last_mut().filter(|used| used.slot == Slot::Alpha) {
            last.base = Rgb::splat(base);
        }
        Ok(())
    }

    fn number_map(
        &mut self,
        info: &Item<'_>,
        parameter: Parameter,
        channel: Channel,
        factor: f32,
    ) -> Result<()> {
        self.map(info, Slot::Parameter(parameter), Some(channel), Rgb::splat(factor))
    }

    fn map(&mut self, info: &Item<'_>, slot: Slot, channel: Option<Channel>, gain: Rgb) -> Result<()> {
        let is_color = channel.is_none() && matches!(slot, Slot::Parameter(_));
        let transfer = if is_color { Transfer::Srgb } else { Transfer::Linear };
        let laid = laid(info, self.document, transfer, self.images, self.findings)?;
        let way = info.way.clone();
        self.maps.extend(laid.map(|laid| Use { laid, slot, channel, gain, base: Rgb::ZERO, way }));
        Ok(())
    }

    /// The coordinates of the first picture. A rotation that all pictures share is done to the coordinates themselves.
    fn coordinates(&self) -> (usize, DAffine2) {
        let Some(first) = self.maps.first() else { return (0, DAffine2::IDENTITY) };
        let (uv_set, transform) = (first.laid.uv_set, first.laid.transform);
        let is_shared = self.maps.iter().all(|used| used.laid.transform == transform);
        let in_mapping = scale_and_offset(&transform).is_some();
        (uv_set, if is_shared && !in_mapping { transform } else { DAffine2::IDENTITY })
    }

    fn spec(&mut self, used: Use, uv_set: usize, done: &DAffine2) -> Option<MapSpec> {
        let file = self.document.file;
        let mut mapping = used.laid.mapping;
        if used.laid.uv_set != uv_set {
            let message =
                format!("{} uses other texture coordinates than the material's first: left out", used.way);
            self.findings.push(finding(file, "texture-not-shown", Severity::Warning, message));
            return None;
        }
        if *done == DAffine2::IDENTITY {
            let placed = scale_and_offset(&used.laid.transform);
            if placed.is_none() {
                let message = format!(
                    "{} is turned, and other pictures of its material are not: shown unturned",
                    used.way
                );
                self.findings.push(finding(file, "texture-rotation-ignored", Severity::Warning, message));
            }
            (mapping.scale, mapping.offset) = placed.unwrap_or(([1.0; 2], [0.0; 2]));
        }
        (mapping.channel, mapping.gain, mapping.base) = (used.channel, used.gain, used.base);
        let stated = Stated { file: file.to_path_buf(), line: 0, title: used.way };
        Some(MapSpec { slot: used.slot, source: used.laid.source, mapping, fallback: None, stated })
    }
}

fn base_factor(item: &Item<'_>) -> Result<[f64; 4]> {
    item.get("pbrMetallicRoughness").map_or(Ok([1.0; 4]), |pbr| pbr.numbers("baseColorFactor", [1.0; 4]))
}

fn color(factor: [f64; 3]) -> Rgb {
    Rgb::from(factor.map(|c| c.clamp(0.0, 1.0) as f32))
}
