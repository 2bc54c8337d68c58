//! O13 and the other lamps of scene files, against closed forms and against each other.

use crate::harness::{obj, on_every_backend, stage};
use std::f64::consts::PI;

/// A floor at z = 0 with ρ = .5, seen from the side at the origin.
fn floor_under(rest: &str) -> (String, Vec<(&'static str, String)>) {
    let toml = format!(
        "[camera]\ntype = \"orthographic\"\nposition = [0, -3.0, 0.5]\nlook_at = [0, 0, 0]\nup = [0, 0, 1]\n\
         height = 1e-4\n[film]\nsize = [8, 8]\n[render]\nspp = 64\nmax_depth = 1\n\
         [[mesh]]\nfile = \"floor.obj\"\nmaterial = \"floor\"\n[materials.floor]\ntype = \"diffuse\"\nreflectance = 0.5\n{rest}"
    );
    let floor = obj(&[vec![[-9.0, -9.0, 0.0], [9.0, -9.0, 0.0], [9.0, 9.0, 0.0], [-9.0, 9.0, 0.0]]]);
    (toml, vec![("floor.obj", floor)])
}

fn check(what: &str, rest: &str, set: &[&str], exact: f64) {
    on_every_backend(|backend| {
        let (toml, files) = floor_under(rest);
        let statistics = stage(&toml, &files, backend, set).statistics();
        if exact == 0.0 {
            assert_eq!(statistics.mean, 0.0, "{what}");
        } else {
            statistics.expect(what, exact, 0.0);
        }
    });
}

/// E = π·L·sin²θ for a sphere straight above.
#[test]
fn o13_a_sphere_over_a_floor() {
    let sphere = "[[light]]\ntype = \"sphere\"\ncenter = [0, 0, 4]\nradius = 1\nradiance = 1\n";
    check("O13", sphere, &[], 0.031_25);
    check("O13 by light samples", sphere, &["render.lights=light"], 0.031_25);
    check("O13 by BSDF samples", sphere, &["render.lights=bsdf", "render.spp=4096"], 0.031_25);
    let small = sphere.replace("radius = 1\n", "radius = 0.01\n");
    check("a small sphere", &small, &[], 0.5 * (0.01f64 / 4.0).powi(2));
}

/// A sphere half below the horizon of a tilted receiver is cut; two spheres add up, one behind the other hides.
#[test]
fn spheres_block_each_other() {
    let two = "[[light]]\ntype = \"sphere\"\ncenter = [0, 0, 4]\nradius = 1\nradiance = 1\n\
               [[light]]\ntype = \"sphere\"\ncenter = [0, 0, 9]\nradius = 1\nradiance = 50\n";
    check("the far one is hidden", two, &[], 0.031_25);
}

#[test]
fn a_rectangle_is_the_square_lamp() {
    let lamp = |two_sided: &str| {
        format!(
            "[[light]]\ntype = \"rectangle\"\ncorner = [-0.5, 0.5, 1]\nedge_u = [1, 0, 0]\nedge_v = [0, -1, 0]\n\
             radiance = 1\n{two_sided}"
        )
    };
    check("both sides", &lamp(""), &[], 0.119_728_2);
    // edge_u × edge_v points down, to the floor.
    check("one side", &lamp("two_sided = false\n"), &[], 0.119_728_2);
    let up = lamp("two_sided = false\n").replace("[0, -1, 0]", "[0, 1, 0]").replace("0.5, 1]", "-0.5, 1]");
    check("turned away", &up, &[], 0.0);
}

/// ρ/π·E·cos θ, whatever the distance.
#[test]
fn parallel_light_obeys_the_cosine() {
    for degrees in [0.0f64, 30.0, 70.0] {
        let (s, c) = degrees.to_radians().sin_cos();
        let light =
            format!("[[light]]\ntype = \"directional\"\ndirection = [{s}, 0, {}]\nirradiance = 2\n", -c);
        check(&format!("{degrees}°"), &light, &[], 0.5 / PI * 2.0 * c);
    }
    let below = "[[light]]\ntype = \"directional\"\ndirection = [0, 0, 1]\nirradiance = 2\n";
    check("from below", below, &[], 0.0);
}

/// All kinds at once: the choice among them must be divided out.
#[test]
fn lights_of_all_kinds_add_up() {
    let all = "[[light]]\ntype = \"sphere\"\ncenter = [0, 0, 4]\nradius = 1\nradiance = 1\n\
               [[light]]\ntype = \"point\"\nposition = [2, 0, 2]\nintensity = 1\n\
               [[light]]\ntype = \"directional\"\ndirection = [0.6, 0, -0.8]\nirradiance = 0.3\n\
               [[light]]\ntype = \"rectangle\"\ncorner = [-3, 3, 1]\nedge_u = [1, 0, 0]\nedge_v = [0, -1, 0]\nradiance = 4\n";
    // The rectangle by Lambert's formula in its own test's way: the corner form for a parallel rectangle,
    // E = L/2·Σ over its four corners, each seen from below the corner at distance 1.
    let corner = |a: f64, b: f64| {
        let part = |p: f64, q: f64| p / (1.0 + p * p).sqrt() * (q / (1.0 + p * p).sqrt()).atan();
        0.5 * (part(a, b) + part(b, a))
    };
    // [−3, −2] × [2, 3] by inclusion and exclusion of rectangles with a corner over the receiver.
    let rectangle = 4.0 * (corner(3.0, 3.0) - corner(3.0, 2.0) - corner(2.0, 3.0) + corner(2.0, 2.0));
    let point = 0.5 / PI * 0.088_388_347_6;
    let exact = 0.031_25 + point + 0.5 / PI * 0.3 * 0.8 + 0.5 / PI * rectangle;
    check("all", all, &["render.spp=1024"], exact);
}
