//! What the tasks of a build leave behind, and how it becomes one tree.

use super::bounds::Bounds;
use super::node::{Child, Node};
use super::triangle::{BLOCK, Block};
use crate::accel::{BuildOptions, cancelled};
use crate::error::{Error, Result};
use crate::memory;
use crate::shape::Mesh;
use rayon::prelude::*;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// Reserves room for `more` elements, or says that memory ran out.
pub fn reserve<T>(vec: &mut Vec<T>, more: usize) -> Result<()> {
    memory::reserve(vec, more).map_err(|_| {
        let mib = (more * size_of::<T>()) >> 20;
        Error::new(format!("not enough memory for the acceleration structure ({mib} MiB more were needed)"))
            .advise("use a smaller mesh or a machine with more memory")
    })?;
    super::kernel::prefer_huge_pages(vec.spare_capacity_mut());
    Ok(())
}

/// Tells the caller how far a build is, and the tasks whether to go on.
pub struct Progress<'a> {
    total: usize,
    done: AtomicUsize,
    stopped: AtomicBool,
    each: &'a (dyn Fn(f64) -> bool + Sync),
}

impl<'a> Progress<'a> {
    /// Of `total` triangles, none is done.
    pub fn new(total: usize, options: &BuildOptions<'a>) -> Self {
        let (done, stopped) = (AtomicUsize::new(0), AtomicBool::new(false));
        Progress { total, done, stopped, each: options.progress }
    }

    /// Counts finished triangles and asks whether to go on.
    pub fn report(&self, finished: usize) -> Result<()> {
        let done = self.done.fetch_add(finished, Ordering::Relaxed) + finished;
        let share = if self.total == 0 { 1.0 } else { (done as f64 / self.total as f64).min(1.0) };
        if self.stopped.load(Ordering::Relaxed) || !(self.each)(share) {
            self.stopped.store(true, Ordering::Relaxed);
            return Err(cancelled());
        }
        Ok(())
    }
}

/// A finished piece of the tree: nodes, and per block the first reference and the number of triangles.
#[derive(Default)]
pub struct Part {
    /// Nodes.
    pub nodes: Vec<Node>,
    /// First reference and number of triangles of each block.
    pub spans: Vec<(u32, u32)>,
}

/// The tree above the tasks.
pub enum Tree {
    /// A leaf over these references.
    Leaf {
        /// Index of the first.
        first: usize,
        /// How many.
        len: usize,
    },
    /// What one task built; its node 0 is the root.
    Part(Part),
    /// A node's children and the boxes around them.
    Node(Vec<(Bounds, Tree)>),
}

impl Part {
    /// Adds the blocks of a leaf.
    pub fn leaf(&mut self, first: usize, len: usize) -> Child {
        let child = Child::leaf(self.spans.len(), len.div_ceil(BLOCK));
        for start in (0..len).step_by(BLOCK) {
            self.spans.push(((first + start) as u32, BLOCK.min(len - start) as u32));
        }
        child
    }
}

impl Tree {
    /// All nodes in one piece, depth first, and freed where they were. The blocks are those of [`Tree::spans`].
    pub fn join(self) -> Result<Vec<Node>> {
        let mut nodes = Vec::new();
        reserve(&mut nodes, self.size().0)?;
        self.append(&mut nodes, &mut 0);
        Ok(nodes)
    }

    /// Appends its nodes to `nodes`; `blocks` are there already.
    fn append(self, nodes: &mut Vec<Node>, blocks: &mut usize) -> Child {
        match self {
            Tree::Leaf { len, .. } => {
                let child = Child::leaf(*blocks, len.div_ceil(BLOCK));
                *blocks += len.div_ceil(BLOCK);
                child
            }
            Tree::Part(part) => {
                let before = nodes.len();
                nodes.extend(part.nodes.into_iter().map(|mut node| {
                    node.children = node.children.map(|c| c.moved(before, *blocks));
                    node
                }));
                *blocks += part.spans.len();
                Child::node(before)
            }
            Tree::Node(children) => {
                let index = nodes.len();
                nodes.push(Node::EMPTY);
                for (slot, (bounds, child)) in children.into_iter().enumerate() {
                    let child = child.append(nodes, blocks);
                    nodes[index].set(slot, &bounds, child);
                }
                Child::node(index)
            }
        }
    }

    /// The spans of all blocks, in the order in which [`Tree::join`] counts them.
    pub fn spans(&self) -> Result<Vec<(u32, u32)>> {
        let mut all = Part::default();
        reserve(&mut all.spans, self.size().1)?;
        self.append_spans(&mut all);
        Ok(all.spans)
    }

    fn append_spans(&self, all: &mut Part) {
        match self {
            Tree::Leaf { first, len } => {
                all.leaf(*first, *len);
            }
            Tree::Part(part) => all.spans.extend_from_slice(&part.spans),
            Tree::Node(children) => children.iter().for_each(|(_, child)| child.append_spans(all)),
        }
    }

    /// Numbers of nodes and blocks.
    fn size(&self) -> (usize, usize) {
        match self {
            Tree::Leaf { len, .. } => (0, len.div_ceil(BLOCK)),
            Tree::Part(part) => (part.nodes.len(), part.spans.len()),
            Tree::Node(children) => children.iter().fold((1, 0), |(n, b), (_, child)| {
                let (more_nodes, more_blocks) = child.size();
                (n + more_nodes, b + more_blocks)
            }),
        }
    }
}

/// Copies the triangles into their blocks; `ids` tells mesh and triangle of a reference.
pub fn fill_blocks(
    meshes: &[Arc<Mesh>],
    ids: impl Fn(usize) -> (u32, u32) + Sync,
    spans: &[(u32, u32)],
) -> Result<Vec<Block>> {
    let mut blocks = Vec::new();
    reserve(&mut blocks, spans.len())?;
    blocks.par_extend(spans.par_iter().map(|&(first, len)| {
        let mut block = Block::EMPTY;
        for lane in 0..len as usize {
            let (mesh, triangle) = ids(first as usize + lane);
            let corners = meshes[mesh as usize].triangle(triangle as usize);
            block.set(lane, corners.map(|p| p.to_array()), mesh, triangle);
        }
        block
    }));
    Ok(blocks)
}
