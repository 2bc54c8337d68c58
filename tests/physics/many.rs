//! The choice among lights by importance, and near lights by solid angle, against Lambert's formula.

use crate::direct::{LAMP, SQUARE, floor, floor_at, lambert};
use crate::harness::{obj, on_every_backend, sphere, stage};
use std::f64::consts::PI;

/// Lamps that touch the floor's neighbourhood: where sampling by area would need thousands of samples.
#[test]
fn near_lamps_are_exact() {
    // None of them stands between the floor and the camera.
    let low = |z: f64| SQUARE.map(|[x, y, _]| [x, y.max(-0.2), z]);
    let tilted = [[0.2, -0.5, 0.02], [0.9, -0.5, 0.72], [0.9, 0.5, 0.72], [0.2, 0.5, 0.02]];
    on_every_backend(|backend| {
        for (x, polygon) in [
            (0.0, low(0.05).to_vec()),
            (0.45, low(0.1).to_vec()),
            (0.7, low(0.1).to_vec()),
            (0.0, tilted.to_vec()),
            (0.3, vec![[0.0, -0.5, 0.1], [1.0, 0.0, 0.3], [0.0, 0.5, 0.2]]),
        ] {
            let exact = 0.5 / PI * lambert(&polygon, [x, 0.0, 0.0]);
            for lights in ["mis", "light"] {
                let lamp = ("lamp.obj", obj(std::slice::from_ref(&polygon)));
                stage(&floor_at(x, LAMP), &[floor(), lamp], backend, &[&format!("render.lights={lights}")])
                    .statistics()
                    .expect(&format!("x {x} {polygon:?} {lights}"), exact, 0.0);
            }
        }
    });
}

/// A square cut into 100,352 triangles is still that square, at 64 samples a pixel; so is a lamp of 100,800 facets a
/// sphere.
#[test]
fn a_hundred_thousand_lamps_are_the_lamp_that_they_make() {
    let n = 224;
    let at = |i: usize| i as f64 / n as f64 - 0.5;
    let cells = (0..n * n).map(|k| (k % n, k / n));
    let square: Vec<Vec<[f64; 3]>> = cells
        .flat_map(|(i, j)| {
            let [a, b, c, d] =
                [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|(i, j)| [at(i), at(j), 1.0]);
            // Every other row the other way round, so that not all of them make rectangles.
            if j % 2 == 0 { [vec![a, b, c], vec![a, c, d]] } else { [vec![a, b, c], vec![c, a, d]] }
        })
        .collect();
    on_every_backend(|backend| {
        for (x, exact) in [(0.0, 0.119_728_2), (2.0, 0.006_961_86)] {
            let lamp = ("lamp.obj", obj(&square));
            let stage = stage(&floor_at(x, LAMP), &[floor(), lamp], backend, &[]);
            assert!(stage.scene.triangles() > 100_000);
            stage.statistics().expect(&format!("square, x {x}"), exact, 0.0);
        }
        let mesh = "[[mesh]]\nfile = \"ball.obj\"\nmaterial = \"lamp\"\ntransform = { translate = [0, 0, 4] }\n\
                    [materials.lamp]\ntype = \"diffuse\"\nreflectance = 0.0\nemission = 1.0\n";
        let ball = ("ball.obj", sphere(210, 240));
        for lights in ["mis", "light"] {
            stage(
                &floor_at(0.0, mesh),
                &[floor(), ball.clone()],
                backend,
                &[&format!("render.lights={lights}")],
            )
            .statistics()
            .expect("ball", 0.031_25, 5e-4);
        }
    });
}

