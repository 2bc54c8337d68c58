//! `.gz` and `.zst`, unpacked while they are read and only up to a limit.
//!
//! Ten megabytes can unpack to ten gigabytes of nothing, so the limit counts bytes as they come out: nothing is
//! reserved by what a header promises.

use flate2::bufread::MultiGzDecoder;
use ruzstd::decoding::errors::{FrameDecoderError, ReadFrameHeaderError};
use ruzstd::decoding::{BlockDecodingStrategy, FrameDecoder};
use std::io::{self, BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// What unpacks to no more than this is never refused, where nobody says otherwise.
pub const ALWAYS_ALLOWED: u64 = 256 << 20;

/// Nor what unpacks to no more than this many times its size. Meshes as text shrink to a third or a tenth.
pub const TIMES_ALLOWED: u64 = 64;

/// How a file is packed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Packing {
    Gzip,
    Zstd,
}

impl Packing {
    /// Extension, first bytes, value.
    pub const TABLE: &'static [(&'static str, &'static [u8], Packing)] =
        &[("gz", &[0x1f, 0x8b], Packing::Gzip), ("zst", &[0x28, 0xb5, 0x2f, 0xfd], Packing::Zstd)];

    /// The packing of a file that begins with `head`.
    pub fn of(head: &[u8]) -> Option<Packing> {
        Packing::TABLE.iter().find(|row| head.starts_with(row.1)).map(|row| row.2)
    }

    /// What `from` holds, unpacked; `limit`: the most bytes of it.
    pub fn unpack<'a>(self, from: impl Read + Send + 'a, limit: Limit) -> Box<dyn Read + Send + 'a> {
        let from = BufReader::with_capacity(1 << 16, from);
        match self {
            Packing::Gzip => Box::new(Limited { from: MultiGzDecoder::new(from), limit, unpacked: 0 }),
            Packing::Zstd => Box::new(Limited { from: Zstd::new(from), limit, unpacked: 0 }),
        }
    }
}

/// `name` without the extension of a packing, if it has one.
pub fn strip(name: &Path) -> PathBuf {
    let extension = name.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
    let is_packed = Packing::TABLE.iter().any(|row| row.0 == extension);
    if is_packed { name.with_extension("") } else { name.to_path_buf() }
}

/// How much may come out.
#[derive(Clone)]
pub(super) struct Limit {
    /// The number of bytes that was asked for.
    pub stated: Option<u64>,
    /// Bytes that went in so far.
    pub packed: Arc<AtomicU64>,
    /// The file's length, where it is known.
    pub length: Option<u64>,
}

impl Limit {
    fn bytes(&self) -> u64 {
        let packed = self.length.unwrap_or_else(|| self.packed.load(Ordering::Relaxed));
        self.stated.unwrap_or(ALWAYS_ALLOWED.max(packed.saturating_mul(TIMES_ALLOWED)))
    }

    fn error(&self) -> io::Error {
        let bytes = self.bytes();
        let why = match self.stated {
            Some(_) => String::new(),
            None if bytes > ALWAYS_ALLOWED => format!(", {TIMES_ALLOWED} times its size"),
            None => format!(" and {TIMES_ALLOWED} times its size"),
        };
        io::Error::other(format!(
            "it unpacks to more than {} MiB{why}; raise --max-unpacked if it is to be trusted",
            bytes >> 20
        ))
    }
}

/// Ends with an error where more comes out than may.
struct Limited<R> {
    from: R,
    limit: Limit,
    unpacked: u64,
}

impl<R: Read> Read for Limited<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.from.read(buffer).map_err(|e| match e.kind() {
            io::ErrorKind::Interrupted => e,
            io::ErrorKind::UnexpectedEof => {
                io::Error::other("the packed file ends too early: it is incomplete")
            }
            _ => io::Error::other(format!("the packed file is damaged ({e})")),
        })?;
        self.unpacked += count as u64;
        if self.unpacked > self.limit.bytes() { Err(self.limit.error()) } else { Ok(count) }
    }
}

/// Every frame of a Zstandard file, one after the other, with their checksums where they have them.
struct Zstd<R> {
    from: R,
    frame: FrameDecoder,
    is_open: bool,
}

impl<R: BufRead> Zstd<R> {
    fn new(from: R) -> Self {
        Zstd { from, frame: FrameDecoder::new(), is_open: false }
    }

