//! The render loop: tiles × blocks of samples in parallel, pass by pass.

use super::keep::{Keep, Keeper};
use super::{Hooks, Progress, Rendering, record};
use crate::accel::Intersector;
use crate::error::{Error, Result};
use crate::film::{Develop, Film, FilmUse, Tile, block, is_whole};
use crate::integrator::wave::{Job, Wave};
use crate::integrator::{Context, Integrator, RenderStats};
use crate::math::isa::{self, Isa, Kernel};
use crate::memory;
use crate::sampler::PREVIEW;
use crate::scene::need::developed;
use crate::scene::{Quantity, Scene, Settings};
use rayon::prelude::*;
use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};

/// A picture to be rendered.
pub struct Picture<'a> {
    pub scene: &'a Scene,
    pub settings: &'a Settings,
    pub accel: &'a dyn Intersector,
    pub isa: Isa,
    pub hooks: &'a Hooks<'a>,
    pub keep: Option<&'a Keep<'a>>,
}

impl Picture<'_> {
    /// Renders it.
    ///
    /// # Errors
    /// As [`super::render_kept`].
    pub fn render<I: Integrator>(&self, integrator: &I) -> Result<Rendering> {
        let s = self.settings;
        let mut cx = Context::new(self.scene, s)?;
        if let Some(grid) = s.rule.grid()
            && grid.points() != u64::from(s.spp)
        {
            return Err(Error::new(format!(
                "{} points of the pixel rule do not make {} samples a pixel",
                grid.points(),
                s.spp
            )));
        }
        let keeps = self.keep.is_some() && !is_whole(s.spp);
        let film =
            Film::new(s.size, FilmUse { layers: !s.aovs.is_empty(), signed: cx.pixel.is_signed(), keeps })?;
        // What the end needs is asked for before the first sample, not after the last.
        memory::probe(developed(s) as usize + memory::HEADROOM)
            .map_err(|_| Error::new("not enough memory for the picture").advise("take a smaller --size"))?;
        cx.look_out(s, self.accel, self.hooks.stop);
        let crop = s.crop.unwrap_or([0, 0, s.size[0], s.size[1]]);
        let tiles = touched_tiles(crop, film.tiles()[0]);
        let done = AtomicU64::new(0);
        let keeper = match self.keep {
            Some(keep) => Some(Keeper::new(keep, self, &film, &tiles, &done)?),
            None => None,
        };
        let restored: u64 = tiles.iter().map(|&tile| u64::from(film.samples_of(tile))).sum();
        done.store(restored * TILE_PIXELS, Ordering::Relaxed);
        let work = AtomicU64::new(tiles.iter().map(|&tile| work(&cx, film.samples_of(tile))).sum());
        let (film, tiles, done) = (&film, &tiles[..], &done);
        let job = Passes { picture: self, cx: &cx, integrator, film, tiles, done, work: &work };
        let (stats, complete) = match &keeper {
            Some(keeper) => keeper.while_saving(|| job.run())?,
            None => job.run(),
        };
        let settings = record::attribute(s, self.scene, self.accel, film.samples_done(crop));
        let area = match s.quantity {
            Quantity::Radiance => 1.0,
            Quantity::Flux => self.scene.camera.window.pixel_area(s.size),
        };
        let samples = done.load(Ordering::Relaxed) as f64 / (tiles.len() as u64 * TILE_PIXELS).max(1) as f64;
        let (origin, total) = (self.scene.origin, |samples| cx.splits.total_weight(samples));
        let image = film.develop(Develop { crop, aovs: &s.aovs, origin, area, total: &total, settings });
        Ok(Rendering { image, stats, samples, complete })
    }
}

const TILE_PIXELS: u64 = (Film::TILE * Film::TILE) as u64;

/// All blocks of samples over the picture.
struct Passes<'a, I> {
    picture: &'a Picture<'a>,
    cx: &'a Context<'a>,
    integrator: &'a I,
    film: &'a Film,
    tiles: &'a [usize],
    /// Samples of all pixels of all tiles.
    done: &'a AtomicU64,
    /// Their [`work`].
    work: &'a AtomicU64,
}

/// What the first `samples` of a pixel cost, about: a camera ray each, and their paths.
fn work(cx: &Context<'_>, samples: u32) -> u64 {
    u64::from(samples) + cx.splits.before(samples)
}

/// What a thread works with.
#[derive(Default)]
struct Bench {
    wave: Wave,
    tile: Tile,
}

