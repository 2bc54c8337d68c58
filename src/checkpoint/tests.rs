//! Row D6: a checkpoint is whole and the render's own, or refused.

use super::*;
use crate::film::{FilmUse, Tile};
use serde_json::json;

const OF: FilmUse = FilmUse { layers: true, signed: false, keeps: true };

/// A film of 2×1 tiles, the second one only partly in the picture, with `samples[i]` in tile i.
fn film(samples: [u32; 2], spp: u32) -> Film {
    let film = Film::new([13, 8], OF).unwrap();
    let mut tile = Tile::default();
    for (i, samples) in samples.into_iter().enumerate() {
        let mut done = 0;
        for block in (0..).map(crate::film::block).take_while(|b| b.start < samples) {
            film.copy(i, &mut tile);
            for pixel in (0..64).filter(|p| i == 0 || p % 8 < 5) {
                for index in block.start..block.end.min(samples) {
                    let value = f64::from(index * 7 + pixel) / 3.0;
                    tile.add(pixel as usize, crate::math::DVec3::splat(value), 1.0, true);
                }
            }
            done = block.end;
            film.put(i, &tile, block.end > spp);
        }
        assert!(done >= samples);
    }
    film
}

fn header(spp: u32) -> Header {
    let identity = json!({ "drt": { "version": "1", "render": { "seed": 0 } }, "scene": { "meshes": "a" } });
    Header { identity, spp, layers: true, tiles: 2, samples: (0, 0) }
}

fn bytes_of(film: &Film, spp: u32) -> Vec<u8> {
    let mut bytes = Vec::new();
    format::write(&mut bytes, &header(spp), film, &[0, 1]).unwrap();
    bytes
}

#[test]
fn d6_a_checkpoint_comes_back_bit_for_bit() {
    for (samples, spp) in [([16, 1], 64), ([0, 16], 16), ([20, 16], 20), ([7, 7], 7), ([0, 0], 4)] {
        let bytes = bytes_of(&film(samples, spp), spp);
        let header = read(&bytes).unwrap();
        assert_eq!(header.samples, (samples[0].min(samples[1]), samples[0].max(samples[1])));
        let again = Film::new([13, 8], OF).unwrap();
        format::scan(&*bytes, &mut |i, saved| {
            assert!(again.restore(i, saved, spp));
            Ok(())
        })
        .unwrap();
        assert_eq!([again.samples_of(0), again.samples_of(1)], samples);
        assert_eq!(again.samples_done([8, 0, 5, 8]), (samples[1], samples[1]), "pixels outside the picture");
        assert!(bytes_of(&again, spp) == bytes);
    }
}

/// A last block that was cut short is taken back for more samples; whole blocks are not.
#[test]
fn a_block_that_was_cut_short_is_traced_again_for_more_samples() {
    let bytes = bytes_of(&film([20, 16], 20), 20);
    for (spp, expected) in [(20, [20, 16]), (18, [16, 16]), (64, [16, 16])] {
        let again = Film::new([13, 8], OF).unwrap();
        format::scan(&*bytes, &mut |i, saved| {
            assert!(again.restore(i, saved, spp));
            Ok(())
        })
        .unwrap();
        assert_eq!([again.samples_of(0), again.samples_of(1)], expected);
        let whole = bytes_of(&film(expected, spp), spp);
        assert!(spp == 20 || bytes_of(&again, spp) == whole, "not what {expected:?} samples would have been");
    }
    let few = Film::new([13, 8], OF).unwrap();
    format::scan(&*bytes, &mut |i, saved| {
        assert!(!few.restore(i, saved, 8), "16 samples are no 8");
        Ok(())
    })
    .unwrap();
}

/// Every flipped bit, every cut, and anything behind the end.
#[test]
fn d6_damage_anywhere_is_noticed() {
    let mut bytes = bytes_of(&film([1, 0], 16), 16);
    read(&bytes).unwrap();
    for i in 0..bytes.len() {
        for bit in [0, 3, 7] {
            bytes[i] ^= 1 << bit;
            let error = read(&bytes).unwrap_err().message;
            assert!(error.contains("checkpoint"), "byte {i}: {error}");
            bytes[i] ^= 1 << bit;
        }
        assert!(read(&bytes[..i]).is_err(), "cut at {i}");
    }
    bytes.push(0);
    assert!(read(&bytes).is_err());
}

