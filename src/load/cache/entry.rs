//! A mesh file's entry: what its reader made of it.

use super::wire::{Problem, Sink, Source, room};
use super::{Key, READER, hex};
use crate::accel::LARGEST;
use crate::error::{Finding, Findings, Result};
use crate::load::obj::{self, Counts, Library, ObjFile};
use crate::math::DVec3;
use crate::output::file::write_private;
use crate::shape::{Attribute, FaceMaterials, Mesh, NO_INDEX, Positions};
use rayon::prelude::*;
use std::fs::File;
use std::io;
use std::path::Path;

const MAGIC: [u8; 8] = *b"drtmesh\n";

/// The name of the entry of a content that was read within `limits`.
pub(super) fn file_name(content: &Key, limits: &[u64]) -> String {
    let mut hasher = blake3::Hasher::new();
    for limit in limits {
        hasher.update(&limit.to_le_bytes());
    }
    hasher.update(content).update(&READER.to_le_bytes()).update(env!("CARGO_PKG_VERSION").as_bytes());
    format!("{}.mesh", hex(hasher.finalize().as_bytes()))
}

/// Writes the entry of a file with that content.
pub(super) fn write(path: &Path, content: &Key, read: &ObjFile) -> Result<()> {
    write_private(path, |file| put(file, content, read))
}

fn put(file: &mut File, content: &Key, read: &ObjFile) -> io::Result<()> {
    let mut sink = Sink::new(file, MAGIC)?;
    sink.bytes(content)?;
    for number in counts(&read.counts) {
        sink.number(number)?;
    }
    for x in read.origin.to_array() {
        sink.number(x.to_bits())?;
    }
    sink.number(read.material_names.len() as u64)?;
    read.material_names.iter().try_for_each(|name| sink.text(name))?;
    sink.number(read.libraries.len() as u64)?;
    for library in &read.libraries {
        sink.number(library.line)?;
        sink.text(&library.names)?;
    }
    put_findings(&mut sink, &read.findings)?;
    let mesh = &read.mesh;
    sink.list(&mesh.positions, f32::to_le_bytes)?;
    sink.list(&mesh.indices, u32::to_le_bytes)?;
    put_attribute(&mut sink, mesh.normals.as_ref())?;
    put_attribute(&mut sink, mesh.uvs.as_ref())?;
    match &mesh.materials {
        FaceMaterials::Uniform(id) => sink.number(u64::from(*id))?,
        FaceMaterials::PerFace(ids) => {
            sink.number(u64::MAX)?;
            sink.list(ids.as_chunks::<1>().0, u32::to_le_bytes)?;
        }
    }
    sink.finish()
}

/// Number of values + 1 (0: no attribute), values, whether they have indices of their own, those.
fn put_attribute<const N: usize>(
    sink: &mut Sink<'_>,
    attribute: Option<&Attribute<[f32; N]>>,
) -> io::Result<()> {
    sink.number(u64::from(attribute.is_some()))?;
    let Some(attribute) = attribute else { return Ok(()) };
    sink.list(&attribute.values, f32::to_le_bytes)?;
    sink.number(u64::from(attribute.indices.is_some()))?;
    match &attribute.indices {
        Some(own) => sink.list(own, u32::to_le_bytes),
        None => Ok(()),
    }
}

fn put_findings(sink: &mut Sink<'_>, findings: &Findings) -> io::Result<()> {
    sink.number(findings.counts().count() as u64)?;
    for (kind, count, _) in findings.counts() {
        let kept: Vec<&Finding> = findings.kept().filter(|finding| finding.kind == kind).collect();
        sink.text(kind.as_bytes())?;
        sink.number(count)?;
        sink.number(kept.len() as u64)?;
        for finding in kept {
            sink.number(finding.line)?;
            sink.text(finding.message.as_bytes())?;
        }
    }
    Ok(())
}

fn counts(c: &Counts) -> [u64; 9] {
    [c.lines, c.vertices, c.uvs, c.normals, c.faces, c.skipped_faces, c.triangles, c.zero_area, c.duplicates]
}

