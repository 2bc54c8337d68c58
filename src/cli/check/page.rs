//! The report as a page: what is wrong first, then the figures, a verdict in the last line.

use crate::cli::console::summary;
use drt::check::{Bounds, MeshReport, Report, Topology, short};
use drt::error::{Severity, one_line, show_path};
use std::fmt::Write;

/// Rows of a list before it is cut short.
const ROWS: usize = 20;

/// The page.
pub fn text(report: &Report) -> String {
    let mut page = format!("{}\n", show_path(&report.input));
    findings(&mut page, report);
    match report.meshes.as_slice() {
        [mesh] if mesh.file == report.input => mesh_rows(&mut page, mesh),
        meshes => {
            scene_rows(&mut page, report);
            for mesh in meshes.iter().take(ROWS) {
                let _ = writeln!(page, "\n{}", show_path(&mesh.file));
                mesh_rows(&mut page, mesh);
            }
            more(&mut page, meshes.len(), "meshes");
        }
    }
    row(
        &mut page,
        "emission",
        &match report.emitting_triangles {
            0 => "none".to_string(),
            count => format!("{count} triangles emit light"),
        },
    );
    materials(&mut page, report);
    textures(&mut page, report);
    let _ = writeln!(page, "\n{}", verdict(report));
    page
}

fn row(page: &mut String, name: &str, value: &str) {
    let _ = writeln!(page, "  {name:<12} {value}");
}

fn more(page: &mut String, all: usize, what: &str) {
    if all > ROWS {
        let _ = writeln!(page, "  … and {} more {what} (--json names all)", all - ROWS);
    }
}

/// One line a kind, the worst first.
fn findings(page: &mut String, report: &Report) {
    let mut kinds: Vec<_> = report.findings.counts().collect();
    kinds.sort_by_key(|(kind, _, severity)| (std::cmp::Reverse(*severity), *kind));
    for (kind, count, severity) in kinds {
        let _ = writeln!(page, "  {:<12} {}", severity.name(), summary(&report.findings, kind, count));
    }
}

fn box_rows(page: &mut String, bounds: Option<Bounds>) {
    let Some(Bounds { min, max }) = bounds else { return };
    let point = |p: [f64; 3]| format!("{} {} {}", short(p[0]), short(p[1]), short(p[2]));
    row(page, "bounds", &format!("{}  to  {}", point(min.to_array()), point(max.to_array())));
    let size = (max - min).to_array().map(short);
    row(page, "size", &size.join(" x "));
}

fn scene_rows(page: &mut String, report: &Report) {
    row(page, "triangles", &format!("{} in {} mesh files", report.triangles, report.meshes.len()));
    row(page, "vertices", &report.vertices.to_string());
    box_rows(page, report.bounds);
}

fn mesh_rows(page: &mut String, m: &MeshReport) {
    let c = &m.counts;
    let mut triangles = format!("{} of {} faces", m.triangles, c.faces);
    for (count, what) in [
        (c.skipped_faces, "faces skipped"),
        (c.zero_area, "triangles without area dropped"),
        (c.duplicates, "repeated triangles dropped"),
    ] {
        if count > 0 {
            let _ = write!(triangles, ", {count} {what}");
        }
    }
    row(page, "triangles", &triangles);
    let normals = if m.has_normals { "normals" } else { "no normals" };
    let uvs = if m.has_uvs { "texture coordinates" } else { "no texture coordinates" };
    row(page, "vertices", &format!("{}, {normals}, {uvs}", m.vertices));
    box_rows(page, m.bounds);
    row(page, "area", &short(m.area));
    if let Some(volume) = m.volume {
        row(page, "volume", &short(volume));
    }
    let watertight = if m.welded.watertight { "yes" } else { "no" };
    row(page, "watertight", &format!("{watertight}: {}", edges(&m.welded)));
    if m.by_index != m.welded {
        row(
            page,
            "  by index",
            &format!("{} ({} vertices to weld)", edges(&m.by_index), m.coincident_vertices),
        );
    }
}

