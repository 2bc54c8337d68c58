//! The header of a PLY file: what follows, how often, and of which type. Turk, "The PLY Polygon File Format" (1994).

use crate::error::{Error, Result, one_line};
use std::io::{self, BufRead};
use std::path::Path;

/// A longer header is no header.
const MOST_BYTES: u64 = 1 << 20;

/// How values are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    Ascii,
    LittleEndian,
    BigEndian,
}

/// A type of numbers, by its old and its new name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Type {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Type {
    const NAMES: [(&'static str, &'static str, Type); 8] = [
        ("char", "int8", Type::I8),
        ("uchar", "uint8", Type::U8),
        ("short", "int16", Type::I16),
        ("ushort", "uint16", Type::U16),
        ("int", "int32", Type::I32),
        ("uint", "uint32", Type::U32),
        ("float", "float32", Type::F32),
        ("double", "float64", Type::F64),
    ];

    fn named(name: &str) -> Option<Type> {
        Type::NAMES.iter().find(|row| row.0 == name || row.1 == name).map(|row| row.2)
    }

    fn is_whole(self) -> bool {
        !matches!(self, Type::F32 | Type::F64)
    }
}

/// A property of an element.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Property {
    pub name: String,
    /// The type of a list's length; `None`: one value.
    pub list: Option<Type>,
    pub kind: Type,
}

/// A kind of rows.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Element {
    pub name: String,
    /// How many the header promises.
    pub count: u64,
    pub properties: Vec<Property>,
    /// The line that declares it.
    pub line: u64,
}

/// What a header says.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Header {
    pub encoding: Encoding,
    pub elements: Vec<Element>,
    /// The pictures that comments name, as MeshLab writes them, with their lines.
    pub textures: Vec<(u64, String)>,
    /// The first line that says nothing a header can say.
    pub unknown: Option<u64>,
    /// How many lines it has.
    pub lines: u64,
}

impl Header {
    /// Reads up to the line `end_header`, and that one.
    ///
    /// # Errors
    /// By line, what is no header.
    pub fn read(from: &mut impl BufRead, file: &Path) -> Result<Header> {
        let mut lines = Lines { from, left: MOST_BYTES, ending: None };
        let mut header = Header {
            encoding: Encoding::Ascii,
            elements: Vec::new(),
            textures: Vec::new(),
            unknown: None,
            lines: 0,
        };
        let mut format = None;
        loop {
            header.lines += 1;
            let at = |message: &str| Error::new(message).at(file).line(header.lines);
            let line = lines.next().map_err(|e| Error::io("read", file, &e))?;
            let line = line.ok_or_else(|| at("the header has no end").advise("is it really a PLY file?"))?;
            let words: Vec<&str> = line.split_ascii_whitespace().collect();
            match words.as_slice() {
                ["ply"] if header.lines == 1 => {}
                _ if header.lines == 1 => return Err(at("it does not begin with \"ply\"")),
                [] | ["obj_info", ..] => {}
                ["comment", "TextureFile", ..] => {
                    let name = line.split_once("TextureFile").map_or("", |parts| parts.1).trim();
                    header.textures.push((header.lines, name.to_string()));
                }
                ["comment", ..] => {}
                ["format", word, _version] => {
                    format = match *word {
                        "ascii" => Some(Encoding::Ascii),
                        "binary_little_endian" => Some(Encoding::LittleEndian),
                        "binary_big_endian" => Some(Encoding::BigEndian),
                        _ => return Err(at("an unknown format").advise(KNOWN_FORMATS)),
                    }
                }
                ["element", name, count] => {
                    let count =
                        count.parse().map_err(|_| at("an element's number must be a whole number"))?;
                    let (name, properties) = (one_line(name), Vec::new());
                    header.elements.push(Element { name, count, properties, line: header.lines });
                }
                ["property", words @ ..] => {
                    let property = property(words).map_err(at)?;
                    let element = header.elements.last_mut();
                    element.ok_or_else(|| at("a property before any element"))?.properties.push(property);
                }
                ["end_header"] => break,
                // Some exporters write remarks without the word.
                _ => header.unknown = header.unknown.or(Some(header.lines)),
            }
        }
        let missing = || Error::new("the header states no format").at(file).advise(KNOWN_FORMATS);
        header.encoding = format.ok_or_else(missing)?;
        Ok(header)
    }
}

const KNOWN_FORMATS: &str = "known: ascii, binary_little_endian, binary_big_endian";

/// `TYPE NAME` or `list LENGTH-TYPE TYPE NAME`.
fn property(words: &[&str]) -> Result<Property, &'static str> {
    let kind = |word| Type::named(word).ok_or("an unknown type of numbers");
    match words {
        ["list", length, item, name] => {
            let length = kind(length)?;
            if !length.is_whole() {
                return Err("the length of a list must be a whole number's type");
            }
            Ok(Property { name: (*name).to_string(), list: Some(length), kind: kind(item)? })
        }
        [word, name] => Ok(Property { name: (*name).to_string(), list: None, kind: kind(word)? }),
        _ => Err("a property is TYPE NAME or list TYPE TYPE NAME"),
    }
}

/// Lines that end as the first one does: what follows the last one may be any byte.
struct Lines<'r, R> {
    from: &'r mut R,
    left: u64,
    ending: Option<&'static [u8]>,
}

impl<R: BufRead> Lines<'_, R> {
    /// `None` where the file or the patience ends.
    fn next(&mut self) -> io::Result<Option<String>> {
        let mut line = Vec::new();
        loop {
            let Some(byte) = self.byte()? else { return Ok(None) };
            if self.ending.is_none() && matches!(byte, b'\n' | b'\r') {
                let follows = self.from.fill_buf()?.first() == Some(&b'\n');
                let ending: &[u8] = match byte {
                    b'\n' => b"\n",
                    _ if follows => b"\r\n",
                    _ => b"\r",
                };
                self.ending = Some(ending);
                if ending.len() == 2 {
                    self.byte()?;
                }
                break;
            }
            line.push(byte);
            if let Some(ending) = self.ending.filter(|ending| line.ends_with(ending)) {
                line.truncate(line.len() - ending.len());
                break;
            }
        }
        Ok(Some(String::from_utf8_lossy(&line).into_owned()))
    }

    fn byte(&mut self) -> io::Result<Option<u8>> {
        let byte = self.from.fill_buf()?.first().copied();
        if byte.is_none() || self.left == 0 {
            return Ok(None);
        }
        self.from.consume(1);
        self.left -= 1;
        Ok(byte)
    }
}
