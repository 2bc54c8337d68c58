//! Findings with their place in the file.

use crate::error::{Finding, Findings, Severity};
use std::path::Path;

/// What a finding is about.
#[derive(Clone, Copy)]
pub(super) enum Place {
    /// The whole file.
    File,
    /// A triangle of the mesh.
    Triangle(u32),
}

/// Writes findings about one mesh file.
pub(super) struct Writer<'a> {
    pub file: &'a Path,
    /// By triangle: the line of its face; empty where unknown.
    pub lines: &'a [u32],
    pub findings: Findings,
}

impl Writer<'_> {
    /// Adds a finding; where the line is unknown, the triangle's number is told.
    pub fn add(&mut self, kind: &'static str, severity: Severity, place: Place, mut message: String) {
        let line = match place {
            Place::File => 0,
            Place::Triangle(triangle) => {
                let line = self.lines.get(triangle as usize).copied().unwrap_or(0);
                if line == 0 {
                    message = format!("triangle {triangle} (from 0): {message}");
                }
                u64::from(line)
            }
        };
        self.findings.push(Finding { file: self.file.to_path_buf(), line, kind, message, severity });
    }

    /// Counts those of `all` findings of a kind that were not `added`.
    pub fn more(&mut self, kind: &'static str, severity: Severity, all: u64, added: usize) {
        self.findings.count_more(kind, severity, all.saturating_sub(added as u64));
    }
}
