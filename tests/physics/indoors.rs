//! Rooms into which little of a constant sky is seen: light samples are taken through the openings.

use crate::direct::lambert;
use crate::harness::{Stage, Statistics, obj, on_every_backend, stage};
use drt::accel::Backend;
use std::f64::consts::PI;

/// A room of 4 m by 4 m by 2.5 m with a hole of 0.3 m by 0.2 m in its ceiling, seen at the point (1, 1) of its floor;
/// `walls`: their reflectance.
fn room(walls: f64, rest: &str, backend: Backend, set: &[&str]) -> Stage {
    let (a, h) = (4.0, 2.5);
    let [x, y] = HOLE;
    let rectangle =
        |[x0, x1]: [f64; 2], [y0, y1]: [f64; 2]| vec![[x0, y0, h], [x1, y0, h], [x1, y1, h], [x0, y1, h]];
    let mut shell = vec![
        rectangle([0.0, a], [0.0, y[0]]),
        rectangle([0.0, a], [y[1], a]),
        rectangle([0.0, x[0]], y),
        rectangle([x[1], a], y),
    ];
    let wall = |p: [f64; 2], q: [f64; 2]| {
        vec![[p[0], p[1], 0.0], [q[0], q[1], 0.0], [q[0], q[1], h], [p[0], p[1], h]]
    };
    let corners = [[0.0, 0.0], [a, 0.0], [a, a], [0.0, a]];
    shell.extend((0..4).map(|i| wall(corners[i], corners[(i + 1) % 4])));
    let floor = obj(&[corners.map(|[x, y]| [x, y, 0.0]).to_vec()]);
    let toml = format!(
        "[camera]\ntype = \"orthographic\"\nposition = [1, 1, 1]\nlook_at = [1, 1, 0]\nup = [0, 1, 0]\nheight = 1e-3\n\
         [film]\nsize = [8, 8]\n[render]\nspp = 64\nmax_depth = 1\n\
         [[mesh]]\nfile = \"floor.obj\"\nmaterial = \"floor\"\n[[mesh]]\nfile = \"shell.obj\"\nmaterial = \"walls\"\n\
         [materials.floor]\ntype = \"diffuse\"\nreflectance = 0.5\n\
         [materials.walls]\ntype = \"diffuse\"\nreflectance = {walls}\n\
         [[light]]\ntype = \"environment\"\nradiance = 1.0\n{rest}"
    );
    stage(&toml, &[("floor.obj", floor), ("shell.obj", obj(&shell))], backend, set)
}

/// The means of 16 seeds' pictures: each looks for the openings again, which takes longer than the picture.
fn statistics(stage: &Stage, spp: u32) -> Statistics {
    let mean = |seed| {
        let (image, _) = stage.render(|s| (s.seed, s.spp) = (seed, spp));
        let green = image.f32_channel("G").unwrap();
        green.iter().map(|v| f64::from(*v)).sum::<f64>() / green.len() as f64
    };
    Statistics::of(&(0..16).map(mean).collect::<Vec<_>>())
}

/// The hole's sides along x and y.
const HOLE: [[f64; 2]; 2] = [[2.4, 2.7], [1.5, 1.7]];

/// The share of the cosine-weighted sky that the hole leaves at (1, 1): parallel rectangles from the foot of the normal to
/// each of its corners (Howell's catalogue, B-4), added with signs.
fn form_factor() -> f64 {
    let corner = |x: f64, y: f64| {
        let (a, b) = ((x - 1.0) / 2.5, (y - 1.0) / 2.5);
        let (p, q) = (a.hypot(1.0), b.hypot(1.0));
        ((a / p) * (b / p).atan() + (b / q) * (a / q).atan()) / (2.0 * PI)
    };
    let [[x0, x1], [y0, y1]] = HOLE;
    corner(x1, y1) - corner(x0, y1) - corner(x1, y0) + corner(x0, y0)
}

/// Some 3 of 1,000 directions lead out. Light samples that know which find as much light as the formula says, with a fraction of
/// the noise of BSDF samples.
#[test]
fn a_hole_in_the_ceiling_lights_the_floor_as_its_form_factor_says() {
    let exact = 0.5 * form_factor();
    assert!((0.5 * 0.001..0.5 * 0.01).contains(&exact), "{exact}");
    on_every_backend(|backend| {
        let known = room(0.0, "", backend, &[]);
        let (_, stats) = known.render(|_| ());
        assert!(stats.shadow_rays > 0, "no light samples");
        let known = statistics(&known, 1024);
        known.expect("through the hole", exact, 2e-5);
        let by_chance = statistics(&room(0.0, "", backend, &["render.lights=bsdf"]), 1024);
        assert!(known.error < 0.1 * by_chance.error, "{} {}", known.error, by_chance.error);
    });
}

