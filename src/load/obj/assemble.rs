//! Blocks in the order of the file become one mesh.

mod finish;

use super::block::{Block, FaceRun, Materials};
use super::corners::Corners;
use super::faces::{Before, Known, finish_block};
use super::memory::{OutOfMemory, extend, grow, push};
use super::notes::{Kind, Notes};
use super::refuse::{check_limit, fatal_error, no_memory};
use super::{Counts, Library};
use crate::error::{Error, Result};
use rayon::prelude::*;
use std::collections::HashMap;
use std::path::Path;

/// What has been read so far.
pub(super) struct Assembly<'a> {
    file: &'a Path,
    max_elements: u64,
    positions: Vec<[f32; 3]>,
    residuals: Vec<[i32; 3]>,
    normals: Vec<[f32; 3]>,
    uvs: Vec<[f32; 2]>,
    unusable: [bool; 3],
    triangles: Vec<[u32; 3]>,
    uv_corners: Corners,
    normal_corners: Corners,
    materials: Materials,
    names: Vec<Vec<u8>>,
    ids: HashMap<Vec<u8>, u32>,
    current_material: Option<u32>,
    libraries: Vec<Library>,
    deferred: Vec<FaceRun>,
    /// The triangles' lines, where they are asked for.
    lines: Option<Vec<u32>>,
    notes: Notes,
    counts: Counts,
}

/// Where a block's elements go.
struct Place {
    before: Before,
    first_line: u64,
    /// The file's material ids by the block's.
    materials: Vec<u32>,
}

impl<'a> Assembly<'a> {
    pub fn new(file: &'a Path, max_elements: u64, keep_lines: bool) -> Self {
        Assembly {
            file,
            max_elements,
            positions: Vec::new(),
            residuals: Vec::new(),
            normals: Vec::new(),
            uvs: Vec::new(),
            unusable: [false; 3],
            triangles: Vec::new(),
            uv_corners: Corners::Absent,
            normal_corners: Corners::Absent,
            materials: Materials::default(),
            names: Vec::new(),
            ids: HashMap::new(),
            current_material: None,
            libraries: Vec::new(),
            deferred: Vec::new(),
            lines: keep_lines.then(Vec::new),
            notes: Notes::default(),
            counts: Counts::default(),
        }
    }

    /// Lines of all blocks so far.
    pub fn lines(&self) -> u64 {
        self.counts.lines
    }

    /// Adds the file's next blocks; empties them.
    pub fn add(&mut self, blocks: &mut [Block]) -> Result<()> {
        let mut places = Vec::with_capacity(blocks.len());
        for block in blocks.iter_mut() {
            places.push(self.add_vertices(block)?);
        }
        let known = Known {
            positions: &self.positions,
            residuals: &self.residuals,
            normals: &self.normals,
            uvs: &self.uvs,
            unusable: self.unusable,
            complete: false,
        };
        let deferred: Result<Vec<_>, OutOfMemory> = (blocks.par_iter_mut().zip(&places))
            .map(|(block, place)| finish_block(block, place.before, &known))
            .collect();
        let deferred = deferred.map_err(|_| self.no_memory())?;
        for ((block, place), deferred) in blocks.iter_mut().zip(places).zip(deferred) {
            self.add_faces(block, &place, &deferred)?;
            block.clear();
        }
        Ok(())
    }

    fn no_memory(&self) -> Error {
        let (vertices, triangles) = (self.positions.len(), self.triangles.len());
        Error::new(format!("not enough memory: {vertices} vertices and {triangles} triangles were read"))
            .at(self.file)
            .advise("use a machine with more memory, or split the mesh")
    }

    fn add_vertices(&mut self, block: &mut Block) -> Result<Place> {
        let first_line = self.counts.lines + 1;
        if let Some((line, fatal)) = block.fatal {
            return Err(fatal_error(fatal, self.file, first_line + line));
        }
        let before = [self.positions.len(), self.uvs.len(), self.normals.len()];
        self.check_limit("vertices", before[0] + block.positions.len())?;
        self.check_limit("texture coordinates", before[1] + block.uvs.len())?;
        self.check_limit("normals", before[2] + block.normals.len())?;
        self.append_values(block).map_err(|_| self.no_memory())?;
        for (ours, theirs) in self.unusable.iter_mut().zip(block.unusable) {
            *ours |= theirs;
        }
        self.counts.lines += block.lines;
        for (line, name) in block.libraries.drain(..) {
            push(&mut self.libraries, Library { line: first_line + line, names: name })
                .map_err(|_| no_memory(self.file))?;
        }
        let materials = self.map_materials(block).map_err(|_| self.no_memory())?;
        Ok(Place { before: Before(before), first_line, materials })
    }

