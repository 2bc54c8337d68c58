//! O7, O10, O15: direct light with closed forms, looked at through a very small window.

use crate::harness::{obj, on_every_backend, stage};
use std::f64::consts::PI;

/// A floor at z = 0 with ρ = .5, seen at (x, 0, 0) from the side; `rest` adds what shines.
pub fn floor_at(x: f64, rest: &str) -> String {
    format!(
        "[camera]\ntype = \"orthographic\"\nposition = [{x}, -3.0, 0.5]\nlook_at = [{x}, 0.0, 0.0]\nup = [0, 0, 1]\n\
         height = 1e-4\n[film]\nsize = [8, 8]\n[render]\nspp = 64\nmax_depth = 1\n\
         [[mesh]]\nfile = \"floor.obj\"\nmaterial = \"floor\"\n[materials.floor]\ntype = \"diffuse\"\nreflectance = 0.5\n{rest}"
    )
}

pub fn floor() -> (&'static str, String) {
    ("floor.obj", obj(&[vec![[-9.0, -9.0, 0.0], [9.0, -9.0, 0.0], [9.0, 9.0, 0.0], [-9.0, 9.0, 0.0]]]))
}

pub const LAMP: &str = "[[mesh]]\nfile = \"lamp.obj\"\nmaterial = \"lamp\"\n\
                    [materials.lamp]\ntype = \"diffuse\"\nreflectance = 0.0\nemission = 1.0\n";

/// Lambert's formula: E = (L/2) Σ Θᵢ (Γᵢ·n) over the edges of a polygon above the horizon, seen from the
/// origin of the receiver with normal n = +z.
pub fn lambert(polygon: &[[f64; 3]], from: [f64; 3]) -> f64 {
    let v: Vec<glam::DVec3> =
        polygon.iter().map(|p| (glam::DVec3::from(*p) - glam::DVec3::from(from)).normalize()).collect();
    let edge = |i: usize| {
        let (a, b) = (v[i], v[(i + 1) % v.len()]);
        a.dot(b).clamp(-1.0, 1.0).acos() * a.cross(b).normalize().z
    };
    (0.5 * (0..v.len()).map(edge).sum::<f64>()).abs()
}

pub const SQUARE: [[f64; 3]; 4] = [[-0.5, -0.5, 1.0], [0.5, -0.5, 1.0], [0.5, 0.5, 1.0], [-0.5, 0.5, 1.0]];

#[test]
fn o7_a_square_lamp_over_a_floor() {
    on_every_backend(|backend| {
        for (x, exact) in [(0.0, 0.119_728_2), (0.5, 0.090_184_4), (1.0, 0.042_176_8), (2.0, 0.006_961_86)] {
            let formula = 0.5 / PI * lambert(&SQUARE, [x, 0.0, 0.0]);
            assert!((formula / exact - 1.0).abs() < 1e-5, "the formula itself: {formula}");
            let lamp = ("lamp.obj", obj(&[SQUARE.to_vec()]));
            for lights in ["mis", "light"] {
                stage(
                    &floor_at(x, LAMP),
                    &[floor(), lamp.clone()],
                    backend,
                    &[&format!("render.lights={lights}")],
                )
                .statistics()
                .expect(&format!("O7 x {x} {lights}"), exact, 0.0);
            }
        }
        let lamp = ("lamp.obj", obj(&[SQUARE.to_vec()]));
        stage(&floor_at(0.0, LAMP), &[floor(), lamp], backend, &["render.lights=bsdf", "render.spp=1024"])
            .statistics()
            .expect("O7 by BSDF samples", 0.119_728_2, 0.0);
    });
}

/// Two lamps of different size and place: choosing between them must divide by the choice's probability.
#[test]
fn two_lamps_add_up() {
    let small = [[1.0, 0.5, 0.7], [1.4, 0.5, 0.7], [1.4, 1.1, 0.9], [1.0, 1.1, 0.9]];
    let exact = 0.5 / PI * (lambert(&SQUARE, [0.3, 0.0, 0.0]) + lambert(&small, [0.3, 0.0, 0.0]));
    on_every_backend(|backend| {
        let lamps = ("lamp.obj", obj(&[SQUARE.to_vec(), small.to_vec()]));
        stage(&floor_at(0.3, LAMP), &[floor(), lamps], backend, &["render.spp=256"]).statistics().expect(
            "two lamps",
            exact,
            0.0,
        );
    });
}

#[test]
fn o10_a_triangular_lamp() {
    on_every_backend(|backend| {
        let triangle = [[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0]];
        assert!((lambert(&triangle, [0.0; 3]) - 0.302_299_9).abs() < 1e-6);
        let lamp = ("lamp.obj", obj(&[triangle.to_vec()]));
        stage(&floor_at(0.0, LAMP), &[floor(), lamp], backend, &[]).statistics().expect(
            "O10",
            0.048_112_5,
            0.0,
        );
    });
}

/// A lamp that shines on one side only, turned to the floor and turned away.
#[test]
fn one_sided_lamps_shine_where_their_winding_says() {
    let one_sided = format!("{LAMP}two_sided = false\n");
    let down: Vec<[f64; 3]> = SQUARE.iter().rev().copied().collect();
    on_every_backend(|backend| {
        let shine = |polygon: &[[f64; 3]]| {
            let lamp = ("lamp.obj", obj(&[polygon.to_vec()]));
            stage(&floor_at(0.0, &one_sided), &[floor(), lamp], backend, &[]).statistics()
        };
        shine(&down).expect("towards the floor", 0.119_728_2, 0.0);
        assert_eq!(shine(&SQUARE).mean, 0.0);
    });
}

fn point(height: f64) -> String {
    format!("[[light]]\ntype = \"point\"\nposition = [0, 0, {height}]\nintensity = 1.0\n")
}

#[test]
fn o15_a_point_over_a_floor() {
    on_every_backend(|backend| {
        let at =
            |x: f64, height: f64| stage(&floor_at(x, &point(height)), &[floor()], backend, &[]).statistics();
        at(0.0, 2.0).expect("O15 below", 0.039_788_7, 0.0);
        at(2.0, 2.0).expect("O15 at x = 2", 0.5 / PI * 0.088_388_3, 0.0);
        let ratio = at(0.0, 4.0).mean / at(0.0, 2.0).mean;
        assert!((ratio - 0.25).abs() < 1e-6, "twice as far is a quarter: {ratio}");
    });
}

/// What stands between light and floor makes a shadow.
#[test]
fn a_screen_blocks_a_point() {
    let screen = "[[mesh]]\nfile = \"screen.obj\"\nmaterial = \"floor\"\n";
    let square = |z: f64| SQUARE.map(|[x, y, _]| [x, y, z]).to_vec();
    on_every_backend(|backend| {
        let toml = floor_at(0.0, &format!("{}{screen}", point(2.0)));
        let blocked = stage(&toml, &[floor(), ("screen.obj", obj(&[square(1.0)]))], backend, &[]);
        assert_eq!(blocked.statistics().mean, 0.0);
        let behind = stage(&toml, &[floor(), ("screen.obj", obj(&[square(3.0)]))], backend, &[]);
        behind.statistics().expect("a screen behind the light", 0.039_788_7, 0.0);
    });
}
