//! From a file to its JSON document and its buffers: `.glb`, `.gltf` with buffers beside it or as `data:` URIs.

use super::item::Item;
use crate::error::{Error, Result};
use crate::load::input::{Input, ReadingProgress, no_memory};
use crate::load::open::{Finder, Reach, real};
use serde_json::Value;
use std::collections::HashMap;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A file is read as a whole; more than this many bytes are refused.
const MOST_BYTES: u64 = 64 << 30;

/// The first bytes of a `.glb`.
pub(super) const MAGIC: &[u8] = b"glTF";

/// The JSON of a file, and what a `.glb` carries behind it.
pub(super) struct Document {
    pub json: Value,
    binary: Option<Vec<u8>>,
}

impl Document {
    /// Reads a whole file.
    ///
    /// # Errors
    /// What is no glTF 2.0; cancelled.
    pub fn read(input: Input<'_>, progress: ReadingProgress<'_>) -> Result<Document> {
        let file = input.name;
        let mut bytes = input.read_all(MOST_BYTES, progress)?;
        let error = |message: &str| Error::new(message).at(file);
        if !bytes.starts_with(MAGIC) {
            return Ok(Document { json: parse(&bytes, file)?, binary: None });
        }
        let number =
            |at: usize| bytes.get(at..).and_then(|rest| rest.first_chunk().copied()).map(u32::from_le_bytes);
        if number(4) != Some(2) {
            return Err(error("not version 2 of glTF").advise("convert it to glTF 2.0"));
        }
        let (length, kind) = (number(12).unwrap_or(0) as usize, number(16));
        let (start, end) = (20, length.saturating_add(20));
        let text = bytes.get(start..end).filter(|_| kind == Some(u32::from_le_bytes(*b"JSON")));
        let text = text.ok_or_else(|| error("damaged or incomplete: it has no whole JSON chunk"))?;
        let json = parse(text, file)?;
        let binary = match (number(end), number(end + 4)) {
            (Some(length), Some(kind)) if kind == u32::from_le_bytes(*b"BIN\0") => {
                let (from, length) = (end + 8, length as usize);
                if bytes.len() - from < length {
                    return Err(error("damaged or incomplete: it ends within its binary chunk"));
                }
                bytes.truncate(from + length);
                bytes.drain(..from);
                Some(bytes)
            }
            _ => None,
        };
        Ok(Document { json, binary })
    }

    /// The bytes of every buffer of the document, whose files are within `reach`.
    ///
    /// # Errors
    /// A buffer that is missing, shorter than it says, or no `data:` URI that can be read.
    pub fn buffers(&mut self, file: &Path, reach: &Reach) -> Result<Vec<Arc<Vec<u8>>>> {
        let mut binary = self.binary.take();
        let root = Item::root(&self.json, file);
        let longest = root.list("buffers").map(|buffer| buffer.size("byteLength", None));
        let longest = longest.collect::<Result<Vec<usize>>>()?.into_iter().max().unwrap_or(0);
        let mut beside = Beside { finder: Finder::new(reach), reach, longest, read: HashMap::new() };
        let mut buffers = Vec::new();
        for buffer in root.list("buffers") {
            let length = buffer.size("byteLength", None)?;
            let bytes = match buffer.text("uri") {
                // A buffer that nothing uses may be a stand-in for a compressed one.
                None => Arc::new(binary.take().unwrap_or_default()),
                Some(uri) => beside.fetch(uri, &buffer, file)?,
            };
            if bytes.len() < length && !(bytes.is_empty() && buffer.get("extensions").is_some()) {
                let have = bytes.len();
                return Err(buffer.error(&format!("says {length} bytes, and there are {have}")));
            }
            buffers.push(bytes);
        }
        Ok(buffers)
    }
}

fn parse(text: &[u8], file: &Path) -> Result<Value> {
    let text = text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(text);
    serde_json::from_slice(text).map_err(|e| {
        let error = Error::new("not a whole JSON document").at(file).line(e.line() as u64);
        error.column(e.column() as u64).advise("is it really a glTF file?")
    })
}

