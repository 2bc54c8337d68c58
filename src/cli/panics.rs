//! A panic is a bug; it becomes one error line and exit code 1 instead of a trace, whichever thread it was on.

use std::panic::{self, AssertUnwindSafe, PanicHookInfo};
use std::sync::Mutex;

static FIRST: Mutex<Option<String>> = Mutex::new(None);

/// Keeps the first panic's message instead of printing every one.
pub fn silence() {
    panic::set_hook(Box::new(|info: &PanicHookInfo<'_>| {
        let what = info.payload();
        let text = what.downcast_ref::<&str>().map(ToString::to_string);
        let text = text.or_else(|| what.downcast_ref::<String>().cloned()).unwrap_or_default();
        let place = info.location().map(|l| format!(" ({}:{})", l.file(), l.line())).unwrap_or_default();
        if let Ok(mut first) = FIRST.lock() {
            first.get_or_insert(format!("{text}{place}"));
        }
    }));
}

/// Runs `work`; a panic, its own or one that a worker thread handed on, is the message of the first one.
pub fn catch<T>(work: impl FnOnce() -> T) -> Result<T, String> {
    panic::catch_unwind(AssertUnwindSafe(work)).map_err(|_| {
        let first = FIRST.lock().ok().and_then(|mut first| first.take());
        first.unwrap_or_else(|| "unknown".to_string())
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use drt::accel::{Backend, Checked, Coherence, Hits, Intersector, Mask};
    use drt::render::{self, Hooks};
    use std::path::Path;
    use std::sync::atomic::{AtomicU32, Ordering};

    /// Breaks at the question of that number.
    struct Broken<'a> {
        whole: &'a dyn Intersector,
        left: AtomicU32,
    }

    impl Intersector for Broken<'_> {
        fn closest(&self, rays: Checked<'_>, coherence: Coherence, hits: &mut Hits) {
            assert!(self.left.fetch_sub(1, Ordering::Relaxed) > 1, "the hierarchy broke");
            self.whole.closest(rays, coherence, hits);
        }

        fn occluded(&self, rays: Checked<'_>, coherence: Coherence) -> Mask {
            self.whole.occluded(rays, coherence)
        }

        fn bytes(&self) -> usize {
            self.whole.bytes()
        }

        fn isa(&self) -> &str {
            self.whole.isa()
        }
    }

    /// A worker that panics in the middle of a picture ends the render with its message; nobody waits for it.
    #[test]
    fn d8_a_worker_that_panics_is_one_message() {
        let input = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/cornell-box.toml");
        let mut loaded = drt::load::scene(&input, drt::load::Options::default()).unwrap();
        (loaded.settings.size, loaded.settings.spp) = ([96, 96], 4);
        loaded.settings.backend = Backend::Bvh;
        let (scene, settings) = (&loaded.scene, &loaded.settings);
        let hooks = Hooks::NONE;
        let whole = render::build(scene, settings, None, &hooks).unwrap();
        let usual = panic::take_hook();
        silence();
        let messages = [(2, 1), (2, 40), (64, 1), (64, 40)].map(|(threads, left)| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let broken = Broken { whole: &*whole, left: AtomicU32::new(left) };
            catch(|| pool.install(|| render::render(scene, settings, &broken, None, &hooks).map(|_| ())))
        });
        panic::set_hook(usual);
        for message in messages {
            let message = message.expect_err("a panic");
            assert!(message.starts_with("the hierarchy broke (src/cli/panics.rs:"), "{message}");
        }
        assert_eq!(catch(|| 1), Ok(1));
    }
}
