//! How triangles hang together: edges that one, two or more of them share, and in which direction.
//!
//! Every triangle contributes three edges as sorted 64-bit keys; equal keys then stand side by side. That takes
//! eight bytes an edge and no hash table, and gives the same answer on any number of threads.

use super::out_of_memory;
use crate::error::Result;
use rayon::prelude::*;

/// Triangles in a unit of parallel work.
pub(super) const CHUNK: usize = 1 << 16;

/// An edge's two vertices, the smaller first, and whether a triangle runs from the larger to the smaller:
/// 31 + 32 + 1 bits. Positions are fewer than 2³²/3, so 31 bits hold an index.
fn key(from: u32, to: u32) -> u64 {
    let (low, high, backward) = if from <= to { (from, to, 0) } else { (to, from, 1) };
    u64::from(low) << 33 | u64::from(high) << 1 | backward
}

/// The vertices of an edge whose key, less its direction, is `edge`.
pub(super) fn ends(edge: u64) -> [u32; 2] {
    [(edge >> 32) as u32, edge as u32]
}

/// A hole's rim, or several that touch in a vertex.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Rim {
    /// How many edges.
    pub edges: u64,
    /// The first of them.
    pub edge: u64,
}

/// What the edges show.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Topology {
    /// Edges that belong to one triangle alone: the rims of holes.
    pub boundary_edges: u64,
    /// Connected rims; holes that touch in a vertex count as one.
    pub boundary_loops: u64,
    /// Edges that more than two triangles share.
    pub non_manifold_edges: u64,
    /// Edges whose two triangles run along them in the same direction: one of the two is turned over.
    pub mixed_edges: u64,
    /// Every edge is shared by an even number of triangles, at least two.
    pub watertight: bool,
    /// Every edge is run along as often one way as the other, so that the volume inside is defined.
    pub oriented: bool,
    /// The largest rims.
    pub(super) rims: Vec<Rim>,
    /// The first edges of more than two triangles.
    pub(super) non_manifold: Vec<u64>,
    /// The first edges of two triangles in the same direction.
    pub(super) mixed: Vec<u64>,
}

/// Looks at every edge of `triangles`, whose vertices are taken for those that `same` names (below
/// `vertices`); the first `kept` places of each kind are kept.
///
/// # Errors
/// Not enough memory.
pub(super) fn survey(
    triangles: &[[u32; 3]],
    vertices: usize,
    same: &(dyn Fn(u32) -> u32 + Sync),
    kept: usize,
) -> Result<Topology> {
    let keys = sorted_keys(triangles, same)?;
    let mut topology = Topology { watertight: !keys.is_empty(), oriented: true, ..Topology::default() };
    let mut boundary = Vec::new();
    for shared in keys.chunk_by(|a, b| a >> 1 == b >> 1) {
        let Some(edge) = shared.first().map(|key| key >> 1) else { continue };
        let backward = shared.iter().filter(|key| *key & 1 == 1).count();
        topology.watertight &= shared.len().is_multiple_of(2);
        topology.oriented &= 2 * backward == shared.len();
        match shared.len() {
            1 => {
                boundary.try_reserve(1).map_err(|_| out_of_memory())?;
                boundary.push(edge);
            }
            2 if backward != 1 => {
                topology.mixed_edges += 1;
                if topology.mixed.len() < kept {
                    topology.mixed.push(edge);
                }
            }
            2 => {}
            _ => {
                topology.non_manifold_edges += 1;
                if topology.non_manifold.len() < kept {
                    topology.non_manifold.push(edge);
                }
            }
        }
    }
    drop(keys);
    topology.boundary_edges = boundary.len() as u64;
    let mut rims = rims(&boundary, vertices)?;
    topology.boundary_loops = rims.len() as u64;
    rims.sort_unstable_by_key(|rim| (std::cmp::Reverse(rim.edges), rim.edge));
    rims.truncate(kept);
    topology.rims = rims;
    Ok(topology)
}

