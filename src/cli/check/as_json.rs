//! The report as JSON. Paths and names are text; bytes that are none become U+FFFD.
//!
//! `materials` lists the names after `usemtl` (of a scene: its materials), `triangles` 0 where no face has one and
//! `defined` null where no library does; `materials_in_use` counts those with triangles, a mesh's
//! `library_materials` what its libraries define, named by the mesh or not.

use drt::check::{Bounds, MaterialReport, MeshReport, Report, TextureReport, Topology};
use drt::error::{Finding, Severity};
use serde_json::{Map, Value, json};
use std::path::Path;

/// One line of JSON with sorted keys.
pub fn text(report: &Report) -> String {
    let findings = &report.findings;
    let counts: Map<String, Value> =
        findings.counts().map(|(kind, count, _)| (kind.to_string(), count.into())).collect();
    let errors = findings.at_least(Severity::Error);
    let warnings = findings.at_least(Severity::Warning) - errors;
    let value = json!({
        "input": path(&report.input),
        "triangles": report.triangles,
        "vertices": report.vertices,
        "skipped_faces": report.skipped_faces,
        "bounds": bounds(report.bounds),
        "emitting_triangles": report.emitting_triangles,
        "materials": report.materials.iter().map(material).collect::<Vec<_>>(),
        "materials_in_use": report.materials_in_use(),
        "textures": report.textures.iter().map(texture).collect::<Vec<_>>(),
        "meshes": report.meshes.iter().map(mesh).collect::<Vec<_>>(),
        "findings": findings.kept().map(finding).collect::<Vec<_>>(),
        "finding_counts": counts,
        "errors": errors,
        "warnings": warnings,
        "notes": findings.at_least(Severity::Note) - errors - warnings,
    });
    format!("{value}\n")
}

fn path(path: &Path) -> String {
    path.to_string_lossy().into_owned()
}

fn bounds(bounds: Option<Bounds>) -> Value {
    bounds.map_or(Value::Null, |b| json!({ "min": b.min.to_array(), "max": b.max.to_array() }))
}

fn material(m: &MaterialReport) -> Value {
    let defined = m.defined.as_ref().map(|(file, line)| json!({ "file": path(file), "line": line }));
    json!({ "name": m.name, "model": m.model, "triangles": m.triangles, "emits": m.emits, "defined": defined })
}

fn texture(t: &TextureReport) -> Value {
    json!({
        "file": path(&t.library), "line": t.line, "key": t.key, "material": t.material,
        "path": t.path.as_deref().map(path), "size": t.size, "tiles": t.tiles,
    })
}

/// `line` is 0 where no line applies.
fn finding(f: &Finding) -> Value {
    json!({
        "file": path(&f.file), "line": f.line, "kind": f.kind, "message": f.message, "severity": f.severity.name(),
    })
}

fn mesh(m: &MeshReport) -> Value {
    json!({
        "file": path(&m.file),
        "lines": m.counts.lines,
        "faces": m.counts.faces,
        "skipped_faces": m.counts.skipped_faces,
        "zero_area_triangles": m.counts.zero_area,
        "duplicate_triangles": m.counts.duplicates,
        "triangles": m.triangles,
        "vertices": m.vertices,
        "unreferenced_vertices": m.unreferenced_vertices,
        "coincident_vertices": m.coincident_vertices,
        "bounds": bounds(m.bounds),
        "origin": m.origin.to_array(),
        "area": m.area,
        "volume": m.volume,
        "has_normals": m.has_normals,
        "has_uvs": m.has_uvs,
        "flipped_normals": m.flipped_normals,
        "watertight": m.welded.watertight,
        "topology": topology(&m.welded),
        "topology_by_index": topology(&m.by_index),
        "library_materials": m.library_materials,
        "libraries": m.libraries.iter().map(|file| path(file)).collect::<Vec<_>>(),
    })
}

fn topology(t: &Topology) -> Value {
    json!({
        "boundary_edges": t.boundary_edges,
        "boundary_loops": t.boundary_loops,
        "non_manifold_edges": t.non_manifold_edges,
        "mixed_winding_edges": t.mixed_edges,
        "watertight": t.watertight,
        "oriented": t.oriented,
    })
}
