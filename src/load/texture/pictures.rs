//! Every picture is decoded once, in parallel, and only if its header promises to fit.

use super::{MapSpec, Place, Stated};
use crate::error::{Finding, Findings, Result, Severity, show_path};
use crate::load::cancelled;
use crate::load::picture::texels::{Probe, Trouble, probe, texels};
use crate::texture::Texels;
use rayon::prelude::*;
use std::collections::HashMap;
use std::sync::Arc;

/// What all textures together may take where nobody says otherwise: 4 GiB.
pub(crate) const MOST_BYTES: u64 = 4 << 30;

/// The pictures that could be decoded.
pub(super) type Pictures = HashMap<Place, Arc<Texels>>;

/// A picture, the first statement that names it, and what its header says.
type Candidate<'m> = (&'m Place, &'m Stated, Probe);

/// Decodes the files of `maps`, each once. Headers are read first and in order, so that which pictures fit into
/// `most_bytes` does not depend on threads.
///
/// # Errors
/// `progress` cancelled.
pub(super) fn load<'m>(
    maps: impl Iterator<Item = &'m MapSpec>,
    most_bytes: u64,
    progress: &(dyn Fn(f64) -> bool + Sync),
    findings: &mut Findings,
) -> Result<Pictures> {
    let mut seen = std::collections::HashSet::new();
    let mut candidates: Vec<Candidate<'m>> = Vec::new();
    let mut left = most_bytes;
    for (place, stated) in maps.flat_map(|map| map.source.places().map(|place| (place, &map.stated))) {
        if !seen.insert(place) {
            continue;
        }
        if !progress(1.0) {
            return Err(cancelled());
        }
        match probe(place) {
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
                note(findings, stated, "texture-unreadable", &format!("the file {}", trouble.message()));
            }
        }
    }
    let decoded: Vec<Option<Result<Texels, Trouble>>> =
        candidates.par_iter().map(|(place, _, probe)| progress(1.0).then(|| texels(place, probe))).collect();
    let mut pictures = Pictures::new();
    for ((place, stated, _), texels) in candidates.into_iter().zip(decoded) {
        match texels.ok_or_else(cancelled)? {
            Ok(texels) => {
                pictures.insert(place.clone(), Arc::new(texels));
            }
            Err(trouble) => {
                note(findings, stated, "texture-unreadable", &format!("the file {}", trouble.message()));
            }
        }
    }
    Ok(pictures)
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
