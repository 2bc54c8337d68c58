//! Pictures on surfaces. A [`Texture`] is a picture with the way it is laid over texture coordinates; it knows
//! no files and no materials.
//!
//! (0, 0) of the texture coordinates is the picture's bottom left corner and (1, 1) its top right one, as in OBJ
//! files. The centre of texel (i, j), counted from the top left, is at ((i + ½)/w, 1 − (j + ½)/h). Values are
//! linear; filtering happens after decoding.

mod lookup;
mod opacity;
mod relief;
#[cfg(test)]
mod tests;
mod texels;

pub use lookup::{Filter, Wrap};
pub use opacity::Opacity;
pub use relief::{Relief, Shape, Tangents};
pub use texels::{Data, Texels, Transfer};

use crate::math::digest::Digest;
use crate::math::{DVec3, Rgb, Vec2, luminance};
use std::sync::Arc;
use texels::Decoder;

/// Which part of a picture a number is taken from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Channel {
    /// Red, or the grey of a picture without colours.
    Red,
    /// Green.
    Green,
    /// Blue.
    Blue,
    /// Alpha; 1 where the picture has none.
    Alpha,
    /// Rec.709 luminance.
    Luminance,
}

/// How a picture is laid over texture coordinates, and what is made of its values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mapping {
    /// What happens between texels.
    pub filter: Filter,
    /// What happens outside the unit square.
    pub wrap: Wrap,
    /// Texture coordinates times this …
    pub scale: [f32; 2],
    /// … plus this.
    pub offset: [f32; 2],
    /// What codes mean.
    pub transfer: Transfer,
    /// One channel instead of the colour.
    pub channel: Option<Channel>,
    /// Values times this …
    pub gain: Rgb,
    /// … plus this.
    pub base: Rgb,
}

impl Mapping {
    /// The picture once over the unit square, repeated outside, its values as they are.
    pub fn plain(transfer: Transfer) -> Mapping {
        Mapping {
            filter: Filter::Bilinear,
            wrap: Wrap::Repeat,
            scale: [1.0; 2],
            offset: [0.0; 2],
            transfer,
            channel: None,
            gain: Rgb::ONE,
            base: Rgb::ZERO,
        }
    }
}

/// A tile of a UDIM set: its number, 1001 + column + 10·row, and its picture.
pub type Tile = (u32, Arc<Texels>);

/// Pictures and what is read from them, for as long as the pictures live.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct MeanKey(usize, Transfer, Option<Channel>);

/// The tiles of a UDIM set by number, ascending; at least one.
#[derive(Clone, Debug)]
pub struct Tiles(Arc<[Tile]>);

impl Tiles {
    /// A set; `None` without tiles. All must store their texels alike: those that differ from the first are left out.
    pub fn new(mut tiles: Vec<Tile>) -> Option<Tiles> {
        tiles.sort_by_key(|tile| tile.0);
        let first = tiles.first()?.1.clone();
        tiles.retain(|tile| std::mem::discriminant(tile.1.data()) == std::mem::discriminant(first.data()));
        Some(Tiles(tiles.into()))
    }
}

/// The pictures of a texture.
#[derive(Clone, Debug)]
enum Pictures {
    One(Arc<Texels>),
    Tiles(Tiles),
}

/// A picture, or a UDIM set of them, on a surface.
#[derive(Clone, Debug)]
pub struct Texture {
    pictures: Pictures,
    mapping: Mapping,
    decoder: Decoder,
    /// What tiles show that are not there.
    absent: Rgb,
}

impl PartialEq for Texture {
    fn eq(&self, other: &Texture) -> bool {
        let same = match (&self.pictures, &other.pictures) {
            (Pictures::One(a), Pictures::One(b)) => Arc::ptr_eq(a, b) || a == b,
            (Pictures::Tiles(a), Pictures::Tiles(b)) => Arc::ptr_eq(&a.0, &b.0) || a.0 == b.0,
            _ => false,
        };
        same && self.mapping == other.mapping && self.absent == other.absent
    }
}

impl Texture {
    /// One picture.
    pub fn new(texels: Arc<Texels>, mapping: Mapping) -> Texture {
        let decoder = Decoder::new(mapping.transfer, &texels);
        Texture { pictures: Pictures::One(texels), mapping, decoder, absent: Rgb::ZERO }
    }

    /// A UDIM set; tiles that are not there have the value `absent`.
    pub fn tiles(tiles: Tiles, mapping: Mapping, absent: Rgb) -> Texture {
        let decoder = Decoder::new(mapping.transfer, &tiles.0[0].1);
        Texture { pictures: Pictures::Tiles(tiles), mapping, decoder, absent }
    }

    /// How it is laid over the surface.
    pub fn mapping(&self) -> &Mapping {
        &self.mapping
    }

