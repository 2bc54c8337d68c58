//! How fast pixels converge: slopes of log RMSE against log N over 200 seeds, N = 16 … 1024.

use crate::harness::{Stage, obj, on_every_backend, stage};
use drt::scene::SamplerKind;
use std::f64::consts::PI;

/// Root mean square error of a one-pixel picture over 200 seeds.
fn rms(stage: &Stage, sampler: SamplerKind, spp: u32, exact: f64) -> f64 {
    let square = |seed| {
        let (image, _) = stage.render(|s| (s.seed, s.spp, s.sampler) = (seed, spp, sampler));
        (f64::from(image.f32_channel("G").unwrap()[0]) - exact).powi(2)
    };
    ((0..200).map(square).sum::<f64>() / 200.0).sqrt()
}

fn slope(stage: &Stage, sampler: SamplerKind, exact: f64) -> f64 {
    let points: Vec<(f64, f64)> =
        (4..=10).map(|k| (f64::from(k), rms(stage, sampler, 1 << k, exact).log2())).collect();
    let n = points.len() as f64;
    let (mx, my) = (points.iter().map(|p| p.0).sum::<f64>() / n, points.iter().map(|p| p.1).sum::<f64>() / n);
    let covariance: f64 = points.iter().map(|p| (p.0 - mx) * (p.1 - my)).sum();
    covariance / points.iter().map(|p| (p.0 - mx).powi(2)).sum::<f64>()
}

/// One pixel that looks at the square [0, 1]² of the plane z = 0 from above.
fn pixel(rest: &str) -> String {
    format!(
        "[camera]\ntype = \"orthographic\"\nposition = [0.5, 0.5, 5]\nlook_at = [0.5, 0.5, 0]\nheight = 1\n\
         [film]\nsize = [1, 1]\n[render]\nmax_depth = 1\n[[mesh]]\nfile = \"m.obj\"\nmaterial = \"m\"\n\
         [materials.m]\ntype = \"diffuse\"\n{rest}"
    )
}

#[test]
fn slopes_on_a_smooth_pixel() {
    // ρ/π times the square's solid angle from a point above its middle: ∫ h/r³ dA.
    let h: f64 = 0.8;
    let exact = 0.5 / PI * 4.0 * (0.25 / (h * (0.5 + h * h).sqrt())).atan();
    let light =
        "reflectance = 0.5\n[[light]]\ntype = \"point\"\nposition = [0.5, 0.5, 0.8]\nintensity = 1.0\n";
    let floor = obj(&[vec![[-1.0, -1.0, 0.0], [2.0, -1.0, 0.0], [2.0, 2.0, 0.0], [-1.0, 2.0, 0.0]]]);
    on_every_backend(|backend| {
        let stage = stage(&pixel(light), &[("m.obj", floor.clone())], backend, &[]);
        let random = slope(&stage, SamplerKind::Random, exact);
        assert!((-0.58..=-0.42).contains(&random), "random {random}");
        let stratified = slope(&stage, SamplerKind::Stratified, exact);
        assert!(stratified <= -0.92, "stratified {stratified}");
        let sobol = slope(&stage, SamplerKind::Sobol, exact);
        assert!(sobol <= -1.25, "sobol {sobol}");
    });
}

#[test]
fn slopes_on_an_edge() {
    // A luminous half plane x + 0.7·y < 0.9 covers .55 of the pixel.
    let emit = "reflectance = 0.0\nemission = 1.0\n";
    let half = obj(&[vec![
        [0.9 + 7.0, -10.0, 0.0],
        [0.9 - 7.0, 10.0, 0.0],
        [-20.0, 10.0, 0.0],
        [-20.0, -10.0, 0.0],
    ]]);
    on_every_backend(|backend| {
        let stage = stage(&pixel(emit), &[("m.obj", half.clone())], backend, &[]);
        for (sampler, gate) in
            [(SamplerKind::Random, -0.42), (SamplerKind::Stratified, -0.67), (SamplerKind::Sobol, -0.67)]
        {
            let slope = slope(&stage, sampler, 0.55);
            assert!(slope <= gate, "{sampler:?} {slope}");
        }
    });
}

/// A sample that splits into four sends four rays on, whose directions and lamps are as good as those of four samples:
/// with random numbers they halve the standard deviation. The mean stays.
#[test]
fn a_sample_that_splits_in_four_is_worth_four() {
    let floor = obj(&[vec![[-1.0, -1.0, 0.0], [2.0, -1.0, 0.0], [2.0, 2.0, 0.0], [-1.0, 2.0, 0.0]]]);
    let lamp = |x: f64, z: f64| vec![[x, 0.0, z], [x + 1.0, 0.0, z], [x + 1.0, 1.0, z], [x, 1.0, z]];
    let lamps = obj(&[lamp(-0.5, 1.0), lamp(0.7, 2.0)]);
    // Nothing but what comes from behind the first hit varies: the pixel is a millimetre wide.
    let rest = "reflectance = 0.5\n[[mesh]]\nfile = \"l.obj\"\nmaterial = \"l\"\n\
                [materials.l]\ntype = \"diffuse\"\nreflectance = 0.0\nemission = 2.0\n";
    let toml = pixel(rest).replace("height = 1", "height = 0.001").replace("0.5, 5]", "0.5, 0.5]");
    let files = [("m.obj", floor), ("l.obj", lamps)];
    on_every_backend(|backend| {
        for lights in ["render.lights=bsdf", "render.lights=light"] {
            let stage = stage(&toml, &files, backend, &[lights, "render.sampler=random", "render.spp=16"]);
            let moments = |split| {
                let value = |seed| {
                    let (image, stats) = stage.render(|s| (s.seed, s.split) = (seed, Some(split)));
                    assert_eq!(stats.camera_rays, 16);
                    let sent = if lights.ends_with("bsdf") { stats.bounce_rays } else { stats.shadow_rays };
                    assert_eq!(sent, 16 * u64::from(split), "{lights}");
                    f64::from(image.f32_channel("G").unwrap()[0])
                };
                let values: Vec<f64> = (0..400).map(value).collect();
                let mean = values.iter().sum::<f64>() / 400.0;
                (mean, (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / 399.0).sqrt())
            };
            let ((one, spread), (four, narrow)) = (moments(1), moments(4));
            assert!((one - four).abs() < 5.0 * spread / 400f64.sqrt(), "{lights}: {one} {four}");
            // The ratio of two such estimates is known to 5 %.
            assert!((narrow / spread - 0.5).abs() < 0.1, "{lights}: {spread} {narrow}");
        }
    });
}

