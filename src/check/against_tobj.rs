//! The OBJ reader judged by `tobj`, an independent one, on the file at hand.

use super::mesh::short;
use crate::error::{Error, Finding, Findings, Result, Severity};
use crate::load::obj::ReadOptions;
use crate::load::object::Object;
use crate::load::open::{Finder, Reach};
use crate::load::{Opening, Reading, cancelled, is_mesh, read};
use crate::math::DVec3;
use std::collections::BTreeSet;
use std::io::BufReader;
use std::path::Path;

/// A triangle that only one reader has moves the other list on by at most this much, so that lists which do
/// not fit at all take no square of their length.
const SEARCH: usize = 256;

type Triangle = [DVec3; 3];

/// Reads the mesh `input` with both readers and says where they differ, or that they agree.
///
/// Triangles are compared by the positions of their corners, in the order of the file, without those that have no
/// area. A polygon that is no triangle may be split differently by the two, which is reported
/// too. `reach`: the files that may be read.
///
/// # Errors
/// `input` is no mesh or our reader cannot read it. What tobj cannot read is a finding.
pub fn compare(input: &Path, reach: &Reach, progress: &(dyn Fn(f64) -> bool + Sync)) -> Result<Findings> {
    let is_obj = input.extension().is_some_and(|e| e.eq_ignore_ascii_case("obj"));
    if !is_mesh(input, &Opening::default())? || !is_obj {
        return Err(Error::usage("--against: only an OBJ file can be compared").advise("name an .obj"));
    }
    let options = ReadOptions { progress, keep_empty: true, face_lines: true, ..ReadOptions::default() };
    let object = read(input, &Reading { options, reach, ..Reading::new(progress) })?;
    let mut findings = Findings::default();
    let mut note = |kind, severity, line, message| {
        findings.push(Finding { file: input.to_path_buf(), line, kind, message, severity });
    };
    let theirs = match Theirs::read(input, reach)? {
        Ok(theirs) => theirs,
        Err(why) => {
            note("tobj-cannot-read", Severity::Note, 0, format!("tobj refuses the file: {why}"));
            return Ok(findings);
        }
    };
    if !progress(1.0) {
        return Err(cancelled());
    }
    let ours = our_triangles(&object);
    let mut figures = vec![
        ("triangles", object.counts.triangles, theirs.stated),
        ("materials in use", our_materials(&object), theirs.materials),
    ];
    if object.origin == DVec3::ZERO {
        // Far from the origin, f32 puts some of tobj's vertices at one place.
        figures.push(("places of vertices", places(&ours), places(&theirs.triangles)));
    }
    let mut agrees = true;
    for (what, ours, theirs) in figures.into_iter().filter(|(_, ours, theirs)| ours != theirs) {
        agrees = false;
        note("tobj-counts-differ", Severity::Warning, 0, format!("{ours} {what} here, {theirs} in tobj"));
    }
    for triangle in differing(&ours, &theirs.triangles, object.origin != DVec3::ZERO) {
        agrees = false;
        let line = object.face_lines.as_ref().and_then(|lines| lines.get(triangle)).copied().unwrap_or(0);
        let corners = ours.get(triangle).copied().unwrap_or_default();
        let corners = corners.map(|p| format!("({} {} {})", short(p.x), short(p.y), short(p.z))).join(" ");
        let message = format!("tobj has no such triangle here: {corners}");
        note("tobj-triangle-differs", Severity::Warning, u64::from(line), message);
    }
    if agrees {
        note("tobj-agrees", Severity::Note, 0, format!("tobj reads the same {} triangles", ours.len()));
    }
    Ok(findings)
}

fn our_triangles(object: &Object) -> Vec<Triangle> {
    let mesh = &object.mesh;
    let file = |p: crate::math::Vec3| p.as_dvec3() + object.origin;
    (0..mesh.indices.len()).map(|t| mesh.triangle(t).map(file)).collect()
}