/// The files beside a document. Each is read once, however many buffers are said to be in it.
struct Beside<'r> {
    finder: Finder,
    reach: &'r Reach,
    /// So many bytes of each are enough.
    longest: usize,
    read: HashMap<PathBuf, Arc<Vec<u8>>>,
}

impl Beside<'_> {
    /// The bytes that a URI names.
    fn fetch(&mut self, uri: &str, item: &Item<'_>, file: &Path) -> Result<Arc<Vec<u8>>> {
        if let Some(data) = uri.strip_prefix("data:") {
            let bytes = data_uri(data).ok_or_else(|| item.error("has a data: URI that is not base64"))?;
            return Ok(Arc::new(bytes));
        }
        let folder = file.parent().unwrap_or(Path::new(""));
        let found = self.finder.find(folder, &unescape(uri));
        let found = found.ok_or_else(|| item.error("is in a file that was not found beside this one"))?;
        let path = real(&found.path);
        if let Some(bytes) = self.read.get(&path) {
            return Ok(bytes.clone());
        }
        let failed = |why: String| item.error(&format!("is in a file that cannot be read: {why}"));
        let (handle, length) = self.reach.open(&found.path).map_err(|e| failed(e.message))?;
        let mut bytes = Vec::new();
        let most = length.min(self.longest as u64);
        bytes.try_reserve_exact(most as usize).map_err(|_| no_memory(file))?;
        handle.take(most).read_to_end(&mut bytes).map_err(|e| failed(e.to_string()))?;
        let bytes = Arc::new(bytes);
        self.read.insert(path, bytes.clone());
        Ok(bytes)
    }
}

/// What follows `data:`, decoded.
pub(super) fn data_uri(data: &str) -> Option<Vec<u8>> {
    let (kind, text) = data.split_once(',')?;
    if !kind.ends_with(";base64") { Some(unescape(text)) } else { base64(&unescape(text)) }
}

/// Percent signs and two digits become the byte they stand for.
pub(super) fn unescape(uri: &str) -> Vec<u8> {
    let mut out = Vec::with_capacity(uri.len());
    let mut rest = uri.as_bytes();
    while let [first, tail @ ..] = rest {
        let digit = |i: usize| tail.get(i).and_then(|b| char::from(*b).to_digit(16));
        if let (b'%', Some(high), Some(low)) = (first, digit(0), digit(1)) {
            out.push((16 * high + low) as u8);
            rest = tail.get(2..).unwrap_or_default();
        } else {
            out.push(*first);
            rest = tail;
        }
    }
    out
}

/// RFC 4648, with or without padding; `None` for anything else.
fn base64(text: &[u8]) -> Option<Vec<u8>> {
    let end = text.iter().rposition(|b| *b != b'=').map_or(0, |last| last + 1);
    let mut out = Vec::with_capacity(text.len() / 4 * 3 + 3);
    let (mut bits, mut count) = (0u32, 0);
    for byte in text.get(..end)?.iter().filter(|b| !b.is_ascii_whitespace()) {
        let digit = match byte {
            b'A'..=b'Z' => byte - b'A',
            b'a'..=b'z' => byte - b'a' + 26,
            b'0'..=b'9' => byte - b'0' + 52,
            b'+' | b'-' => 62,
            b'/' | b'_' => 63,
            _ => return None,
        };
        bits = bits << 6 | u32::from(digit);
        count += 6;
        if count >= 8 {
            count -= 8;
            out.push((bits >> count) as u8);
        }
    }
    Some(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn uris_are_decoded() {
        assert_eq!(unescape("a%20b%2f%zz%4"), b"a b/%zz%4");
        for (text, bytes) in
            [("", ""), ("Zg==", "f"), ("Zm8=", "fo"), ("Zm9v", "foo"), ("Zm9vYmFy", "foobar"), ("Zg", "f")]
        {
            let data = format!("application/octet-stream;base64,{text}");
            assert_eq!(data_uri(&data).as_deref(), Some(bytes.as_bytes()), "{text}");
        }
        assert_eq!(data_uri("text/plain,a%20b").as_deref(), Some(b"a b".as_slice()));
        assert_eq!(data_uri("x;base64,?"), None);
        assert_eq!(data_uri("no comma"), None);
    }
}
