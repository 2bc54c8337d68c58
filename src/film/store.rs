//! Per-pixel sums, kept by tile so that threads never share a pixel.
//!
//! Who traces a tile works on a copy of its own ([`Film::copy`], [`Film::put`]): what is in the film is always whole
//! blocks of samples, whoever looks and whenever a thread is stopped.

mod saved;

pub use saved::Saved;

use super::{Channel, Data, Image};
use crate::error::{Error, Result, unknown_word_advice};
use crate::math::{DVec3, Rgb, Vec2, Vec3};
use std::sync::Mutex;

/// A layer of the first hit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Aov {
    /// Distance along the ray in metres: the mean over the samples that hit; +∞ where none did.
    Depth,
    /// Shading normal in world coordinates: the mean over the samples that hit.
    Normal,
    /// Reflectance: the mean over the samples that hit.
    Albedo,
    /// Position in the file's own coordinates: the mean over the samples that hit.
    Position,
    /// Texture coordinates: the mean over the samples that hit.
    Uv,
    /// Mesh, triangle and material of sample 0, exactly; [`u32::MAX`] where it hit nothing.
    Ids,
}

impl Aov {
    /// Every layer.
    pub const ALL: [Aov; 6] = [Aov::Depth, Aov::Normal, Aov::Albedo, Aov::Position, Aov::Uv, Aov::Ids];

    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Aov::Depth => "depth",
            Aov::Normal => "normal",
            Aov::Albedo => "albedo",
            Aov::Position => "position",
            Aov::Uv => "uv",
            Aov::Ids => "ids",
        }
    }

    /// The layer of that name.
    pub fn from_name(word: &str) -> Result<Aov> {
        Aov::ALL.into_iter().find(|a| a.name() == word).ok_or_else(|| {
            Error::usage(format!("unknown layer \"{word}\""))
                .advise(unknown_word_advice(word, &Aov::ALL.map(Aov::name)))
        })
    }
}

/// What the first hit of a sample adds to the layers.
#[derive(Clone, Copy, Debug)]
pub struct FirstHit {
    /// Distance along the ray in metres.
    pub depth: f32,
    /// Shading normal.
    pub normal: Vec3,
    /// Reflectance.
    pub albedo: Rgb,
    /// Position in scene coordinates.
    pub position: Vec3,
    /// Texture coordinates.
    pub uv: Vec2,
    /// Mesh, triangle and material.
    pub ids: [u32; 3],
}

/// Sums of one pixel.
#[derive(Clone, Copy, Debug)]
struct Pixel {
    radiance: [f64; 3],
    weight: f64,
    samples: u32,
}

impl Pixel {
    /// What samples are divided by: what they count together, by `total`; under a filter with negative lobes the sum of their
    /// weights, which keeps a constant picture exact, unless too few samples make that sum small.
    fn divisor(&self, signed: bool, total: &dyn Fn(u32) -> f64) -> f64 {
        let total = total(self.samples);
        if signed && self.weight > 0.25 * total { self.weight } else { total }
    }
}

/// Layer sums of one pixel.
#[derive(Clone, Copy, Debug)]
struct Layers {
    hits: u32,
    /// Depth, normal, albedo, position, uv.
    sums: [f64; 12],
    ids: [u32; 3],
}

/// The sums of one tile of [`Film::TILE`]² pixels.
#[derive(Debug, Default)]
pub struct Tile {
    pixels: Vec<Pixel>,
    layers: Vec<Layers>,
}

impl Tile {
    /// Samples that each of its pixels has.
    pub fn samples(&self) -> u32 {
        // The first one of every tile is inside the picture.
        self.pixels.first().map_or(0, |pixel| pixel.samples)
    }

    /// An empty tile; `None` where there is no memory for it.
    fn new(layers: bool) -> Option<Tile> {
        let pixels = (Film::TILE * Film::TILE) as usize;
        let mut tile = Tile::default();
        tile.pixels.try_reserve_exact(pixels).ok()?;
        tile.pixels.resize(pixels, Pixel { radiance: [0.0; 3], weight: 0.0, samples: 0 });
        if layers {
            tile.layers.try_reserve_exact(pixels).ok()?;
            tile.layers.resize(pixels, Layers { hits: 0, sums: [0.0; 12], ids: [u32::MAX; 3] });
        }
        Some(tile)
    }

