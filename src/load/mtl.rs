//! The MTL reader: classic and physically based (`Pr`, `Pm`, …) statements as plain values.
//!
//! Values leave it finite and in their physical range; what was clamped or ignored is a finding. What the
//! values mean for a material is decided elsewhere. A material library is a file that another file names,
//! so no message ever quotes it: messages are made of the key words below, lines, and nothing else.

mod resolve;
mod statements;
mod texture;

pub(super) use resolve::shown;
pub use resolve::{Resolved, resolve};
pub use texture::{Channel, Texture, TextureOptions};

use super::obj::number::number;
use super::open::Reach;
use crate::error::{Error, Findings, Result};
use statements::Reader;
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
    /// Texture of `ps`.
    pub map_ps: Option<At<Texture>>,
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
            ("map_Ps", &self.map_ps),
            ("disp", &self.disp),
        ];
        all.into_iter().filter_map(|(key, texture)| Some((key, texture.as_ref()?)))
    }
}

/// Reads the regular file `path` within `reach`.
///
/// # Errors
/// It cannot be opened or read, is no regular file, or larger than [`MAX_BYTES`].
pub fn read(path: &Path, reach: &Reach) -> Result<MtlFile> {
    let (file, _) = reach.open(path)?;
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
    let mut reader = Reader::new(path);
    for (line, content) in logical_lines(text) {
        reader.statement(line, &content);
    }
    reader.finish()
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
