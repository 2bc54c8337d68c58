//! Texture statements: options, then a file name that may hold spaces, or the other way round.

use super::{whole_number, words};
use crate::load::open::path_from_bytes;
use std::path::PathBuf;

/// A texture as stated.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    /// The name as stated, `\` turned into `/`; relative to the library's folder.
    pub file: PathBuf,
    /// The options.
    pub options: TextureOptions,
}

/// Which part of an image a scalar is taken from (`-imfchan`).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Channel {
    /// Red.
    Red,
    /// Green.
    Green,
    /// Blue.
    Blue,
    /// Alpha ("matte").
    Matte,
    /// Luminance.
    Luminance,
    /// Depth.
    Depth,
}

/// Options of a texture statement.
#[derive(Clone, Debug, PartialEq)]
pub struct TextureOptions {
    /// `-o`: offset of (u, v, w).
    pub offset: [f32; 3],
    /// `-s`: scale of (u, v, w).
    pub scale: [f32; 3],
    /// `-t`: turbulence.
    pub turbulence: [f32; 3],
    /// `-bm`: bump multiplier.
    pub bump_multiplier: f32,
    /// `-clamp on`: nothing outside the unit square, instead of repetition.
    pub clamp: bool,
    /// `-imfchan`.
    pub channel: Option<Channel>,
    /// `-mm`: base and gain: value · gain + base.
    pub base_gain: [f32; 2],
    /// `-type`: a reflection map's (`sphere`, `cube_top`, …).
    pub kind: Option<String>,
    /// `-blendu`: blending across u.
    pub blend_u: bool,
    /// `-blendv`: blending across v.
    pub blend_v: bool,
    /// `-cc`: colour correction.
    pub color_correction: bool,
    /// `-boost`: sharpening.
    pub boost: f32,
    /// `-texres`: resolution, 0 where not stated.
    pub resolution: f32,
}

impl Default for TextureOptions {
    fn default() -> Self {
        TextureOptions {
            offset: [0.0; 3],
            scale: [1.0; 3],
            turbulence: [0.0; 3],
            bump_multiplier: 1.0,
            clamp: false,
            channel: None,
            base_gain: [0.0, 1.0],
            kind: None,
            blend_u: true,
            blend_v: true,
            color_correction: false,
            boost: 0.0,
            resolution: 0.0,
        }
    }
}

impl Texture {
    /// What stands behind the key word; `None` without a file name.
    pub(super) fn parse(text: &[u8]) -> Option<Texture> {
        let words: Vec<&[u8]> = words(text).collect();
        let mut options = TextureOptions::default();
        let mut start = 0;
        while let Some(used) = take_option(words.get(start..words.len().checked_sub(1)?)?, &mut options) {
            start += used;
        }
        // Some exporters write the options behind the name; they count when nothing else follows them.
        let end = trailing_options(&words, start + 1);
        let mut at = end;
        while let Some(used) = words.get(at..).and_then(|rest| take_option(rest, &mut options)) {
            at += used;
        }
        let name = span(text, words.get(start..end)?)?;
        let slashes: Vec<u8> = name.iter().map(|&b| if b == b'\\' { b'/' } else { b }).collect();
        Some(Texture { file: path_from_bytes(&slashes), options })
    }
}

/// The text from the first word to the last, with the blanks in between as they are.
fn span<'a>(text: &'a [u8], words: &[&'a [u8]]) -> Option<&'a [u8]> {
    let offset = |part: &[u8]| (part.as_ptr() as usize).checked_sub(text.as_ptr() as usize);
    let (first, last) = (words.first()?, words.last()?);
    text.get(offset(first)?..offset(last)? + last.len())
}

/// Where, not before `first`, the words begin that are options to the last. Answered from the end, so that words that
/// are options almost to the last take no square of their number.
fn trailing_options(words: &[&[u8]], first: usize) -> usize {
    let mut scratch = TextureOptions::default();
    let mut are_options = vec![false; words.len()];
    for at in (first..words.len()).rev() {
        let used = words.get(at..).and_then(|rest| take_option(rest, &mut scratch));
        let rest = used.is_some_and(|used| are_options.get(at + used).copied().unwrap_or(true));
        if let Some(slot) = are_options.get_mut(at) {
            *slot = rest;
        }
    }
    are_options.iter().position(|are| *are).unwrap_or(words.len())
}

/// Takes the option at the start of `words`; how many words that were.
fn take_option(words: &[&[u8]], options: &mut TextureOptions) -> Option<usize> {
    let (key, values) = words.split_first()?;
    let numbers: Vec<f32> = values
        .iter()
        .take(3)
        .map_while(|w| whole_number(w).filter(|x| x.abs() <= 1e18).map(|x| x as f32))
        .collect();
    let switch = match values.first().map(|w| w.to_ascii_lowercase()).as_deref() {
        Some(b"on") => Some(true),
        Some(b"off") => Some(false),
        _ => None,
    };
    let one = numbers.first().copied();
    match *key {
        b"-o" => take_vector(&numbers, &mut options.offset),
        b"-s" => take_vector(&numbers, &mut options.scale),
        b"-t" => take_vector(&numbers, &mut options.turbulence),
        b"-bm" => store(one, &mut options.bump_multiplier),
        b"-boost" => store(one, &mut options.boost),
        b"-texres" => store(one, &mut options.resolution),
        b"-clamp" => store(switch, &mut options.clamp),
        b"-blendu" => store(switch, &mut options.blend_u),
        b"-blendv" => store(switch, &mut options.blend_v),
        b"-cc" => store(switch, &mut options.color_correction),
        b"-imfchan" => store(values.first().and_then(|w| channel(w)).map(Some), &mut options.channel),
        b"-type" => {
            let kind = values.first().map(|w| String::from_utf8_lossy(w).into_owned());
            store(kind.map(Some), &mut options.kind)
        }
        b"-mm" => match *numbers.as_slice() {
            [base, gain, ..] => {
                options.base_gain = [base, gain];
                Some(3)
            }
            _ => None,
        },
        _ => None,
    }
}

/// One to three numbers; those left out keep their values.
fn take_vector(numbers: &[f32], to: &mut [f32; 3]) -> Option<usize> {
    for (to, &from) in to.iter_mut().zip(numbers) {
        *to = from;
    }
    (!numbers.is_empty()).then_some(1 + numbers.len())
}

fn store<T>(value: Option<T>, to: &mut T) -> Option<usize> {
    *to = value?;
    Some(2)
}

fn channel(word: &[u8]) -> Option<Channel> {
    Some(match word.to_ascii_lowercase().as_slice() {
        b"r" => Channel::Red,
        b"g" => Channel::Green,
        b"b" => Channel::Blue,
        b"m" => Channel::Matte,
        b"l" => Channel::Luminance,
        b"z" => Channel::Depth,
        _ => return None,
    })
}
