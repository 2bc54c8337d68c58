//! Every scene of `scenes/`, small: all backends see the same surfaces through every pixel and make the same picture, with
//! the same random numbers nearly bit by bit, with others within the noise.
//!
//! What a scene needs of `scenes/data` is made by the generators that need nothing but Python; without Python, and for what
//! has to be fetched, scenes are left out and named.

use crate::harness::{Stage, stage_of};
use drt::accel::Backend;
use drt::film::{Data, Image};
use std::path::{Path, PathBuf};
use std::process::Command;

/// Pixels along the longer side.
const SIDE: u32 = 48;
/// Renders for the statistics; the error of a mean is 10 % at most, in the noisiest scene (soft-shadows) 4 %.
const SEEDS: u64 = 8;
const SPP: u32 = 32;

/// A copy of the folder, with what Python can make of it.
fn copy_of_the_scenes() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let names = std::fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes")).unwrap();
    for file in names.map(|entry| entry.unwrap().path()).filter(|path| path.is_file()) {
        std::fs::copy(&file, folder.path().join(file.file_name().unwrap())).unwrap();
    }
    for generator in ["make_billiards.py", "make_lamps.py", "make_shapes.py"] {
        // What is missing then is seen below.
        let _ = Command::new("python3").arg(folder.path().join(generator)).output();
    }
    folder
}

fn scenes_of(folder: &Path) -> Vec<PathBuf> {
    let all = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut scenes: Vec<PathBuf> = all.filter(|path| path.extension().is_some_and(|e| e == "toml")).collect();
    scenes.sort();
    scenes
}

/// A file of `data/` that the scene names and that is not there.
fn missing(scene: &Path) -> Option<String> {
    let text = std::fs::read_to_string(scene).unwrap();
    let files = text.split('"').filter(|word| word.starts_with("data/")).map(str::to_string);
    files.into_iter().find(|file| !scene.with_file_name(file).exists())
}

fn small(scene: &Path, backend: Backend) -> Stage {
    let mut stage = stage_of(scene, backend, &["film.aov=[\"depth\", \"ids\"]", "film.filter=box"]);
    let [w, h] = stage.settings.size.map(|n| n as f32);
    stage.settings.size = [w, h].map(|n| (n * SIDE as f32 / w.max(h)).round() as u32);
    stage.settings.spp = SPP;
    stage
}

fn ids<'a>(image: &'a Image, name: &str) -> &'a [u32] {
    let channel = image.channels.iter().find(|c| c.name == name).unwrap();
    match &channel.data {
        Data::U32(ids) => ids,
        _ => panic!("{name} holds no ids"),
    }
}

/// First hits of sample 0, pixel by pixel: depths within rounding, which a ground seen under a grazing angle multiplies by
/// its distance over the camera's height, and the same triangle but where two meet.
fn same_hits(what: &str, a: &Image, b: &Image) {
    let depths = [a, b].map(|image| image.f32_channel("depth.Z").unwrap());
    let far = |x: f32, y: f32| x != y && (x - y).abs() > 1e-3 * x.abs();
    let apart = (0..depths[0].len()).filter(|i| far(depths[0][*i], depths[1][*i])).count();
    assert_eq!(apart, 0, "{what}: pixels see other depths");
    for name in ["id.mesh", "id.triangle", "id.material"] {
        let others = ids(a, name).iter().zip(ids(b, name)).filter(|(a, b)| a != b).count();
        assert!(others <= 2, "{what}: {others} pixels have another {name}");
    }
}

fn green(image: &Image) -> impl Iterator<Item = f64> {
    image.f32_channel("G").unwrap().iter().map(|v| f64::from(*v))
}

/// With the same numbers, paths part only where rounding decides, as it does now and then between a hundred thousand lamps.
fn same_picture(what: &str, a: &Image, b: &Image) {
    let apart = green(a).zip(green(b)).filter(|(a, b)| (a - b).abs() > 0.01 * a.max(*b)).count();
    let pixels = green(a).count();
    assert!(apart * 10 <= pixels, "{what}: {apart} of {pixels} pixels differ by more than 1 %");
}

/// Means over `SEEDS` pictures and the variance of that.
fn mean(stage: &Stage, first_seed: u64) -> [f64; 2] {
    let one = |seed| {
        let image = stage.render(|s| s.seed = first_seed + seed).0;
        green(&image).sum::<f64>() / green(&image).count() as f64
    };
    let means: Vec<f64> = (0..SEEDS).map(one).collect();
    let mean = means.iter().sum::<f64>() / SEEDS as f64;
    let spread = means.iter().map(|m| (m - mean).powi(2)).sum::<f64>();
    [mean, spread / (SEEDS * (SEEDS - 1)) as f64]
}

#[test]
fn backends_agree_about_every_scene() {
    let folder = copy_of_the_scenes();
    let scenes = scenes_of(folder.path());
    let mut left_out = 0;
    for scene in &scenes {
        let what = scene.file_stem().unwrap().to_string_lossy();
        if let Some(file) = missing(scene) {
            println!("SKIPPED {what}: {file} is not there");
            left_out += 1;
            continue;
        }
        let stages: Vec<Stage> = Backend::ALL.iter().map(|backend| small(scene, *backend)).collect();
        let image = |stage: &Stage| stage.render(|_| ()).0;
        let Some((first, others)) = stages.split_first() else { continue };
        let (picture, [m, v]) = (image(first), mean(first, 100));
        let error = |v: f64| v.sqrt() / m;
        assert!(m > 0.0 && error(v) < 0.1, "{what}: {m} ± {} says nothing", error(v));
        for (k, other) in others.iter().enumerate() {
            let theirs = image(other);
            same_hits(&what, &picture, &theirs);
            same_picture(&what, &picture, &theirs);
            let [n, w] = mean(other, 200 + 100 * k as u64);
            let allowed = 7.0 * (v + w).sqrt() + 1e-5 * m;
            assert!((n - m).abs() < allowed, "{what}: {n} is not {m} ± {allowed}");
        }
    }
    assert!(scenes.len() - left_out >= 7, "only {} scenes were rendered", scenes.len() - left_out);
}
