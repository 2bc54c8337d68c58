//! The end of the file: what had to wait is judged, what does harm dropped, and the mesh handed over.

use super::Assembly;
use crate::error::Result;
use crate::load::obj::ObjFile;
use crate::load::obj::block::Materials;
use crate::load::obj::cleanup::{duplicates, remove, survey};
use crate::load::obj::corners::Corners;
use crate::load::obj::faces::{Known, finish_deferred};
use crate::load::obj::memory::{OutOfMemory, grow};
use crate::load::obj::notes::Kind;
use crate::load::obj::recenter::{choose_origin, recenter};
use crate::load::obj::refuse::{no_faces, no_memory};
use crate::math::DVec3;
use crate::shape::{Attribute, FaceMaterials, Mesh, Positions};

impl Assembly<'_> {
    /// The mesh of everything that was added.
    pub fn finish(mut self, keep_empty: bool) -> Result<ObjFile> {
        self.counts.vertices = self.positions.len() as u64;
        self.counts.normals = self.normals.len() as u64;
        self.counts.uvs = self.uvs.len() as u64;
        let file = self.file;
        let origin = self.clean_up().map_err(|_| no_memory(file))?;
        let findings = self.notes.into_findings(file);
        if self.triangles.is_empty() && !keep_empty {
            return Err(no_faces(file, &self.counts, &findings));
        }
        let attribute = |corners| match corners {
            Corners::Own(list) => Some(list),
            Corners::Absent | Corners::Same => None,
        };
        let normals = (self.normal_corners != Corners::Absent)
            .then(|| Attribute { values: self.normals, indices: attribute(self.normal_corners) });
        let uvs = (self.uv_corners != Corners::Absent)
            .then(|| Attribute { values: self.uvs, indices: attribute(self.uv_corners) });
        let materials = face_materials(&mut self.materials);
        let positions = Positions::new(self.positions);
        Ok(ObjFile {
            mesh: Mesh { positions, indices: self.triangles, normals, uvs, materials },
            origin,
            material_names: self.names,
            libraries: self.libraries,
            findings,
            counts: self.counts,
            face_lines: self.lines,
        })
    }

    /// Judges what had to wait, chooses the origin, drops what does harm.
    fn clean_up(&mut self) -> Result<DVec3, OutOfMemory> {
        self.finish_deferred()?;
        self.counts.triangles = self.triangles.len() as u64;
        for position in self.positions.iter_mut().filter(|_| self.unusable[0]) {
            if position[0].is_nan() {
                *position = [0.0; 3];
            }
        }
        for uv in self.uvs.iter_mut().filter(|_| self.unusable[2]) {
            if uv[0].is_nan() {
                *uv = [0.0; 2];
            }
        }
        let mut found = survey(&self.triangles, &self.positions)?;
        let origin = choose_origin(found.bounds, &self.triangles, &self.positions, &self.residuals);
        if origin != DVec3::ZERO {
            recenter(&mut self.positions, &self.residuals, origin);
            found = survey(&self.triangles, &self.positions)?;
        }
        self.residuals = Vec::new();
        grow(&mut self.positions, Positions::PADDING)?;

        self.counts.zero_area = found.without_area.len() as u64;
        self.note_removed(Kind::FaceZeroArea, &found.without_area);
        remove(&mut found.hashes, &found.without_area);
        self.remove_triangles(&found.without_area);
        let materials = face_materials(&mut self.materials);
        let copies = duplicates(&found.hashes, &self.triangles, &self.positions, &materials)?;
        if let FaceMaterials::PerFace(ids) = materials {
            self.materials.per_face = ids;
        }
        self.counts.duplicates = copies.len() as u64;
        self.note_removed(Kind::FaceDuplicate, &copies);
        self.remove_triangles(&copies);
        self.uv_corners.compress(&self.triangles);
        self.normal_corners.compress(&self.triangles);
        self.shrink();
        Ok(origin)
    }

    fn finish_deferred(&mut self) -> Result<(), OutOfMemory> {
        let known = Known {
            positions: &self.positions,
            residuals: &self.residuals,
            normals: &self.normals,
            uvs: &self.uvs,
            unusable: self.unusable,
            complete: true,
        };
        let (uvs, normals) = (&mut self.uv_corners, &mut self.normal_corners);
        let (removed, skipped) =
            finish_deferred(&mut self.triangles, uvs, normals, &self.deferred, &known, &mut self.notes)?;
        self.counts.skipped_faces += skipped;
        self.deferred = Vec::new();
        self.remove_triangles(&removed);
        Ok(())
    }

    /// Counts what is dropped, with its lines where they are known.
    fn note_removed(&mut self, kind: Kind, removed: &[u32]) {
        match &self.lines {
            None => self.notes.add_without_line(kind, removed.len() as u64),
            Some(lines) => {
                for &triangle in removed {
                    let line = lines.get(triangle as usize).copied().unwrap_or(0);
                    self.notes.add(kind, u64::from(line), 0);
                }
            }
        }
    }

    fn remove_triangles(&mut self, removed: &[u32]) {
        remove(&mut self.triangles, removed);
        if let Some(lines) = &mut self.lines {
            remove(lines, removed);
        }
        remove(&mut self.materials.per_face, removed);
        for corners in [&mut self.uv_corners, &mut self.normal_corners] {
            if let Corners::Own(list) = corners {
                remove(list, removed);
            }
        }
    }

    /// Gives the room for growth back.
    fn shrink(&mut self) {
        self.positions.shrink_to(self.positions.len() + Positions::PADDING);
        self.normals.shrink_to_fit();
        self.uvs.shrink_to_fit();
        self.triangles.shrink_to_fit();
        if let Some(lines) = &mut self.lines {
            lines.shrink_to_fit();
        }
        self.materials.per_face.shrink_to_fit();
        for corners in [&mut self.uv_corners, &mut self.normal_corners] {
            if let Corners::Own(list) = corners {
                list.shrink_to_fit();
            }
        }
    }
}

/// Takes the materials; one for all where they are the same.
fn face_materials(materials: &mut Materials) -> FaceMaterials {
    let ids = std::mem::take(&mut materials.per_face);
    match ids.first() {
        None => FaceMaterials::Uniform(materials.uniform),
        Some(&first) if ids.iter().all(|&id| id == first) => {
            materials.uniform = first;
            FaceMaterials::Uniform(first)
        }
        Some(_) => FaceMaterials::PerFace(ids),
    }
}
