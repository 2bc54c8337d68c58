//! The MTL reader: classic and physically based (`Pr`, `Pm`, …) statements as plain values.
//!
//! Values leave it finite and in their physical range; what was clamped or ignored is a finding. What the
//! values mean for a material is decided elsewhere. A material library is a file that another file names,
//! so no message ever quotes it: messages are made of the key words below, lines, and nothing else.

mod resolve;
mod texture;

pub(super) use resolve::shown;
pub use resolve::{Resolved, resolve};
pub use texture::{Channel, Texture, TextureOptions};

use super::obj::number::number;
use crate::error::{Error, Finding, Findings, Result, Severity};
use std::io::Read;
use std::path::{Path, PathBuf};

/// The largest library that is read, in bytes.
pub const MAX_BYTES: u64 = 64 << 20;

/// A value and the line that states it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct At<T> {
    /// The value.
    pub value: T,
    /// 1-based line in the library.
    pub line: u64,
}

/// A material library.
#[derive(Clone, Debug, Default)]
pub struct MtlFile {
    /// The materials in the order of the file; names may repeat (the last one holds).
    pub materials: Vec<MtlMaterial>,
    /// What was clamped or ignored.
    pub findings: Findings,
}

/// A material as stated: `None` where the library is silent. Colours are linear RGB.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MtlMaterial {
    /// The name after `newmtl`, in whatever encoding.
    pub name: Vec<u8>,
    /// Its 1-based line.
    pub line: u64,
    /// The library; names of textures are relative to its folder.
    pub library: PathBuf,
    /// Diffuse reflectance, 0 to 1.
    pub kd: Option<At<[f32; 3]>>,
    /// Specular reflectance, 0 to 1.
    pub ks: Option<At<[f32; 3]>>,
    /// Emitted radiance, W/(m²·sr), 0 to 1e9.
    pub ke: Option<At<[f32; 3]>>,
    /// Transmission filter, 0 to 1.
    pub tf: Option<At<[f32; 3]>>,
    /// Specular exponent, 0 to 1e6.
    pub ns: Option<At<f32>>,
    /// Index of refraction, 1 to 10.
    pub ni: Option<At<f32>>,
    /// Opacity, 0 to 1: `d`, or 1 − `Tr`, whichever comes last.
    pub d: Option<At<f32>>,
    /// Illumination model, 0 to 10.
    pub illum: Option<At<u8>>,
    /// Roughness, 0 to 1.
    pub pr: Option<At<f32>>,
    /// Metallic, 0 to 1.
    pub pm: Option<At<f32>>,
    /// Sheen, 0 to 1.
    pub ps: Option<At<f32>>,
    /// Clearcoat thickness, 0 to 1.
    pub pc: Option<At<f32>>,
    /// Clearcoat roughness, 0 to 1.
    pub pcr: Option<At<f32>>,
    /// Anisotropy, −1 to 1.
    pub aniso: Option<At<f32>>,
    /// Rotation of the anisotropy in turns, 0 to 1.
    pub anisor: Option<At<f32>>,
    /// Texture of `kd`.
    pub map_kd: Option<At<Texture>>,
    /// Texture of `ks`.
    pub map_ks: Option<At<Texture>>,
    /// Texture of `ke`.
    pub map_ke: Option<At<Texture>>,
    /// Texture of `ns`.
    pub map_ns: Option<At<Texture>>,
    /// Texture of `d`.
    pub map_d: Option<At<Texture>>,
    /// Height map: `bump` or `map_Bump`.
    pub bump: Option<At<Texture>>,
    /// Tangent-space normal map.
    pub norm: Option<At<Texture>>,
    /// Texture of `pr`.
    pub map_pr: Option<At<Texture>>,
    /// Texture of `pm`.
    pub map_pm: Option<At<Texture>>,
    /// Displacement.
    pub disp: Option<At<Texture>>,
}