    /// Becomes what `other` is, in the memory that it has.
    fn become_as(&mut self, other: &Tile) {
        self.pixels.clone_from(&other.pixels);
        self.layers.clone_from(&other.layers);
    }

    /// Adds a sample's radiance with its weight (the filter's, of mean 1, times what the sample counts) to the pixel of that
    /// index in the tile (row by row). Unless it is `new`, the sample is there already, and this is the light of further
    /// paths.
    #[inline]
    pub fn add(&mut self, pixel: usize, radiance: DVec3, weight: f32, new: bool) {
        let p = &mut self.pixels[pixel];
        let weight = f64::from(weight);
        p.radiance[0] += radiance.x * weight;
        p.radiance[1] += radiance.y * weight;
        p.radiance[2] += radiance.z * weight;
        p.weight += weight;
        p.samples += u32::from(new);
    }

    /// Adds the first hit of sample `index`; does nothing when no layer was asked for.
    #[inline]
    pub fn add_first_hit(&mut self, pixel: usize, index: u32, hit: &FirstHit) {
        let Some(layers) = self.layers.get_mut(pixel) else { return };
        layers.hits += 1;
        let (n, a, p, t) = (hit.normal, hit.albedo, hit.position, hit.uv);
        let values = [hit.depth, n.x, n.y, n.z, a.x, a.y, a.z, p.x, p.y, p.z, t.x, t.y];
        for (sum, value) in layers.sums.iter_mut().zip(values) {
            *sum += f64::from(value);
        }
        if index == 0 {
            layers.ids = hit.ids;
        }
    }
}

/// What a picture is developed with.
#[derive(Clone)]
pub struct Develop<'a> {
    /// The part that is wanted: x, y, width, height.
    pub crop: [u32; 4],
    /// The layers that are wanted.
    pub aovs: &'a [Aov],
    /// The scene's origin in file coordinates.
    pub origin: DVec3,
    /// What the colours are multiplied by: 1 for radiance, the pixel's area |Δi·Δj| for the flux of eq. (6).
    pub area: f64,
    /// What the first so many samples of a pixel count together.
    pub total: &'a dyn Fn(u32) -> f64,
    /// The `drt` attribute.
    pub settings: String,
}

/// What the film holds of a tile.
#[derive(Debug)]
struct Place {
    now: Tile,
    /// What it was before a last block that was cut short by the number of samples; empty where that is not kept.
    before: Tile,
}

/// All tiles of a picture.
#[derive(Debug)]
pub struct Film {
    size: [u32; 2],
    tiles: [u32; 2],
    store: Vec<Mutex<Place>>,
    signed: bool,
}

/// What a film is for.
#[derive(Clone, Copy, Debug)]
pub struct FilmUse {
    /// Room for layers.
    pub layers: bool,
    /// Weights may be negative.
    pub signed: bool,
    /// What tiles were before their last block is kept, see [`Film::put`].
    pub keeps: bool,
}

impl Film {
    /// Pixels along a tile's edge. Waves are made of whole tiles, so this is part of what a picture's bytes
    /// depend on.
    pub const TILE: u32 = 8;

    /// An empty film of `size` pixels.
    ///
    /// # Errors
    /// Not enough memory.
    pub fn new(size: [u32; 2], of: FilmUse) -> Result<Film> {
        let tiles = size.map(|s| s.div_ceil(Self::TILE));
        let count = tiles[0] as usize * tiles[1] as usize;
        let mut store = Vec::new();
        let none = || Error::new(format!("not enough memory for a picture of {}×{}", size[0], size[1]));
        store.try_reserve_exact(count).map_err(|_| none())?;
        for _ in 0..count {
            let now = Tile::new(of.layers).ok_or_else(none)?;
            let before = if of.keeps { Tile::new(of.layers).ok_or_else(none)? } else { Tile::default() };
            store.push(Mutex::new(Place { now, before }));
        }
        Ok(Film { size, tiles, store, signed: of.signed })
    }

    /// Number of tiles along x and y.
    pub fn tiles(&self) -> [u32; 2] {
        self.tiles
    }

