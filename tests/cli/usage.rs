//! Wrong words end with 2 before anything is read or written.

use super::{drt, folder, names};
use std::os::unix::ffi::OsStrExt;

/// Flag, words that are wrong for it, what the message must name.
const NUMBERS: &[(&str, &[&str], &str)] = &[
    ("--spp", &["0", "-1", "1e18", "nan", "inf", "٣", "", "text", "1.5", "1048577"], "from 1 to 1048576"),
    ("--max-depth", &["-1", "1e9", "65536", "nan", "inf", "", "text"], "from 0 to 65535"),
    ("--seed", &["-1", "18446744073709551616", "nan", "inf", "", "text"], "from 0 to 18446744073709551615"),
    ("--threads", &["0", "-1", "1000000", "nan", "inf", "", "text"], "from 1 to 1024"),
    ("--exposure", &["inf", "nan", "1e9", "", "text"], "from -64 to 64"),
    (
        "--size",
        &["0x0", "-1x5", "1000000000x1000000000", "4294967296x1", "nanx5", "infx5"],
        "from 1 to 1048576",
    ),
    ("--size", &["65536x65536"], "268435456"),
    ("--size", &["", "5", "5x", "text", "5x5x5"], "--size"),
    ("--crop", &["0,0,0,0", "0,0,99999,1", "-1,0,1,1", "nan,0,1,1"], "film.crop"),
    ("--crop", &["", "1", "1,2,3", "text"], "X,Y,WIDTH,HEIGHT"),
];

const WORDS: &[(&str, &str)] = &[
    ("--integrator", "path"),
    ("--sampler", "sobol"),
    ("--backend", "bvh"),
    ("--isa", "avx2"),
    ("--tone-map", "reinhard"),
    ("--progress", "plain"),
    ("--view", "front"),
    ("--sky", "studio"),
    ("--focus", "X,Y"),
    ("--up", "-z"),
    ("--aov", "depth"),
];

#[test]
fn numbers_out_of_range_name_the_range() {
    let folder = folder();
    for (flag, values, range) in NUMBERS {
        for value in *values {
            let ended = drt(folder.path(), &["t.obj", flag, value]);
            ended.expect(2, &[flag, range]);
        }
    }
    assert_eq!(names(folder.path()), ["s.toml", "t.obj"]);
}

#[test]
fn unknown_names_list_the_known_ones() {
    let folder = folder();
    for (flag, known) in WORDS {
        for value in ["", "0", "nan", "no such name"] {
            drt(folder.path(), &["t.obj", flag, value]).expect(2, &[flag, known]);
        }
    }
}

#[test]
fn a_slip_gets_a_suggestion() {
    let folder = folder();
    let dir = folder.path();
    drt(dir, &["t.obj", "--sppp", "4"]).expect(2, &["--sppp", "'--spp'", "drt --help"]);
    drt(dir, &["t.obj", "--integrator", "pth"]).expect(2, &["did you mean \"path\"?"]);
    drt(dir, &["t.obj", "--set", "film.fliter=box"]).expect(2, &["did you mean \"filter\"?"]);
    drt(dir, &["t.obj", "--view", "frnt"]).expect(2, &["did you mean \"front\"?"]);
    drt(dir, &["t.obj", "--sky", "evening.hdr"]).expect(1, &["evening.hdr", "No such file"]);
}

#[test]
fn other_wrong_words() {
    let folder = folder();
    let dir = folder.path();
    drt::<&str>(dir, &[]).expect(2, &["no input"]);
    drt(dir, &["render"]).expect(2, &["no input"]);
    drt(dir, &["t.obj", "--spp"]).expect(2, &["--spp"]);
    drt(dir, &["t.obj", "--spp", "4", "--spp", "5"]).expect(2, &["--spp"]);
    drt(dir, &["t.obj", "s.toml"]).expect(2, &["s.toml"]);
    drt(dir, &["t.obj", "-q", "-v"]).expect(2, &[]);
    drt(dir, &["t.obj", "--set", "camera.fov=180"]).expect(2, &["camera.fov", "179.9"]);
    drt(dir, &["s.toml", "--view", "top", "--set", "camera.position=[0,0,9]"]).expect(2, &["--view"]);
    drt(dir, &["t.obj", "-o", "a.png", "-o", "./a.png"]).expect(2, &["twice"]);
    let not_utf8 = std::ffi::OsStr::from_bytes(b"\xff\xfe");
    drt(dir, &["t.obj".as_ref(), "--spp".as_ref(), not_utf8]).expect(2, &[]);
    assert_eq!(names(dir), ["s.toml", "t.obj"]);
}

#[test]
fn help_and_version_answer_on_stdout() {
    let folder = folder();
    let help = drt(folder.path(), &["--help"]);
    help.expect(0, &[]);
    for word in
        ["EXAMPLES", "--spp", "EXIT CODES", "gaussian", "conductor", "three-quarter", "sobol", "render"]
    {
        assert!(help.out.contains(word), "{word} is not in the help");
    }
    assert!(help.err.is_empty());
    let version = drt(folder.path(), &["--version"]);
    version.expect(0, &[]);
    assert!(version.out.starts_with(concat!("drt ", env!("CARGO_PKG_VERSION"), "\n")), "{}", version.out);
    assert!(version.out.contains("bvh") && version.out.contains("mbree") && version.out.contains("sse2"));
    drt(folder.path(), &["-h"]).expect(0, &[]);
    drt(folder.path(), &["render", "--help"]).expect(0, &[]);
}

#[test]
fn focus_needs_a_lens_and_something_to_see() {
    let folder = folder();
    let dir = folder.path();
    let small = ["t.obj", "--size", "32x24", "--spp", "1", "--focus"];
    let with = |rest: &[&'static str]| drt(dir, &[&small[..], rest].concat());
    with(&["16,12"]).expect(2, &["--focus", "no lens", "camera.aperture"]);
    with(&["32,0", "--set", "camera.aperture=0.01"]).expect(2, &["--focus", "outside the picture of 32x24"]);
    with(&["0,0", "--set", "camera.aperture=0.01"]).expect(2, &["--focus", "0,0 sees nothing"]);
}

/// What one run writes, the next one takes as its light.
#[test]
fn a_picture_is_a_sky() {
    let folder = folder();
    let dir = folder.path();
    let small = ["t.obj", "--size", "32x16", "--spp", "1"];
    drt(dir, &[&small[..], &["-q", "-o", "sky.hdr"]].concat()).expect(0, &[]);
    drt(dir, &[&small[..], &["-q", "--sky", "sky.hdr", "-o", "lit.png"]].concat()).expect(0, &[]);
    drt(dir, &[&small[..], &["--sky", "sky.hdr", "-o", "sky.hdr"]].concat())
        .expect(1, &["sky.hdr", "both input and output"]);
}
