//! The file: two lines of text (`head -n 2` shows them), the tiles in binary, and a checksum over all of it.
//!
//! ```text
//! drt checkpoint 1\n
//! {"identity":…,"layers":…,"spp":…,"tiles":…}\n
//! tiles, see film/store/saved.rs
//! 32 bytes: BLAKE3 of everything before
//! ```

use crate::error::{Error, Result};
use crate::film::{Film, Saved, is_whole};
use serde_json::{Value, json};
use std::io::{self, Read, Write};

/// What the file begins with, before the number of the format.
const MAGIC: &[u8] = b"drt checkpoint ";
/// The format's number; another one is refused.
const VERSION: &str = "1";
/// Bytes of the second line at most.
const LONGEST_HEADER: usize = 1 << 16;
/// Bytes of the checksum.
const SUM: usize = 32;

/// What a checkpoint says of itself.
#[derive(Clone, Debug, PartialEq)]
pub struct Header {
    /// The render that it belongs to.
    pub identity: Value,
    /// Samples a pixel that the render was for.
    pub spp: u32,
    /// Whether tiles have layers.
    pub layers: bool,
    /// Tiles that follow.
    pub tiles: usize,
    /// The least and the most samples of a tile; not in the text.
    pub samples: (u32, u32),
}

impl Header {
    fn text(&self) -> String {
        let Header { identity, spp, layers, tiles, samples: _ } = self;
        json!({ "identity": identity, "spp": spp, "layers": layers, "tiles": tiles }).to_string()
    }

    fn of(text: &[u8]) -> Option<Header> {
        let value: Value = serde_json::from_slice(text).ok()?;
        Some(Header {
            identity: value.get("identity").filter(|identity| identity.is_object())?.clone(),
            spp: value.get("spp")?.as_u64()?.try_into().ok()?,
            layers: value.get("layers")?.as_bool()?,
            tiles: value.get("tiles")?.as_u64()?.try_into().ok()?,
            samples: (0, 0),
        })
    }
}

/// Reads a checkpoint's bytes and checks all of it, keeping nothing but what it says of itself.
///
/// # Errors
/// Not a checkpoint, one of another version, or a damaged one.
pub fn read(bytes: &[u8]) -> Result<Header> {
    scan(bytes, &mut |_, _| Ok(()))
}

/// Writes a checkpoint.
pub(super) fn write(out: &mut impl Write, header: &Header, film: &Film, tiles: &[usize]) -> io::Result<()> {
    let mut hasher = blake3::Hasher::new();
    let mut bytes = [MAGIC, VERSION.as_bytes(), b"\n", header.text().as_bytes(), b"\n"].concat();
    for &tile in tiles {
        film.save(tile, is_whole, &mut bytes);
        if bytes.len() >= 1 << 16 {
            hasher.update(&bytes);
            out.write_all(&bytes)?;
            bytes.clear();
        }
    }
    hasher.update(&bytes);
    out.write_all(&bytes)?;
    out.write_all(hasher.finalize().as_bytes())
}

/// Reads all of a checkpoint, handing each tile with its number to `each`. What was handed over counts only if this
/// ends well: the checksum comes last.
pub(super) fn scan(from: impl Read, each: &mut dyn FnMut(usize, Saved) -> Result<()>) -> Result<Header> {
    let mut from = Hashed { from, hasher: blake3::Hasher::new() };
    let mut magic = [0; MAGIC.len()];
    if from.read_exact(&mut magic).is_err() || magic != MAGIC {
        return Err(Error::new("is no checkpoint of drt").advise("give another --checkpoint"));
    }
    let version = line(&mut from, 16)?;
    if version != VERSION.as_bytes() {
        let version = String::from_utf8_lossy(&version).into_owned();
        return Err(Error::new(format!("is a checkpoint of format {version}, and this drt has {VERSION}"))
            .advise("finish it with the drt that wrote it, or begin anew"));
    }
    let text = line(&mut from, LONGEST_HEADER)?;
    let mut header = Header::of(&text).ok_or_else(|| damaged("its header is none"))?;
    let mut samples: Option<(u32, u32)> = None;
    for i in 0..header.tiles {
        let saved = Saved::read(&mut from, header.layers).map_err(|e| damaged(&e.message))?;
        let (whole, all) = (saved.whole(), saved.all());
        // Only the last block of all can have been cut short.
        let is_cut = all > whole;
        if !is_whole(whole) || whole > header.spp || is_cut && (is_whole(all) || all != header.spp) {
            return Err(damaged("a tile has a number of samples that cannot be"));
        }
        let (least, most) = samples.unwrap_or((all, all));
        samples = Some((least.min(all), most.max(all)));
        each(i, saved)?;
    }
    header.samples = samples.unwrap_or_default();
    let sum = *from.hasher.finalize().as_bytes();
    let mut stated = [0; SUM];
    let is_whole = from.from.read_exact(&mut stated).is_ok();
    if !is_whole || stated != sum || !matches!(from.from.read(&mut [0]), Ok(0)) {
        return Err(damaged("its checksum does not fit"));
    }
    Ok(header)
}

fn damaged(how: &str) -> Error {
    Error::new(format!("the checkpoint is damaged: {how}")).advise("remove it to begin anew")
}

/// Bytes up to the end of the line, `most` of them.
fn line(from: &mut Hashed<impl Read>, most: usize) -> Result<Vec<u8>> {
    let mut line = Vec::new();
    let mut byte = [0];
    // Hashed as a whole: with a call a byte, small checkpoints took several times as long to read.
    while line.len() < most {
        if from.from.read_exact(&mut byte).is_err() {
            return Err(damaged("it is cut short"));
        }
        line.push(byte[0]);
        if byte == *b"\n" {
            from.hasher.update(&line);
            line.pop();
            return Ok(line);
        }
    }
    Err(damaged("its header does not end"))
}

/// Hashes what goes through.
struct Hashed<R> {
    from: R,
    hasher: blake3::Hasher,
}

impl<R: Read> Read for Hashed<R> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        let read = self.from.read(bytes)?;
        self.hasher.update(bytes.get(..read).unwrap_or_default());
        Ok(read)
    }
}
