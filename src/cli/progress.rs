//! Progress on stderr: a bar for people, lines for logs, JSON for programs.

use super::console::line_to_stderr;
use drt::error::{Error, Result, unknown_word_advice};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::IsTerminal;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

/// How progress is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Style {
    /// A bar where stderr is a terminal, else nothing.
    Auto,
    /// A line every few per cent.
    Plain,
    /// A JSON object a line.
    Json,
    /// Nothing.
    None,
}

impl Style {
    /// Name and meaning, the default first.
    pub const TABLE: &'static [(&'static str, Style)] =
        &[("auto", Style::Auto), ("plain", Style::Plain), ("json", Style::Json), ("none", Style::None)];

    /// The style of that name.
    pub fn from_name(word: &str) -> Result<Style> {
        Self::TABLE.iter().find(|row| row.0 == word).map(|row| row.1).ok_or_else(|| {
            let known: Vec<&str> = Self::TABLE.iter().map(|row| row.0).collect();
            Error::usage(format!("--progress: unknown style \"{word}\""))
                .advise(unknown_word_advice(word, &known))
        })
    }
}

/// Steps in a phase: a bar of 1000, lines of 5 %, objects of 1 %.
const STEPS: u64 = 1000;

/// A phase under way, heard of from several threads.
pub struct Phase {
    style: Style,
    name: &'static str,
    started: Instant,
    /// The last step shown, one up.
    shown: AtomicU64,
    /// Lines must not overtake each other.
    order: Mutex<()>,
    bar: Option<ProgressBar>,
}

impl Phase {
    /// Begins a phase.
    pub fn begin(style: Style, name: &'static str) -> Phase {
        let bar = (style == Style::Auto && std::io::stderr().is_terminal()).then(|| bar(name));
        Phase { style, name, started: Instant::now(), shown: AtomicU64::new(0), order: Mutex::new(()), bar }
    }

    /// `done` of `total`; `unit` names what is counted.
    pub fn show(&self, done: u64, total: u64) {
        self.show_work(
            if total > 0 { (done as f64 / total as f64).clamp(0.0, 1.0) } else { 0.0 },
            done,
            total,
        );
    }

    /// `done` of `total`, which are a `share` of the work.
    pub fn show_work(&self, share: f64, done: u64, total: u64) {
        if let Some(bar) = &self.bar {
            bar.set_position((share * STEPS as f64) as u64);
            return;
        }
        let width = match self.style {
            Style::Plain => STEPS / 20,
            Style::Json => STEPS / 100,
            Style::Auto | Style::None => return,
        };
        let step = (share * STEPS as f64) as u64 / width + 1;
        if self.shown.load(Ordering::Relaxed) >= step {
            return;
        }
        let Ok(_in_order) = self.order.lock() else { return };
        if self.shown.fetch_max(step, Ordering::Relaxed) < step {
            self.print(share, done, total);
        }
    }

    /// A share of a phase that counts nothing.
    pub fn show_share(&self, share: f64) {
        self.show((share.clamp(0.0, 1.0) * 1e6) as u64, 1_000_000);
    }

    fn print(&self, share: f64, done: u64, total: u64) {
        let elapsed = self.started.elapsed().as_secs_f64();
        // Before the first per cent any guess is noise.
        let left = (share >= 0.01).then(|| elapsed / share * (1.0 - share));
        if self.style == Style::Json {
            let mut object = serde_json::json!({ "phase": self.name, "share": share, "seconds": elapsed, "seconds_left": left });
            if self.name == "render" {
                object["samples_done"] = done.into();
                object["samples"] = total.into();
            }
            line_to_stderr(&object.to_string());
        } else {
            let left = left.map_or(String::new(), |s| format!(", {} left", duration(s)));
            line_to_stderr(&format!("{} {:.0} %{left}", self.name, (share * 100.0).floor()));
        }
    }
}

impl Drop for Phase {
    fn drop(&mut self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

fn bar(name: &'static str) -> ProgressBar {
    let bar = ProgressBar::with_draw_target(Some(STEPS), ProgressDrawTarget::stderr_with_hz(10));
    if let Ok(style) = ProgressStyle::with_template("{msg:>7} [{bar:40}] {percent:>3} %  {eta} left") {
        bar.set_style(style.progress_chars("=> "));
    }
    bar.set_message(name);
    bar
}

/// `95` seconds as `1 min 35 s`.
pub fn duration(seconds: f64) -> String {
    let whole = seconds.round() as u64;
    match whole {
        0..10 => format!("{seconds:.1} s"),
        10..120 => format!("{whole} s"),
        120..7200 => format!("{} min {} s", whole / 60, whole % 60),
        _ => format!("{} h {} min", whole / 3600, whole / 60 % 60),
    }
}
