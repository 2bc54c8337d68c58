//! Lists whose length the input decides: a failed allocation is an error, never the end of the program.
//!
//! Hundreds of small allocations stand beside the few large ones, and ending the program is all that can be done when
//! one of those fails. So a large list is granted only where [`HEADROOM`] is left for them.

use std::hint::black_box;

/// What stays free for everything small. More than 32 MiB: the least size at which freeing memory does not move glibc's
/// threshold between memory that goes back to the system at once and memory that is kept.
pub const HEADROOM: usize = 40 << 20;

/// Lists from here on leave the headroom.
const LARGE: usize = 1 << 20;

/// Lists from here on are asked about: the system would promise them, and end the program once they are filled.
const HUGE: usize = 16 << 20;

/// There is not enough memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OutOfMemory;

/// Makes room for `more` elements, and no more than that.
///
/// # Errors
/// They cannot be had, are more than a limit leaves, or are many and nothing would be left beside them.
#[inline]
pub fn reserve<T>(list: &mut Vec<T>, more: usize) -> Result<(), OutOfMemory> {
    list.try_reserve_exact(more).map_err(|_| OutOfMemory)?;
    let bytes = more.saturating_mul(size_of::<T>());
    if bytes < LARGE { Ok(()) } else { consider(bytes) }
}

#[cold]
fn consider(bytes: usize) -> Result<(), OutOfMemory> {
    if bytes >= HUGE && super::left().is_some_and(|left| left.bytes < bytes as u64) {
        return Err(OutOfMemory);
    }
    probe(HEADROOM)
}

/// Whether so many bytes could be had now. They are given back at once, untouched.
///
/// # Errors
/// They could not.
pub fn probe(bytes: usize) -> Result<(), OutOfMemory> {
    let mut room: Vec<u8> = Vec::new();
    // Without the box the compiler may leave an allocation out that nobody uses.
    black_box(&mut room).try_reserve_exact(bytes).map_err(|_| OutOfMemory)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_cannot_be_had_is_an_error() {
        assert_eq!(probe(isize::MAX as usize), Err(OutOfMemory));
        assert_eq!(probe(HEADROOM), Ok(()));
        let mut list: Vec<u64> = Vec::new();
        assert_eq!(reserve(&mut list, usize::MAX), Err(OutOfMemory));
        assert_eq!(reserve(&mut list, 1 << 20), Ok(()));
        assert!(list.capacity() >= 1 << 20);
    }
}
