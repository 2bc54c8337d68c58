//! An entry of our BVH: the tree that was built over a scene's meshes.
//!
//! Its name is the digest of what a tree depends on: the corners of all triangles in order, the build's quality, and the
//! form of the tree. Neither threads nor instruction set are part of it, since the tree depends on neither.

use super::wire::{Problem, Sink, Source};
use super::{Cache, NOT_WRITTEN, UNUSABLE, finding, hex};
use crate::accel::bvh::Bvh;
use crate::accel::bvh::stored::{LAYOUT, NODE, Stored, TRIANGLES};
use crate::accel::{BuildOptions, Quality, cancelled};
use crate::error::Result;
use crate::output::file::write_private;
use crate::shape::Mesh;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::Ordering;

const MAGIC: [u8; 8] = *b"drttree\n";

impl Cache {
    /// The BVH over `meshes`: from the cache, or built, and then in the cache.
    ///
    /// # Errors
    /// As [`Bvh::build`].
    pub fn bvh(&self, meshes: &[Arc<Mesh>], options: &BuildOptions<'_>) -> Result<Bvh> {
        let key = key(meshes, options.quality, options.progress).ok_or_else(cancelled)?;
        let path = self.folder.join(format!("{}.tree", hex(&key)));
        match read(&path, meshes, options) {
            Ok(Some(bvh)) if (options.progress)(1.0) => {
                self.trees.fetch_add(1, Ordering::Relaxed);
                return Ok(bvh);
            }
            Ok(Some(_)) => return Err(cancelled()),
            Ok(None) => {}
            Err(why) => self.say(finding(&path, UNUSABLE, format!("{why}; the structure was built anew"))),
        }
        let bvh = Bvh::build(meshes, options)?;
        if let Err(why) = write_private(&path, |file| put(file, &bvh)) {
            self.say(finding(&path, NOT_WRITTEN, format!("the structure is not kept: {}", why.message)));
        }
        Ok(bvh)
    }
}

/// The digest of everything that the tree depends on; `None` when `progress` cancelled.
fn key(meshes: &[Arc<Mesh>], quality: Quality, progress: &dyn Fn(f64) -> bool) -> Option<super::Key> {
    let mut hasher = blake3::Hasher::new();
    hasher.update(&LAYOUT.to_le_bytes()).update(env!("CARGO_PKG_VERSION").as_bytes());
    hasher.update(quality.name().as_bytes());
    let mut buffer = Vec::new();
    for mesh in meshes {
        hasher.update(&(mesh.positions.len() as u64).to_le_bytes());
        hasher.update(&(mesh.indices.len() as u64).to_le_bytes());
        let coordinates = mesh.positions.as_flattened().iter().map(|x| x.to_le_bytes());
        let mut pieces = Pieces { progress, hasher: &mut hasher, buffer: &mut buffer };
        pieces.add(coordinates)?;
        pieces.add(mesh.indices.as_flattened().iter().map(|x| x.to_le_bytes()))?;
    }
    Some(*hasher.finalize().as_bytes())
}

/// Feeds a digest piece by piece.
struct Pieces<'a> {
    progress: &'a dyn Fn(f64) -> bool,
    hasher: &'a mut blake3::Hasher,
    buffer: &'a mut Vec<u8>,
}

impl Pieces<'_> {
    /// `None` when the progress callback cancelled.
    fn add(&mut self, words: impl Iterator<Item = [u8; 4]>) -> Option<()> {
        let mut words = words.peekable();
        while words.peek().is_some() {
            self.buffer.clear();
            self.buffer.extend(words.by_ref().take(1 << 16).flatten());
            self.hasher.update(self.buffer);
            if !(self.progress)(0.0) {
                return None;
            }
        }
        Some(())
    }
}

fn put(file: &mut std::fs::File, bvh: &Bvh) -> std::io::Result<()> {
    let mut sink = Sink::new(file, MAGIC)?;
    sink.number(bvh.nodes().len() as u64)?;
    sink.number(bvh.blocks().len() as u64)?;
    sink.number(bvh.leaves_of_one().to_bits())?;
    bvh.nodes().try_for_each(|node| sink.numbers(&node))?;
    bvh.blocks().try_for_each(|block| sink.numbers(&block))?;
    sink.finish()
}

fn read(path: &Path, meshes: &[Arc<Mesh>], options: &BuildOptions<'_>) -> Result<Option<Bvh>, Problem> {
    let Some(mut source) = Source::open(path, MAGIC)? else { return Ok(None) };
    let nodes = source.count(4 * NODE as u64)?;
    let blocks = source.count(4 * TRIANGLES as u64)?;
    let leaves_of_one = f64::from_bits(source.number()?);
    let mut stored = Stored::new(nodes, blocks).map_err(|_| "does not fit into the memory")?;
    source.items(nodes, |node| stored.node(node))?;
    source.items(blocks, |block| stored.block(block))?;
    source.finish()?;
    stored
        .finish(meshes, leaves_of_one, options.isa)
        .map(Some)
        .ok_or_else(|| "is no sound structure".to_string())
}
