//! A digest of data that stands for the data: 32 bytes (BLAKE3) that no other content has, in practice.

use std::fmt::{Debug, Write};

/// Takes values in, one after the other; equal sequences give equal digests on every machine.
pub struct Digest {
    hasher: blake3::Hasher,
    buffer: Vec<u8>,
}

/// Bytes that are gathered before they are hashed: long inputs go through the hash's wide kernels.
const GATHERED: usize = 1 << 16;

impl Default for Digest {
    fn default() -> Self {
        Digest::new()
    }
}

impl Digest {
    /// Of nothing yet.
    pub fn new() -> Digest {
        Digest { hasher: blake3::Hasher::new(), buffer: Vec::with_capacity(GATHERED + 64) }
    }

    /// Raw bytes. What needs a length to be told apart from what follows goes through [`Digest::values`].
    pub fn bytes(&mut self, bytes: &[u8]) {
        if self.buffer.len() + bytes.len() > GATHERED {
            self.hasher.update(&self.buffer);
            self.buffer.clear();
        }
        if bytes.len() > GATHERED {
            self.hasher.update(bytes);
        } else {
            self.buffer.extend_from_slice(bytes);
        }
    }

    /// A list of values of `N` bytes each, with its length.
    pub fn values<T: Copy, const N: usize>(&mut self, values: &[T], bytes: impl Fn(T) -> [u8; N]) {
        self.bytes(&(values.len() as u64).to_le_bytes());
        for &value in values {
            self.bytes(&bytes(value));
        }
    }

    /// A list of vectors of floats, bit by bit.
    pub fn floats<const N: usize>(&mut self, values: &[[f32; N]]) {
        self.values(values.as_flattened(), f32::to_le_bytes);
    }

    /// A list of vectors of whole numbers.
    pub fn numbers<const N: usize>(&mut self, values: &[[u32; N]]) {
        self.values(values.as_flattened(), u32::to_le_bytes);
    }

    /// All that `{:?}` shows of a small value, in which every number is exact.
    pub fn value(&mut self, value: &dyn Debug) {
        // Writing to a digest cannot fail; a value that ends with a byte that no text has cannot run into the next.
        let _ = write!(self, "{value:?}");
        self.bytes(&[0xff]);
    }

    /// The digest of all that was taken in.
    pub fn finish(&mut self) -> [u8; 32] {
        self.hasher.update(&self.buffer);
        self.buffer.clear();
        *self.hasher.finalize().as_bytes()
    }

    /// [`Digest::finish`] in hexadecimal digits.
    pub fn hex(&mut self) -> String {
        self.finish().iter().map(|byte| format!("{byte:02x}")).collect()
    }
}

impl Write for Digest {
    fn write_str(&mut self, text: &str) -> std::fmt::Result {
        self.bytes(text.as_bytes());
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_digest_is_that_of_the_bytes_however_they_come() {
        let bytes: Vec<u8> = (0..300_000u32).map(|i| (i * 7 + i / 251) as u8).collect();
        let whole = *blake3::hash(&bytes).as_bytes();
        for step in [1, 3, 1000, GATHERED, GATHERED + 1, 300_000] {
            let mut digest = Digest::new();
            bytes.chunks(step).for_each(|part| digest.bytes(part));
            assert_eq!(digest.finish(), whole, "{step}");
        }
    }

    #[test]
    fn neighbours_do_not_run_into_each_other() {
        let of = |lists: &[&[[u32; 1]]]| {
            let mut digest = Digest::new();
            lists.iter().for_each(|list| digest.numbers(list));
            digest.hex()
        };
        assert_ne!(of(&[&[[1], [2]], &[]]), of(&[&[[1]], &[[2]]]));
        let of = |values: [&dyn Debug; 2]| {
            let mut digest = Digest::new();
            values.into_iter().for_each(|value| digest.value(value));
            digest.hex()
        };
        assert_ne!(of([&12, &3]), of([&1, &23]));
        // −0 and 0 are equal and differ.
        let floats = |values: &[[f32; 1]]| {
            let mut digest = Digest::new();
            digest.floats(values);
            digest.finish()
        };
        assert_ne!(floats(&[[0.0]]), floats(&[[-0.0]]));
    }
}
