//! Tiles as bytes, for checkpoints: whole blocks of samples, and beside them a last block that was cut short.
//!
//! A tile is its number of samples in whole blocks, its number of samples in all, and the sums of each if there are
//! any: of each pixel four f64 (radiance and weight), and with layers twelve f64 and four u32 more. Little-endian.

use super::{Film, Layers, Tile};
use crate::error::{Error, Result};
use std::io::Read;

/// Bytes of a pixel's sums.
const PIXEL_BYTES: usize = 4 * 8;
/// Bytes of a pixel's layers.
const LAYER_BYTES: usize = 12 * 8 + 4 * 4;

/// A tile that was read.
#[derive(Debug)]
pub struct Saved {
    /// After its last whole block.
    whole: Tile,
    /// After a block that was cut short.
    all: Option<Tile>,
}

impl Saved {
    /// Samples of a pixel in whole blocks.
    pub fn whole(&self) -> u32 {
        self.whole.samples()
    }

    /// Samples of a pixel.
    pub fn all(&self) -> u32 {
        self.all.as_ref().map_or(self.whole(), Tile::samples)
    }

    /// Reads a tile.
    ///
    /// # Errors
    /// The end of the input; not enough memory; more samples in whole blocks than in all.
    pub fn read(from: &mut impl Read, layers: bool) -> Result<Saved> {
        let [whole, all] = [word(from)?, word(from)?];
        if whole > all {
            return Err(Error::new("a tile with fewer samples than its blocks have"));
        }
        let mut read = |samples: u32| -> Result<Tile> {
            let mut tile = Tile::new(layers).ok_or_else(|| Error::new("not enough memory for a tile"))?;
            if samples > 0 {
                tile.read(from, samples)?;
            }
            Ok(tile)
        };
        let of_blocks = read(whole)?;
        let beyond = if all > whole { Some(read(all)?) } else { None };
        Ok(Saved { whole: of_blocks, all: beyond })
    }
}

impl Film {
    /// Adds a tile's bytes to `bytes`. `whole`: whether so many samples are whole blocks; a tile that has others is
    /// saved with what it was before, if the film keeps that.
    pub fn save(&self, tile: usize, whole: impl Fn(u32) -> bool, bytes: &mut Vec<u8>) {
        self.with(tile, |place| {
            let (now, before) = (&place.now, &place.before);
            let all = now.samples();
            let of_blocks = if whole(all) { now } else { before };
            for samples in [of_blocks.samples(), all] {
                bytes.extend_from_slice(&samples.to_le_bytes());
            }
            for (tile, is_there) in [(of_blocks, of_blocks.samples() > 0), (now, !whole(all))] {
                if is_there {
                    tile.write(bytes);
                }
            }
        });
    }

    /// Puts a saved tile into the film, as far as a picture of `spp` samples can use it: with all of them, or else
    /// those of whole blocks. False when it has more.
    pub fn restore(&self, tile: usize, saved: Saved, spp: u32) -> bool {
        let Saved { mut whole, all } = saved;
        if whole.samples() > spp {
            return false;
        }
        self.clip(tile, &mut whole);
        self.with(tile, |place| match all {
            Some(mut all) if all.samples() == spp => {
                self.clip(tile, &mut all);
                if !place.before.pixels.is_empty() {
                    place.before = whole;
                }
                place.now = all;
            }
            _ => place.now = whole,
        });
        true
    }

    /// The pixels of a tile that are outside the picture have no samples.
    fn clip(&self, tile: usize, sums: &mut Tile) {
        let [column, row] = [tile as u32 % self.tiles[0], tile as u32 / self.tiles[0]];
        let right = self.size[0].saturating_sub(column * Film::TILE);
        let bottom = self.size[1].saturating_sub(row * Film::TILE);
        for (i, pixel) in (0u32..).zip(&mut sums.pixels) {
            if i % Film::TILE >= right || i / Film::TILE >= bottom {
                pixel.samples = 0;
            }
        }
    }
}

impl Tile {
    fn write(&self, bytes: &mut Vec<u8>) {
        for pixel in &self.pixels {
            let [r, g, b] = pixel.radiance;
            for sum in [r, g, b, pixel.weight] {
                bytes.extend_from_slice(&sum.to_le_bytes());
            }
        }
        for layers in &self.layers {
            let Layers { hits, sums, ids: [mesh, triangle, material] } = *layers;
            for sum in sums {
                bytes.extend_from_slice(&sum.to_le_bytes());
            }
            for number in [hits, mesh, triangle, material] {
                bytes.extend_from_slice(&number.to_le_bytes());
            }
        }
    }

    fn read(&mut self, from: &mut impl Read, samples: u32) -> Result<()> {
        for pixel in &mut self.pixels {
            let mut bytes = [0; PIXEL_BYTES];
            fill(from, &mut bytes)?;
            let mut sums = bytes.chunks_exact(8).map(f64_of);
            let mut next = || sums.next().unwrap_or_default();
            pixel.radiance = [next(), next(), next()];
            pixel.weight = next();
            pixel.samples = samples;
        }
        for layers in &mut self.layers {
            let mut bytes = [0; LAYER_BYTES];
            fill(from, &mut bytes)?;
            let (sums, numbers) = bytes.split_at(12 * 8);
            for (sum, bytes) in layers.sums.iter_mut().zip(sums.chunks_exact(8)) {
                *sum = f64_of(bytes);
            }
            let mut numbers = numbers.chunks_exact(4).map(u32_of);
            let mut next = || numbers.next().unwrap_or_default();
            layers.hits = next();
            layers.ids = [next(), next(), next()];
        }
        Ok(())
    }
}

fn f64_of(bytes: &[u8]) -> f64 {
    bytes.try_into().map_or(0.0, f64::from_le_bytes)
}

fn u32_of(bytes: &[u8]) -> u32 {
    bytes.try_into().map_or(0, u32::from_le_bytes)
}

fn word(from: &mut impl Read) -> Result<u32> {
    let mut bytes = [0; 4];
    fill(from, &mut bytes)?;
    Ok(u32::from_le_bytes(bytes))
}

/// Fills `bytes`.
///
/// # Errors
/// The end of the input, or its own.
fn fill(from: &mut impl Read, bytes: &mut [u8]) -> Result<()> {
    from.read_exact(bytes).map_err(|e| match e.kind() {
        std::io::ErrorKind::UnexpectedEof => Error::new("the file is cut short"),
        _ => Error::new(format!("cannot read: {e}")),
    })
}
