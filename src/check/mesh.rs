//! One mesh: its figures and what is wrong with it.

use super::findings::{Place, Writer};
use super::geometry::{Sizes, measure};
use super::topology::{Topology, ends, first_triangles, survey};
use super::weld::Weld;
use crate::error::{Findings, Result, Severity};
use crate::load::obj::Counts;
use crate::math::DVec3;
use crate::shape::Mesh;
use std::path::{Path, PathBuf};

/// A box in the coordinates of a file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Smallest corner.
    pub min: DVec3,
    /// Largest corner.
    pub max: DVec3,
}

/// The figures of a mesh file.
#[derive(Clone, Debug)]
pub struct MeshReport {
    /// The file.
    pub file: PathBuf,
    /// What the file held.
    pub counts: Counts,
    /// Triangles that would be rendered.
    pub triangles: u64,
    /// Vertices in memory, used or not.
    pub vertices: u64,
    /// Vertices that no triangle uses.
    pub unreferenced_vertices: u64,
    /// Used vertices that repeat an earlier one's position.
    pub coincident_vertices: u64,
    /// The box around the triangles in the file's coordinates.
    pub bounds: Option<Bounds>,
    /// File coordinates of the point that the mesh was moved to for f32; zero where it was not.
    pub origin: DVec3,
    /// Surface area in square metres.
    pub area: f64,
    /// Volume inside in cubic metres, where it is defined ([`Topology::oriented`], after welding); negative when
    /// the surface is inside out.
    pub volume: Option<f64>,
    /// Whether the file has shading normals.
    pub has_normals: bool,
    /// Whether the file has texture coordinates.
    pub has_uvs: bool,
    /// Triangles whose shading normals all point to the back.
    pub flipped_normals: u64,
    /// How the triangles hang together by index.
    pub by_index: Topology,
    /// How they hang together after welding vertices at exactly the same place.
    pub welded: Topology,
    /// The material libraries that were read.
    pub libraries: Vec<PathBuf>,
    /// How many names they define, whether a `usemtl` names them or not.
    pub library_materials: u64,
}

/// Beyond this a coordinate in metres is more likely a mistake in units or a map's: 1000 km.
const HUGE: f64 = 1e6;

/// Checks a mesh as the reader gives it: relative to `origin`, with the line of each triangle (`lines`, empty
/// where unknown). Library names are left to the caller.
///
/// # Errors
/// Not enough memory.
pub fn check_mesh(
    file: &Path,
    mesh: &Mesh,
    origin: DVec3,
    lines: &[u32],
    counts: Counts,
) -> Result<(MeshReport, Findings)> {
    let kept = Findings::KEPT;
    let sizes = measure(mesh, kept);
    let weld = Weld::new(&mesh.positions, &mesh.indices)?;
    let vertices = mesh.positions.len();
    let by_index = survey(&mesh.indices, vertices, &|vertex| vertex, kept)?;
    let welded = match weld.coincident {
        0 => by_index.clone(),
        _ => survey(&mesh.indices, vertices, &|vertex| weld.first(vertex), kept)?,
    };
    let is_empty = mesh.indices.is_empty();
    let report = MeshReport {
        file: file.to_path_buf(),
        counts,
        triangles: mesh.indices.len() as u64,
        vertices: vertices as u64,
        unreferenced_vertices: weld.unreferenced,
        coincident_vertices: weld.coincident,
        bounds: (!is_empty).then_some(Bounds { min: sizes.min + origin, max: sizes.max + origin }),
        origin,
        area: sizes.area,
        volume: (welded.oriented && !is_empty).then_some(sizes.six_volumes / 6.0),
        has_normals: mesh.normals.is_some(),
        has_uvs: mesh.uvs.is_some(),
        flipped_normals: sizes.flipped,
        by_index,
        welded,
        libraries: Vec::new(),
        library_materials: 0,
    };
    let mut writer = Writer { file, lines, findings: Findings::default() };
    if is_empty {
        writer.add("no-renderable-faces", Severity::Error, Place::File, empty_message(&counts));
    }
    note_edges(&mut writer, mesh, origin, &report.welded, &weld);
    note_sizes(&mut writer, &report, &sizes);
    note_vertices(&mut writer, &report);
    Ok((report, writer.findings))
}

fn empty_message(counts: &Counts) -> String {
    let Counts { faces, skipped_faces, .. } = counts;
    let why = match (faces, skipped_faces) {
        (0, _) => "it has no faces".to_string(),
        (_, 0) => format!("none of the {faces} faces has an area"),
        (faces, skipped) if faces == skipped => format!("all {faces} faces were skipped"),
        (faces, skipped) => format!("{skipped} of {faces} faces were skipped, the others have no area"),
    };
    format!("there is nothing to render: {why}")
}

