//! Skies from picture files, and the words that name a sky.

use super::auto::Sky;
use super::picture;
use crate::error::{Error, Finding, Result, Severity, unknown_word_advice};
use crate::light::panorama::{HIGHEST, Panorama, Repairs, axes, repair};
use crate::light::{Environment, Light};
use crate::load::auto::Bearings;
use crate::load::open::Reach;
use crate::math::{DVec3, Rgb};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// What `--sky` names.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum SkySource {
    /// A built-in sky.
    BuiltIn(Sky),
    /// A picture of all directions.
    Picture(PathBuf),
}

impl SkySource {
    /// The built-in sky of that name, or a picture, told by its extension.
    ///
    /// # Errors
    /// A word that is neither.
    pub fn from_word(word: &str) -> Result<SkySource> {
        match Sky::from_name(word) {
            Ok(sky) => Ok(SkySource::BuiltIn(sky)),
            Err(_) if is_picture(word) => Ok(SkySource::Picture(word.into())),
            Err(_) => {
                let known: Vec<&str> = Sky::TABLE.iter().map(|row| row.0).collect();
                let advice = format!("{}, or a picture (.exr, .hdr)", unknown_word_advice(word, &known));
                Err(Error::usage(format!("unknown sky \"{word}\"")).advise(advice))
            }
        }
    }
}

/// True for a name that ends like a picture's.
pub(crate) fn is_picture(word: &str) -> bool {
    let word = word.to_lowercase();
    [".hdr", ".exr", ".pfm", ".png", ".jpg", ".jpeg"].iter().any(|e| word.ends_with(e))
}

/// A picture of all directions, read and repaired.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SkyPicture {
    /// Where it came from.
    pub file: PathBuf,
    size: [usize; 2],
    texels: Arc<Vec<[f32; 3]>>,
    repairs: Repairs,
}

impl SkyPicture {
    /// Reads a picture within `reach` in any format that [`picture::read`] knows.
    ///
    /// # Errors
    /// As [`picture::read`].
    pub fn read(file: &Path, reach: &Reach) -> Result<SkyPicture> {
        let image = picture::read_within(reach, file)?.image;
        let mut texels = image.rgb_pixels();
        let repairs = repair(&mut texels);
        let size = [image.width as usize, image.height as usize];
        Ok(SkyPicture { file: file.to_path_buf(), size, texels: Arc::new(texels), repairs })
    }

    /// The light: `scale` times the picture, its zenith at `up`, turned by `rotate` degrees.
    pub fn light(&self, scale: f32, rotate: f64, up: DVec3) -> Option<Light> {
        let up = up.normalize_or(DVec3::Y);
        let axes = axes(up, Bearings::new(up).front, rotate);
        let scaled = |t: &[f32; 3]| (Rgb::from(*t) * scale).min(Rgb::splat(HIGHEST)).to_array();
        let texels = self.texels.iter().map(scaled).collect();
        let map = Panorama::new(self.size, texels, axes)?;
        Some(Light::Environment(Environment::Panorama(Arc::new(map))))
    }

    /// What had to be repaired.
    pub fn finding(&self) -> Option<Finding> {
        let Repairs { nan, negative, huge } = self.repairs;
        let kinds =
            [(nan, "are no numbers"), (negative, "are negative"), (huge, "are infinite or beyond 1e12")];
        let said: Vec<String> =
            kinds.iter().filter(|k| k.0 > 0).map(|(count, what)| format!("{count} values {what}")).collect();
        (!said.is_empty()).then(|| Finding {
            file: self.file.clone(),
            line: 0,
            kind: "sky-values",
            message: format!("{}; taken as black, or as bright as can be", said.join(", ")),
            severity: Severity::Warning,
        })
    }
}
