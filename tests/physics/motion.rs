//! What moves while the shutter is open: exact profiles of streaks, and what must not change.

use crate::direct::{LAMP, floor, floor_at, lambert};
use crate::harness::{SKY, cube, obj, on_every_backend, square, stage};
use drt::accel::Backend;
use drt::film::Image;

/// Looks down the z axis at [−2, 2] × [−1/4, 1/4], one pixel high.
fn strip(shutter: [f64; 2], spp: u32, rest: &str) -> String {
    format!(
        "[camera]\ntype = \"orthographic\"\nposition = [0, 0, 9]\nlook_at = [0, 0, 0]\nheight = 0.5\nshutter = {shutter:?}\n\
         [film]\nsize = [64, 8]\n[render]\nspp = {spp}\nmax_depth = 0\n{rest}\
         [materials.m]\ntype = \"diffuse\"\nemission = 1\n"
    )
}

/// The streak of a square from −½ to ½ whose middle goes evenly from `a` to `b`: at x it is seen while the middle is
/// between x − ½ and x + ½. The share of the time, and its mean over a pixel, piecewise quadratic.
fn trapezoid(a: f64, b: f64, pixel: usize) -> f64 {
    let (width, left) = (4.0 / 64.0, -2.0 + 4.0 / 64.0 * pixel as f64);
    let seen = |x: f64| ((x + 0.5).min(b) - (x - 0.5).max(a)).max(0.0) / (b - a);
    // Simpson's rule is exact between the kinks; 64 parts leave nothing of those that fall inside.
    let part = |i: i32| {
        let (x, h) = (left + width * f64::from(i) / 64.0, width / 64.0);
        (seen(x) + 4.0 * seen(x + 0.5 * h) + seen(x + h)) / 6.0
    };
    (0..64).map(part).sum::<f64>() / 64.0
}

fn green(image: &Image) -> Vec<f64> {
    image.f32_channel("G").unwrap().iter().map(|v| f64::from(*v)).collect()
}

/// The mean of each column.
fn columns(image: &Image) -> Vec<f64> {
    let green = green(image);
    (0..64).map(|x| (0..8).map(|y| green[64 * y + x]).sum::<f64>() / 8.0).collect()
}

fn check_streak(what: &str, toml: &str, [a, b]: [f64; 2]) {
    on_every_backend(|backend| {
        let stage = stage(toml, &[("square.obj", square(0.5, 0.0))], backend, &[]);
        let found = columns(&stage.render(|_| ()).0);
        for (x, found) in found.iter().enumerate() {
            let exact = trapezoid(a, b, x);
            assert!((found - exact).abs() < 2e-3, "{what}: column {x}: {found} not {exact}");
        }
        let by_half: f64 = found.iter().sum::<f64>() / 64.0 * 4.0;
        assert!((by_half - 1.0).abs() < 1e-3, "{what}: all of it: {by_half}");
    });
}

const GOING: &str = "[[mesh]]\nfile = \"square.obj\"\nmaterial = \"m\"\n\
                     motion = [{ time = 0.0, translate = [-1, 0, 0] }, { time = 2.0, translate = [1, 0, 0] }]\n";

#[test]
fn a_moving_square_leaves_the_exact_trapezoid() {
    check_streak("whole", &strip([0.0, 2.0], 1024, GOING), [-1.0, 1.0]);
    check_streak("part of the way", &strip([0.5, 1.0], 1024, GOING), [-0.5, 0.0]);
    // Before the first pose and after the last all is at rest.
    let late = strip([1.0, 3.0], 1024, GOING);
    on_every_backend(|backend| {
        let stage = stage(&late, &[("square.obj", square(0.5, 0.0))], backend, &[]);
        for (x, found) in columns(&stage.render(|_| ()).0).into_iter().enumerate() {
            let exact = 0.5 * trapezoid(0.0, 1.0, x) + 0.5 * trapezoid(1.0, 1.0 + 1e-9, x);
            assert!((found - exact).abs() < 2e-3, "column {x}: {found} not {exact}");
        }
    });
}

