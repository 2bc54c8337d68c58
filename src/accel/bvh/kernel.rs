//! The two kernels and the prefetch, each in the form of the instruction set that is being compiled for.
#![allow(unsafe_code)]

#[cfg(target_arch = "x86_64")]
use super::avx;
use super::node::{Node, WIDTH};
use super::ray::Prepared;
use super::triangle::{Block, Met};
use crate::math::isa::Set;

/// [`Node::enter`].
#[inline(always)]
pub fn enter<S: Set>(node: &Node, rays: &Prepared, i: usize, tmax: f32) -> ([f32; WIDTH], u32) {
    #[cfg(target_arch = "x86_64")]
    if S::ISA != crate::math::isa::Isa::Baseline {
        // SAFETY: only `isa::run` names another set than the baseline, on machines that have it, and each has AVX2 and FMA.
        return unsafe { avx::enter(node, rays, i, tmax) };
    }
    node.enter(rays, i, tmax)
}

/// [`Block::meet`].
#[inline(always)]
pub fn meet<S: Set>(block: &Block, rays: &Prepared, i: usize, tmax: f32) -> Met {
    #[cfg(target_arch = "x86_64")]
    if S::ISA != crate::math::isa::Isa::Baseline {
        // SAFETY: as in `enter`.
        return unsafe { avx::meet(block, rays, i, tmax) };
    }
    block.meet::<S>(rays, i, tmax)
}

/// Starts loading the first `lines` cache lines of what `place` refers to, where there is an instruction for it.
#[inline(always)]
pub fn prefetch<T>(place: &T, lines: usize) {
    #[cfg(target_arch = "x86_64")]
    avx::prefetch(place, lines);
    #[cfg(not(target_arch = "x86_64"))]
    let _ = (place, lines);
}

/// Smaller memory gains nothing.
const WORTH_IT: usize = 4 << 20;

/// Asks for pages of 2 MiB where the system has them on request, as Linux mostly does: a ray goes from place to place in
/// tens of megabytes, and small pages would have to be looked up each time. A wish; nothing depends on its being granted.
pub fn prefer_huge_pages<T>(memory: &mut [std::mem::MaybeUninit<T>]) {
    #[cfg(target_os = "linux")]
    if size_of_val(memory) >= WORTH_IT {
        use rustix::mm::{Advice, madvise};
        let page = rustix::param::page_size();
        let first = memory.as_mut_ptr().cast::<u8>();
        let before = first.align_offset(page);
        let len = (size_of_val(memory) - before) / page * page;
        // SAFETY: whole pages within `memory`, which is borrowed; the advice does not change what they hold.
        let _ = unsafe { madvise(first.wrapping_add(before).cast(), len, Advice::LinuxHugepage) };
    }
    #[cfg(not(target_os = "linux"))]
    let _ = (memory, WORTH_IT);
}
