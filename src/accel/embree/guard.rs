//! Shared buffers that end at memory that must not be touched.
//!
//! A vertex is read by 16 bytes where it has 12, so the last one's read goes beyond the buffer. These tests put the
//! buffers at the end of readable memory: with the padding of [`Positions`] nothing happens, in any of Embree's
//! layouts and with any of its kernels; without it the process dies, which shows that the guard is on duty.
#![allow(unsafe_code)]

use super::device::Device;
use super::scene::{Buffers, Uncommitted};
use super::tests::isas;
use super::trace::{self, Way, Width};
use crate::accel::{Hits, LANES, MISS, Quality, Rays};
use crate::math::Vec3;
use crate::shape::Positions;
use rustix::mm::{MapFlags, MprotectFlags, ProtFlags, mmap_anonymous, mprotect, munmap};
use std::ffi::c_void;
use std::marker::PhantomData;
use std::os::unix::process::ExitStatusExt;
use std::ptr::null_mut;

/// Items whose last byte, `padding` bytes before it, is the last that may be read.
struct Guarded<T> {
    map: *mut c_void,
    bytes: usize,
    items: *const T,
    len: usize,
    of: PhantomData<T>,
}

impl<T: Copy> Guarded<T> {
    fn new(items: &[T], padding: usize) -> Self {
        let page = rustix::param::page_size();
        let used = size_of_val(items) + padding;
        let readable = used.next_multiple_of(page);
        let bytes = readable + page;
        // SAFETY: a new mapping at a place of the kernel's choice; the copy fits in front of the guard page, and
        // all items are multiples of 4 bytes, so that they stay aligned.
        unsafe {
            let map =
                mmap_anonymous(null_mut(), bytes, ProtFlags::READ | ProtFlags::WRITE, MapFlags::PRIVATE)
                    .expect("a mapping");
            mprotect(map.byte_add(readable), page, MprotectFlags::empty()).expect("a guard page");
            let at = map.byte_add(readable - used).cast::<T>();
            std::ptr::copy_nonoverlapping(items.as_ptr(), at, items.len());
            Guarded { map, bytes, items: at, len: items.len(), of: PhantomData }
        }
    }

    fn items(&self) -> &[T] {
        // SAFETY: written in `new`, mapped until `drop`.
        unsafe { std::slice::from_raw_parts(self.items, self.len) }
    }
}

impl<T> Drop for Guarded<T> {
    fn drop(&mut self) {
        // SAFETY: the mapping of `new`, whole.
        let _ = unsafe { munmap(self.map, self.bytes) };
    }
}

/// Builds over a strip of `vertices` vertices, the last of which ends `padding` bytes before the guard, and hits its
/// last triangle by every way.
fn build_and_trace(isa: &str, quality: Quality, compact: bool, vertices: u32, padding: usize) {
    let positions: Vec<[f32; 3]> = (0..vertices).map(|i| [i as f32, (i % 2) as f32, 0.0]).collect();
    let indices: Vec<[u32; 3]> = (0..vertices - 2).map(|i| [i, i + 1, i + 2]).collect();
    let (positions, indices) = (Guarded::new(&positions, padding), Guarded::new(&indices, 0));
    let device = Device::new(isa, 1, None).expect("a device");
    let mut uncommitted = Uncommitted::new(&device, quality, true, compact).expect("a scene");
    // SAFETY: true of the tests with enough padding; the other one is there to die.
    let buffers = unsafe { Buffers::padded(positions.items(), indices.items()) };
    uncommitted.attach(0, buffers).expect("attached");
    let scene = uncommitted.commit(&|_| true).expect("built");
    let mut rays = Rays::default();
    for lane in 0..LANES {
        let o = Vec3::new(vertices as f32 - 2.0, 0.5, 1.0);
        rays.set(lane, o, Vec3::NEG_Z, 0.0, f32::INFINITY);
    }
    for way in Way::ALL {
        let mut hits = Hits::default();
        let _ = trace::closest_by(way, &scene, Width::native(&device), rays.check(!0), &mut hits);
        assert!(hits.mesh.iter().all(|&m| m != MISS), "{isa} {way:?}");
        // Never for any-hit, where Embree may loop for ever: see `Way::for_occluded`.
        if way != Way::CoherentPacket {
            assert_eq!(trace::occluded_by(way, &scene, Width::native(&device), rays.check(!0)), !0);
        }
    }
}

#[test]
fn padded_buffers_at_the_end_of_memory_can_be_shared() {
    for isa in isas() {
        for (quality, compact) in [(Quality::Low, false), (Quality::Medium, false), (Quality::Medium, true)] {
            for vertices in [3, 4, 5, 342, 2000] {
                build_and_trace(isa, quality, compact, vertices, Positions::PADDING * 12);
            }
        }
    }
}

/// In a process of its own, this test dies of the read that the padding is for.
#[test]
fn without_padding_the_guard_is_hit() {
    const SIGSEGV: i32 = 11;
    if std::env::var_os("DRT_GUARD_DIES").is_some() {
        build_and_trace("sse2", Quality::Medium, false, 342, 0);
        return;
    }
    let this = std::env::current_exe().expect("a path");
    let output = std::process::Command::new(this)
        .args(["accel::embree::guard::without_padding_the_guard_is_hit", "--exact"])
        .env("DRT_GUARD_DIES", "1")
        .output()
        .expect("it runs");
    assert_eq!(output.status.signal(), Some(SIGSEGV), "{output:?}");
}