/// The camera's way is the world's way back.
#[test]
fn a_moving_camera_leaves_the_same_streak() {
    let still = "[[mesh]]\nfile = \"square.obj\"\nmaterial = \"m\"\n";
    let moving = strip([0.0, 2.0], 1024, still).replace(
        "[film]",
        "motion = [{ time = 0.0, translate = [1, 0, 0] }, { time = 2.0, translate = [-1, 0, 0] }]\n[film]",
    );
    check_streak("camera", &moving, [-1.0, 1.0]);
}

/// Time is as well distributed as the places in the pixel: the streak's error falls faster than that of independent
/// samples.
#[test]
fn times_are_stratified() {
    let error = |set: &[&str]| {
        let stage =
            stage(&strip([0.0, 2.0], 64, GOING), &[("square.obj", square(0.5, 0.0))], Backend::Bvh, set);
        let image = stage.render(|_| ()).0;
        let squares = green(&image)
            .into_iter()
            .enumerate()
            .map(|(i, found)| (found - trapezoid(-1.0, 1.0, i % 64)).powi(2));
        (squares.sum::<f64>() / 512.0).sqrt()
    };
    let (sobol, random) = (error(&[]), error(&["render.sampler=random"]));
    assert!(sobol < 0.5 * random, "{sobol} against {random}");
}

/// A small square on a wheel of radius 1 that turns by a quarter: its light lies on the arc, evenly, and nowhere else. (A
/// straight line between the two matrices would cut the corner at radius 0.71.)
#[test]
fn a_wheels_rim_is_blurred_along_its_arc() {
    let dot = obj(&[vec![[0.95, -0.05, 0.0], [1.05, -0.05, 0.0], [1.05, 0.05, 0.0], [0.95, 0.05, 0.0]]]);
    let toml = "[camera]\ntype = \"orthographic\"\nposition = [0, 0, 9]\nlook_at = [0, 0, 0]\nheight = 2.4\nshutter = [0, 1]\n\
                [film]\nsize = [96, 96]\n[render]\nspp = 256\nmax_depth = 0\n\
                [[mesh]]\nfile = \"dot.obj\"\nmaterial = \"m\"\n\
                motion = [{ time = 0, rotate = { axis = [0, 0, 1], angle = 0 } }, { time = 1, rotate = { axis = [0, 0, 1], angle = ANGLE } }]\n\
                [materials.m]\ntype = \"diffuse\"\nemission = 1\n";
    on_every_backend(|backend| {
        for (angle, arc) in [(90.0, 90.0), (-630.0, 360.0)] {
            let toml = toml.replace("ANGLE", &format!("{angle}"));
            let stage = stage(&toml, &[("dot.obj", dot.clone())], backend, &[]);
            let image = stage.render(|_| ()).0;
            let (mut whole, mut by_quarter) = (0.0, [0.0; 4]);
            for (i, light) in green(&image).into_iter().enumerate() {
                let (x, y) = ((i % 96) as f64 + 0.5, (i / 96) as f64 + 0.5);
                let (x, y) = ((x - 48.0) / 40.0, (48.0 - y) / 40.0);
                whole += light / 1600.0;
                let on_rim = (x.hypot(y) - 1.0).abs() < 0.09;
                assert!(on_rim || light == 0.0, "{light} at {x} {y}");
                let turned = y.atan2(x).to_degrees().rem_euclid(360.0);
                by_quarter[(turned / 90.0) as usize] += light / 1600.0;
            }
            assert!((whole - 0.01).abs() < 1e-4, "{angle}: {whole}");
            if arc == 90.0 {
                assert!(by_quarter[0] > 0.95 * whole, "{by_quarter:?}");
            } else {
                // 630° are one turn and three quarters: every quarter twice, but the first one, backwards the last.
                let share = [1.0, 2.0, 2.0, 2.0].map(|times| times / 7.0 * whole);
                for (found, exact) in by_quarter.iter().zip(share) {
                    assert!((found - exact).abs() < 0.03 * whole, "{by_quarter:?}");
                }
            }
        }
    });
}

