//! What a large file will take in memory, from a look at a few of its places.
//!
//! Reading gigabytes only to say that the result does not fit would waste minutes. Statements of one kind look alike
//! all through a file, so the bytes of a hundred places tell how many there are of each, within a few per cent.

use crate::accel::need::Extent;
use crate::scene::need::Meshes;
use std::fs::File;
use std::os::unix::fs::FileExt;

/// Smaller files are read without much ado.
const WORTH_A_LOOK: u64 = 8 << 20;
/// How many places are looked at, evenly spread.
const PLACES: u64 = 128;
/// Bytes at each.
const BYTES: usize = 32 << 10;
/// The reader's own buffers, whatever the size of the file.
const BUFFERS: u64 = 32 << 20;

/// How many there are of everything that takes memory.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Tally {
    vertices: f64,
    normals: f64,
    uvs: f64,
    triangles: f64,
    /// Corners whose texture coordinate or normal has not the position's index.
    uv_corners: f64,
    normal_corners: f64,
    materials: f64,
}

/// What is built over the file's mesh and what the mesh takes. `None` for small files and where reading fails: the
/// reader itself will say why.
pub(in crate::load) fn forecast(file: &File, bytes: u64) -> Option<(Extent, Meshes)> {
    if bytes < WORTH_A_LOOK {
        return None;
    }
    let mut tally = Tally::default();
    let mut seen = 0;
    let mut buffer = vec![0; BYTES];
    for place in 0..PLACES {
        let at = (bytes - BYTES as u64) / (PLACES - 1) * place;
        let got = file.read_at(&mut buffer, at).ok()?;
        seen += tally.add(buffer.get(..got)?, place == 0);
    }
    Some(tally.scaled(bytes as f64 / (seen.max(1) as f64)))
}

impl Tally {
    /// Counts the whole lines in `text`, which starts a line where `is_start` says so; returns their bytes.
    fn add(&mut self, text: &[u8], is_start: bool) -> usize {
        let is_end = |byte: &u8| matches!(byte, b'\n' | b'\r');
        let start = if is_start { 0 } else { text.iter().position(is_end).map_or(text.len(), |at| at + 1) };
        let end = text.iter().rposition(is_end).map_or(start, |at| at + 1).max(start);
        let lines = text.get(start..end).unwrap_or_default();
        lines.split(is_end).for_each(|line| self.line(line));
        lines.len()
    }

    fn line(&mut self, line: &[u8]) {
        let mut words = line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
        match words.next() {
            Some(b"v") => self.vertices += 1.0,
            Some(b"vn") => self.normals += 1.0,
            Some(b"vt") => self.uvs += 1.0,
            Some(b"usemtl") => self.materials += 1.0,
            Some(b"f") => {
                let (mut corners, mut own_uvs, mut own_normals) = (0.0, false, false);
                for corner in words {
                    let mut indices = corner.split(|b| *b == b'/');
                    let position = indices.next();
                    let is_own =
                        |index: Option<&[u8]>| index.is_some_and(|i| !i.is_empty()) && index != position;
                    own_uvs |= is_own(indices.next());
                    own_normals |= is_own(indices.next());
                    corners += 1.0;
                }
                let triangles = f64::max(corners - 2.0, 0.0);
                self.triangles += triangles;
                self.uv_corners += if own_uvs { triangles } else { 0.0 };
                self.normal_corners += if own_normals { triangles } else { 0.0 };
            }
            _ => {}
        }
    }

    /// For the whole file, which is `by` times what was counted.
    fn scaled(&self, by: f64) -> (Extent, Meshes) {
        let whole = |count: f64| (count * by) as u64;
        let (vertices, triangles) = (whole(self.vertices), whole(self.triangles));
        // An attribute is listed by corner for all triangles or for none.
        let lists =
            [self.uv_corners, self.normal_corners].into_iter().filter(|own| *own > 0.0).count() as u64;
        // A name alone is the file's only material.
        let ids = if self.materials > 1.0 { 4 * triangles } else { 0 };
        let attributes = 12 * whole(self.normals) + 8 * whole(self.uvs) + 12 * lists * triangles + ids;
        let (extent, Meshes { kept, peak }) = plain(vertices, triangles);
        (extent, Meshes { kept: kept + attributes, peak: peak + attributes })
    }
}

