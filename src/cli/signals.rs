//! SIGINT and SIGTERM: the first asks the work to end, the second ends the program at once.
//!
//! Work that can be ended asks [`Signals::stop`] now and then. Where nothing would be lost (while loading, building,
//! comparing) the program does not wait for longer than [`PATIENCE`]: some work (a large picture being decoded) asks too
//! seldom. A thread of its own hears the signals, since a handler may do next to nothing.

use super::console::Console;
use drt::error::{Error, Result};
use signal_hook::consts::{SIGINT, SIGTERM, SIGXFSZ};
use signal_hook::iterator::Signals as Incoming;
use signal_hook::{flag, low_level};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::Duration;

/// How long work may take to end by itself.
const PATIENCE: Duration = Duration::from_secs(1);

/// A write beyond the limit on file sizes (`ulimit -f`) shall fail like any other, so that it is reported and
/// the temporary file goes away, instead of ending the program.
pub fn outlive_file_size_limit() {
    // Where it cannot be registered the signal ends the program, as it would have.
    let _ = flag::register(SIGXFSZ, Arc::new(AtomicBool::new(false)));
}

/// What was received so far.
pub struct Signals {
    shared: Arc<Shared>,
}

#[derive(Default)]
struct Shared {
    received: AtomicUsize,
    /// What is being done, where nothing would be lost by ending it.
    expendable: Mutex<Option<&'static str>>,
}

impl Signals {
    /// Starts to listen.
    pub fn listen() -> Result<Signals> {
        let cannot = |e: std::io::Error| Error::new(format!("cannot listen to signals: {e}"));
        // Armed by the second signal: a third one ends the program even if it cannot say so.
        let again = Arc::new(AtomicBool::new(false));
        for signal in [SIGINT, SIGTERM] {
            flag::register_conditional_shutdown(signal, 128 + signal, again.clone()).map_err(cannot)?;
        }
        let incoming = Incoming::new([SIGINT, SIGTERM]).map_err(cannot)?;
        let shared = Arc::<Shared>::default();
        let heard = shared.clone();
        let listen = move || heard.listen(incoming, &again);
        thread::Builder::new().name("signals".to_string()).spawn(listen).map_err(cannot)?;
        Ok(Signals { shared })
    }

    /// True once one was received.
    pub fn stop(&self) -> bool {
        self.shared.received.load(Ordering::Relaxed) != 0
    }

    /// The number and name of the one received. Who asks is about to conclude, and is left to it.
    pub fn received(&self) -> Option<(i32, &'static str)> {
        self.something_to_lose();
        match self.shared.received.load(Ordering::Relaxed) as i32 {
            0 => None,
            signal => Some((signal, name(signal))),
        }
    }

    /// From now on nothing is lost if a signal ends the program in the midst of `doing` (`loading`).
    pub fn nothing_to_lose(&self, doing: &'static str) {
        *self.shared.expendable.lock().unwrap_or_else(PoisonError::into_inner) = Some(doing);
    }

    /// From now on there is something to write.
    pub fn something_to_lose(&self) {
        *self.shared.expendable.lock().unwrap_or_else(PoisonError::into_inner) = None;
    }
}

impl Shared {
    /// Hears signals for as long as the program runs.
    fn listen(self: Arc<Self>, mut incoming: Incoming, again: &AtomicBool) {
        loop {
            // All that have come are looked at before the first one's effect can be seen.
            let signals: Vec<i32> = incoming.wait().collect();
            let mut before = self.received.load(Ordering::Relaxed);
            for &signal in &signals {
                if before != 0 {
                    again.store(true, Ordering::SeqCst);
                    end(signal, "ended at once by a second signal; what was not written yet is lost");
                }
                before = signal as usize;
            }
            let is_first = self.received.swap(before, Ordering::SeqCst) == 0;
            if is_first && before != 0 {
                let waiting = self.clone();
                // Where there is no thread to be had, the work has to end by itself.
                let _ = thread::Builder::new().spawn(move || waiting.end_what_is_expendable());
            }
        }
    }

    fn end_what_is_expendable(&self) {
        thread::sleep(PATIENCE);
        // Held to the end: what begins meanwhile waits.
        let expendable = self.expendable.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(doing) = *expendable {
            let signal = self.received.load(Ordering::Relaxed) as i32;
            end(signal, &format!("stopped by {} while {doing}; nothing was written", name(signal)));
        }
    }
}

/// Ends the program, whatever other threads do.
fn end(signal: i32, message: &str) -> ! {
    Console::error(message);
    low_level::exit(128 + signal)
}

fn name(signal: i32) -> &'static str {
    if signal == SIGTERM { "SIGTERM" } else { "SIGINT" }
}
