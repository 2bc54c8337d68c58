//! Growing lists whose length the input decides: a failed allocation is an error, never an abort.

pub(super) use crate::memory::OutOfMemory;
use crate::memory::reserve;

/// Makes room for `more` elements. Long lists grow by half, not to double: the address space counts where
/// memory is limited, and the allocator moves large blocks without copying (`mremap`).
#[inline]
pub(super) fn grow<T>(list: &mut Vec<T>, more: usize) -> Result<(), OutOfMemory> {
    if list.capacity() - list.len() >= more { Ok(()) } else { reallocate(list, more) }
}

#[cold]
fn reallocate<T>(list: &mut Vec<T>, more: usize) -> Result<(), OutOfMemory> {
    let more = more.max(list.len() / 2).max(64);
    reserve(list, more)
}

/// Appends one element.
#[inline]
pub(super) fn push<T>(list: &mut Vec<T>, element: T) -> Result<(), OutOfMemory> {
    grow(list, 1)?;
    list.push(element);
    Ok(())
}

/// Appends copies of elements.
pub(super) fn extend<T: Copy>(list: &mut Vec<T>, elements: &[T]) -> Result<(), OutOfMemory> {
    grow(list, elements.len())?;
    list.extend_from_slice(elements);
    Ok(())
}
