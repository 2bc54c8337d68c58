//! distRtShade, 13.9, against the path integrator, and what its branching costs.

use crate::harness::{Statistics, cube, obj, on_every_backend, sphere, stage};
use crate::hemisphere::rule;
use drt::accel::Backend;

/// Name, scene file, meshes.
type Case = (&'static str, String, Vec<(&'static str, String)>);

/// Five scenes.
fn scenes() -> Vec<Case> {
    let look = "[camera]\nposition = [1.5, 1.2, 3.2]\nlook_at = [0, 0.2, 0]\nfov = 45\n[film]\nsize = [6, 6]\n[render]\nmax_depth = 4\n";
    let inside = "[camera]\nposition = [0.13, 0.21, 0.6]\nlook_at = [0, -0.2, -1]\nfov = 70\n[film]\nsize = [6, 6]\n[render]\nmax_depth = 4\n";
    let body = |mesh: &str, material: &str| {
        format!("[[mesh]]\nfile = \"{mesh}.obj\"\nmaterial = \"{mesh}\"\n[materials.{mesh}]\n{material}\n")
    };
    let diffuse = "type = \"diffuse\"\nreflectance = [0.7, 0.5, 0.3]";
    let floor =
        ("floor", obj(&[vec![[-6.0, -1.0, 6.0], [6.0, -1.0, 6.0], [6.0, -1.0, -6.0], [-6.0, -1.0, -6.0]]]));
    let ball = sphere(24, 36);
    let sky = "[[light]]\ntype = \"environment\"\nradiance = [0.8, 1.0, 1.3]\n";
    let panel = "[[light]]\ntype = \"rectangle\"\ncorner = [-0.6, 0.9, -0.5]\nedge_u = [1.2, 0, 0]\nedge_v = [0, 0, 1]\nradiance = 3\n";
    let floor_file = ("floor.obj", floor.1);
    vec![
        ("closed box", format!("{inside}{}{panel}", body("room", diffuse)), vec![("room.obj", cube())]),
        (
            "emissive mesh",
            format!("{look}{}{}", body("ball", "emission = [1, 2, 3]"), body("floor", diffuse)),
            vec![("ball.obj", ball.clone()), floor_file.clone()],
        ),
        (
            "mirror",
            format!(
                "{look}{}{}{sky}",
                body("ball", "type = \"mirror\"\nreflectance = 0.9"),
                body("floor", diffuse)
            ),
            vec![("ball.obj", ball.clone()), floor_file.clone()],
        ),
        (
            "glass",
            format!(
                "{look}{}{}{sky}",
                body("ball", "type = \"dielectric\"\nior = 1.5"),
                body("floor", diffuse)
            ),
            vec![("ball.obj", ball.clone()), floor_file.clone()],
        ),
        (
            "environment",
            format!(
                "{look}{}{}{sky}",
                body("ball", "type = \"phong\"\ndiffuse = 0.4\nspecular = 0.4\nexponent = 20"),
                body("floor", diffuse)
            ),
            vec![("ball.obj", ball), floor_file],
        ),
    ]
}

/// Unbiased rules with directions for the first two depths.
const RULES: [&str; 8] = [
    "rule = \"random\", directions = [12, 2, 1]",
    "rule = \"random\", measure = \"solid-angle\", directions = [12, 2, 1]",
    "rule = \"stratified\", directions = [[3, 4], 2, 1]",
    "rule = \"stratified\", per_cell = 2, directions = [[2, 3], [1, 1]]",
    "rule = \"nonuniform\", per_cell = 1, directions = [[3, 4], [1, 2], [1, 1]]",
    "rule = \"importance\", directions = [12, 2, 1]",
    "rule = \"sobol\", directions = [12, 2, 1]",
    "rule = \"sobol\", measure = \"projected\", directions = [16, 1]",
];

fn agree(a: Statistics, b: Statistics, what: &str) {
    let error = a.error.hypot(b.error);
    assert!(error < 0.005 * a.mean, "{what}: standard error {error:e} of {} is too wide", a.mean);
    assert!((a.mean - b.mean).abs() < 6.37 * error + 1e-6, "{what}: {} and {}, ± {error:e}", a.mean, b.mean);
}

#[test]
fn every_unbiased_rule_agrees_with_path() {
    on_every_backend(|backend| {
        for (name, toml, files) in scenes() {
            let path = stage(&toml, &files, backend, &["render.spp=128"]).statistics();
            for text in RULES {
                let stage = stage(&toml, &files, backend, &[&rule(text), "render.spp=48"]);
                agree(path, stage.statistics(), &format!("{name}: {text}"));
            }
        }
    });
}

