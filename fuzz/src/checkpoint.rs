//! Checkpoints: refused, or what they say of themselves holds together.

use drt::checkpoint::{compare, read};

/// The bytes are a checkpoint, once as they are and once with the checksum that they should have.
pub fn run(bytes: &[u8]) {
    let sealed = [bytes, blake3::hash(bytes).as_bytes()].concat();
    for bytes in [bytes, &sealed] {
        match read(bytes) {
            Ok(header) => {
                let (least, most) = header.samples;
                assert!(least <= most && most <= header.spp, "{header:?}");
                assert!(compare(&header.identity, &header.identity).is_ok(), "{header:?}");
                let _ = compare(&header.identity, &serde_json::json!({ "scene": 1, "seed": 7 }));
            }
            Err(error) => assert!(!error.to_string().contains('\n'), "{error}"),
        }
    }
}
