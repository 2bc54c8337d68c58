//! Memory limits (row D7): what does not fit is refused with the figures, before it is begun; at any limit the program
//! ends with 0 or 1.

use super::universal::{Run, engines};
use super::{drt, folder};
use std::fmt::Write;
use std::fs;
use std::path::Path;

/// A mesh of 2·side² triangles, `large.obj`.
fn terrain(dir: &Path, side: usize) {
    let mut text = String::new();
    for i in 0..(side + 1) * (side + 1) {
        let (x, z) = (i % (side + 1), i / (side + 1));
        writeln!(text, "v {x} {}.{} {z}", i * 7919 % 3, i * 31 % 10).unwrap();
    }
    for i in (0..(side + 1) * side).filter(|i| i % (side + 1) < side) {
        let (a, b) = (i + 1, i + side + 2);
        writeln!(text, "f {a} {} {b}\nf {} {} {b}", a + 1, a + 1, b + 1).unwrap();
    }
    fs::write(dir.join("large.obj"), text).unwrap();
}

const TINY: [&str; 6] = ["--size", "16x12", "--spp", "1", "-o", "p.png"];

#[test]
fn what_does_not_fit_is_refused_with_what_would() {
    let folder = folder();
    let dir = folder.path();
    let limit = "--max-memory";
    drt(dir, &["t.obj", limit, "200M", "--size", "10000x10000"]).expect(
        1,
        &[
            "7200 MB are needed",
            "10000x10000",
            "MB are left (--max-memory of 210 MB)",
            "--size 1250x1250 needs",
        ],
    );
    terrain(dir, 700);
    let words = |more: &[&'static str]| [&["large.obj"], TINY.as_slice(), more].concat();
    let refused = drt(dir, &words(&[limit, "64M"]));
    refused.expect(1, &["1.0 million triangles", "(--max-memory of 68 MB)", "a machine with more memory"]);
    #[cfg(feature = "embree")]
    {
        drt(dir, &words(&[limit, "120M"])).expect(1, &["--compact needs"]);
        drt(dir, &words(&[limit, "132M", "--compact"])).expect(0, &[]);
    }
    drt(dir, &words(&[limit, "1G"])).expect(0, &[]);
}

#[test]
fn limits_that_are_none_are_wrong_usage() {
    let folder = folder();
    for word in ["0", "-1", "nan", "inf", "1e300", "much", "", "63M", "1Q"] {
        drt(folder.path(), &["t.obj", "--max-memory", word]).expect(2, &["--max-memory"]);
    }
}

/// The flag and the key are one: the picture says so, and the automatic build is the one that stays small.
#[cfg(feature = "embree")]
#[test]
fn compact_is_a_flag_and_in_the_picture() {
    let folder = folder();
    let dir = folder.path();
    terrain(dir, 300);
    let settings = |more: &[&str]| {
        let words = ["large.obj", "-o", "p.exr", "--spp", "1", "--size", "8x8", "--backend", "embree"];
        drt(dir, &[&words, more].concat()).expect(0, &[]);
        // The settings are plain text in the file's header.
        let bytes = fs::read(dir.join("p.exr")).expect("a picture");
        let text = String::from_utf8_lossy(&bytes).into_owned();
        let has = |word: &str| text.contains(word);
        [has("\"compact\":true"), has("\"build\":\"medium\""), has("\"build\":\"low\"")]
    };
    assert_eq!(settings(&[]), [false, false, true]);
    for flag in [["--compact", "-q"], ["--set", "render.compact=true"]] {
        assert_eq!(settings(&flag), [true, true, false]);
        assert_eq!(settings(&[&flag[..], &["--set", "render.build=low"]].concat()), [true, false, true]);
    }
}

/// Row D7: whatever the limit of the address space, a mesh of half a million triangles is rendered or refused.
#[test]
fn d7_at_any_limit_the_program_ends_with_0_or_1() {
    let folder = folder();
    let dir = folder.path();
    terrain(dir, 500);
    for engine in engines() {
        let words: Vec<&str> = [&["large.obj"], TINY.as_slice(), &engine].concat();
        let code = |megabytes: usize| {
            let limits = format!("ulimit -v {}", megabytes * 1000);
            Run::new(dir, &words).limits(&limits).check().code
        };
        let codes: Vec<Option<i32>> = (0..5).map(|i| code(256 + 60 * i)).collect();
        assert!(codes.iter().all(|code| [Some(0), Some(1)].contains(code)), "{engine:?}: {codes:?}");
        assert_eq!(code(4000), Some(0), "{engine:?}");
    }
}

/// Row D12: the peak grows with the triangles, evenly: nowhere a cliff. `DRT_HEAVY_TESTS=1` goes to ten million.
#[test]
fn d12_peak_memory_is_linear_in_the_triangles() {
    let heavy = std::env::var_os("DRT_HEAVY_TESTS").is_some_and(|v| v == "1");
    let sides: &[usize] = if heavy { &[225, 707, 1304, 2225] } else { &[225, 707, 1000] };
    for engine in engines() {
        let peaks: Vec<[f64; 2]> =
            sides.iter().map(|side| [2.0 * (side * side) as f64, peak(*side, &engine)]).collect();
        let slopes: Vec<f64> = peaks.windows(2).map(|p| (p[1][1] - p[0][1]) / (p[1][0] - p[0][0])).collect();
        eprintln!("{engine:?}: bytes a triangle {slopes:.0?}");
        assert!(slopes.iter().all(|slope| *slope > 30.0 && *slope < 170.0), "{engine:?}: {slopes:?}");
        let (least, most) = slopes.iter().fold((f64::MAX, 0.0f64), |(a, b), s| (a.min(*s), b.max(*s)));
        assert!(most < 1.5 * least, "{engine:?}: {slopes:?}");
    }
}

/// The most memory that a render of `terrain` takes.
fn peak(side: usize, engine: &[&str]) -> f64 {
    let folder = folder();
    let dir = folder.path();
    terrain(dir, side);
    drt(dir, &[&["large.obj", "--stats", "s.json"], TINY.as_slice(), engine].concat()).expect(0, &[]);
    let stats: serde_json::Value = serde_json::from_slice(&fs::read(dir.join("s.json")).unwrap()).unwrap();
    stats["peak_rss_bytes"].as_f64().unwrap()
}