    /// Adds all that it shows to `digest`, with `of` for each of its pictures.
    pub fn digest(&self, digest: &mut Digest, of: &mut dyn FnMut(&Arc<Texels>) -> [u8; 32]) {
        // Which table decodes follows from the mapping and the pictures.
        let Texture { pictures, mapping, decoder: _, absent } = self;
        digest.value(&(mapping, absent));
        match pictures {
            Pictures::One(texels) => digest.bytes(&of(texels)),
            Pictures::Tiles(tiles) => {
                for (number, texels) in tiles.0.iter() {
                    digest.value(number);
                    digest.bytes(&of(texels));
                }
            }
        }
    }

    /// The first of its pictures.
    pub fn texels(&self) -> &Texels {
        match &self.pictures {
            Pictures::One(texels) => texels,
            Pictures::Tiles(tiles) => &tiles.0[0].1,
        }
    }

    /// True when a picture has an alpha channel that varies.
    pub fn has_alpha(&self) -> bool {
        match &self.pictures {
            Pictures::One(texels) => texels.has_alpha(),
            Pictures::Tiles(tiles) => tiles.0.iter().any(|tile| tile.1.has_alpha()),
        }
    }

    /// The same pictures; where no channel was asked for, `channel`.
    #[must_use]
    pub fn with_channel(mut self, channel: Channel) -> Texture {
        self.mapping.channel.get_or_insert(channel);
        self
    }

    /// The mean over all texels, the mapping's gain and base included.
    pub fn mean(&self) -> Rgb {
        self.of_mean(self.texel_mean())
    }

    /// What [`Texture::mean`] makes of a [`Texture::texel_mean`].
    pub fn of_mean(&self, mean: DVec3) -> Rgb {
        let (gain, base) = (self.mapping.gain.as_dvec3(), self.mapping.base.as_dvec3());
        (mean * gain + base).as_vec3()
    }

    /// What the texels' mean depends on: textures of one such value have the same.
    pub fn mean_key(&self) -> MeanKey {
        let pictures = match &self.pictures {
            Pictures::One(texels) => Arc::as_ptr(texels).addr(),
            Pictures::Tiles(tiles) => tiles.0.as_ptr().addr(),
        };
        MeanKey(pictures, self.mapping.transfer, self.mapping.channel)
    }

    /// The mean of the texels' colours, or of the mapping's channel as grey. Looks at every texel.
    pub fn texel_mean(&self) -> DVec3 {
        let mut sum = DVec3::ZERO;
        let mut count = 0u64;
        let mut add = |texels: &Texels| {
            for texel in texels.pixels(self.mapping.transfer) {
                sum += self.color(texel).as_dvec3();
                count += 1;
            }
        };
        match &self.pictures {
            Pictures::One(texels) => add(texels),
            Pictures::Tiles(tiles) => tiles.0.iter().for_each(|tile| add(&tile.1)),
        }
        sum / count.max(1) as f64
    }

    /// The colour at `uv`; a single channel as grey.
    pub fn rgb(&self, uv: Vec2) -> Rgb {
        self.texel(uv).map_or(self.absent, |texel| self.value(texel))
    }

    fn value(&self, texel: [f32; 4]) -> Rgb {
        self.color(texel) * self.mapping.gain + self.mapping.base
    }

    fn color(&self, texel: [f32; 4]) -> Rgb {
        match self.mapping.channel {
            None => Rgb::new(texel[0], texel[1], texel[2]),
            Some(channel) => Rgb::splat(one(texel, channel)),
        }
    }

    /// The number at `uv`: the mapping's channel, or the first one.
    pub fn number(&self, uv: Vec2) -> f32 {
        let Some(texel) = self.texel(uv) else { return self.absent.x };
        let value = one(texel, self.mapping.channel.unwrap_or(Channel::Red));
        value * self.mapping.gain.x + self.mapping.base.x
    }

    /// The filtered texel; `None` in a tile that is not there.
    fn texel(&self, uv: Vec2) -> Option<[f32; 4]> {
        let [u, v] = [0, 1].map(|i| uv[i] * self.mapping.scale[i] + self.mapping.offset[i]);
        match &self.pictures {
            Pictures::One(texels) => {
                Some(lookup::lookup(texels, &self.decoder, self.mapping.filter, self.mapping.wrap, [u, v]))
            }
            Pictures::Tiles(tiles) => {
                let (column, row) = (u.floor(), v.floor());
                if !((0.0..10.0).contains(&column) && (0.0..900.0).contains(&row)) {
                    return None;
                }
                let number = 1001 + column as u32 + 10 * row as u32;
                let tile = tiles.0.binary_search_by_key(&number, |tile| tile.0).ok()?;
                let inside = [u - column, v - row];
                Some(lookup::lookup(
                    &tiles.0[tile].1,
                    &self.decoder,
                    self.mapping.filter,
                    Wrap::Clamp,
                    inside,
                ))
            }
        }
    }
}

fn one(texel: [f32; 4], channel: Channel) -> f32 {
    match channel {
        Channel::Red => texel[0],
        Channel::Green => texel[1],
        Channel::Blue => texel[2],
        Channel::Alpha => texel[3],
        Channel::Luminance => luminance(Rgb::new(texel[0], texel[1], texel[2])),
    }
}