/// The same pixels, bit for bit, whether the shutter is open or closed, where nothing moves while it is open.
#[test]
fn still_scenes_do_not_know_the_shutter() {
    let toml = |shutter: &str| {
        format!(
            "[camera]\nposition = [3, 4, 5]\nlook_at = [0, 0, 0]\naperture = 0.1\nshutter = {shutter}\n\
             [film]\nsize = [24, 16]\n[render]\nspp = 16\n{SKY}\
             [[mesh]]\nfile = \"cube.obj\"\ninstance = true\ninstances = [{{}}, {{ translate = [0, 2, 0] }}]\n\
             [[mesh]]\nfile = \"cube.obj\"\ntransform = {{ translate = [-3, 0, 0] }}\n\
             motion = [{{ time = 9.0 }}, {{ time = 10.0, translate = [5, 0, 0] }}]\n"
        )
    };
    on_every_backend(|backend| {
        let picture = |shutter: &str| {
            let stage = stage(&toml(shutter), &[("cube.obj", cube())], backend, &[]);
            stage.render(|_| ()).0.f32_channel("G").unwrap().iter().map(|v| v.to_bits()).collect::<Vec<_>>()
        };
        let closed = picture("[0, 0]");
        assert_eq!(closed, picture("[0, 9]"));
        assert_ne!(closed, picture("[0, 9.5]"));
    });
}

/// A closed shutter shows what stands there at that time.
#[test]
fn a_closed_shutter_is_a_still_at_its_time() {
    on_every_backend(|backend| {
        let files = [("square.obj", square(0.5, 0.0))];
        let moving = stage(&strip([1.5, 1.5], 16, GOING), &files, backend, &[]).render(|_| ()).0;
        let there =
            "[[mesh]]\nfile = \"square.obj\"\nmaterial = \"m\"\ntransform = { translate = [0.5, 0, 0] }\n";
        let still = stage(&strip([0.0, 0.0], 16, there), &files, backend, &[]).render(|_| ()).0;
        assert_eq!(green(&moving), green(&still));
    });
}

/// A lamp that hardly moves lights like one at rest, whichever way light is sampled; the square lamp's closed form.
#[test]
fn moving_lamps_light_like_others() {
    let lamp = obj(&[vec![[-0.5, 0.5, 1.0], [0.5, 0.5, 1.0], [0.5, -0.5, 1.0], [-0.5, -0.5, 1.0]]]);
    let floor = obj(&[vec![[-9.0, -9.0, 0.0], [9.0, -9.0, 0.0], [9.0, 9.0, 0.0], [-9.0, 9.0, 0.0]]]);
    let toml = "[camera]\ntype = \"orthographic\"\nposition = [0, -3.0, 0.5]\nlook_at = [0, 0, 0]\nup = [0, 0, 1]\n\
         height = 1e-4\nshutter = [0, 1]\n[film]\nsize = [8, 8]\n[render]\nspp = 1024\nmax_depth = 1\n\
         [[mesh]]\nfile = \"floor.obj\"\nmaterial = \"floor\"\n\
         [[mesh]]\nfile = \"lamp.obj\"\nmaterial = \"lamp\"\nmotion = [{ time = 0 }, { time = 1, translate = [1e-5, 0, 0] }]\n\
         [materials.floor]\ntype = \"diffuse\"\nreflectance = 0.5\n\
         [materials.lamp]\ntype = \"diffuse\"\nreflectance = 0\nemission = 1\n";
    let point = "[[light]]\ntype = \"point\"\nposition = [0, 0, -5]\nintensity = 1\n";
    on_every_backend(|backend| {
        for way in ["mis", "light", "bsdf"] {
            let set = format!("render.lights={way}");
            let files = [("floor.obj", floor.clone()), ("lamp.obj", lamp.clone())];
            let stage = stage(&format!("{toml}{point}"), &files, backend, &[&set]);
            stage.statistics().expect(way, 0.119_728_2, 0.0);
        }
    });
}

