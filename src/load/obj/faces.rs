//! Faces meet the vertices they name: indices become absolute, what is missing is judged, polygons split.

use super::block::{Block, FaceRun, exact};
use super::corners::Corners;
use super::memory::{OutOfMemory, grow};
use super::notes::{Kind, Notes};
use super::triangulate::Triangulator;
use crate::math::DVec3;
use crate::shape::NO_INDEX;

/// The vertices read so far.
pub(super) struct Known<'a> {
    /// As in [`Block::positions`], of the whole file.
    pub positions: &'a [[f32; 3]],
    /// As in [`Block::residuals`].
    pub residuals: &'a [[i32; 3]],
    /// Normals; zero where unusable.
    pub normals: &'a [[f32; 3]],
    /// Texture coordinates; NaN where unusable.
    pub uvs: &'a [[f32; 2]],
    /// Whether some position, normal, texture coordinate is unusable.
    pub unusable: [bool; 3],
    /// Whether there will be no more: an index beyond them is wrong then, and a reference forward before.
    pub complete: bool,
}

/// How many positions, texture coordinates and normals there are before a block.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Before(pub [usize; 3]);

/// Index lists of triangles, those of attributes only where they are listed.
struct Lists<'a> {
    triangles: &'a mut [[u32; 3]],
    uvs: Option<&'a mut [[u32; 3]]>,
    normals: Option<&'a mut [[u32; 3]]>,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Verdict {
    Keep,
    Skip,
    /// It names a vertex that may still come.
    Defer,
}

/// Finishes the faces of a block, and takes the skipped ones out of its runs; returns those that must wait for the end of the file.
pub(super) fn finish_block(
    block: &mut Block,
    before: Before,
    known: &Known<'_>,
) -> Result<Vec<FaceRun>, OutOfMemory> {
    if nothing_to_do(block, known) {
        return Ok(Vec::new());
    }
    // Before `relative` is resolved: positions and attributes count from different starts.
    for corners in [&mut block.uv_corners, &mut block.normal_corners] {
        if *corners != Corners::Absent {
            corners.listed(&block.triangles)?;
        }
    }
    resolve_relative(block, before);
    let mut lists = Lists {
        triangles: &mut block.triangles,
        uvs: own(&mut block.uv_corners),
        normals: own(&mut block.normal_corners),
    };
    let materials = &mut block.materials.per_face;
    let mut work = FaceWork::default();
    let mut deferred = Vec::new();
    let mut kept = Vec::new();
    let mut write = 0;
    for run in &block.runs {
        for (first, line) in run.iter() {
            let verdict =
                work.finish(&mut lists, first, write, run.corners, line, known, &mut block.notes)?;
            if verdict == Verdict::Skip {
                block.skipped += 1;
                continue;
            }
            if verdict == Verdict::Defer {
                FaceRun::add(&mut deferred, write, run.corners, line)?;
            }
            if let Some(&material) = materials.get(first)
                && let Some(ids) = materials.get_mut(write..write + run.corners - 2)
            {
                ids.fill(material);
            }
            FaceRun::add(&mut kept, write, run.corners, line)?;
            write += run.corners - 2;
        }
    }
    block.runs = kept;
    materials.truncate(write);
    block.triangles.truncate(write);
    for corners in [&mut block.uv_corners, &mut block.normal_corners] {
        if let Corners::Own(list) = corners {
            list.truncate(write);
        }
        corners.compress(&block.triangles);
    }
    Ok(deferred)
}

/// Finishes the faces that had to wait; returns the triangles of those that are skipped, ascending, and
/// how many faces that were.
pub(super) fn finish_deferred(
    triangles: &mut [[u32; 3]],
    uvs: &mut Corners,
    normals: &mut Corners,
    runs: &[FaceRun],
    known: &Known<'_>,
    notes: &mut Notes,
) -> Result<(Vec<u32>, u64), OutOfMemory> {
    let mut skipped = (Vec::new(), 0);
    if runs.is_empty() {
        return Ok(skipped);
    }
    for corners in [&mut *uvs, &mut *normals] {
        if *corners != Corners::Absent {
            corners.listed(triangles)?;
        }
    }
    let mut lists = Lists { triangles, uvs: own(uvs), normals: own(normals) };
    let mut work = FaceWork::default();
    for run in runs {
        for (first, line) in run.iter() {
            if work.finish(&mut lists, first, first, run.corners, line, known, notes)? == Verdict::Skip {
                grow(&mut skipped.0, run.corners - 2)?;
                skipped.0.extend((first..first + run.corners - 2).map(|t| t as u32));
                skipped.1 += 1;
            }
        }
    }
    Ok(skipped)
}

