//! `--stats`: what was done, as JSON.

use super::console::write_stdout;
use super::machine;
use drt::error::{Findings, Result};
use drt::memory;
use drt::output;
use drt::render::RenderStats;
use drt::scene::{Scene, Settings};
use serde_json::{Map, Value, json};
use std::path::Path;
use std::time::Instant;

/// Wall and CPU time of the phases, one after the other.
pub struct Clock {
    begun: (Instant, f64),
    last: (Instant, f64),
    phases: Vec<(&'static str, f64, f64)>,
}

impl Clock {
    /// Starts now; CPU time counts from the start of the program.
    pub fn start() -> Clock {
        Clock { begun: (Instant::now(), 0.0), last: (Instant::now(), 0.0), phases: Vec::new() }
    }

    /// Ends a phase; the next begins.
    pub fn end(&mut self, phase: &'static str) -> f64 {
        let now = (Instant::now(), machine::cpu_seconds());
        let seconds = (now.0 - self.last.0).as_secs_f64();
        let cpu = now.1 - self.last.1;
        match self.phases.iter_mut().find(|known| known.0 == phase) {
            // Of a series, the sum.
            Some(known) => (known.1, known.2) = (known.1 + seconds, known.2 + cpu),
            None => self.phases.push((phase, seconds, cpu)),
        }
        self.last = now;
        seconds
    }

    /// Seconds since the start.
    pub fn total(&self) -> f64 {
        self.begun.0.elapsed().as_secs_f64()
    }

    fn json(&self, value: impl Fn(&(&'static str, f64, f64)) -> f64, total: f64) -> Value {
        let mut object: Map<String, Value> =
            self.phases.iter().map(|phase| (phase.0.to_string(), json!(value(phase)))).collect();
        object.insert("total".to_string(), json!(total));
        Value::Object(object)
    }
}

/// What the file holds.
pub struct Report<'a> {
    pub scene: &'a Scene,
    pub settings: &'a Settings,
    pub findings: &'a Findings,
    pub skipped_faces: u64,
    /// Triangles as the files say.
    pub triangles: u64,
    pub threads: usize,
    pub isa: &'a str,
    pub bvh_bytes: usize,
    pub stats: &'a RenderStats,
    pub complete: bool,
    pub clock: &'a Clock,
}

impl Report<'_> {
    /// Writes the report to `path`, or to stdout for `-`.
    pub fn write(&self, path: &Path) -> Result<()> {
        let mut text = serde_json::to_string_pretty(&self.json()).unwrap_or_default();
        text.push('\n');
        if path.as_os_str() == "-" { write_stdout(&text) } else { output::write_bytes(path, text.as_bytes()) }
    }

    fn json(&self) -> Value {
        let warnings: Map<String, Value> =
            self.findings.counts().map(|(kind, count, _)| (kind.to_string(), json!(count))).collect();
        let (s, stats) = (self.settings, self.stats);
        json!({
            "version": env!("CARGO_PKG_VERSION"),
            "backend": s.backend.name(),
            "isa": self.isa,
            "threads": self.threads,
            "seed": s.seed,
            "spp": s.spp,
            "width": s.size[0],
            "height": s.size[1],
            "crop": s.crop,
            "integrator": s.integrator.name(),
            "sampler": s.sampler.name(),
            "complete": self.complete,
            "meshes": self.scene.all_meshes().count(),
            "instances": self.scene.instances.places.len(),
            "materials": self.scene.materials.len(),
            "triangles": self.triangles,
            "vertices": self.scene.vertices(),
            "skipped_faces": self.skipped_faces,
            "warnings": warnings,
            "seconds": self.clock.json(|phase| phase.1, self.clock.total()),
            "cpu_seconds": self.clock.json(|phase| phase.2, machine::cpu_seconds()),
            "seconds_in": {
                "intersect": stats.intersect_seconds,
                "shade": stats.shade_seconds,
                "rest": stats.rest_seconds,
            },
            "rays": { "camera": stats.camera_rays, "bounce": stats.bounce_rays, "shadow": stats.shadow_rays },
            "rejected_rays": stats.rejected_rays,
            "invalid_samples": stats.invalid_samples,
            "peak_rss_bytes": memory::peak(),
            "bvh_bytes": self.bvh_bytes,
        })
    }
}