/// Materials with a definition that faces have.
fn our_materials(object: &Object) -> u64 {
    let uses = super::materials::uses([(&object.mesh, 1)], object.materials.len());
    uses.iter().zip(&object.definitions).filter(|(uses, known)| **uses > 0 && known.is_some()).count() as u64
}

fn places(triangles: &[Triangle]) -> u64 {
    let bits = |p: &DVec3| (*p + DVec3::ZERO).to_array().map(f64::to_bits);
    let mut places: Vec<_> = triangles.iter().flatten().map(bits).collect();
    places.sort_unstable();
    places.dedup();
    places.len() as u64
}

/// Indices of our triangles that the other list does not have in their place. What only the other one has (the
/// copies that we drop) is passed over. `rounded`: the other list's positions lost digits to f32.
fn differing(ours: &[Triangle], theirs: &[Triangle], rounded: bool) -> Vec<usize> {
    let near = |a: &DVec3, b: &DVec3| {
        let slack = if rounded { b.abs() * f64::from(f32::EPSILON) } else { DVec3::ZERO };
        (*a - *b).abs().cmple(slack).all()
    };
    let same = |a: &Triangle, b: &Triangle| a.iter().zip(b).all(|(a, b)| near(a, b));
    let mut next = 0;
    let mut found = Vec::new();
    for (i, triangle) in ours.iter().enumerate() {
        let ahead = theirs.get(next..).unwrap_or_default();
        match ahead.iter().take(SEARCH).position(|other| same(triangle, other)) {
            Some(skipped) => next += skipped + 1,
            None => found.push(i),
        }
    }
    found
}

/// What tobj reads.
struct Theirs {
    /// Triangles in the order of the file, without those that have no area.
    triangles: Vec<Triangle>,
    /// With those.
    stated: u64,
    materials: u64,
}

impl Theirs {
    /// The inner error is tobj's own, which quotes nothing.
    fn read(input: &Path, reach: &Reach) -> Result<std::result::Result<Theirs, tobj::LoadError>> {
        let options = tobj::LoadOptions {
            triangulate: true,
            ignore_points: true,
            ignore_lines: true,
            ..tobj::LoadOptions::default()
        };
        let folder = input.parent().unwrap_or(Path::new(""));
        let library = |name: &Path| {
            let found = Finder::new(reach).find(folder, name.as_os_str().as_encoded_bytes());
            match found.map(|found| reach.open(&found.path)) {
                Some(Ok((file, _))) => tobj::load_mtl_buf(&mut BufReader::new(file)),
                _ => Err(tobj::LoadError::OpenFileFailed),
            }
        };
        let (file, _) = reach.open(input)?;
        let models = match tobj::load_obj_buf(&mut BufReader::new(file), &options, library) {
            Ok((models, _)) => models,
            Err(why) => return Ok(Err(why)),
        };
        let used: BTreeSet<usize> = models.iter().filter_map(|model| model.mesh.material_id).collect();
        let mut triangles: Vec<Triangle> = Vec::new();
        for mesh in models.iter().map(|model| &model.mesh) {
            let point = |i: &u32| {
                let at = 3 * *i as usize;
                let p = mesh.positions.get(at..at + 3).unwrap_or_default();
                let mut point = [0.0; 3];
                point.iter_mut().zip(p).for_each(|(x, p)| *x = f64::from(*p));
                DVec3::from_array(point)
            };
            let corners = |t: &[u32]| {
                let mut triangle = Triangle::default();
                triangle.iter_mut().zip(t).for_each(|(corner, i)| *corner = point(i));
                triangle
            };
            triangles.extend(mesh.indices.chunks_exact(3).map(corners));
        }
        let stated = triangles.len() as u64;
        triangles.retain(|[a, b, c]| (*b - *a).cross(*c - *a) != DVec3::ZERO);
        Ok(Ok(Theirs { triangles, stated, materials: used.len() as u64 }))
    }
}
