//! What a block of text says, before its place in the file is known.
//!
//! Blocks are parsed in any order, so an index that counts backwards is kept relative to the block's own
//! first element ([`Block::relative`]) and lines count from the block's start.

use super::corners::Corners;
use super::memory::{OutOfMemory, grow, push};
use super::notes::Notes;

/// The largest number of vertices, normals, texture coordinates or triangles: 2³²/3. Twelve bytes each
/// then fill 16 GiB, the largest buffer Embree takes, and any index fits an `i32`.
pub(super) const MAX_ELEMENTS: u64 = (1 << 32) / 3;

/// Faces of equally many corners on consecutive lines: one entry for most of a large mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct FaceRun {
    /// Triangles before the run.
    pub first_triangle: usize,
    /// How many faces.
    pub faces: usize,
    /// Corners of each face, at least 3; it is `corners - 2` triangles.
    pub corners: usize,
    /// Line of the first face.
    pub first_line: u64,
}

impl FaceRun {
    /// Adds a face that follows the last of `runs` there, or as a run of its own.
    #[inline]
    pub fn add(
        runs: &mut Vec<FaceRun>,
        first_triangle: usize,
        corners: usize,
        line: u64,
    ) -> Result<(), OutOfMemory> {
        if let Some(last) = runs.last_mut()
            && last.corners == corners
            && last.first_line + last.faces as u64 == line
            && last.first_triangle + last.faces * (corners - 2) == first_triangle
        {
            last.faces += 1;
            return Ok(());
        }
        push(runs, FaceRun { first_triangle, faces: 1, corners, first_line: line })
    }

    /// The faces: (first triangle, line).
    pub fn iter(self) -> impl Iterator<Item = (usize, u64)> {
        (0..self.faces)
            .map(move |i| (self.first_triangle + i * (self.corners - 2), self.first_line + i as u64))
    }
}

/// What makes a whole file unreadable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Fatal {
    /// A NUL byte.
    Nul,
    /// Every other byte is NUL.
    Utf16,
    /// A line beyond the limit.
    LineTooLong,
    /// No memory for the block.
    OutOfMemory,
}

/// Materials of triangles, while they are one.
#[derive(Clone, Debug, Default)]
pub(super) struct Materials {
    /// One id a triangle; empty while all have `current`'s only value so far.
    pub per_face: Vec<u32>,
    /// The id that holds for the next triangle.
    pub current: u32,
    /// The id of all triangles while `per_face` is empty.
    pub uniform: u32,
}

impl Materials {
    /// Adds a triangle; `before` is how many there are.
    #[inline]
    pub fn push(&mut self, before: usize) -> Result<(), OutOfMemory> {
        self.extend(before, 1, self.current)
    }

    /// Adds `count` triangles of one material.
    pub fn extend(&mut self, before: usize, count: usize, id: u32) -> Result<(), OutOfMemory> {
        if before == 0 {
            self.uniform = id;
        } else if self.per_face.is_empty() && id != self.uniform {
            grow(&mut self.per_face, before + count)?;
            self.per_face.resize(before, self.uniform);
        }
        if before > 0 && !self.per_face.is_empty() {
            grow(&mut self.per_face, count)?;
            self.per_face.resize(before + count, id);
        }
        Ok(())
    }

    pub fn clear(&mut self) {
        self.per_face.clear();
        (self.current, self.uniform) = (0, 0);
    }
}

/// A parsed block.
#[derive(Debug, Default)]
pub(super) struct Block {
    /// Positions rounded to f32; NaN where unusable.
    pub positions: Vec<[f32; 3]>,
    /// What is missing from each to the f64: a difference of f64 bit patterns (see [`residual`]).
    pub residuals: Vec<[i32; 3]>,
    /// Normals; zero where unusable.
    pub normals: Vec<[f32; 3]>,
    /// Texture coordinates; NaN where unusable.
    pub uvs: Vec<[f32; 2]>,
    /// Whether some position, normal, texture coordinate is unusable.
    pub unusable: [bool; 3],
    /// Position indices of the triangles, faces split as fans around their first corner.
    pub triangles: Vec<[u32; 3]>,
    /// Texture coordinates' and normals' indices.
    pub uv_corners: Corners,
    /// Normals' indices.
    pub normal_corners: Corners,
    /// Which of a triangle's indices count from this block's first element (as an `i32`): bits 0–2
    /// positions, 3–5 texture coordinates, 6–8 normals. Empty when none does.
    pub relative: Vec<u16>,
    /// The triangles' materials: 0 is what held before the block, k is `names[k - 1]`.
    pub materials: Materials,
    /// Names after `usemtl`, each once.
    pub names: Vec<Vec<u8>>,
    /// What follows `mtllib`, with the line.
    pub libraries: Vec<(u64, Vec<u8>)>,
    /// The faces.
    pub runs: Vec<FaceRun>,
    /// Faces stated, and how many of them were skipped.
    pub faces: u64,
    /// Faces skipped so far.
    pub skipped: u64,
    /// Physical lines.
    pub lines: u64,
    /// Findings; lines count from 0.
    pub notes: Notes,
    /// Why nothing after this line could be read.
    pub fatal: Option<(u64, Fatal)>,
}

impl Block {
    /// Empties the block, keeping its memory.
    pub fn clear(&mut self) {
        self.positions.clear();
        self.residuals.clear();
        self.normals.clear();
        self.uvs.clear();
        self.unusable = [false; 3];
        self.triangles.clear();
        self.uv_corners.clear();
        self.normal_corners.clear();
        self.relative.clear();
        self.materials.clear();
        self.names.clear();
        self.libraries.clear();
        self.runs.clear();
        (self.faces, self.skipped, self.lines) = (0, 0, 0);
        self.notes = Notes::default();
        self.fatal = None;
    }
}

/// `value − rounded` as a difference of their bit patterns as f64s: at most 2²⁸ apart, so an i32 holds it
/// and [`exact`] gives back the very f64 for half its memory. Zero for values so small (below 10⁻³⁷) that
/// f32 has no full mantissa for them.
#[inline]
pub(super) fn residual(value: f64, rounded: f32) -> i32 {
    let difference = value.to_bits().wrapping_sub(f64::from(rounded).to_bits()) as i64;
    i32::try_from(difference).unwrap_or(0)
}

/// The f64 that [`residual`] was taken of.
#[inline]
pub(super) fn exact(rounded: [f32; 3], residual: [i32; 3]) -> [f64; 3] {
    std::array::from_fn(|k| {
        f64::from_bits(f64::from(rounded[k]).to_bits().wrapping_add_signed(i64::from(residual[k])))
    })
}
