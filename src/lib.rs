//! drt, a distribution ray tracer: one command turns a large OBJ mesh into a physically correct picture.
//!
//! This page is the architecture. The modules stand in the order of the data's way, which runs in one
//! direction; nothing on the left knows anything on the right:
//!
//! ```text
//! scene.toml / mesh.*   ──load──▶ Scene ──accel──▶ Intersector ──┐
//!       (text)                 (plain data)     (Embree | BVH)    │
//!                                                                 ▼
//! image files ◀──output── Image ◀──film── pixels ◀──render── Integrator (waves of paths)
//! ```
//!
//! `math, error, memory ◀ quadrature, shape ◀ accel, texture ◀ {bsdf, light, camera, sampler, film} ◀ scene ◀ load ◀ integrator ◀ render ◀ cli`; `output ◀ checkpoint ◀ render`
//!
//! | to find … | open |
//! |---|---|
//! | what happens at a path's vertices | [`integrator`], `path.rs`: in the order of the rendering equation, sixteen lanes at a time; one alone: `distribution.rs` |
//! | where camera rays are made | [`integrator`], `wave/start.rs`; of points by [`film::rule`] and [`camera`] |
//! | how hits become such lanes | [`integrator`], `batch.rs` and `wave/gather.rs` |
//! | how paths are kept in flight | [`integrator::wave`]: lanes, chunks of 16, compaction; it knows no physics |
//! | how a hit becomes a point with normals and an error bound | [`shape::Surface`] |
//! | one mesh in many places, things in motion | [`shape`], `instance.rs` and `motion.rs`; for rays: [`accel`], `instances/` |
//! | a picture on a surface: texels, filters, normals from heights | [`texture`]; its files: `load/texture` |
//! | how rays pass holes in surfaces | [`integrator`], `cutout.rs` |
//! | into how many paths samples split, and what a preview lacks | [`sampler`], `splits.rs`; who walks them: `path.rs` |
//! | which lamp is sampled, and where lamps are that move | [`light`], `tree.rs`, `lights.rs`, `lights/collect.rs` and `lights/instanced.rs` |
//! | where a room sees the sky | `light/openings.rs`, learnt by `integrator/explore.rs` |
//! | a BRDF, a light, a camera, a filter, a sampler | one file each in [`bsdf`], [`light`], [`camera`], [`film`], [`sampler`] |
//! | who intersects, and who judges | [`accel`]: the trait, Embree, our BVH, the f64 judge |
//! | which mesh formats there are | [`load`], `format.rs`: a format is a file and a row; packed files and standard input: `unpack.rs`, `input.rs` |
//! | how OBJ, MTL and scene files are read | [`load`] |
//! | which files an input may name | [`load::open`], `reach.rs` |
//! | what is kept of meshes from run to run | [`load::cache`] |
//! | how much memory there is, and what a picture needs | [`memory`], [`scene::need`] |
//! | what is wrong with a mesh file | [`check`]: counts, topology, materials, findings |
//! | what a picture file holds | [`output`], which sees only [`film::Image`] |
//! | how a render goes on after an interruption | [`checkpoint`] |
//! | how far two pictures are apart | [`compare`]: MSE, relMSE, PSNR, FLIP |
//! | the notes' rules of integration over [0, D], and over the hemisphere | [`quadrature`] |
//! | the notes' distRtShade | [`integrator`], `distribution.rs`; the rules for a pixel's points are in [`film::rule`] |
//! | who is right where two intersectors disagree | [`diff`]: recorded and aimed rays, the f64 court, reproducers |
//! | how fast a rule's error falls with the number of samples | [`converge`] |
//!
//! # Conventions
//! Right-handed, y up, metres; linear Rec.709 RGB; radiance in W/(m²·sr). `wo` points to the viewer and `wi`
//! to the light, both unit and away from the surface; `f_cos` is f·|cos θi|; `pdf` is per solid angle;
//! `ng`/`ns` are the geometric and the shading normal; `beta` is a path's throughput. Pixel (0, 0) is the
//! top left one.
//!
//! # Determinism
//! Every random number is a function of (seed, pixel, sample, dimension); waves are fixed tiles × fixed blocks
//! of samples of the whole picture; functions like sine are our own or the `libm` crate's. The same scene,
//! settings, backend and instruction set give the same bytes on any number of threads.
//!
//! # The library
//! The library never prints and never exits: progress, warnings and cancellation go through callbacks. A
//! picture in four calls (see `examples/library.rs` for a whole program):
//!
//! ```no_run
//! use drt::{load, output, render};
//!
//! # fn main() -> drt::error::Result<()> {
//! let loaded = load::scene("scenes/cornell-box.toml".as_ref(), load::Options::default())?;
//! let (scene, settings, hooks) = (&loaded.scene, &loaded.settings, render::Hooks::NONE);
//! let accel = render::build(scene, settings, None, &hooks)?;
//! let rendering = render::render(scene, settings, accel.as_ref(), None, &hooks)?;
//! output::write("picture.png".as_ref(), &rendering.image, &output::Options::default())?;
//! # Ok(())
//! # }
//! ```

// What a user brings is answered with an error: nothing here may give up, tests apart.
#![cfg_attr(
    not(test),
    warn(
        clippy::unwrap_used,
        clippy::expect_used,
        clippy::panic,
        clippy::unreachable,
        clippy::todo,
        clippy::unimplemented
    )
)]

pub mod error;
pub mod math;
pub mod memory;
pub mod quadrature;
pub mod shape;

pub mod accel;
pub mod bsdf;
pub mod camera;
pub mod film;
pub mod light;
pub mod sampler;
pub mod texture;

pub mod scene;

pub mod load;

pub mod output;

pub mod integrator;

pub mod checkpoint;

pub mod render;

pub mod compare;

pub mod converge;

pub mod diff;

pub mod check;
