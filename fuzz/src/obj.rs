//! The OBJ reader: whatever the bytes are, the mesh is sound, and it is the same one in blocks of any size.

use drt::load::obj::{ObjFile, ReadOptions, read_from};
use std::path::Path;

/// The first byte chooses how large blocks are; the rest is the file.
pub fn run(data: &[u8]) {
    let Some((&choice, text)) = data.split_first() else { return };
    let whole = read(text, 1 << 20);
    let parts = read(text, 1 + usize::from(choice));
    match (whole, parts) {
        (Ok(whole), Ok(parts)) => {
            super::sound(&whole.mesh, whole.material_names.len());
            assert_eq!(whole.mesh.indices.len() as u64, kept(&whole));
            assert_eq!(whole.counts, parts.counts);
            assert_eq!(whole.mesh.indices, parts.mesh.indices);
            assert_eq!(*whole.mesh.positions, *parts.mesh.positions);
            let materials = |file: &ObjFile| -> Vec<u32> {
                (0..file.mesh.indices.len()).map(|t| file.mesh.materials.get(t)).collect()
            };
            assert_eq!(materials(&whole), materials(&parts));
            assert_eq!(whole.material_names, parts.material_names);
            assert_eq!(whole.face_lines, parts.face_lines);
        }
        (Err(whole), Err(parts)) => assert_eq!(whole, parts),
        (whole, parts) => panic!("{:?} in one block, {:?} in many", whole.err(), parts.err()),
    }
}

fn read(text: &[u8], block_bytes: usize) -> drt::error::Result<ObjFile> {
    let options = ReadOptions {
        block_bytes,
        keep_empty: true,
        face_lines: true,
        max_line_bytes: 1 << 16,
        ..Default::default()
    };
    read_from(text, Path::new("fuzz.obj"), Some(text.len() as u64), &options)
}

/// The triangles that are left of those in the file.
fn kept(file: &ObjFile) -> u64 {
    file.counts.triangles - file.counts.zero_area - file.counts.duplicates
}