/// The entry of a file with that content, which is now called `name`; `None` where there is none.
pub(super) fn read(path: &Path, content: &Key, name: &Path) -> Result<Option<ObjFile>, Problem> {
    let Some(mut source) = Source::open(path, MAGIC)? else { return Ok(None) };
    if source.key()? != *content {
        return Err("is another file's".to_string());
    }
    let mut numbers = [0; 9];
    for number in &mut numbers {
        *number = source.number()?;
    }
    let [lines, vertices, uvs, normals, faces, skipped_faces, triangles, zero_area, duplicates] = numbers;
    let counts =
        Counts { lines, vertices, uvs, normals, faces, skipped_faces, triangles, zero_area, duplicates };
    let mut origin = DVec3::ZERO;
    for axis in 0..3 {
        origin[axis] = f64::from_bits(source.number()?);
    }
    let names = source.count(8)?;
    let mut material_names = room(names)?;
    for _ in 0..names {
        material_names.push(source.text()?);
    }
    let count = source.count(16)?;
    let mut libraries = room(count)?;
    for _ in 0..count {
        libraries.push(Library { line: source.number()?, names: source.text()? });
    }
    let findings = take_findings(&mut source, name)?;
    let mesh = take_mesh(&mut source)?;
    source.finish()?;
    check(&mesh, names, origin)?;
    Ok(Some(ObjFile { mesh, origin, material_names, libraries, findings, counts, face_lines: None }))
}

fn take_findings(source: &mut Source, name: &Path) -> Result<Findings, Problem> {
    let mut findings = Findings::default();
    for _ in 0..source.count(24)? {
        let kind = source.text()?;
        let (kind, severity) = obj::kind_of_finding(&kind).ok_or("has findings of another version")?;
        let count = source.number()?;
        let kept = source.count(16)?;
        for _ in 0..kept {
            let line = source.number()?;
            let message = String::from_utf8(source.text()?).map_err(|_| "is damaged: text that is none")?;
            findings.push(Finding { file: name.to_path_buf(), line, kind, message, severity });
        }
        findings.count_more(kind, severity, count.saturating_sub(kept as u64));
    }
    Ok(findings)
}

fn take_mesh(source: &mut Source) -> Result<Mesh, Problem> {
    let positions = Positions::new(source.list(Positions::PADDING, f32::from_le_bytes)?);
    let indices = source.list(0, u32::from_le_bytes)?;
    let normals = take_attribute(source)?;
    let uvs = take_attribute(source)?;
    let materials = match source.number()? {
        u64::MAX => {
            let ids: Vec<[u32; 1]> = source.list(0, u32::from_le_bytes)?;
            FaceMaterials::PerFace(ids.into_flattened())
        }
        id => FaceMaterials::Uniform(u32::try_from(id).map_err(|_| "is damaged: a material's number")?),
    };
    Ok(Mesh { positions, indices, normals, uvs, materials })
}

fn take_attribute<const N: usize>(source: &mut Source) -> Result<Option<Attribute<[f32; N]>>, Problem> {
    if source.number()? == 0 {
        return Ok(None);
    }
    let values = source.list(0, f32::from_le_bytes)?;
    let indices = if source.number()? == 0 { None } else { Some(source.list(0, u32::from_le_bytes)?) };
    Ok(Some(Attribute { values, indices }))
}

/// Whether the mesh keeps what [`Mesh`] promises: whoever wrote the entry may have been anybody.
fn check(mesh: &Mesh, names: usize, origin: DVec3) -> Result<(), Problem> {
    let below = |list: &[[u32; 3]], count: usize, none: bool| {
        let sound = |index: &u32| (*index as usize) < count || none && *index == NO_INDEX;
        list.par_iter().with_min_len(1 << 14).all(|triangle| triangle.iter().all(sound))
    };
    let triangles = mesh.indices.len();
    let attribute = |values: usize, own: Option<&Vec<[u32; 3]>>| match own {
        Some(own) => own.len() == triangles && below(own, values, true),
        None => true,
    };
    let finite = |p: &[f32; 3]| p.iter().all(|x| x.abs() <= LARGEST);
    let materials = match &mesh.materials {
        FaceMaterials::Uniform(id) => triangles == 0 || (*id as usize) < names,
        FaceMaterials::PerFace(ids) => ids.len() == triangles && ids.iter().all(|id| (*id as usize) < names),
    };
    let sound = origin.is_finite()
        && materials
        && below(&mesh.indices, mesh.positions.len(), false)
        && mesh.positions.par_iter().with_min_len(1 << 14).all(finite)
        && mesh.normals.as_ref().is_none_or(|n| attribute(n.values.len(), n.indices.as_ref()))
        && mesh.uvs.as_ref().is_none_or(|t| attribute(t.values.len(), t.indices.as_ref()));
    if sound { Ok(()) } else { Err("is no sound mesh".to_string()) }
}
