//! A reproducer's files keep every bit, and what is none is told apart.

use super::*;
use crate::load::open::Reach;

#[test]
fn files_that_are_no_reproducer() {
    let folder = tempfile::TempDir::new().unwrap();
    let (case, obj) = (folder.path().join("c.toml"), folder.path().join("c.obj"));
    let text = "[case]\nmesh = \"c.obj\"\norigin = [0, 0, 1]\ndirection = [0, 0, -1]\ntmin = 0\ntmax = inf\n";
    std::fs::write(&obj, "o a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    let read = |text: &str| {
        std::fs::write(&case, text).unwrap();
        Reproducer::read(&case, &Reach::Anywhere)
    };
    assert_eq!(read(text).unwrap().unwrap().meshes[0].indices, [[0, 1, 2]]);
    assert!(read("[camera]\nfov = 3\n").unwrap().is_none());
    assert!(read("no TOML").unwrap().is_none());
    for (from, to, said) in [
        ("origin = [0, 0, 1]", "origin = [0, 1]", "case.origin must be three numbers"),
        ("tmin = 0", "tmin = -1", "tmin not negative"),
        ("tmin = 0", "", "case.tmin must be a number"),
        ("c.obj", "d.obj", "d.obj"),
    ] {
        let error = read(&text.replace(from, to)).unwrap_err().to_string();
        assert!(error.contains(said), "{error}");
    }
    for line in ["v 1 2", "v 1 2 nan", "v 1 2 1e30", "f 1 2 4", "f 0 1 2", "g x"] {
        std::fs::write(&obj, format!("o a\nv 0 0 0\nv 1 0 0\nv 0 1 0\n{line}\n")).unwrap();
        let error = read(text).unwrap_err();
        assert_eq!((error.line, error.message.as_str()), (Some(5), "not a line of a reproducer"), "{line}");
    }
}

#[test]
fn coordinates_keep_every_bit_in_files() {
    let corners =
        [[0.1, -1.0 / 3.0, 1e-30], [123_456.79, f32::MIN_POSITIVE, -0.0], [1e18, 16_777_217.0, 2.5e-7]];
    let rays = aimed::chunks([(Vec3::from(corners[0]), Vec3::from(corners[1]), 0.1, 1e18)].into_iter());
    let meshes = vec![Arc::new(Mesh::new(corners.to_vec(), vec![[2, 0, 1]]))];
    let made = Reproducer { meshes, rays: RaySet { kind: Kind::Replay, chunks: rays }, fails: true };
    let folder = tempfile::TempDir::new().unwrap();
    let read =
        Reproducer::read(&made.write(folder.path(), 7, "").unwrap(), &Reach::Anywhere).unwrap().unwrap();
    let bits = |r: &Reproducer| r.meshes[0].positions.iter().map(|p| p.map(f32::to_bits)).collect::<Vec<_>>();
    assert_eq!((bits(&read), &read.meshes[0].indices), (bits(&made), &made.meshes[0].indices));
    let ray = |r: &Reproducer| {
        let rays = &r.rays.chunks[0].rays;
        [rays.o(0).to_array(), rays.d(0).to_array(), [rays.tmin[0], rays.tmax[0], 0.0]]
            .map(|v| v.map(f32::to_bits))
    };
    assert_eq!(ray(&read), ray(&made));
}