/// Below a sky a preview takes one path a sample. More samples give those the paths that they lack: in the end each has eight,
/// all weigh alike, what is seen directly stays exact, and the mean is that of whole samples.
#[test]
fn samples_of_a_preview_get_their_paths_later() {
    let sky = "reflectance = 0.5\n[[mesh]]\nfile = \"r.obj\"\nmaterial = \"m\"\n\
               [[light]]\ntype = \"environment\"\nradiance = 2.0\n";
    // Half of the pixel sees a floor under a roof, the other half the sky.
    let half = obj(&[vec![[-9.0, -9.0, 0.0], [0.5, -9.0, 0.0], [0.5, 9.0, 0.0], [-9.0, 9.0, 0.0]]]);
    let roof = obj(&[vec![[-0.5, -9.0, 1.0], [-0.5, 9.0, 1.0], [-9.0, 9.0, 1.0], [-9.0, -9.0, 1.0]]]);
    on_every_backend(|backend| {
        let files = [("m.obj", half.clone()), ("r.obj", roof.clone())];
        let stage = stage(&pixel(sky), &files, backend, &["render.sampler=random"]);
        let render = |seed, spp, split| {
            let (image, stats) = stage.render(|s| (s.seed, s.spp, s.split) = (seed, spp, split));
            let rays = [stats.camera_rays, stats.bounce_rays];
            (f64::from(image.f32_channel("G").unwrap()[0]), rays)
        };
        assert_eq!(render(7, 16, None), render(7, 16, Some(1)), "a preview is whole samples");
        // Sixteen camera rays are traced once more; every sample that meets the floor sends eight rays on.
        let ([camera, bounce], [_, whole]) = (render(7, 64, None).1, render(7, 64, Some(1)).1);
        assert_eq!((camera, bounce), (64 + 16, 8 * whole));
        for spp in [16, 17, 64] {
            let all_sky = stage.render(|s| (s.spp, s.crop, s.size) = (spp, Some([60, 0, 1, 1]), [64, 1])).0;
            assert_eq!(all_sky.f32_channel("G").unwrap()[0], 2.0, "{spp} samples");
        }
        let moments = |spp, split| {
            let values: Vec<f64> = (0..400).map(|seed| render(seed, spp, split).0).collect();
            let mean = values.iter().sum::<f64>() / 400.0;
            (mean, (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / 399.0).sqrt())
        };
        for spp in [20, 64] {
            let ((one, spread), (all, narrow)) = (moments(spp, Some(1)), moments(spp, None));
            assert!((one - all).abs() < 5.0 * spread / 200f64.sqrt(), "{spp} samples: {one} {all}");
            // As many paths for every sample, so as good as when all of them split at once.
            let eight = moments(spp, Some(8)).1;
            assert!(
                narrow < spread && (narrow / eight - 1.0).abs() < 0.15,
                "{spp}: {spread} {narrow} {eight}"
            );
        }
    });
}

/// Between a floor and a ceiling: also the directions at the second and third hit are new ones for each sample.
#[test]
fn every_sample_of_the_notes_recursion_has_directions_of_its_own() {
    let square = |z: f64| vec![[-1.0, -1.0, z], [2.0, -1.0, z], [2.0, 2.0, z], [-1.0, 2.0, z]];
    let toml = pixel("reflectance = 0.9\n[[light]]\ntype = \"environment\"\n")
        .replace("position = [0.5, 0.5, 5]", "position = [0.5, 0.5, 0.9]")
        .replace("max_depth = 1", "max_depth = 4\nlights = \"bsdf\"");
    let recursion = "render.integrator={ type = \"distribution\", rule = \"random\", directions = [8, 1] }";
    on_every_backend(|backend| {
        let files = [("m.obj", obj(&[square(0.0), square(1.0)]))];
        let stage = stage(&toml, &files, backend, &[recursion]);
        let values = |spp| -> Vec<f64> {
            let value = |seed| {
                let (image, _) = stage.render(|s| (s.seed, s.spp) = (seed, spp));
                f64::from(image.f32_channel("G").unwrap()[0])
            };
            (0..200).map(value).collect()
        };
        let [few, many] = [4, 64].map(|spp| crate::harness::Statistics::of(&values(spp)).error);
        assert!(many < 0.35 * few, "{many} after 64 samples, {few} after 4");
    });
}