fn edges(t: &Topology) -> String {
    let mut parts = Vec::new();
    if t.boundary_edges > 0 {
        let rims = if t.boundary_loops == 1 { "rim" } else { "rims" };
        parts.push(format!("{} open edges in {} {rims}", t.boundary_edges, t.boundary_loops));
    }
    if t.non_manifold_edges > 0 {
        parts.push(format!("{} edges of more than two triangles", t.non_manifold_edges));
    }
    if t.mixed_edges > 0 {
        parts.push(format!("{} edges of mixed winding", t.mixed_edges));
    }
    if parts.is_empty() { "two triangles at every edge, wound alike".to_string() } else { parts.join(", ") }
}

fn materials(page: &mut String, report: &Report) {
    let all = &report.materials;
    let in_use = report.materials_in_use();
    let unused = if in_use < all.len() { format!(", {in_use} of them in use") } else { String::new() };
    let defined: u64 = report.meshes.iter().map(|m| m.library_materials).sum();
    let known = all.iter().filter(|m| m.defined.is_some()).count() as u64;
    let others = if defined > known { format!("; the libraries define {defined}") } else { String::new() };
    let _ = writeln!(page, "\nmaterials ({}{unused}{others})", all.len());
    let shown: Vec<String> = all.iter().take(ROWS).map(|m| name(&m.name)).collect();
    let width = shown.iter().map(|n| n.chars().count()).max().unwrap_or(0).clamp(12, 40);
    for (m, name) in all.iter().zip(shown) {
        let defined = m.defined.as_ref().map(|(file, line)| format!("{}:{line}", show_path(file)));
        let unknown = if m.name.is_empty() { "the default" } else { "no library defines it" };
        let defined = defined.unwrap_or_else(|| unknown.to_string());
        let emits = if m.emits { ", emits" } else { "" };
        let _ = writeln!(
            page,
            "  {name:<width$} {:<12} {:>10} triangles, {defined}{emits}",
            m.model, m.triangles
        );
    }
    more(page, all.len(), "materials");
}

/// A material's name for people.
fn name(name: &str) -> String {
    if name.is_empty() { "(none)".to_string() } else { one_line(name) }
}

fn textures(page: &mut String, report: &Report) {
    let all = &report.textures;
    let missing = all.iter().filter(|t| t.path.is_none()).count();
    if all.is_empty() {
        return;
    }
    let _ = writeln!(page, "\ntextures ({}, {missing} missing)", all.len());
    let mut sorted: Vec<_> = all.iter().collect();
    sorted.sort_by_key(|t| t.path.is_some());
    for t in sorted.into_iter().take(ROWS) {
        let path = t.path.as_ref().map_or_else(|| "missing".to_string(), |path| show_path(path));
        let size = match (t.size, t.tiles) {
            (Some([width, height]), 0 | 1) => format!(", {width}x{height}"),
            (Some([width, height]), tiles) => format!(", {width}x{height} and {} more tiles", tiles - 1),
            (None, _) if t.path.is_some() => ", not shown".to_string(),
            (None, _) => String::new(),
        };
        let _ = writeln!(
            page,
            "  {:<12} {path}{size}  ({}:{}, {})",
            t.key,
            show_path(&t.library),
            t.line,
            name(&t.material)
        );
    }
    more(page, all.len(), "textures");
}

fn verdict(report: &Report) -> String {
    let findings = &report.findings;
    let errors = findings.at_least(Severity::Error);
    let warnings = findings.at_least(Severity::Warning) - errors;
    let notes = findings.at_least(Severity::Note) - errors - warnings;
    let count = |n: u64, word: &str| format!("{n} {word}{}", if n == 1 { "" } else { "s" });
    match (errors, warnings, notes) {
        (0, 0, 0) => "nothing wrong".to_string(),
        (0, 0, _) => format!("nothing wrong; {}", count(notes, "note")),
        _ => {
            let [errors, warnings, notes] =
                [count(errors, "error"), count(warnings, "warning"), count(notes, "note")];
            format!("{errors}, {warnings}, {notes}")
        }
    }
}