/// Rays follow from the settings alone: Σ over depths of the product of the directions up to there, no more and no
/// less, since even a direction of weight zero is followed.
#[test]
fn the_branching_cost_is_what_the_settings_say() {
    on_every_backend(|backend| {
        let toml = "[camera]\nposition = [0.13, 0.21, 0.08]\nlook_at = [0.5, 0.1, -1]\nfov = 90\n[film]\nsize = [9, 7]\n\
                    [render]\nspp = 3\n[[mesh]]\nfile = \"m.obj\"\nmaterial = \"m\"\n\
                    [materials.m]\nreflectance = 0.5\nemission = 1\n";
        let cases: [(&str, u32, u64); 6] = [
            ("rule = \"uniform-corner\", directions = [[8, 8], 8, 1]", 3, 64 + 512 + 512),
            ("rule = \"stratified\", per_cell = 3, directions = [[2, 3], 2]", 2, 18 + 108),
            ("rule = \"random\", directions = [5]", 4, 5 + 25 + 125 + 625),
            ("rule = \"nonuniform\", directions = [[2, 2], [1, 1]]", 5, 20),
            ("rule = \"sobol\", directions = [7, 3]", 1, 7),
            ("rule = \"uniform\", directions = [[90, 100]]", 1, 9000),
        ];
        for (text, depth, rays) in cases {
            let depth = format!("render.max_depth={depth}");
            let (_, stats) =
                stage(toml, &[("m.obj", cube())], backend, &[&rule(text), &depth]).render(|_| ());
            assert_eq!(stats.camera_rays, 9 * 7 * 3);
            assert_eq!(stats.bounce_rays, rays * 9 * 7 * 3, "{text}");
        }
    });
}

/// Each delta direction gets its own branch: behind glass there is no choice left to chance.
#[test]
fn glass_and_mirror_branch_without_noise() {
    on_every_backend(|backend| {
        let (_, toml, files) = scenes().swap_remove(3);
        let fixed = rule("rule = \"uniform\", directions = [[4, 4], [1, 1]]");
        // From the centre of each pixel: neither pixel nor hemisphere nor glass may depend on the seed.
        let set = [fixed.as_str(), "film.rule={ type = \"uniform\", grid = [1, 1] }"];
        let stage = stage(&toml, &files, backend, &set);
        let [a, b] = [1, 2].map(|seed| stage.render(|s| s.seed = seed).0);
        assert_eq!(a.f32_channel("G"), b.f32_channel("G"));
    });
}

/// Waves are cut into pieces where a vertex sends out many rays; neither threads nor a crop may show it.
#[test]
fn pieces_do_not_show() {
    let backend = Backend::ALL[0];
    let (_, toml, files) = scenes().swap_remove(0);
    let set = [
        &rule("rule = \"stratified\", directions = [[20, 50], [2, 2], [1, 1]]"),
        "film.size=[20, 12]",
        "render.spp=5",
    ];
    let whole = stage(&toml, &files, backend, &set).render(|_| ()).0;
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let alone = one.install(|| stage(&toml, &files, backend, &set).render(|_| ()).0);
    assert_eq!(whole.f32_channel("R"), alone.f32_channel("R"));
    let part = stage(&toml, &files, backend, &set).render(|s| s.crop = Some([9, 3, 7, 8])).0;
    let (whole, part) = (whole.f32_channel("R").unwrap(), part.f32_channel("R").unwrap());
    for (i, v) in part.iter().enumerate() {
        assert_eq!(*v, whole[(3 + i / 7) * 20 + 9 + i % 7]);
    }
}

/// 13.8: with p = 1/D importance sampling is simple Monte Carlo. On a surface that the cosine's density fits, random
/// points of equal projected solid angle and importance sampling see the same.
#[test]
fn importance_reduces_to_random_points_of_its_own_density() {
    on_every_backend(|backend| {
        let (_, toml, files) = scenes().swap_remove(4);
        let diffuse = "materials.ball={ type = \"diffuse\", reflectance = 0.5 }";
        let of =
            |text: &str| stage(&toml, &files, backend, &[diffuse, &rule(text), "render.spp=48"]).statistics();
        let random = of("rule = \"random\", measure = \"projected\", directions = [8, 1]");
        agree(random, of("rule = \"importance\", directions = [8, 1]"), "importance");
    });
}