/// Findings about edges, each at the first face that has it.
fn note_edges(writer: &mut Writer<'_>, mesh: &Mesh, origin: DVec3, topology: &Topology, weld: &Weld) {
    let rims: Vec<u64> = topology.rims.iter().map(|rim| rim.edge).collect();
    let edges: Vec<u64> =
        [&topology.non_manifold, &topology.mixed, &rims].into_iter().flatten().copied().collect();
    let faces = first_triangles(&edges, &mesh.indices, &|vertex| weld.first(vertex));
    let described: Vec<(u32, String)> = faces
        .into_iter()
        .zip(&edges)
        .map(|(face, edge)| {
            let [from, to] = ends(*edge).map(|vertex| point(mesh, origin, vertex));
            (face, format!("the edge from {from} to {to}"))
        })
        .collect();
    let (non_manifold, rest) = described.split_at(topology.non_manifold.len().min(described.len()));
    let (mixed, open) = rest.split_at(topology.mixed.len().min(rest.len()));
    for (face, edge) in non_manifold {
        let message = format!("more than two triangles share {edge}");
        writer.add("edge-non-manifold", Severity::Warning, Place::Triangle(*face), message);
    }
    for (face, edge) in mixed {
        let message = format!("the two triangles along {edge} face opposite ways: one is turned over");
        writer.add("winding-mixed", Severity::Warning, Place::Triangle(*face), message);
    }
    for ((face, edge), rim) in open.iter().zip(&topology.rims) {
        let message = format!("the surface is open: a rim of {} edges, among them {edge}", rim.edges);
        writer.add("surface-open", Severity::Note, Place::Triangle(*face), message);
    }
    writer.more("edge-non-manifold", Severity::Warning, topology.non_manifold_edges, non_manifold.len());
    writer.more("winding-mixed", Severity::Warning, topology.mixed_edges, mixed.len());
    writer.more("surface-open", Severity::Note, topology.boundary_loops, open.len());
}

fn point(mesh: &Mesh, origin: DVec3, vertex: u32) -> String {
    let p = mesh.positions.get(vertex as usize).copied().unwrap_or_default();
    let p = DVec3::from_array(p.map(f64::from)) + origin;
    format!("({} {} {})", short(p.x), short(p.y), short(p.z))
}

/// `x` for people: seven digits, as f32 has, without zeros at the end.
pub fn short(x: f64) -> String {
    let magnitude = x.abs();
    if x != 0.0 && !(1e-4..1e7).contains(&magnitude) {
        return format!("{x:.5e}");
    }
    let whole_digits = if magnitude < 1.0 { 1 } else { magnitude.log10() as usize + 1 };
    let text = format!("{x:.*}", 7usize.saturating_sub(whole_digits));
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    if text == "-0" { "0".to_string() } else { text.to_string() }
}

fn note_sizes(writer: &mut Writer<'_>, report: &MeshReport, sizes: &Sizes) {
    for &triangle in &sizes.first_flipped {
        let message = "the shading normals point to the back of the face, which winding decides".to_string();
        writer.add("normals-flipped", Severity::Warning, Place::Triangle(triangle), message);
    }
    writer.more("normals-flipped", Severity::Warning, sizes.flipped, sizes.first_flipped.len());
    if report.volume.is_some_and(|volume| volume < 0.0) {
        let message = "the closed surface is inside out: its faces are wound clockwise seen from outside";
        writer.add("inside-out", Severity::Warning, Place::File, message.to_string());
    }
    let Some(bounds) = report.bounds else { return };
    let size = (bounds.max - bounds.min).max_element();
    if report.origin != DVec3::ZERO {
        let distance = ((bounds.min + bounds.max) * 0.5).length() / size;
        let message = format!(
            "the mesh lies {} times its size from the origin; it is moved there to be rendered",
            short(distance.round())
        );
        writer.add("far-from-origin", Severity::Note, Place::File, message);
    }
    let largest = bounds.min.abs().max(bounds.max.abs()).max_element();
    if largest > HUGE {
        let message = format!("coordinates up to {} metres: are the units meant?", short(largest));
        writer.add("coordinates-huge", Severity::Note, Place::File, message);
    }
}

fn note_vertices(writer: &mut Writer<'_>, report: &MeshReport) {
    let unreferenced = report.unreferenced_vertices;
    if unreferenced > 0 {
        let message = format!("{unreferenced} vertices belong to no face that is rendered");
        writer.add("vertices-unreferenced", Severity::Note, Place::File, message);
    }
    let coincident = report.coincident_vertices;
    if coincident > 0 {
        let message = format!(
            "{coincident} vertices repeat the position of another: faces that meet there do not share them"
        );
        writer.add("vertices-coincident", Severity::Note, Place::File, message);
    }
}