/// Embree and the BVH see the same motion.
#[test]
fn backends_agree_about_motion() {
    let toml = format!(
        "[camera]\nposition = [4, 3, 6]\nlook_at = [0, 0, 0]\nshutter = [0, 1]\n\
         motion = [{{ time = 0 }}, {{ time = 1, rotate = {{ axis = [0, 1, 0], angle = 3 }} }}]\n\
         [film]\nsize = [48, 32]\n[render]\nspp = 64\nmax_depth = 3\n{SKY}\
         [[groups.pair]]\nfile = \"cube.obj\"\nmotion = [{{ time = 0 }}, {{ time = 1, rotate = {{ axis = [1, 0, 0], angle = 200 }} }}]\n\
         [[groups.pair]]\nfile = \"cube.obj\"\ntransform = {{ scale = 0.5, translate = [0, 2, 0] }}\n\
         [[mesh]]\ngroup = \"pair\"\nmotion = [{{ time = 0, translate = [-3, 0, 0] }}, {{ time = 1, scale = [1, 2, 1] }}]\n\
         instances = [{{}}, {{ translate = [3, -1, -2], material = \"red\" }}]\n\
         [materials.red]\ntype = \"diffuse\"\nreflectance = [0.8, 0.1, 0.1]\n"
    );
    let pictures: Vec<Vec<f64>> = Backend::ALL
        .iter()
        .map(|backend| green(&stage(&toml, &[("cube.obj", cube())], *backend, &[]).render(|_| ()).0))
        .collect();
    for other in &pictures[1..] {
        let differing = pictures[0].iter().zip(other).filter(|(a, b)| (*a - *b).abs() > 1e-4 * **a).count();
        assert!(differing <= 15, "{differing} of 1536 pixels differ");
    }
}

/// The square lamp after a time from 0 to 1: it flies over the floor, tumbles and grows.
fn lamp_at(time: f64) -> Vec<[f64; 3]> {
    let (turn, size, x) = ((180.0 * time).to_radians(), 0.5 + time, 2.0 * time - 1.0);
    let corners = [[-0.2, 0.2], [0.2, 0.2], [0.2, -0.2], [-0.2, -0.2]];
    corners.map(|[a, b]| [size * a * turn.cos() + x, size * b, 1.0 - size * a * turn.sin()]).to_vec()
}

/// What a lamp on its way sends to a point of the floor is the mean over the time of Lambert's closed form, whichever way
/// light is sampled; from both sides and from one, moved as a whole or by a group.
#[test]
fn a_moving_lamp_sends_the_mean_over_its_way() {
    let lamp = obj(&[vec![[-0.2, 0.2, 0.0], [0.2, 0.2, 0.0], [0.2, -0.2, 0.0], [-0.2, -0.2, 0.0]]]);
    let poses = "motion = [{ time = 0, scale = 0.5, translate = [-1, 0, 1] },\n\
                 { time = 1, scale = 1.5, rotate = { axis = [0, 1, 0], angle = 180 }, translate = [1, 0, 1] }]\n";
    let times = 4096;
    for (x, two_sided) in [(0.0, true), (-1.2, true), (0.0, false), (-0.6, false)] {
        let seen = |i: usize| {
            let time = (i as f64 + 0.5) / times as f64;
            let lamp = lamp_at(time);
            // Its winding points down at first, and turns away.
            let [a, b, c] = [0, 1, 2].map(|i| glam::DVec3::from(lamp[i]));
            let shines = two_sided || (b - a).cross(c - a).dot(glam::DVec3::X * x - a) > 0.0;
            if shines { lambert(&lamp, [x, 0.0, 0.0]) } else { 0.0 }
        };
        let exact = 0.5 / std::f64::consts::PI * (0..times).map(seen).sum::<f64>() / times as f64;
        let toml = floor_at(x, LAMP)
            .replace("height = 1e-4", "height = 1e-4\nshutter = [0, 1]")
            .replace("emission = 1.0", &format!("emission = 1.0\ntwo_sided = {two_sided}"))
            .replace("material = \"lamp\"\n", &format!("material = \"lamp\"\n{poses}"));
        on_every_backend(|backend| {
            let files = [floor(), ("lamp.obj", lamp.clone())];
            let by = |lights: &str, spp: u32| {
                let set = [&*format!("render.lights={lights}"), &*format!("render.spp={spp}")];
                stage(&toml, &files, backend, &set).statistics()
            };
            let [light, mis] = ["light", "mis"].map(|lights| by(lights, 256));
            for (lights, seen) in [("light", light), ("mis", mis)] {
                seen.expect(&format!("x {x}, two-sided {two_sided}, {lights}"), exact, 0.0);
            }
            if x != 0.0 {
                return;
            }
            // Rays alone rarely meet it.
            let rays = by("bsdf", 1024);
            rays.verdict(exact, 0.0, 0.1).unwrap_or_else(|why| panic!("x {x}, two-sided {two_sided}: {why}"));
            assert!(light.error < 0.5 * rays.error, "{} against {}", light.error, rays.error);
        });
    }
}