/// A mesh of nothing but corners, of any format.
pub(in crate::load) fn plain(vertices: u64, triangles: u64) -> (Extent, Meshes) {
    let each = |vertex: u64, triangle: u64| {
        vertices.saturating_mul(vertex).saturating_add(triangles.saturating_mul(triangle))
    };
    let kept = each(12, 12);
    // What f32 rounds away of positions, a hash a triangle and the filter over the hashes.
    let peak = kept.saturating_add(each(12, 6)).saturating_add(BUFFERS);
    (Extent { triangles, vertices, meshes: 1 }, Meshes { kept, peak })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fmt::Write as _;
    use std::io::Write as _;

    /// A grid of quads as exporters write it, of about 12 MB: statements of a kind together, and the corners named as
    /// `corner` does it.
    fn file(
        rows: usize,
        attributes: bool,
        corner: impl Fn(usize) -> String,
    ) -> (tempfile::NamedTempFile, u64) {
        let mut text = String::from("# a grid\nmtllib a.mtl\n");
        for i in 0..rows * rows {
            let (x, y) = (i % rows, i / rows);
            writeln!(text, "v {}.25 {}.125 0.5", x, y).unwrap();
        }
        for i in (0..rows * rows).filter(|_| attributes) {
            writeln!(text, "vt 0.{i} 0.5\nvn 0 0 1").unwrap();
        }
        text += "usemtl one\n";
        for i in (0..rows * (rows - 1)).filter(|i| i % rows + 1 < rows) {
            let corners = [i, i + 1, i + rows + 1, i + rows].map(|i| corner(i + 1));
            writeln!(text, "f {}", corners.join(" ")).unwrap();
        }
        let mut file = tempfile::NamedTempFile::new().unwrap();
        file.write_all(text.as_bytes()).unwrap();
        (file, text.len() as u64)
    }

    #[track_caller]
    fn check(rows: usize, attributes: bool, corner: impl Fn(usize) -> String) {
        let (file, bytes) = file(rows, attributes, corner);
        assert!(bytes > WORTH_A_LOOK, "{bytes}");
        let (extent, meshes) = forecast(file.as_file(), bytes).unwrap();
        let mesh = super::super::read(file.path(), &Default::default()).unwrap().mesh;
        let near = |guess: u64, truth: usize| (guess as f64 / truth as f64 - 1.0).abs() < 0.05;
        assert!(near(extent.triangles, mesh.indices.len()), "{extent:?}");
        assert!(near(extent.vertices, mesh.positions.len()), "{extent:?}");
        assert!(near(meshes.kept, mesh.bytes()), "{meshes:?} {}", mesh.bytes());
        assert!(meshes.peak > meshes.kept && meshes.peak < 2 * meshes.kept + BUFFERS, "{meshes:?}");
    }

    #[test]
    fn a_look_at_a_file_tells_its_mesh() {
        check(450, false, |i| i.to_string());
        check(300, true, |i| format!("{i}/{i}/{i}"));
        check(330, true, |i| format!("{i}/{}/1", i % 330 + 1));
    }

    #[test]
    fn small_files_and_other_text_say_nothing() {
        let mut small = tempfile::NamedTempFile::new().unwrap();
        small.write_all(b"v 0 0 0\n").unwrap();
        assert!(forecast(small.as_file(), 8).is_none());
        // A file that shrank in between, one line without end, and no text at all.
        assert!(forecast(small.as_file(), WORTH_A_LOOK).is_some());
        let mut tally = Tally::default();
        assert_eq!(tally.add(&[b'v'; 100], false), 0);
        tally.add(b"f\nf 1\nf / // 1\nv\n\0\xff\n", true);
        assert_eq!((tally.vertices, tally.triangles), (1.0, 1.0));
    }
}
