//! SIGINT and SIGTERM: the first asks the work to end, the second ends the program at once.

use drt::error::{Error, Result};
use signal_hook::consts::{SIGINT, SIGTERM, SIGXFSZ};
use signal_hook::flag;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// A write beyond the limit on file sizes (`ulimit -f`) shall fail like any other, so that it is reported and
/// the temporary file goes away, instead of ending the program.
pub fn outlive_file_size_limit() {
    // Where it cannot be registered the signal ends the program, as it would have.
    let _ = flag::register(SIGXFSZ, Arc::new(AtomicBool::new(false)));
}

/// What was received so far.
pub struct Signals {
    received: Arc<AtomicUsize>,
}

impl Signals {
    /// Starts to listen.
    pub fn listen() -> Result<Signals> {
        let received = Arc::new(AtomicUsize::new(0));
        let again = Arc::new(AtomicBool::new(false));
        for signal in [SIGINT, SIGTERM] {
            // Actions run in the order of registration: the shutdown sees the flag of the signal before.
            flag::register_conditional_shutdown(signal, 128 + signal, again.clone())
                .and_then(|_| flag::register(signal, again.clone()))
                .and_then(|_| flag::register_usize(signal, received.clone(), signal as usize))
                .map_err(|e| Error::new(format!("cannot listen to signals: {e}")))?;
        }
        Ok(Signals { received })
    }

    /// True once one was received.
    pub fn stop(&self) -> bool {
        self.received.load(Ordering::Relaxed) != 0
    }

    /// The number and name of the one received.
    pub fn received(&self) -> Option<(i32, &'static str)> {
        match self.received.load(Ordering::Relaxed) as i32 {
            0 => None,
            SIGTERM => Some((SIGTERM, "SIGTERM")),
            _ => Some((SIGINT, "SIGINT")),
        }
    }
}
