//! Rows B1 … B5, B10 of the table of inputs that go wrong.

use super::*;
use crate::load::obj::Library;
use proptest::prelude::*;

fn one(text: &str) -> MtlMaterial {
    let file = parse(format!("newmtl m\n{text}").as_bytes(), Path::new("t.mtl"));
    assert_eq!(file.materials.len(), 1, "{text}");
    file.materials.into_iter().next().unwrap()
}

fn findings(text: &str) -> Vec<(&'static str, u64)> {
    let file = parse(format!("newmtl m\n{text}").as_bytes(), Path::new("t.mtl"));
    file.findings.kept().map(|f| (f.kind, f.line)).collect()
}

/// A folder with files; the OBJ is `scene.obj` in it.
struct Folder(tempfile::TempDir);

impl Folder {
    fn with(files: &[(&str, &str)]) -> Folder {
        let folder = tempfile::tempdir().unwrap();
        for (name, text) in files {
            let path = folder.path().join(name);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, text).unwrap();
        }
        Folder(folder)
    }

    fn resolve(&self, statements: &[&str], names: &[&str]) -> Resolved {
        let libraries: Vec<_> = (1..)
            .zip(statements)
            .map(|(line, names)| Library { line, names: names.as_bytes().to_vec() })
            .collect();
        let names: Vec<_> = names.iter().map(|n| n.as_bytes().to_vec()).collect();
        resolve(&self.0.path().join("scene.obj"), &libraries, &names, &|_| false, &Reach::Anywhere)
    }
}

fn kinds(resolved: &Resolved) -> Vec<(&'static str, u64)> {
    resolved.findings.kept().map(|f| (f.kind, f.line)).collect()
}

#[test]
fn every_key_is_read() {
    let m = one(
        "Kd .1 .2 .3\nKs 0.5\nKe 10 20 30\nTf 1 .5 1\nNs 250\nNi 1.5\nd 0.25\nillum 7\nPr .1\nPm .2\nPs .3\nPc .4\nPcr .5\naniso -.6\nanisor .7\n\
         map_Kd a\nmap_Ks b\nmap_Ke c\nmap_Ns d\nmap_d e\nmap_Bump f\nnorm g\nmap_Pr h\nmap_Pm i\ndisp j\n",
    );
    assert_eq!(m.kd, Some(At { value: [0.1, 0.2, 0.3], line: 2 }));
    assert_eq!(m.ks.unwrap().value, [0.5; 3]);
    assert_eq!(m.ke.unwrap().value, [10.0, 20.0, 30.0]);
    assert_eq!(m.tf.unwrap().value, [1.0, 0.5, 1.0]);
    let scalars = [m.ns, m.ni, m.d, m.pr, m.pm, m.ps, m.pc, m.pcr, m.aniso, m.anisor].map(|s| s.unwrap());
    assert_eq!(scalars.map(|s| s.value), [250.0, 1.5, 0.25, 0.1, 0.2, 0.3, 0.4, 0.5, -0.6, 0.7]);
    assert_eq!(scalars.map(|s| s.line), [6, 7, 8, 10, 11, 12, 13, 14, 15, 16]);
    assert_eq!(m.illum.unwrap().value, 7);
    let files: String = m.textures().map(|(_, t)| t.value.file.display().to_string()).collect();
    assert_eq!(files, "abcdefghij");
    assert_eq!(one("Tr 0.25\r\n\tKD 1 1 1").d.unwrap().value, 0.75);
    assert_eq!(one("kd \\\n 1 0 \\\r\n 1\nd -halo .5").kd.unwrap(), At { value: [1.0, 0.0, 1.0], line: 2 });
    assert_eq!(one("kd \\\n 1 0 1\nd -halo .5").d.unwrap(), At { value: 0.5, line: 4 });
    assert_eq!(one("bump x\rmap_Kd y").map_kd.unwrap().line, 3);
}