impl MtlMaterial {
    /// What a message calls it. Only for one that an OBJ names: the name is the OBJ's own then, and no library
    /// is quoted.
    pub(crate) fn title(&self) -> String {
        match self.name.as_slice() {
            [] => "the default material".to_string(),
            name => format!("material \"{}\"", shown(name)),
        }
    }

    /// Every texture, with the key word that states it.
    pub fn textures(&self) -> impl Iterator<Item = (&'static str, &At<Texture>)> {
        let all = [
            ("map_Kd", &self.map_kd),
            ("map_Ks", &self.map_ks),
            ("map_Ke", &self.map_ke),
            ("map_Ns", &self.map_ns),
            ("map_d", &self.map_d),
            ("bump", &self.bump),
            ("norm", &self.norm),
            ("map_Pr", &self.map_pr),
            ("map_Pm", &self.map_pm),
            ("disp", &self.disp),
        ];
        all.into_iter().filter_map(|(key, texture)| Some((key, texture.as_ref()?)))
    }
}

/// Reads the regular file `path`.
///
/// # Errors
/// It cannot be opened or read, is no regular file, or larger than [`MAX_BYTES`].
pub fn read(path: &Path) -> Result<MtlFile> {
    let (file, _) = super::open::open_regular(path)?;
    let mut text = Vec::new();
    file.take(MAX_BYTES + 1).read_to_end(&mut text).map_err(|e| Error::io("read", path, &e))?;
    if text.len() as u64 > MAX_BYTES {
        return Err(Error::new(format!("a material library of more than {} MiB", MAX_BYTES >> 20)).at(path));
    }
    Ok(parse(&text, path))
}

/// Reads the text of a library; `path` is what findings call it.
pub fn parse(text: &[u8], path: &Path) -> MtlFile {
    let text = text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(text);
    let mut reader = Reader { path, line: 0, out: MtlFile::default() };
    for (line, content) in logical_lines(text) {
        reader.line = line;
        reader.statement(&content);
    }
    if reader.out.materials.is_empty() {
        reader.line = 0;
        reader.note("mtl-without-materials", Severity::Warning, "the library defines no material");
    }
    reader.out
}

/// Lines with their 1-based number; continued ones joined by a space.
fn logical_lines(text: &[u8]) -> impl Iterator<Item = (u64, Vec<u8>)> {
    let mut at = 0;
    let mut ended = 0;
    std::iter::from_fn(move || {
        let first = ended + 1;
        let mut content = Vec::new();
        text.get(at)?;
        loop {
            let rest = text.get(at..).unwrap_or_default();
            let length = rest.iter().position(|b| matches!(b, b'\n' | b'\r')).unwrap_or(rest.len());
            let end = match rest.get(length..length + 2) {
                Some(b"\r\n") => 2,
                _ => 1,
            };
            at = (at + length + end).min(text.len());
            ended += 1;
            let line = rest.get(..length).unwrap_or_default();
            let is_comment = content.is_empty() && line.trim_ascii_start().starts_with(b"#");
            match line.strip_suffix(b"\\").filter(|_| !is_comment) {
                Some(start) if at < text.len() => {
                    content.extend_from_slice(start);
                    content.push(b' ');
                }
                line_start => {
                    content.extend_from_slice(line_start.unwrap_or(line));
                    return Some((first, content));
                }
            }
        }
    })
}

struct Reader<'a> {
    path: &'a Path,
    line: u64,
    out: MtlFile,
}

/// Statements that belong to MTL and mean nothing to us.
const IGNORED: &[&[u8]] = &[
    b"ka",
    b"map_ka",
    b"sharpness",
    b"decal",
    b"refl",
    b"map_refl",
    b"map_aat",
    b"map_ps",
    b"map_pc",
    b"map_pcr",
    b"map_tr",
    b"map_tf",
    b"map_ni",
    b"map_aniso",
    b"map_anisor",
];