/// What has a right checksum and makes no sense.
#[test]
fn d6_forged_checkpoints_are_refused() {
    let seal = |body: &[u8]| [body, blake3::hash(body).as_bytes()].concat();
    let bytes = bytes_of(&film([1, 0], 16), 16);
    let body = &bytes[..bytes.len() - 32];
    assert!(read(&seal(body)).is_ok());
    let tiles = body.len() - (4 * 8 + 12 * 8 + 4 * 4) * 64 - 16;
    let forged = |at: usize, word: u32| {
        let mut body = body.to_vec();
        body[at..at + 4].copy_from_slice(&word.to_le_bytes());
        read(&seal(&body)).unwrap_err().message
    };
    assert!(forged(tiles, 2).contains("damaged"), "more in blocks than in all");
    assert!(forged(tiles + 4, 5).contains("damaged"), "cut short where no block ends");
    for text in [
        "drt checkpoint 1\n{}\n",
        "drt checkpoint 1\n[]\n",
        "drt checkpoint 1\n{\"identity\":{},\"layers\":false,\"spp\":1,\"tiles\":18446744073709551615}\n",
        "drt checkpoint 1\n{\"identity\":{},\"layers\":false,\"spp\":-1,\"tiles\":0}\n",
        &format!("drt checkpoint 1\n{}", " ".repeat(1 << 17)),
        "drt checkpoint 99999999999999999999999\n",
    ] {
        assert!(read(&seal(text.as_bytes())).unwrap_err().message.contains("damaged"), "{text:.60}");
    }
    let other = read(&seal(b"drt checkpoint 2\n{}\n")).unwrap_err().to_string();
    assert!(other.contains("format 2") && other.contains("this drt has 1"), "{other}");
    assert!(read(b"\x89PNG").unwrap_err().message.contains("no checkpoint"));
    assert!(read(b"").unwrap_err().message.contains("no checkpoint"));
}

#[test]
fn d6_what_differs_is_named() {
    let then = json!({ "drt": { "render": { "seed": 1, "spp": 4 }, "version": "0.1.0" }, "scene": { "meshes": "a", "lights": "b" }, "settings": "x" });
    let error = |now: Value| compare(&then, &now).unwrap_err().to_string();
    assert!(compare(&then, &then).is_ok());
    assert!(compare(&then, &json!({ "drt": { "render": { "seed": 1 } } })).is_ok(), "what is not stated");
    assert!(
        error(json!({ "drt": { "render": { "seed": 2 } } })).contains("render.seed = 1, and now it is 2")
    );
    assert!(error(json!({ "drt": { "version": "0.2.0" } })).contains("drt 0.1.0, and this is 0.2.0"));
    assert!(error(json!({ "drt": { "new": 2 } })).contains("new = nothing, and now it is 2"));
    assert!(error(json!({ "scene": { "meshes": "a", "lights": "c" } })).contains("other lights"));
    assert!(error(json!({ "settings": "y" })).contains("other settings"));
}

#[test]
fn d3_checkpoints_follow_no_links_and_belong_to_their_user() {
    use std::os::unix::fs::{PermissionsExt, symlink};
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    std::fs::write(at("victim"), "precious").unwrap();
    symlink("victim", at("planted")).unwrap();
    symlink("nowhere", at("dangling")).unwrap();
    std::fs::create_dir(at("folder")).unwrap();
    rustix::fs::mkfifoat(rustix::fs::CWD, at("fifo"), 0o600.into()).unwrap();
    for (name, why) in [
        ("planted", "link"),
        ("dangling", "link"),
        ("folder", "a folder"),
        ("fifo", "a pipe"),
        ("no/such", "does not exist"),
    ] {
        let error = check_path(&at(name)).unwrap_err().to_string();
        assert!(error.contains(why) && error.contains(name), "{error}");
    }
    // One that is planted after the check is replaced and not followed.
    write(&at("planted"), &header(1), &film([1, 1], 1), &[0, 1]).unwrap();
    assert_eq!(std::fs::read(at("victim")).unwrap(), b"precious");
    let about = std::fs::symlink_metadata(at("planted")).unwrap();
    assert!(about.is_file());
    assert_eq!(about.permissions().mode() & 0o077, 0, "others may read it");
    assert_eq!(Checkpoint::open(&at("planted")).unwrap().unwrap().header().samples, (1, 1));
    assert!(Checkpoint::open(&at("none")).unwrap().is_none());
}