fn own(corners: &mut Corners) -> Option<&mut [[u32; 3]]> {
    match corners {
        Corners::Own(list) => Some(list),
        Corners::Absent | Corners::Same => None,
    }
}

/// The common case: only triangles, every index absolute and known, every value usable.
fn nothing_to_do(block: &Block, known: &Known<'_>) -> bool {
    let below = |list: &[[u32; 3]], count: usize| {
        let largest = list.iter().fold(0, |m: u32, t| m.max(t[0]).max(t[1]).max(t[2]));
        list.is_empty() || (largest as usize) < count
    };
    let attribute = |corners: &Corners, count: usize| match corners {
        Corners::Absent => true,
        Corners::Same => below(&block.triangles, count),
        Corners::Own(list) => below(list, count),
    };
    known.unusable == [false; 3]
        && block.relative.is_empty()
        && block.runs.iter().all(|run| run.corners == 3)
        && below(&block.triangles, known.positions.len())
        && attribute(&block.uv_corners, known.uvs.len())
        && attribute(&block.normal_corners, known.normals.len())
}

/// Indices that count back become absolute; one before the file's start becomes [`before_start`].
fn resolve_relative(block: &mut Block, before: Before) {
    let Before(counts) = before;
    let mut uvs = own(&mut block.uv_corners);
    let mut normals = own(&mut block.normal_corners);
    for (triangle, &mask) in block.relative.iter().enumerate().filter(|(_, mask)| **mask != 0) {
        let lists = [Some(block.triangles.as_mut_slice()), uvs.as_deref_mut(), normals.as_deref_mut()];
        for (part, (list, count)) in lists.into_iter().zip(counts).enumerate() {
            let Some(corners) = list.and_then(|l| l.get_mut(triangle)) else { continue };
            for (corner, index) in corners.iter_mut().enumerate() {
                if mask >> (3 * part + corner) & 1 == 1 {
                    let absolute = count as i64 + i64::from(*index as i32);
                    *index = if absolute < 0 { before_start(absolute) } else { absolute as u32 };
                }
            }
        }
    }
    block.relative.clear();
}

/// A negative index in an unsigned list, distinct from [`NO_INDEX`] (which would be −1).
fn before_start(absolute: i64) -> u32 {
    (absolute - 1) as i32 as u32
}

/// The index as people count, from 1; what lies before the start is 0 and less.
fn as_stated(index: u32) -> i64 {
    if (index as i32) < 0 { i64::from(index as i32) + 2 } else { i64::from(index) + 1 }
}

/// Buffers for one face at a time.
#[derive(Default)]
struct FaceWork {
    positions: Vec<u32>,
    uvs: Vec<u32>,
    normals: Vec<u32>,
    triangulator: Triangulator,
}