    fn append_values(&mut self, block: &Block) -> Result<(), OutOfMemory> {
        extend(&mut self.positions, &block.positions)?;
        extend(&mut self.residuals, &block.residuals)?;
        extend(&mut self.normals, &block.normals)?;
        extend(&mut self.uvs, &block.uvs)
    }

    fn check_limit(&self, what: &str, count: usize) -> Result<()> {
        check_limit(what, count as u64, self.max_elements).map_err(|e| e.at(self.file))
    }

    /// The file's ids for the block's, and what holds after it.
    fn map_materials(&mut self, block: &mut Block) -> Result<Vec<u32>, OutOfMemory> {
        let mut map = Vec::new();
        // Ids never go back to 0, so if any face came before the block's first `usemtl`, its first did.
        let inherits = !block.triangles.is_empty() && block.materials.uniform == 0;
        let inherited = match self.current_material {
            None if inherits => Some(self.material_id(Vec::new())?),
            held => held,
        };
        self.current_material = inherited;
        push(&mut map, inherited.unwrap_or(0))?;
        for name in block.names.drain(..) {
            let id = self.material_id(name)?;
            push(&mut map, id)?;
        }
        if block.materials.current > 0 {
            self.current_material = map.get(block.materials.current as usize).copied();
        }
        Ok(map)
    }

    fn material_id(&mut self, name: Vec<u8>) -> Result<u32, OutOfMemory> {
        if let Some(&id) = self.ids.get(&name) {
            return Ok(id);
        }
        let id = self.names.len() as u32;
        push(&mut self.names, name.clone())?;
        self.ids.try_reserve(1).map_err(|_| OutOfMemory)?;
        self.ids.insert(name, id);
        Ok(id)
    }

    fn add_faces(&mut self, block: &mut Block, place: &Place, deferred: &[FaceRun]) -> Result<()> {
        let Before([vertices, uvs, normals]) = place.before;
        self.notes.append(&mut block.notes, place.first_line, |kind| match kind {
            Kind::VertexUnreadable | Kind::VertexTooLarge => vertices as i64,
            Kind::NormalUnreadable | Kind::NormalZero => normals as i64,
            Kind::UvUnreadable => uvs as i64,
            _ => 0,
        });
        self.counts.faces += block.faces;
        self.counts.skipped_faces += block.skipped;
        self.check_limit("triangles", self.triangles.len() + block.triangles.len())?;
        self.append_faces(block, place, deferred).map_err(|_| self.no_memory())
    }

    fn append_faces(
        &mut self,
        block: &Block,
        place: &Place,
        deferred: &[FaceRun],
    ) -> Result<(), OutOfMemory> {
        let before = self.triangles.len();
        self.uv_corners.append(&block.uv_corners, &self.triangles, &block.triangles)?;
        self.normal_corners.append(&block.normal_corners, &self.triangles, &block.triangles)?;
        let id = |local: u32| place.materials.get(local as usize).copied().unwrap_or(0);
        let mut done = before;
        for same in block.materials.per_face.chunk_by(|a, b| a == b) {
            self.materials.extend(done, same.len(), same.first().map_or(0, |&local| id(local)))?;
            done += same.len();
        }
        if done == before && !block.triangles.is_empty() {
            self.materials.extend(before, block.triangles.len(), id(block.materials.uniform))?;
        }
        extend(&mut self.triangles, &block.triangles)?;
        if let Some(lines) = &mut self.lines {
            append_lines(lines, block, place.first_line)?;
        }
        grow(&mut self.deferred, deferred.len())?;
        for run in deferred {
            let (first_triangle, first_line) =
                (before + run.first_triangle, place.first_line + run.first_line);
            self.deferred.push(FaceRun { first_triangle, first_line, ..*run });
        }
        Ok(())
    }
}

/// Adds the lines of a block's triangles.
fn append_lines(lines: &mut Vec<u32>, block: &Block, first_line: u64) -> Result<(), OutOfMemory> {
    grow(lines, block.triangles.len())?;
    for run in &block.runs {
        for (_, line) in run.iter() {
            let line = u32::try_from(first_line + line).unwrap_or(0);
            lines.extend(std::iter::repeat_n(line, run.corners - 2));
        }
    }
    Ok(())
}
