//! Who is asked: backends with the instruction sets of this machine and build qualities.

use crate::accel::{Backend, BuildOptions, Intersector, Quality};
use crate::error::{Error, Result, unknown_word_advice};
use crate::math::isa::Isa;
use crate::shape::Mesh;
use std::sync::Arc;

/// Builds an intersector.
pub type Build = dyn Fn(&[Arc<Mesh>], &BuildOptions<'_>) -> Result<Box<dyn Intersector>> + Sync;

/// A way to intersect.
pub struct Contestant {
    /// The backend's name.
    pub backend: String,
    /// The instruction set.
    pub isa: Isa,
    /// The effort of the build.
    pub quality: Quality,
    /// False when it is known to be wrong now and then and asked for comparison only: its real disagreements are
    /// counted and shown, but they are no failure.
    pub counts: bool,
    /// Builds it.
    pub build: Box<Build>,
}

/// Embree without its robust flag, as most programs use it: faster, and not watertight.
#[cfg(feature = "embree")]
const FAST: &str = "embree-fast";

impl Contestant {
    /// A backend of this drt.
    pub fn of(backend: Backend, isa: Isa, quality: Quality) -> Contestant {
        let build = move |meshes: &[Arc<Mesh>], options: &BuildOptions<'_>| backend.build(meshes, options);
        let backend = backend.name().to_string();
        Contestant { backend, isa, quality, counts: true, build: Box::new(build) }
    }

    /// Embree without its robust flag.
    #[cfg(feature = "embree")]
    pub fn fast(isa: Isa, quality: Quality) -> Contestant {
        let build = move |meshes: &[Arc<Mesh>], options: &BuildOptions<'_>| {
            let built = crate::accel::embree::Embree::build_fast(meshes, options)?;
            Ok(Box::new(built) as Box<dyn Intersector>)
        };
        Contestant { backend: FAST.to_string(), isa, quality, counts: false, build: Box::new(build) }
    }

    /// All of them. First comes the one that the others are compared with: our hierarchy, whose answer is that of
    /// testing every triangle, while Embree is known to lose rays through vertices.
    pub fn all() -> Vec<Contestant> {
        use Quality::{High, Low, Medium};
        let isas = || Isa::ALL.into_iter().rev().filter(|isa| *isa <= Isa::best());
        let mut all = Vec::new();
        for isa in isas() {
            all.extend([Medium, Low, High].map(|quality| Contestant::of(Backend::Bvh, isa, quality)));
        }
        #[cfg(feature = "embree")]
        for isa in isas() {
            // Embree knows no better than medium where it is robust.
            all.extend([Medium, Low].map(|quality| Contestant::of(Backend::Embree, isa, quality)));
        }
        #[cfg(feature = "embree")]
        for isa in isas() {
            all.extend([Medium, Low, High].map(|quality| Contestant::fast(isa, quality)));
        }
        all
    }

    /// Those that are asked where nobody is named: every instruction set, of Embree with both kinds of tree; what is our
    /// hierarchy's quality and Embree's speed with the best set alone.
    pub fn usual() -> Vec<Contestant> {
        let is_usual = |c: &Contestant| {
            let is_embree = c.counts && c.backend != "bvh";
            c.isa == Isa::best() && c.quality != Quality::Low
                || is_embree
                || c.backend == "bvh" && (c.quality == Quality::Medium || c.isa == Isa::best())
        };
        Contestant::all().into_iter().filter(is_usual).collect()
    }

    /// Those that `list` names: words joined by `-` (`embree-avx2-low`, `bvh`, `fast`) name all contestants that have
    /// all of them; `,` goes on with others; `all`.
    ///
    /// # Errors
    /// A word that nobody has, words that nobody has together.
    pub fn named(list: &str) -> Result<Vec<Contestant>> {
        let mut all: Vec<(Contestant, bool)> = Contestant::all().into_iter().map(|c| (c, false)).collect();
        for name in list.split(',') {
            let words: Vec<&str> = name.trim().split('-').filter(|word| *word != "all").collect();
            let known: Vec<String> = all.iter().flat_map(|(c, _)| c.words()).collect();
            if let Some(word) = words.iter().find(|word| !known.iter().any(|k| k == *word)) {
                let mut known: Vec<&str> = known.iter().map(String::as_str).chain(["all"]).collect();
                known.sort_unstable();
                known.dedup();
                return Err(Error::usage(format!("--contestants {list}: nobody here is called \"{word}\""))
                    .advise(unknown_word_advice(word, &known)));
            }
            let has_all = |c: &Contestant| words.iter().all(|word| c.words().iter().any(|own| own == word));
            let mut found = false;
            for (contestant, taken) in &mut all {
                if has_all(contestant) {
                    (*taken, found) = (true, true);
                }
            }
            if !found {
                return Err(Error::usage(format!("--contestants {list}: nobody is all of \"{name}\""))
                    .advise("a name is a backend, an instruction set and a quality, or some of them: embree-avx2-low"));
            }
        }
        Ok(all.into_iter().filter(|(_, taken)| *taken).map(|(contestant, _)| contestant).collect())
    }

    fn words(&self) -> Vec<String> {
        let backend = self.backend.split('-').map(str::to_string);
        backend.chain([self.isa.name().to_string(), self.quality.name().to_string()]).collect()
    }

    /// e.g. `bvh avx512 medium`.
    pub fn name(&self) -> String {
        format!("{} {} {}", self.backend, self.isa.name(), self.quality.name())
    }

    /// Builds it over `meshes` on at most `threads` threads; a `progress` of `false` cancels.
    ///
    /// # Errors
    /// The backend's own, or [`crate::accel::cancelled`].
    pub fn intersector(
        &self,
        meshes: &[Arc<Mesh>],
        threads: usize,
        progress: &(dyn Fn(f64) -> bool + Sync),
    ) -> Result<Box<dyn Intersector>> {
        let (quality, isa) = (self.quality, Some(self.isa));
        (self.build)(meshes, &BuildOptions { quality, isa, threads, progress, compact: false })
    }
}