/// A small lamp nearby and a thousand times larger one far away: neither drowns the other.
#[test]
fn lamps_of_very_different_size_are_both_found() {
    let far = [[-40.0, -40.0, 60.0], [40.0, -40.0, 60.0], [40.0, 40.0, 60.0], [-40.0, 40.0, 60.0]];
    let near = [[0.44, -0.01, 0.05], [0.46, -0.01, 0.05], [0.46, 0.01, 0.05], [0.44, 0.01, 0.05]];
    let behind = [[-9.0, -9.0, -2.0], [9.0, -9.0, -2.0], [9.0, 9.0, -2.0], [-9.0, 9.0, -2.0]];
    let from = [0.3, 0.0, 0.0];
    let exact = 0.5 / PI * (lambert(&far, from) + lambert(&near, from));
    on_every_backend(|backend| {
        let lamps = ("lamp.obj", obj(&[far.to_vec(), near.to_vec(), behind.to_vec()]));
        stage(&floor_at(0.3, LAMP), &[floor(), lamps], backend, &["render.spp=256"]).statistics().expect(
            "far and near",
            exact,
            0.0,
        );
    });
}

/// I·cos³θ/h² on the axis, in the soft edge and beyond it.
#[test]
fn spots_have_their_cone() {
    let at = |direction: &str, x: f64| {
        let light = format!(
            "[[light]]\ntype = \"spot\"\nposition = [0, 0, 2]\ndirection = {direction}\nangle = 40\nfalloff = 0.5\n\
             intensity = 3\n"
        );
        floor_at(x, &light)
    };
    let exact = |x: f64| {
        let theta = (x / 2.0f64).atan();
        let (outer, inner) = (40f64.to_radians().cos(), 20f64.to_radians().cos());
        let t = ((theta.cos() - outer) / (inner - outer)).clamp(0.0, 1.0);
        0.5 / PI * 3.0 * t * t * (3.0 - 2.0 * t) * theta.cos().powi(3) / 4.0
    };
    on_every_backend(|backend| {
        for x in [0.0, 0.7, 1.0, 1.3, 1.6] {
            stage(&at("[0, 0, -7]", x), &[floor()], backend, &[]).statistics().expect(
                &format!("{x}"),
                exact(x),
                2e-5,
            );
        }
        for (direction, x) in [("[0, 0, -1]", 1.7), ("[0, 0, 1]", 0.0)] {
            assert_eq!(stage(&at(direction, x), &[floor()], backend, &[]).statistics().mean, 0.0);
        }
    });
}

/// Lights with a place and lights at infinity together: the choice between the two is divided out.
#[test]
fn near_and_far_lights_add_up() {
    let lights = format!(
        "{LAMP}[[light]]\ntype = \"spot\"\nposition = [0.5, 0, 2]\ndirection = [0, 0, -1]\nangle = 60\nfalloff = 0\n\
         intensity = 0.3\n[[light]]\ntype = \"directional\"\ndirection = [0.6, 0, -0.8]\nirradiance = 0.3\n\
         [[light]]\ntype = \"environment\"\nsky = \"overcast\"\nup = [0, 0, 1]\n"
    );
    let cos = 2.0 / (0.25f64 + 4.0).sqrt();
    let spot = 0.3 * cos / 4.25;
    // The lamp hides the sky behind it, and blocks neither the spot (beside it) nor the slanted parallel light.
    on_every_backend(|backend| {
        let far = SQUARE.map(|[x, y, _]| [x - 4.0, y, 1.0]);
        let lamp = ("lamp.obj", obj(&[far.to_vec()]));
        let l = lambert(&far, [0.0; 3]);
        // Overcast: L = .4 + .8·√cos above the horizon, so E = 2π∫(.4 + .8√z)z dz = 2π(.2 + .32); what the lamp hides of
        // it is some .4 to 1.2 of the lamp's own.
        let open = 0.5 / PI * (l + spot + 0.3 * 0.8 + 2.0 * PI * 0.52);
        let stage = stage(&floor_at(0.0, &lights), &[floor(), lamp], backend, &["render.spp=1024"]);
        let s = stage.statistics();
        // The hidden part lies at cos θ ≈ 1/√17 … 1/√21: L ≈ .4 + .8·√.24 = .79.
        let exact = open - 0.5 / PI * l * 0.789;
        s.expect("all", exact, 1e-3);
    });
}