#[test]
fn b4_texture_options_and_names_with_spaces() {
    let t = one("map_Kd -s 2 2 2 -o .1 0 0 -clamp on name with  space.png").map_kd.unwrap().value;
    assert_eq!(t.file, Path::new("name with  space.png"));
    assert_eq!((t.options.scale, t.options.offset, t.options.clamp), ([2.0; 3], [0.1, 0.0, 0.0], true));
    let text = "-bm 0.5 -imfchan l -type cube_top -mm 0.1 2 -blendu off -blendv off -cc on -boost 3 -texres 512 -t 1 2 -s 4 a.png";
    let t = one(&format!("bump {text}")).bump.unwrap().value;
    let expected = TextureOptions {
        bump_multiplier: 0.5,
        channel: Some(Channel::Luminance),
        kind: Some("cube_top".to_string()),
        base_gain: [0.1, 2.0],
        blend_u: false,
        blend_v: false,
        color_correction: true,
        boost: 3.0,
        resolution: 512.0,
        turbulence: [1.0, 2.0, 0.0],
        scale: [4.0, 1.0, 1.0],
        ..TextureOptions::default()
    };
    assert_eq!((t.file.to_str().unwrap(), t.options), ("a.png", expected));
    for (statement, file) in [
        ("a b.png -bm 0.3", "a b.png"),
        ("-bm x.png", "-bm x.png"),
        ("-foo a.png", "-foo a.png"),
        ("1", "1"),
        ("-s 1 1 2", "2"),
        ("-o 1", "-o 1"),
        ("..\\tex\\A.PNG", "../tex/A.PNG"),
        ("-clamp on -clamp off", "-clamp off"),
        ("a -bm 1 b.png", "a -bm 1 b.png"),
    ] {
        assert_eq!(
            one(&format!("map_Kd {statement}")).map_kd.unwrap().value.file,
            Path::new(file),
            "{statement}"
        );
    }
    assert_eq!(one("bump a b.png -bm 0.3").bump.unwrap().value.options.bump_multiplier, 0.3);
    assert_eq!(findings("map_Kd"), [("mtl-value-ignored", 2)]);
}

#[test]
fn b5_values_are_physical_and_finite() {
    for (text, value) in [
        ("Kd nan 0 0", None),
        ("Kd -1 0 2", Some([0.0, 0.0, 1.0])),
        ("Kd 1e30", Some([1.0; 3])),
        ("Kd", None),
        ("Kd spectral f.rfl", None),
        ("Kd xyz .1 .2 .3", None),
        ("Kd 1 2", None),
        ("Kd a b c", None),
        ("Kd inf inf inf", None),
    ] {
        assert_eq!(one(text).kd.map(|k| k.value), value, "{text}");
        assert_eq!(findings(text).len(), 1, "{text}");
    }
    let scalar = |text: &str| {
        let m = one(text);
        let stated = [m.ns, m.d, m.ni].into_iter().flatten().next().map(|v| v.value);
        assert_eq!(findings(text).len(), 1, "{text}");
        stated
    };
    assert_eq!(scalar("Ns -5"), Some(0.0));
    assert_eq!(scalar("Ns 1e9"), Some(1e6));
    assert_eq!(scalar("d 2"), Some(1.0));
    assert_eq!(scalar("Ni 0"), Some(1.0));
    assert_eq!(scalar("Ns nan"), None);
    assert_eq!(scalar("d"), None);
    assert_eq!(one("illum 99").illum, None);
    assert_eq!(findings("illum 99"), [("mtl-value-ignored", 2)]);
    let early = parse(b"Kd 1 1 1\nnewmtl a\nKd 0 0 0\nfrobnicate\nKa 1 1 1\n", Path::new("t"));
    let kinds: Vec<_> = early.findings.kept().map(|f| (f.kind, f.line)).collect();
    assert_eq!(kinds, [("mtl-before-newmtl", 1), ("mtl-unknown-statement", 4)]);
    assert_eq!(parse(b"", Path::new("t")).findings.count("mtl-without-materials"), 1);
}

#[test]
fn b5_the_last_definition_holds() {
    let folder = Folder::with(&[
        ("a.mtl", "newmtl m\nKd 1 0 0\nnewmtl m\nKd 0 1 0\n"),
        ("b.mtl", "newmtl m\nKd 0 0 1\n"),
    ]);
    let r = folder.resolve(&["a.mtl"], &["m", "", "unknown"]);
    assert_eq!(r.materials[0].as_ref().unwrap().kd.unwrap().value, [0.0, 1.0, 0.0]);
    assert!(r.materials[1].is_none() && r.materials[2].is_none());
    assert_eq!(kinds(&r), [("material-redefined", 3), ("material-unknown", 0)]);
    let r = folder.resolve(&["a.mtl b.mtl"], &["m"]);
    assert_eq!(r.materials[0].as_ref().unwrap().kd.unwrap().value, [0.0, 0.0, 1.0]);
    assert_eq!(r.findings.count("material-redefined"), 2);
}