fn sorted_keys(triangles: &[[u32; 3]], same: &(dyn Fn(u32) -> u32 + Sync)) -> Result<Vec<u64>> {
    let mut keys: Vec<u64> = Vec::new();
    keys.try_reserve_exact(3 * triangles.len()).map_err(|_| out_of_memory())?;
    keys.resize(3 * triangles.len(), 0);
    keys.par_chunks_mut(3 * CHUNK).zip(triangles.par_chunks(CHUNK)).for_each(|(keys, triangles)| {
        for (keys, triangle) in keys.chunks_exact_mut(3).zip(triangles) {
            keys.copy_from_slice(&keys_of(triangle.map(same)));
        }
    });
    keys.par_sort_unstable();
    Ok(keys)
}

fn keys_of([a, b, c]: [u32; 3]) -> [u64; 3] {
    [key(a, b), key(b, c), key(c, a)]
}

/// Connected sets of edges, by union–find with path halving (Tarjan and van Leeuwen 1984).
fn rims(edges: &[u64], vertices: usize) -> Result<Vec<Rim>> {
    if edges.is_empty() {
        return Ok(Vec::new());
    }
    let mut parents: Vec<u32> = Vec::new();
    parents.try_reserve_exact(vertices).map_err(|_| out_of_memory())?;
    parents.extend(0..vertices as u32);
    for &edge in edges {
        let [a, b] = ends(edge).map(|vertex| root(&mut parents, vertex));
        // The smaller index becomes the root: no dependence on anything but the set of edges.
        if let Some(parent) = parents.get_mut(a.max(b) as usize) {
            *parent = a.min(b);
        }
    }
    let mut by_root: Vec<(u32, u64)> = Vec::new();
    by_root.try_reserve_exact(edges.len()).map_err(|_| out_of_memory())?;
    by_root.extend(edges.iter().map(|&edge| (root(&mut parents, ends(edge)[0]), edge)));
    by_root.par_sort_unstable();
    let sets = by_root.chunk_by(|a, b| a.0 == b.0);
    Ok(sets.filter_map(|set| Some(Rim { edges: set.len() as u64, edge: set.first()?.1 })).collect())
}

fn root(parents: &mut [u32], mut vertex: u32) -> u32 {
    loop {
        let parent = parents.get(vertex as usize).copied().unwrap_or(vertex);
        if parent == vertex {
            return vertex;
        }
        let grandparent = parents.get(parent as usize).copied().unwrap_or(parent);
        if let Some(slot) = parents.get_mut(vertex as usize) {
            *slot = grandparent;
        }
        vertex = grandparent;
    }
}

/// The first triangle that has each of `edges`.
pub(super) fn first_triangles(
    edges: &[u64],
    triangles: &[[u32; 3]],
    same: &(dyn Fn(u32) -> u32 + Sync),
) -> Vec<u32> {
    let mut sorted: Vec<(u64, usize)> = edges.iter().copied().zip(0..).collect();
    sorted.sort_unstable();
    let none = || vec![u32::MAX; edges.len()];
    if edges.is_empty() {
        return none();
    }
    let smaller = |mut a: Vec<u32>, b: Vec<u32>| {
        a.iter_mut().zip(b).for_each(|(a, b)| *a = (*a).min(b));
        a
    };
    let of_chunk = |(chunk, triangles): (usize, &[[u32; 3]])| {
        let mut found = none();
        for (i, triangle) in triangles.iter().enumerate() {
            for key in keys_of(triangle.map(same)) {
                let Ok(at) = sorted.binary_search_by_key(&(key >> 1), |wanted| wanted.0) else { continue };
                if let Some(slot) = sorted.get(at).and_then(|wanted| found.get_mut(wanted.1)) {
                    *slot = (*slot).min((chunk * CHUNK + i) as u32);
                }
            }
        }
        found
    };
    triangles.par_chunks(CHUNK).enumerate().map(of_chunk).reduce(none, smaller)
}
