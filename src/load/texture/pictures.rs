//! Every picture is decoded once, in parallel, and only if its header promises to fit.

use super::{MapSpec, Place, Source, Stated};
use crate::error::{Finding, Findings, Result, Severity, show_path};
use crate::load::cancelled;
use crate::load::open::Reach;
use crate::load::picture::texels::{Probe, Trouble, probe, texels};
use crate::math::DVec3;
use crate::texture::{MeanKey, Texels, Tiles};
use rayon::prelude::*;
use std::collections::HashMap;
use std::sync::Arc;

/// What all textures together may take where nobody says otherwise: 4 GiB.
pub(crate) const MOST_BYTES: u64 = 4 << 30;

/// The pictures that could be decoded, by where they are.
pub(super) type ByPlace = HashMap<Place, Arc<Texels>>;

/// Means of textures.
pub(super) type Means = HashMap<MeanKey, DVec3>;

/// Pictures, and what has been found out about them.
pub(super) struct Pictures {
    pub by_place: ByPlace,
    /// UDIM sets by their list of files, for all who name the set.
    pub sets: HashMap<*const [(u32, Place)], Option<Tiles>>,
    pub means: Means,
}

/// A picture, the first statement that names it, and what its header says.
type Candidate<'m> = (&'m Place, &'m Stated, Probe);

/// Decodes the files of `maps`, each once. Headers are read first and in order, so that which pictures fit into
/// `most_bytes` does not depend on threads; nothing outside of `reach` is.
///
/// # Errors
/// `progress` cancelled.
pub(super) fn load<'m>(
    maps: impl Iterator<Item = &'m MapSpec>,
    reach: &Reach,
    most_bytes: u64,
    progress: &(dyn Fn(f64) -> bool + Sync),
    findings: &mut Findings,
) -> Result<Pictures> {
    let mut seen = std::collections::HashSet::new();
    let mut candidates: Vec<Candidate<'m>> = Vec::new();
    let mut left = most_bytes;
    let mut sets = std::collections::HashSet::new();
    let is_new = |map: &&MapSpec| match &map.source {
        Source::One(_) => true,
        Source::Tiles(tiles) => sets.insert(Arc::as_ptr(tiles)),
    };
    let files = |map: &'m MapSpec| map.source.places().map(|place| (place, &map.stated));
    for (place, stated) in maps.filter(is_new).flat_map(files) {
        if !seen.insert(place) {
            continue;
        }
        if !progress(1.0) {
            return Err(cancelled());
        }
        match probe(place, reach) {
            Ok(probe) if probe.bytes <= left => {
                left -= probe.bytes;
                candidates.push((place, stated, probe));
            }
            Ok(probe) => {
                let [width, height] = probe.size;
                let message = format!(
                    "its {width}x{height} pixels would take all textures beyond {most_bytes} bytes; raise --max-texture-bytes"
                );
                note(findings, stated, "texture-limit", &message);
            }
            Err(Trouble::Unreadable(_)) if !place.exists() => {
                // Only a scene file's own path comes here; an MTL's names are looked for before.
                let name = place.path().map(|path| show_path(path)).unwrap_or_default();
                let message = format!("the file {name} was not found");
                note(findings, stated, "texture-missing", &message);
            }
            Err(trouble) => {
                note(findings, stated, trouble.kind(), &format!("the file {}", trouble.message()));
            }
        }
    }
    let decoded: Vec<Option<Result<Texels, Trouble>>> = candidates
        .par_iter()
        .map(|(place, _, probe)| progress(1.0).then(|| texels(place, reach, probe)))
        .collect();
    let mut by_place = ByPlace::new();
    for ((place, stated, _), texels) in candidates.into_iter().zip(decoded) {
        match texels.ok_or_else(cancelled)? {
            Ok(texels) => {
                by_place.insert(place.clone(), Arc::new(texels));
            }
            Err(trouble) => {
                note(findings, stated, trouble.kind(), &format!("the file {}", trouble.message()));
            }
        }
    }
    Ok(Pictures { by_place, sets: HashMap::new(), means: Means::new() })
}

fn note(findings: &mut Findings, stated: &Stated, kind: &'static str, what: &str) {
    findings.push(Finding {
        file: stated.file.clone(),
        line: stated.line,
        kind,
        message: format!("{}: {what}", stated.title),
        severity: Severity::Warning,
    });
}