impl Reader<'_> {
    fn note(&mut self, kind: &'static str, severity: Severity, message: &str) {
        let finding = Finding {
            file: self.path.to_path_buf(),
            line: self.line,
            kind,
            message: message.to_string(),
            severity,
        };
        self.out.findings.push(finding);
    }

    fn statement(&mut self, line: &[u8]) {
        let line = line.trim_ascii();
        if line.is_empty() || line.starts_with(b"#") {
            return;
        }
        let length = line.iter().position(|b| matches!(b, b' ' | b'\t')).unwrap_or(line.len());
        let (key, rest) = line.split_at(length);
        let (key, rest) = (key.to_ascii_lowercase(), rest.trim_ascii());
        if key == b"newmtl" {
            let material = MtlMaterial {
                name: rest.to_vec(),
                line: self.line,
                library: self.path.to_path_buf(),
                ..MtlMaterial::default()
            };
            self.out.materials.push(material);
        } else if self.out.materials.is_empty() {
            self.note(
                "mtl-before-newmtl",
                Severity::Warning,
                "a statement before the first newmtl was ignored",
            );
        } else {
            self.property(&key, rest);
        }
    }

    #[rustfmt::skip] // a table
    fn property(&mut self, key: &[u8], rest: &[u8]) {
        match key {
            b"kd" => self.color("Kd", rest, 1.0, |m| &mut m.kd),
            b"ks" => self.color("Ks", rest, 1.0, |m| &mut m.ks),
            b"ke" => self.color("Ke", rest, 1e9, |m| &mut m.ke),
            b"tf" => self.color("Tf", rest, 1.0, |m| &mut m.tf),
            b"ns" => self.scalar("Ns", rest, [0.0, 1e6], |m| &mut m.ns),
            b"ni" => self.scalar("Ni", rest, [1.0, 10.0], |m| &mut m.ni),
            b"d" => self.scalar("d", rest, [0.0, 1.0], |m| &mut m.d),
            b"tr" => self.transparency(rest),
            b"illum" => self.illumination(rest),
            b"pr" => self.scalar("Pr", rest, [0.0, 1.0], |m| &mut m.pr),
            b"pm" => self.scalar("Pm", rest, [0.0, 1.0], |m| &mut m.pm),
            b"ps" => self.scalar("Ps", rest, [0.0, 1.0], |m| &mut m.ps),
            b"pc" => self.scalar("Pc", rest, [0.0, 1.0], |m| &mut m.pc),
            b"pcr" => self.scalar("Pcr", rest, [0.0, 1.0], |m| &mut m.pcr),
            b"aniso" => self.scalar("aniso", rest, [-1.0, 1.0], |m| &mut m.aniso),
            b"anisor" => self.scalar("anisor", rest, [0.0, 1.0], |m| &mut m.anisor),
            b"map_kd" => self.texture("map_Kd", rest, |m| &mut m.map_kd),
            b"map_ks" => self.texture("map_Ks", rest, |m| &mut m.map_ks),
            b"map_ke" => self.texture("map_Ke", rest, |m| &mut m.map_ke),
            b"map_ns" => self.texture("map_Ns", rest, |m| &mut m.map_ns),
            b"map_d" => self.texture("map_d", rest, |m| &mut m.map_d),
            b"bump" | b"map_bump" => self.texture("bump", rest, |m| &mut m.bump),
            b"norm" | b"map_norm" => self.texture("norm", rest, |m| &mut m.norm),
            b"map_pr" => self.texture("map_Pr", rest, |m| &mut m.map_pr),
            b"map_pm" => self.texture("map_Pm", rest, |m| &mut m.map_pm),
            b"disp" | b"map_disp" => self.texture("disp", rest, |m| &mut m.disp),
            _ if IGNORED.contains(&key) => {}
            _ => self.note("mtl-unknown-statement", Severity::Note, "a statement that MTL does not have was ignored"),
        }
    }

    /// Stores a value; a second one in the same material replaces the first.
    fn set<T>(&mut self, field: impl Fn(&mut MtlMaterial) -> &mut Option<At<T>>, value: T) {
        let line = self.line;
        if let Some(material) = self.out.materials.last_mut() {
            *field(material) = Some(At { value, line });
        }
    }

    fn ignored(&mut self, key: &str, why: &str) {
        self.note("mtl-value-ignored", Severity::Warning, &format!("{key} was ignored: {why}"));
    }

    /// The value within the range, with a finding when it was not; `None` for what is not finite.
    fn in_range(&mut self, key: &str, value: f64, [low, high]: [f64; 2]) -> Option<f32> {
        if !value.is_finite() {
            self.ignored(key, "its value is not finite");
            return None;
        }
        if !(low..=high).contains(&value) {
            let message = format!("{key} was clamped to its range, {low} to {high}");
            self.note("mtl-value-clamped", Severity::Warning, &message);
        }
        Some(value.clamp(low, high) as f32)
    }

    /// `r g b`, or one number for all three.
    fn color(
        &mut self,
        key: &str,
        rest: &[u8],
        high: f64,
        field: impl Fn(&mut MtlMaterial) -> &mut Option<At<[f32; 3]>>,
    ) {
        if let Some(b"spectral" | b"xyz") = words(rest).next() {
            return self.ignored(key, "only RGB colours are supported");
        }
        let numbers: Vec<f64> = words(rest).map_while(whole_number).take(3).collect();
        let rgb = match *numbers.as_slice() {
            [grey] => [grey; 3],
            [r, g, b] => [r, g, b],
            _ => return self.ignored(key, "it needs one or three numbers"),
        };
        if let Some(bad) = rgb.into_iter().find(|c| !c.is_finite()) {
            self.in_range(key, bad, [0.0, high]);
            return;
        }
        // One finding a statement, not one a channel.
        let worst = rgb.into_iter().find(|c| !(0.0..=high).contains(c)).unwrap_or(0.0);
        self.in_range(key, worst, [0.0, high]);
        self.set(field, rgb.map(|c| c.clamp(0.0, high) as f32));
    }

    fn number_of(&mut self, key: &str, rest: &[u8]) -> Option<f64> {
        // `d -halo 0.5`: transparent in the middle; taken as an even opacity.
        let value = words(rest).find(|w| !w.eq_ignore_ascii_case(b"-halo")).and_then(whole_number);
        if value.is_none() {
            self.ignored(key, "it needs a number");
        }
        value
    }

    fn scalar(
        &mut self,
        key: &str,
        rest: &[u8],
        range: [f64; 2],
        field: impl Fn(&mut MtlMaterial) -> &mut Option<At<f32>>,
    ) {
        if let Some(value) = self.number_of(key, rest)
            && let Some(value) = self.in_range(key, value, range)
        {
            self.set(field, value);
        }
    }

    fn transparency(&mut self, rest: &[u8]) {
        if let Some(value) = self.number_of("Tr", rest)
            && let Some(value) = self.in_range("Tr", value, [0.0, 1.0])
        {
            self.set(|m| &mut m.d, 1.0 - value);
        }
    }

    fn illumination(&mut self, rest: &[u8]) {
        match self.number_of("illum", rest) {
            Some(model) if (0.0..=10.0).contains(&model) && model.fract() == 0.0 => {
                self.set(|m| &mut m.illum, model as u8);
            }
            Some(_) => self.ignored("illum", "the models are 0 to 10"),
            None => {}
        }
    }

    fn texture(
        &mut self,
        key: &str,
        rest: &[u8],
        field: impl Fn(&mut MtlMaterial) -> &mut Option<At<Texture>>,
    ) {
        match Texture::parse(rest) {
            Some(texture) => self.set(field, texture),
            None => self.ignored(key, "it names no file"),
        }
    }
}

fn words(text: &[u8]) -> impl Iterator<Item = &[u8]> {
    text.split(|b| matches!(b, b' ' | b'\t')).filter(|w| !w.is_empty())
}

/// A word that is a number and nothing else; `nan` and `inf` count, so that they are told from text.
fn whole_number(word: &[u8]) -> Option<f64> {
    match number(word, 0) {
        Some(number) if number.end == word.len() => Some(number.value),
        _ => std::str::from_utf8(word).ok()?.parse().ok(),
    }
}

#[cfg(test)]
mod tests;
