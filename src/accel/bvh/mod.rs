//! Our own bounding volume hierarchy.
