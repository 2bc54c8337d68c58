//! What a picture will take in memory, before anything large is made for it; and what would take less.

use super::{BuildQuality, Compact, Settings};
use crate::accel::Backend;
use crate::accel::need::Extent;
use crate::error::Result;
use crate::memory::{self, Left, megabytes};

/// Bytes a pixel of sums in f64, and those of layers.
const SUMS: [u64; 2] = [42, 112];
/// Bytes a pixel of what is developed, with the encoder's copies, and those of layers.
const DEVELOPED: [u64; 2] = [30, 56];

/// What is needed on top of what there is, in bytes.
#[derive(Clone, Copy, Debug, Default)]
pub struct Need {
    /// What is yet to be read: the meshes, and the reader's own at its peak.
    pub meshes: Meshes,
    /// What is built over.
    pub over: Extent,
}

/// What meshes that are not yet read take.
#[derive(Clone, Copy, Debug, Default)]
pub struct Meshes {
    /// Once they are read.
    pub kept: u64,
    /// While they are read.
    pub peak: u64,
}

impl Need {
    /// Adds a mesh that is yet to be read. The reader's own is needed for one at a time.
    pub fn add(&mut self, over: Extent, meshes: Meshes) {
        let reading = self.meshes.kept.saturating_add(meshes.peak);
        self.meshes.peak = self.meshes.peak.max(reading);
        self.meshes.kept = self.meshes.kept.saturating_add(meshes.kept);
        self.over.triangles = self.over.triangles.saturating_add(over.triangles);
        self.over.vertices = self.over.vertices.saturating_add(over.vertices);
        self.over.meshes += over.meshes;
    }

    /// For everything that `settings` ask for.
    pub fn of(&self, settings: &Settings) -> u64 {
        let quality = settings.quality(self.over.triangles);
        let compact = settings.compact == Compact::Yes;
        let structure = settings.backend.need(self.over, quality, compact);
        let later = structure.saturating_add(film(settings));
        self.meshes.kept.saturating_add(later).max(self.meshes.peak)
    }

    /// Refuses what does not fit into `left`. An estimate: a tenth more than there is may pass.
    ///
    /// # Errors
    /// What is needed, what there is, and what would fit.
    pub fn check(&self, settings: &Settings, left: Option<Left>) -> Result<()> {
        let Some(left) = left else { return Ok(()) };
        let needed = self.of(settings);
        let fits = |needed: u64| needed - needed / 10 <= left.bytes;
        if fits(needed) {
            return Ok(());
        }
        let what = self.in_words(settings);
        let mut less: Vec<String> = alternatives(settings)
            .map(|(words, settings)| (words, self.of(&settings)))
            .filter(|(_, needed)| fits(*needed))
            .map(|(words, needed)| format!("{words} needs {}", megabytes(needed)))
            .collect();
        if less.is_empty() {
            less.push("use a machine with more memory, or split or simplify the mesh".to_string());
        }
        Err(memory::refused(needed, &what, left, less.join("; ")))
    }

    /// What the memory is for.
    pub fn in_words(&self, settings: &Settings) -> String {
        let triangles = self.over.triangles as f64 / 1e6;
        let [width, height] = settings.size;
        let film = megabytes(film(settings));
        match self.over.triangles {
            0..100_000 => format!("{film} for a picture of {width}x{height}"),
            _ => format!("{triangles:.1} million triangles; {film} for the picture"),
        }
    }
}

/// The sums, the picture and what writing it takes.
fn film(settings: &Settings) -> u64 {
    let pixels = u64::from(settings.size[0]) * u64::from(settings.size[1]);
    pixels * each(SUMS, settings) + developed(settings)
}

/// What is needed after the last sample: the picture and what writing it takes.
pub fn developed(settings: &Settings) -> u64 {
    let [_, _, width, height] = settings.crop.unwrap_or([0, 0, settings.size[0], settings.size[1]]);
    u64::from(width) * u64::from(height) * each(DEVELOPED, settings)
}

fn each([colours, layers]: [u64; 2], settings: &Settings) -> u64 {
    if settings.aovs.is_empty() { colours } else { colours + layers }
}

/// Settings that take less, with the words that ask for them; the least change first.
fn alternatives(settings: &Settings) -> impl Iterator<Item = (String, Settings)> + '_ {
    let compact = |s: &mut Settings| {
        s.compact = Compact::Yes;
        if s.build == BuildQuality::Auto {
            s.build = BuildQuality::Fixed(crate::accel::Quality::Medium);
        }
    };
    let changed = move |words: String, change: &dyn Fn(&mut Settings)| {
        let mut less = settings.clone();
        change(&mut less);
        (words, less)
    };
    let may_be_compact = settings.compact != Compact::Yes;
    let compact = (may_be_compact && settings.backend.has_compact())
        .then(|| changed("--compact".to_string(), &compact));
    let other = Backend::ALL.iter().copied().filter(|backend| *backend != settings.backend);
    let other = other
        .map(move |b| changed(format!("--backend {}", b.name()), &move |s: &mut Settings| s.backend = b));
    let smaller = [2, 4, 8, 16, 32].into_iter().map(move |by| {
        let size = settings.size.map(|side| (side / by).max(1));
        let words = format!("--size {}x{}", size[0], size[1]);
        changed(words, &move |s: &mut Settings| s.size = size)
    });
    compact.into_iter().chain(other).chain(smaller)
}
