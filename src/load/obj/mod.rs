//! The OBJ reader.
