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
