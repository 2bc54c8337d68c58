use super::*;
use drt::film::Image;

fn args(words: &[&str]) -> Args {
    Args::parse_from([&["bench"], words].concat())
}

/// A small Cornell box and a small bumpy sphere go all the way; the figures hang together.
#[test]
fn small_scenes_are_measured() {
    let folder = tempfile::tempdir().unwrap();
    let dir = folder.path().to_str().unwrap();
    let args = args(&["--dir", dir, "--size", "24", "--spp", "8", "--millions", "0.01", "--longer", "4"]);
    assert!(Bench::make("S2", &args).unwrap().is_none(), "no dragon was given");
    assert!(Bench::make("S5", &args).is_err());
    assert!(Bench::make("U3", &args).unwrap().is_none(), "no dragon was given");
    for name in ["S1", "S3", "U2", "U4"] {
        let bench = Bench::make(name, &args).unwrap().unwrap();
        let m = measure::measure(&bench, "bvh", &args).unwrap();
        assert_eq!((m.samples, m.rays[0]), (24.0 * 24.0 * 8.0, 24 * 24 * 8));
        assert!(m.rays[1] > 0 && (m.rays[2] > 0) == (name != "S3"), "{name}: {:?}", m.rays);
        // Eight samples in a room with one window are few.
        assert!(m.error > 1e-4 && m.error < if name == "U4" { 10.0 } else { 1.0 }, "{name}: {}", m.error);
        assert!(m.replayed > 0.0 && m.inside > 0.0 && m.inside < 1.0);
        assert!(m.bytes.iter().all(|b| *b > 0.0));
    }
}

/// Each triangle of the scan is four of a quarter of its area, which share the middles of the edges.
#[test]
fn a_scan_is_cut_in_four() {
    let folder = tempfile::tempdir().unwrap();
    let dragon = folder.path().join("dragon.obj");
    let corners = "v 0 0 0\nv 2 0 0\nv 0 2 0\nv 2 2 0\nvn 0 0 1\nvn 0 0 1\nvn 0 0 1\nvn 0 0 1\n";
    std::fs::write(&dragon, format!("{corners}f 1//1 2//2 3//3\nf 2//2 4//4 3//3\n")).unwrap();
    let made = args(&["--dir", folder.path().to_str().unwrap(), "--dragon", dragon.to_str().unwrap()]);
    Bench::make("U3", &made).unwrap().unwrap();
    let scan = folder.path().join("scan-3.5M.obj");
    let scene = drt::load::scene(&scan, drt::load::Options::default()).unwrap().scene;
    let mesh = &scene.meshes[0];
    assert_eq!((mesh.positions.len(), mesh.indices.len()), (9, 8));
    for triangle in 0..8 {
        let [a, b, c] = mesh.triangle(triangle);
        assert!(((b - a).cross(c - a).z - 1.0).abs() < 1e-6);
    }
    std::fs::write(&dragon, "v 0 0 0\nf 1 2 3\n").unwrap();
    std::fs::remove_file(scan).unwrap();
    assert!(Bench::make("U3", &made).is_err(), "no normals");
}

/// The error is relative, and a lamp with its rim does not count.
#[test]
fn errors_are_relative_and_leave_the_lamp_out() {
    let flat = |value: f32, lamp: f32| {
        let mut pixels = vec![[value; 3]; 100];
        pixels[0] = [lamp; 3];
        Image::from_rgb(10, 10, &pixels, String::new())
    };
    let error = |a: &Image, b: &Image, hides| measure::relative_error(a, b, hides).unwrap();
    let off = error(&flat(1.1, 1.0), &flat(1.0, 1.0), false);
    assert!((off - 0.99 * 0.01 / 1.01).abs() < 1e-6, "{off}");
    assert_eq!(error(&flat(1.0, 50.0), &flat(1.0, 9.0), true), 0.0);
    assert!(error(&flat(1.0, 50.0), &flat(1.0, 9.0), false) > 0.1);
    let small = Image::from_rgb(1, 1, &[[0.0; 3]], String::new());
    assert!(measure::relative_error(&small, &flat(1.0, 1.0), false).is_err());
}
