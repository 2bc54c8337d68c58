//! The files of a reproducer.
//!
//! `case-1.obj` holds the triangles (`o` begins a mesh; coordinates are the very f32 that were traced), `case-1.toml` the
//! ray. They are read here and not by [`crate::load`], which would move, weld and drop: every bit counts.

use super::{Reproducer, once_and_in_a_packet};
use crate::diff::rays::Chunk;
use crate::error::{Error, Result};
use crate::load::open::Reach;
use crate::math::Vec3;
use crate::output;
use crate::shape::Mesh;
use std::fmt::Write;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Larger files are taken for something else.
const LARGEST_FILE: u64 = 64 << 20;

impl Reproducer {
    /// Writes `case-N.obj` and `case-N.toml` into `folder`; `said` tells what was found, a line each. Returns the
    /// second's path.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn write(&self, folder: &Path, number: usize, said: &str) -> Result<PathBuf> {
        let obj = format!("case-{number}.obj");
        output::write_bytes(&folder.join(&obj), self.obj().as_bytes())?;
        let mut text = String::new();
        for line in said.lines() {
            let _ = writeln!(text, "# {line}");
        }
        if !self.fails {
            text += "# These triangles alone do not fail: the cause lies in the rest of the mesh.\n";
        }
        let _ = writeln!(text, "\n[case]\nmesh = \"{obj}\"");
        if let Some(Chunk { rays, .. }) = self.rays.chunks.first() {
            let number = |x: f32| format!("{:?}", f64::from(x));
            let vector = |v: Vec3| format!("[{}]", v.to_array().map(number).join(", "));
            let _ = writeln!(text, "origin = {}\ndirection = {}", vector(rays.o(0)), vector(rays.d(0)));
            let _ = writeln!(text, "tmin = {}\ntmax = {}", number(rays.tmin[0]), number(rays.tmax[0]));
        }
        let path = folder.join(format!("case-{number}.toml"));
        output::write_bytes(&path, text.as_bytes())?;
        Ok(path)
    }

    fn obj(&self) -> String {
        let (mut text, mut first) = (String::new(), 1);
        for (i, mesh) in self.meshes.iter().enumerate() {
            let _ = writeln!(text, "o mesh-{i}");
            for [x, y, z] in mesh.positions.iter() {
                let _ = writeln!(text, "v {x} {y} {z}");
            }
            for face in &mesh.indices {
                let [a, b, c] = face.map(|i| i as usize + first);
                let _ = writeln!(text, "f {a} {b} {c}");
            }
            first += mesh.positions.len();
        }
        text
    }

    /// Reads what [`Reproducer::write`] wrote; `None` when `path` is no such file but, perhaps, a scene.
    ///
    /// # Errors
    /// A file that cannot be read, or that is a case with something missing or wrong; its mesh is not within
    /// `reach`.
    pub fn read(path: &Path, reach: &Reach) -> Result<Option<Reproducer>> {
        if path.extension().is_none_or(|e| e != "toml") {
            return Ok(None);
        }
        let Ok(table) = text(path, reach)?.parse::<toml::Table>() else { return Ok(None) };
        let Some(case) = table.get("case").and_then(|case| case.as_table()) else { return Ok(None) };
        let wrong = |key: &str, form: &str| Error::new(format!("case.{key} must be {form}")).at(path);
        let number = |value: &toml::Value| value.as_float().or(value.as_integer().map(|i| i as f64));
        let scalar = |key: &str| {
            let found = case.get(key).and_then(number);
            found.map(|x| x as f32).ok_or_else(|| wrong(key, "a number"))
        };
        let vector = |key: &str| {
            let all = case.get(key).and_then(|v| v.as_array()).map(|v| v.iter().filter_map(number).collect());
            let all: Vec<f64> = all.unwrap_or_default();
            let [x, y, z] = all[..] else { return Err(wrong(key, "three numbers")) };
            Ok(Vec3::new(x as f32, y as f32, z as f32))
        };
        let mesh = case.get("mesh").and_then(|v| v.as_str()).ok_or_else(|| wrong("mesh", "a file's name"))?;
        let meshes = meshes(&path.parent().unwrap_or(Path::new("")).join(mesh), reach)?;
        let rays =
            once_and_in_a_packet(vector("origin")?, vector("direction")?, scalar("tmin")?, scalar("tmax")?);
        if rays.is_empty() {
            return Err(wrong("origin", "finite like the other numbers, and tmin not negative"));
        }
        Ok(Some(Reproducer { meshes, rays, fails: true }))
    }
}

fn text(path: &Path, reach: &Reach) -> Result<String> {
    let (file, _) = reach.open(path)?;
    let mut text = String::new();
    file.take(LARGEST_FILE + 1).read_to_string(&mut text).map_err(|e| Error::io("read", path, &e))?;
    if text.len() as u64 > LARGEST_FILE {
        return Err(Error::new("too large for a reproducer (limit 64 MiB)").at(path));
    }
    Ok(text)
}

/// The meshes of a reproducer's OBJ file: `o`, `v` with three numbers and `f` with three indices, and nothing else.
fn meshes(path: &Path, reach: &Reach) -> Result<Vec<Arc<Mesh>>> {
    // A mesh with the number of its first vertex.
    type Part = (usize, Vec<[f32; 3]>, Vec<[u32; 3]>);
    let mut all: Vec<Part> = Vec::new();
    for (i, line) in text(path, reach)?.lines().enumerate() {
        let wrong = || Error::new("not a line of a reproducer").at(path).line(i as u64 + 1);
        let words: Vec<&str> = line.split_whitespace().collect();
        let first = all.last().map_or(1, |(first, positions, _)| first + positions.len());
        match (words.as_slice(), all.last_mut()) {
            (["o", ..], _) => all.push((first, Vec::new(), Vec::new())),
            (["v", x, y, z], Some(mesh)) => {
                let p = [x, y, z]
                    .map(|word| word.parse::<f32>().ok().filter(|x| x.abs() <= crate::accel::LARGEST));
                let [Some(x), Some(y), Some(z)] = p else { return Err(wrong()) };
                mesh.1.push([x, y, z]);
            }
            (["f", a, b, c], Some((first, positions, faces))) => {
                let index = |word: &&str| word.parse::<usize>().ok()?.checked_sub(*first);
                let inside = |i: Option<usize>| i.filter(|i| *i < positions.len()).map(|i| i as u32);
                let face = [a, b, c].map(|word| inside(index(word)));
                let [Some(a), Some(b), Some(c)] = face else { return Err(wrong()) };
                faces.push([a, b, c]);
            }
            ([], _) => {}
            _ => return Err(wrong()),
        }
    }
    Ok(all.into_iter().map(|(_, positions, faces)| Arc::new(Mesh::new(positions, faces))).collect())
}
