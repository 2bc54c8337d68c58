//! The material of a format that knows pictures and nothing else of materials.

use super::{MapSpec, Slot, Sources, Stated};
use crate::bsdf::Parameter;
use crate::error::{Finding, Findings, Severity};
use crate::load::auto;
use crate::load::materials::MaterialSpec;
use crate::texture::{Mapping, Transfer};
use std::path::Path;

/// A diffuse material with the picture that `file` states in a line, or clay.
pub(crate) fn of_picture(
    name: &str,
    picture: Option<(u64, &str)>,
    file: &Path,
    sources: &mut Sources,
    findings: &mut Findings,
) -> MaterialSpec {
    let mut spec = MaterialSpec::diffuse(name, auto::CLAY);
    let Some((line, picture)) = picture else { return spec };
    let folder = file.parent().unwrap_or(Path::new(""));
    let stated = Stated { file: file.to_path_buf(), line, title: format!("\"{name}\"") };
    match sources.find(folder, picture.as_bytes()) {
        Some((source, _)) => spec.maps.push(MapSpec {
            slot: Slot::Parameter(Parameter::Reflectance),
            source,
            mapping: Mapping::plain(Transfer::Srgb),
            fallback: Some(auto::CLAY),
            stated,
        }),
        None => {
            let message = format!("{}: the file that TextureFile names was not found", stated.title);
            let (kind, severity) = ("texture-missing", Severity::Warning);
            findings.push(Finding { file: stated.file, line, kind, message, severity });
        }
    }
    spec
}