#[test]
fn b1_libraries_are_found() {
    let folder = Folder::with(&[
        ("with space.mtl", "newmtl s\n"),
        ("a.mtl", "newmtl a\n"),
        ("b.mtl", "newmtl b\n"),
        ("Big.MTL", "newmtl c\n"),
        ("sub/Deep.mtl", "newmtl d\n"),
    ]);
    let r = folder.resolve(&["with space.mtl"], &["s"]);
    assert!(r.materials[0].is_some() && r.findings.is_empty());
    let r = folder.resolve(&["a.mtl b.mtl", "a.mtl", "none.mtl", "b.mtl nope.mtl"], &["a", "b"]);
    assert!(r.materials.iter().all(Option::is_some));
    assert_eq!(kinds(&r), [("mtllib-missing", 3), ("mtllib-missing", 4)]);
    assert_eq!(r.libraries.len(), 2);
    let r = folder.resolve(&["big.mtl", "SUB/deep.mtl"], &["c", "d"]);
    assert!(r.materials.iter().all(Option::is_some));
    assert_eq!(kinds(&r), [("mtllib-other-case", 1), ("mtllib-other-case", 2)]);
    let none = folder.resolve(&[], &["a"]);
    assert_eq!(kinds(&none), [("material-unknown", 0)]);
}

#[test]
fn b2_paths_of_other_systems() {
    let folder = Folder::with(&[("x.mtl", "newmtl x\n"), ("sub/y.mtl", "newmtl y\n")]);
    for (stated, kind) in [
        (".\\x.mtl", None),
        (".//x.mtl", None),
        ("C:\\models\\x.mtl", Some("mtllib-other-folder")),
        ("c:/x.mtl", Some("mtllib-other-folder")),
        ("..\\elsewhere\\X.mtl", Some("mtllib-other-folder")),
        ("\\\\server\\x.mtl", Some("mtllib-other-folder")),
        ("/nowhere/x.mtl", Some("mtllib-other-folder")),
    ] {
        let r = folder.resolve(&[stated], &["x"]);
        assert!(r.materials[0].is_some(), "{stated}");
        assert_eq!(r.findings.kept().next().map(|f| f.kind), kind, "{stated}");
    }
    assert!(folder.resolve(&["sub\\y.mtl"], &["y"]).findings.is_empty());
}

/// Row B10, and B3 for libraries: nothing blocks, nothing is quoted.
#[test]
#[cfg(unix)]
fn b10_only_regular_files_are_read_and_never_quoted() {
    let secret = "hunter2-not-for-your-eyes";
    let folder = Folder::with(&[(
        "secret.txt",
        &format!("{secret}\nKd {secret}\nnewmtl {secret}\nKd {secret}\n{secret} 1\nmap_Kd -bm {secret}\n"),
    )]);
    let pipe = folder.0.path().join("pipe");
    rustix::fs::mknodat(rustix::fs::CWD, &pipe, rustix::fs::FileType::Fifo, 0o600.into(), 0).unwrap();
    let r = folder.resolve(&["secret.txt", "pipe", "/dev/zero", ".", "a\0b"], &["m"]);
    assert_eq!(r.findings.count("mtllib-unreadable"), 3);
    assert_eq!(r.findings.count("mtllib-missing"), 1);
    assert!(!r.findings.kept().any(|f| f.message.contains("hunter2")));
    assert!(r.findings.count("mtl-value-ignored") > 0);
}

proptest! {
    #[test]
    fn token_soup_is_safe(words in proptest::collection::vec(proptest::sample::select(vec![
        "newmtl", "Kd", "Ns", "d", "Tr", "illum", "map_Kd", "bump", "-s", "-o", "-bm", "-clamp", "on", "-mm", "-imfchan", "r", "1", "-1",
        "nan", "1e99", "\n", "\n", "\n", "\\\n", "\r\n", "\r", "\\", "#", "a b", "é", "spectral", "-halo", "\0", "",
    ]), 0..80), bytes in proptest::collection::vec(any::<u8>(), 0..20)) {
        let mut text = words.join(" ").into_bytes();
        text.extend(bytes);
        for m in parse(&text, Path::new("t")).materials {
            let colors = [m.kd, m.ks, m.ke, m.tf].into_iter().flatten().flat_map(|c| c.value);
            let scalars = [m.ns, m.ni, m.d, m.pr, m.pm].into_iter().flatten().map(|s| s.value);
            prop_assert!(colors.chain(scalars).all(|x| (0.0..=1e9).contains(&x)));
        }
    }
}