impl FaceWork {
    /// Judges the face whose fan starts at `first`, and writes its triangles from `write ≤ first` on.
    #[allow(clippy::too_many_arguments)]
    fn finish(
        &mut self,
        lists: &mut Lists<'_>,
        first: usize,
        write: usize,
        corners: usize,
        line: u64,
        known: &Known<'_>,
        notes: &mut Notes,
    ) -> Result<Verdict, OutOfMemory> {
        gather(Some(lists.triangles), first, corners, &mut self.positions)?;
        gather(lists.uvs.as_deref(), first, corners, &mut self.uvs)?;
        gather(lists.normals.as_deref(), first, corners, &mut self.normals)?;
        let mut verdict = self.judge_positions(line, known, notes);
        if verdict == Verdict::Keep {
            let uv_usable = |i: usize| known.uvs.get(i).map(|uv| !uv[0].is_nan());
            let uvs = judge_attribute(&mut self.uvs, uv_usable, Kind::UvIndex, line, known.complete, notes);
            let normal_usable = |i: usize| known.normals.get(i).map(|n| *n != [0.0; 3]);
            let normals = judge_attribute(
                &mut self.normals,
                normal_usable,
                Kind::NormalIndex,
                line,
                known.complete,
                notes,
            );
            if uvs == Verdict::Defer || normals == Verdict::Defer {
                verdict = Verdict::Defer;
            }
        }
        let order = match verdict {
            Verdict::Skip => return Ok(verdict),
            Verdict::Defer => self.triangulator.fan(corners)?,
            Verdict::Keep => {
                let points = &mut self.triangulator.points;
                points.clear();
                grow(points, corners)?;
                points.extend(self.positions.iter().map(|&i| exact_point(known, i)));
                self.triangulator.split()?
            }
        };
        scatter(Some(lists.triangles), write, &self.positions, order);
        scatter(lists.uvs.as_deref_mut(), write, &self.uvs, order);
        scatter(lists.normals.as_deref_mut(), write, &self.normals, order);
        Ok(verdict)
    }

    fn judge_positions(&self, line: u64, known: &Known<'_>, notes: &mut Notes) -> Verdict {
        let exists = |&&i: &&u32| (i as usize) < known.positions.len();
        let before_start = |&&i: &&u32| (i as i32) < 0;
        if !known.complete && self.positions.iter().any(|i| !exists(&i) && !before_start(&i)) {
            return Verdict::Defer;
        }
        if let Some(&index) = self.positions.iter().find(|i| !exists(i)) {
            notes.add(Kind::FaceIndex, line, as_stated(index));
            return Verdict::Skip;
        }
        let usable = |&&i: &&u32| known.positions.get(i as usize).is_some_and(|p| !p[0].is_nan());
        if known.unusable[0]
            && let Some(&index) = self.positions.iter().find(|i| !usable(i))
        {
            notes.add(Kind::FaceBadVertex, line, as_stated(index));
            return Verdict::Skip;
        }
        Verdict::Keep
    }
}

/// Takes away what is out of range or unusable; `usable` says so of a value, `None` when there is none.
fn judge_attribute(
    indices: &mut [u32],
    usable: impl Fn(usize) -> Option<bool>,
    kind: Kind,
    line: u64,
    complete: bool,
    notes: &mut Notes,
) -> Verdict {
    let mut verdict = Verdict::Keep;
    for index in indices.iter_mut().filter(|i| **i != NO_INDEX) {
        match usable(*index as usize) {
            Some(true) => continue,
            Some(false) => {}
            None if (*index as i32) >= 0 && !complete => {
                verdict = Verdict::Defer;
                continue;
            }
            None => notes.add(kind, line, as_stated(*index)),
        }
        *index = NO_INDEX;
    }
    verdict
}

fn exact_point(known: &Known<'_>, index: u32) -> DVec3 {
    let position = known.positions.get(index as usize).copied().unwrap_or_default();
    let residual = known.residuals.get(index as usize).copied().unwrap_or_default();
    DVec3::from_array(exact(position, residual))
}

/// The corners of a face from its fan.
fn gather(
    list: Option<&[[u32; 3]]>,
    first: usize,
    corners: usize,
    out: &mut Vec<u32>,
) -> Result<(), OutOfMemory> {
    out.clear();
    let Some([head, tail @ ..]) = list.and_then(|l| l.get(first..first + corners - 2)) else { return Ok(()) };
    grow(out, corners)?;
    out.extend(head);
    out.extend(tail.iter().map(|t| t[2]));
    Ok(())
}

/// Writes a face's triangles.
fn scatter(list: Option<&mut [[u32; 3]]>, write: usize, corners: &[u32], order: &[[u32; 3]]) {
    let Some(out) = list.and_then(|l| l.get_mut(write..write + order.len())) else { return };
    for (triangle, order) in out.iter_mut().zip(order) {
        *triangle = order.map(|i| corners.get(i as usize).copied().unwrap_or(NO_INDEX));
    }
}