impl<I: Integrator> Passes<'_, I> {
    /// Traces what the film has not yet; false when it was stopped.
    fn run(&self) -> (RenderStats, bool) {
        let spp = self.picture.settings.spp;
        let mut stats = RenderStats::default();
        for samples in (0..).map(block).take_while(|b| b.start < spp) {
            let (of_pass, complete) = self.pass(samples.start..samples.end.min(spp), samples.end > spp);
            stats = stats.plus(&of_pass);
            if !complete {
                return (stats, false);
            }
        }
        (stats, true)
    }

    /// One block of samples over all tiles, in parallel; `cut`: it is shorter than blocks are.
    fn pass(&self, samples: Range<u32>, cut: bool) -> (RenderStats, bool) {
        let tile = |bench: &mut Bench, &tile: &usize| self.tile(bench, tile, samples.clone(), cut);
        self.tiles
            .par_iter()
            .map_init(Bench::default, tile)
            .reduce(|| (RenderStats::default(), true), |a, b| (a.0.plus(&b.0), a.1 && b.1))
    }

    fn tile(&self, bench: &mut Bench, tile: usize, samples: Range<u32>, cut: bool) -> (RenderStats, bool) {
        let Picture { settings, accel, isa, hooks, .. } = *self.picture;
        if self.film.samples_of(tile) >= samples.end {
            return (RenderStats::default(), true);
        }
        if (hooks.stop)() {
            return (RenderStats::default(), false);
        }
        let columns = self.film.tiles()[0] as usize;
        let count = samples.len() as u64;
        let added = work(self.cx, samples.end) - work(self.cx, samples.start);
        let splits = self.cx.splits;
        let lacking = splits.lacking(samples.start).map(|part| (0..PREVIEW, part));
        let begun = splits.begun(samples.start);
        self.film.copy(tile, &mut bench.tile);
        let Bench { wave, tile: sums } = bench;
        let is_done = lacking.into_iter().chain([(samples, begun)]).all(|(samples, part)| {
            let job = Job {
                cx: self.cx,
                integrator: self.integrator,
                accel,
                tile: [(tile % columns) as u32, (tile / columns) as u32],
                samples,
                part,
                layers: !settings.aovs.is_empty() && !part.again,
                stop: hooks.stop,
            };
            isa::run(isa, TileKernel { wave, job: &job, tile: sums })
        });
        if is_done {
            self.film.put(tile, sums, cut);
            let done = self.done.fetch_add(count * TILE_PIXELS, Ordering::Relaxed) + count * TILE_PIXELS;
            let total = self.tiles.len() as u64 * TILE_PIXELS * u64::from(settings.spp);
            let whole = self.tiles.len() as u64 * work(self.cx, settings.spp);
            let share = (self.work.fetch_add(added, Ordering::Relaxed) + added) as f64 / whole as f64;
            (hooks.progress)(Progress::Render { done, total, share });
        }
        (wave.take_stats(), is_done)
    }
}

/// A wave, compiled per instruction set.
struct TileKernel<'a, I> {
    wave: &'a mut Wave,
    job: &'a Job<'a, I>,
    tile: &'a mut Tile,
}

impl<I: Integrator> Kernel for TileKernel<'_, I> {
    type Output = bool;
    #[inline(always)]
    fn run<S: isa::Set>(self) -> bool {
        self.wave.run(self.job, self.tile)
    }
}

/// The tiles that `crop` touches, counted row by row in a picture of so many columns; whole tiles are traced, so that a
/// crop's pixels are those of the full picture.
fn touched_tiles([x, y, w, h]: [u32; 4], columns: u32) -> Vec<usize> {
    let range = |start: u32, length: u32| start / Film::TILE..(start + length).div_ceil(Film::TILE);
    let at = |row: u32, column: u32| row as usize * columns as usize + column as usize;
    range(y, h).flat_map(|row| range(x, w).map(move |column| at(row, column))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Samples of a preview get further paths when the block after them is begun.
    #[test]
    fn a_preview_is_whole_blocks() {
        assert!((0..4).any(|k| block(k).start == PREVIEW));
    }

    #[test]
    fn a_crop_touches_whole_tiles() {
        assert_eq!(touched_tiles([0, 0, 8, 8], 10), [0]);
        assert_eq!(touched_tiles([7, 15, 2, 1], 10), [10, 11]);
    }
}