/// A flat room of 12 m by 12 m by 2.5 m with a window in the wall x = 0, as grey squares and rectangles of 4 m² and more. Camera
/// and pixels: `view`.
fn flat_room(view: &str, backend: Backend) -> Stage {
    let (a, h) = (12.0, 2.5);
    let [y, z] = WINDOW;
    let beside = |[y0, y1]: [f64; 2], [z0, z1]: [f64; 2]| {
        vec![[0.0, y0, z0], [0.0, y1, z0], [0.0, y1, z1], [0.0, y0, z1]]
    };
    let level = |z: f64| vec![[0.0, 0.0, z], [a, 0.0, z], [a, a, z], [0.0, a, z]];
    let shell = [
        level(0.0),
        level(h),
        beside([0.0, y[0]], [0.0, h]),
        beside([y[1], a], [0.0, h]),
        beside(y, [0.0, z[0]]),
        beside(y, [z[1], h]),
        vec![[a, 0.0, 0.0], [a, a, 0.0], [a, a, h], [a, 0.0, h]],
        vec![[0.0, 0.0, 0.0], [a, 0.0, 0.0], [a, 0.0, h], [0.0, 0.0, h]],
        vec![[0.0, a, 0.0], [a, a, 0.0], [a, a, h], [0.0, a, h]],
    ];
    let toml = format!(
        "[camera]\ntype = \"orthographic\"\n{view}\n[render]\nspp = 64\nmax_depth = 1\n\
         [[mesh]]\nfile = \"shell.obj\"\nmaterial = \"grey\"\n\
         [materials.grey]\ntype = \"diffuse\"\nreflectance = 0.5\n\
         [[light]]\ntype = \"environment\"\nradiance = 1.0\n"
    );
    stage(&toml, &[("shell.obj", obj(&shell))], backend, &[])
}

/// The window's sides along y and z.
const WINDOW: [[f64; 2]; 2] = [[5.0, 7.0], [1.0, 2.0]];

/// Walls that are parallel to the axes, as those of rooms are: what is learnt where is asked for at the same place by
/// light samples on the surface and by rays that start a rounding off it. The whole ceiling, and most of the wall opposite.
#[test]
fn a_window_lights_all_of_the_ceiling_and_the_wall_as_lambert_says() {
    let [y, z] = WINDOW;
    let corners = [[y[0], z[0]], [y[1], z[0]], [y[1], z[1]], [y[0], z[1]]];
    let mean = |n: [usize; 2], at: &dyn Fn(f64, f64) -> f64| -> f64 {
        let each = |k: usize| {
            let (i, j) = (k % n[0], k / n[0]);
            at((i as f64 + 0.5) / n[0] as f64, (j as f64 + 0.5) / n[1] as f64)
        };
        (0..n[0] * n[1]).map(each).sum::<f64>() / (n[0] * n[1]) as f64
    };
    // Seen from the receiver, whose normal is +z.
    let above = corners.map(|[y, z]| [0.0, y, 2.5 - z]);
    let ceiling = mean([120, 120], &|s, t| lambert(&above, [0.05 + 11.9 * s, 0.05 + 11.9 * t, 0.0]));
    let opposite = corners.map(|[y, z]| [y, z, 12.0]);
    let wall = mean([120, 30], &|s, t| lambert(&opposite, [1.2 + 9.6 * s, 0.05 + 2.4 * t, 0.0]));
    let views = [
        (
            "position = [6, 6, 1]\nlook_at = [6, 6, 2.5]\nup = [0, 1, 0]\nheight = 11.9\n[film]\nsize = [8, 8]",
            ceiling,
        ),
        (
            "position = [6, 6, 1.25]\nlook_at = [12, 6, 1.25]\nup = [0, 0, 1]\nheight = 2.4\n[film]\nsize = [16, 4]",
            wall,
        ),
    ];
    on_every_backend(|backend| {
        for (view, irradiance) in views {
            let stage = flat_room(view, backend);
            // Three percent either way would be seen; weighed by the wrong part, the ceiling was too bright by half.
            let verdict = statistics(&stage, 512).verdict(0.5 / PI * irradiance, 1e-3, 0.03);
            verdict.unwrap_or_else(|why| panic!("{view}: {why}"));
        }
    });
}

/// White walls: light that was reflected several times is the same by both ways to find it.
#[test]
fn reflected_light_is_the_same_however_it_is_found() {
    on_every_backend(|backend| {
        let mean = |lights: &str, spp: u32| {
            let set = [&format!("render.lights={lights}"), "render.max_depth=4"];
            statistics(&room(0.8, "", backend, &set), spp)
        };
        let (known, by_chance) = (mean("mis", 256), mean("bsdf", 1024));
        let allowed = 5.0 * known.error.hypot(by_chance.error);
        assert!((known.mean - by_chance.mean).abs() < allowed, "{known:?} {by_chance:?}");
        assert!(
            known.error < 0.01 * known.mean && by_chance.error < 0.01 * by_chance.mean,
            "{known:?} {by_chance:?}"
        );
    });
}

/// A lamp in the room: the sky takes a part of the light samples, and the sum of both is right.
#[test]
fn a_lamp_and_a_hole_share_the_samples() {
    let lamp = "[[light]]\ntype = \"point\"\nposition = [1, 1, 2]\nintensity = 0.02\n";
    let exact = 0.5 * (form_factor() + 0.02 / (4.0 * PI));
    on_every_backend(|backend| {
        statistics(&room(0.0, lamp, backend, &[]), 1024).expect("lamp and hole", exact, 2e-5);
    });
}

/// Outdoors nothing is gained: no light samples of a constant sky there. The same point, with the walls away.
#[test]
fn outdoors_there_are_no_light_samples_of_a_constant_sky() {
    let toml = "[camera]\nposition = [0, 0, 3]\nlook_at = [0, 0, 0]\nup = [0, 1, 0]\n[film]\nsize = [8, 8]\n[[mesh]]\nfile = \"m.obj\"\n\
                [[light]]\ntype = \"environment\"\nradiance = 1.0\n";
    let square = vec![[-9.0, -9.0, 0.0], [9.0, -9.0, 0.0], [9.0, 9.0, 0.0], [-9.0, 9.0, 0.0]];
    let files = [("m.obj", obj(&[square]))];
    on_every_backend(|backend| {
        let stage = stage(toml, &files, backend, &[]);
        assert_eq!(stage.render(|s| s.spp = 4).1.shadow_rays, 0);
    });
}