    fn with<R>(&self, tile: usize, f: impl FnOnce(&mut Place) -> R) -> R {
        // A panic elsewhere cannot leave a tile half copied, so a poisoned lock is still good.
        f(&mut self.store[tile].lock().unwrap_or_else(|poisoned| poisoned.into_inner()))
    }

    /// Samples that each pixel of a tile has.
    pub fn samples_of(&self, tile: usize) -> u32 {
        self.with(tile, |place| place.now.samples())
    }

    /// Copies a tile (counted row by row) to work on it.
    pub fn copy(&self, tile: usize, into: &mut Tile) {
        self.with(tile, |place| into.become_as(&place.now));
    }

    /// Puts a tile back with a block of samples more. `last`: the block was cut short, so that who wants more samples
    /// later has to trace it again; what the tile was is kept if the film was made for that.
    pub fn put(&self, tile: usize, new: &Tile, last: bool) {
        self.with(tile, |place| {
            if last && !place.before.pixels.is_empty() {
                std::mem::swap(&mut place.now, &mut place.before);
            }
            place.now.become_as(new);
        });
    }

    /// The smallest and largest number of samples that a pixel of `crop` has.
    pub fn samples_done(&self, crop: [u32; 4]) -> (u32, u32) {
        let counts = self.collect(crop, |tile, i| tile.pixels[i].samples);
        (counts.iter().min().copied().unwrap_or(0), counts.iter().max().copied().unwrap_or(0))
    }

    /// One value a pixel of `crop` (x, y, width, height), row by row.
    fn collect<T>(&self, crop: [u32; 4], value: impl Fn(&Tile, usize) -> T) -> Vec<T> {
        let [x0, y0, w, h] = crop;
        let mut out = Vec::with_capacity(w as usize * h as usize);
        for y in y0..y0 + h {
            for x in x0..x0 + w {
                let tile = (y / Self::TILE) as usize * self.tiles[0] as usize + (x / Self::TILE) as usize;
                let pixel = ((y % Self::TILE) * Self::TILE + x % Self::TILE) as usize;
                out.push(self.with(tile, |place| value(&place.now, pixel)));
            }
        }
        out
    }

    /// The picture: means of what was added, with the layers asked for.
    pub fn develop(&self, how: Develop<'_>) -> Image {
        let crop = how.crop;
        let colours = self.collect(crop, |tile, i| {
            let p = &tile.pixels[i];
            let mean = |sum: f64| (sum / p.divisor(self.signed, how.total)) as f32;
            // Rounded before it is scaled, so that flux is what the radiance of a file gives.
            p.radiance.map(|sum| if p.samples > 0 { (f64::from(mean(sum)) * how.area) as f32 } else { 0.0 })
        });
        let mut image = Image::from_rgb(crop[2], crop[3], &colours, how.settings);
        image.offset = [crop[0], crop[1]];
        image.full_size = self.size;
        for aov in Aov::ALL.into_iter().filter(|a| how.aovs.contains(a)) {
            self.develop_layer(crop, aov, how.origin, &mut image);
        }
        image
    }

    fn develop_layer(&self, crop: [u32; 4], aov: Aov, origin: DVec3, image: &mut Image) {
        let (names, first): (&[&str], usize) = match aov {
            Aov::Depth => (&["depth.Z"], 0),
            Aov::Normal => (&["normal.X", "normal.Y", "normal.Z"], 1),
            Aov::Albedo => (&["albedo.R", "albedo.G", "albedo.B"], 4),
            Aov::Position => (&["position.X", "position.Y", "position.Z"], 7),
            Aov::Uv => (&["uv.U", "uv.V"], 10),
            Aov::Ids => (&["id.mesh", "id.triangle", "id.material"], 0),
        };
        for (k, name) in names.iter().enumerate() {
            let data = if aov == Aov::Ids {
                Data::U32(self.collect(crop, |tile, i| tile.layers[i].ids[k]))
            } else {
                let miss = if aov == Aov::Depth { f32::INFINITY } else { 0.0 };
                let offset = if aov == Aov::Position { origin[k] } else { 0.0 };
                Data::F32(self.collect(crop, |tile, i| {
                    let l = &tile.layers[i];
                    if l.hits == 0 { miss } else { (l.sums[first + k] / f64::from(l.hits) + offset) as f32 }
                }))
            };
            image.channels.push(Channel { name: (*name).to_string(), data });
        }
    }
}