    /// Opens the next frame; `false` at the end of the file.
    fn open(&mut self) -> io::Result<bool> {
        while !self.from.fill_buf()?.is_empty() {
            match self.frame.reset(&mut self.from) {
                Ok(()) => {
                    self.is_open = true;
                    return Ok(true);
                }
                Err(FrameDecoderError::ReadFrameHeaderError(ReadFrameHeaderError::SkipFrame {
                    length,
                    ..
                })) => {
                    io::copy(&mut self.from.by_ref().take(u64::from(length)), &mut io::sink())?;
                }
                Err(error) => return Err(io::Error::other(error.to_string())),
            }
        }
        Ok(false)
    }

    fn close(&mut self) -> io::Result<()> {
        self.is_open = false;
        match (self.frame.get_checksum_from_data(), self.frame.get_calculated_checksum()) {
            (Some(stated), Some(found)) if stated != found => {
                Err(io::Error::other("its checksum does not fit"))
            }
            _ => Ok(()),
        }
    }
}

impl<R: BufRead> Read for Zstd<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        while !buffer.is_empty() {
            if !self.is_open && !self.open()? {
                break;
            }
            let count = self.frame.read(buffer)?;
            if count > 0 {
                return Ok(count);
            }
            if self.frame.is_finished() {
                self.close()?;
            } else {
                let wanted = BlockDecodingStrategy::UptoBytes(buffer.len());
                let decoded = self.frame.decode_blocks(&mut self.from, wanted);
                decoded.map_err(|error| io::Error::other(error.to_string()))?;
            }
        }
        Ok(0)
    }
}

/// Counts the bytes that are read.
pub(super) struct Counted<R> {
    pub from: R,
    pub count: Arc<AtomicU64>,
}

impl<R: Read> Read for Counted<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.from.read(buffer)?;
        self.count.fetch_add(count as u64, Ordering::Relaxed);
        Ok(count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;

    fn limit(stated: Option<u64>) -> Limit {
        Limit { stated, packed: Arc::default(), length: None }
    }

    fn unpacked(bytes: &[u8], stated: Option<u64>) -> io::Result<Vec<u8>> {
        let packing = Packing::of(bytes).expect("its first bytes");
        let mut out = Vec::new();
        let packed = Arc::new(AtomicU64::new(0));
        let from = Counted { from: bytes, count: packed.clone() };
        packing.unpack(from, Limit { packed, ..limit(stated) }).read_to_end(&mut out).map(|_| out)
    }

    fn gzip(bytes: &[u8]) -> Vec<u8> {
        let mut packer = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::best());
        packer.write_all(bytes).expect("memory");
        packer.finish().expect("memory")
    }

    fn zstd(bytes: &[u8]) -> Vec<u8> {
        ruzstd::encoding::compress_to_vec(bytes, ruzstd::encoding::CompressionLevel::Fastest)
    }

    #[test]
    fn what_was_packed_comes_out_in_several_parts_too() {
        let text: Vec<u8> =
            (0..100_000u32).flat_map(|i| format!("v {i} 0 {}\n", i * 7 % 13).into_bytes()).collect();
        for pack in [gzip, zstd] {
            assert_eq!(unpacked(&pack(&text), None).unwrap(), text);
            let (a, b) = text.split_at(1234);
            assert_eq!(unpacked(&[pack(a), pack(b)].concat(), None).unwrap(), text);
        }
        let skippable = [&[0x50, 0x2a, 0x4d, 0x18, 3, 0, 0, 0, 9, 9, 9], zstd(&text).as_slice()].concat();
        assert_eq!(unpacked(&[zstd(b"# first\n"), skippable].concat(), None).unwrap()[8..], text);
    }

    #[test]
    fn cut_or_changed_files_are_damaged_and_never_short() {
        let text = b"v 1 2 3\nv 4 5 6\nf 1 2 1\n".repeat(100);
        for pack in [gzip, zstd] {
            let packed = pack(&text);
            for end in 5..packed.len() {
                assert!(unpacked(&packed[..end], None).is_err(), "{end}");
            }
            for at in 4..packed.len() {
                let mut changed = packed.clone();
                changed[at] ^= 0x40;
                if let Ok(out) = unpacked(&changed, None) {
                    assert_eq!(out, text, "{at}");
                }
            }
        }
    }

    #[test]
    fn a17_what_grows_beyond_the_limit_is_refused_by_name() {
        let bomb = gzip(&vec![b'#'; 300 << 20]);
        assert!(bomb.len() < 1 << 20);
        let error = unpacked(&bomb, None).unwrap_err().to_string();
        assert!(error.contains("more than 256 MiB and 64 times its size; raise --max-unpacked"), "{error}");
        assert_eq!(unpacked(&bomb, Some(300 << 20)).unwrap().len(), 300 << 20);
        let error = unpacked(&bomb, Some((300 << 20) - 1)).unwrap_err().to_string();
        assert!(error.contains("more than 299 MiB; raise"), "{error}");
    }
}
