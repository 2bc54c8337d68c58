//! A real disagreement cut down to a few triangles and one ray, as two files that can be asked again.
//!
//! [`minimal`] cuts it down, `files.rs` writes and reads it.

mod files;

use super::Hooks;
use super::class::Class;
use super::compare::ask;
use super::contestants::Contestant;
use super::court::Court;
use super::outcome::{Answers, Case};
use super::rays::{Chunk, Kind, RaySet};
use crate::accel::brute::Ray64;
use crate::accel::judge::Answer;
use crate::accel::{LANES, Mask, Rays};
use crate::error::Result;
use crate::math::Vec3;
use crate::shape::Mesh;
use std::sync::Arc;

/// The most triangles that a reproducer may have.
const MOST: usize = 4096;

/// Builds that cutting a case down may take.
const PATIENCE: usize = 300;

/// A case that stands on its own.
#[derive(Clone, Debug)]
pub struct Reproducer {
    /// Its meshes; ids are those of the list and of the order of triangles.
    pub meshes: Vec<Arc<Mesh>>,
    /// The ray, alone and as a packet of sixteen.
    pub rays: RaySet,
    /// True when the same two contestants disagree about it; else the cause lies in the rest of the mesh.
    pub fails: bool,
}

/// Cuts `case` down: the triangles named, or else the nearest to them until it fails, without what it does not need.
///
/// # Errors
/// A backend that cannot be built.
pub fn minimal(
    case: &Case,
    court: &Court,
    meshes: &[Arc<Mesh>],
    contestants: &[Contestant],
) -> Result<Reproducer> {
    let pair: Vec<&Contestant> = case.contestants.iter().filter_map(|&i| contestants.get(i)).collect();
    let rays = once_and_in_a_packet(case.o, case.d, case.tmin, case.tmax);
    let fails = |ids: &[[u32; 2]]| is_real(&cut(meshes, ids), &rays, &pair);
    let named = named(case);
    // What the ray merely passes may have its part in it.
    let ray = Ray64::of(&rays.chunks[0].rays, 0);
    let mut ids: Vec<[u32; 2]> = court.scan().near(&ray).iter().map(|n| [n.mesh, n.triangle]).collect();
    ids.extend(&named);
    ids.sort_unstable();
    ids.dedup();
    let mut found = fails(&ids)?;
    let mut size = 16;
    while !found && size <= MOST {
        ids = court.scan().nearest_to(place(case, meshes), size);
        ids.extend(&named);
        ids.sort_unstable();
        ids.dedup();
        found = fails(&ids)?;
        size *= 4;
    }
    let ids = if found { without_the_needless(ids, &fails)? } else { named };
    Ok(Reproducer { meshes: cut(meshes, &ids), rays, fails: found })
}

/// Leaves out blocks of triangles, ever smaller ones, without which it still fails.
fn without_the_needless(
    mut ids: Vec<[u32; 2]>,
    fails: &dyn Fn(&[[u32; 2]]) -> Result<bool>,
) -> Result<Vec<[u32; 2]>> {
    let mut patience = PATIENCE;
    let mut block = ids.len().div_ceil(2);
    while block >= 1 && ids.len() > 1 {
        let mut at = 0;
        while at < ids.len() && patience > 0 {
            patience -= 1;
            let end = (at + block).min(ids.len());
            let rest = [&ids[..at], &ids[end..]].concat();
            if fails(&rest)? { ids = rest } else { at = end }
        }
        block /= 2;
    }
    Ok(ids)
}

fn is_real(meshes: &[Arc<Mesh>], rays: &RaySet, pair: &[&Contestant]) -> Result<bool> {
    let report = ask(meshes, std::slice::from_ref(rays), pair, &Hooks::NONE)?;
    Ok(report.outcomes.iter().flat_map(|o| &o.tallies).any(|tally| tally.of(Class::Real) > 0))
}

/// The triangles that the answers and f64 name.
fn named(case: &Case) -> Vec<[u32; 2]> {
    let answers: Vec<Answer> = match case.answers {
        Answers::Closest(pair) => pair.into_iter().chain([case.truth]).flatten().collect(),
        Answers::Blocked(_) => case.truth.into_iter().collect(),
    };
    let mut ids: Vec<[u32; 2]> = answers.iter().map(|a| [a.mesh, a.triangle]).collect();
    ids.sort_unstable();
    ids.dedup();
    ids
}

/// Where it happens: the first triangle named, or the ray's origin.
fn place(case: &Case, meshes: &[Arc<Mesh>]) -> crate::math::DVec3 {
    let corner = |[m, t]: &[u32; 2]| {
        let mesh = meshes.get(*m as usize)?;
        ((*t as usize) < mesh.indices.len()).then(|| mesh.triangle(*t as usize)[0])
    };
    named(case).iter().find_map(corner).unwrap_or(case.o).as_dvec3()
}

/// Those triangles alone, with vertices shared as they were; a mesh without any is left out.
fn cut(meshes: &[Arc<Mesh>], ids: &[[u32; 2]]) -> Vec<Arc<Mesh>> {
    let of_mesh = |(m, mesh): (usize, &Arc<Mesh>)| {
        let own =
            ids.iter().filter(|id| id[0] as usize == m).filter_map(|id| mesh.indices.get(id[1] as usize));
        let faces: Vec<[u32; 3]> = own.copied().collect();
        let mut used: Vec<u32> = faces.iter().flatten().copied().collect();
        used.sort_unstable();
        used.dedup();
        let positions = used.iter().map(|&i| mesh.positions[i as usize]).collect();
        let renamed = |i: u32| used.binary_search(&i).unwrap_or_default() as u32;
        (!faces.is_empty())
            .then(|| Arc::new(Mesh::new(positions, faces.iter().map(|f| f.map(renamed)).collect())))
    };
    meshes.iter().enumerate().filter_map(of_mesh).collect()
}

/// Backends trace few rays one by one and many together: both are asked.
fn once_and_in_a_packet(o: Vec3, d: Vec3, tmin: f32, tmax: f32) -> RaySet {
    let mut rays = Rays::default();
    (0..LANES).for_each(|lane| rays.set(lane, o, d, tmin, tmax));
    let chunk = |mask: Mask| Chunk { mask: rays.check(mask).active(), rays: rays.clone() };
    RaySet { kind: Kind::Replay, chunks: vec![chunk(1), chunk(Mask::MAX)] }
}
