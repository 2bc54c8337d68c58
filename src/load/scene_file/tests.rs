mod errors;

use super::*;
use crate::bsdf::fresnel::Reflectance;
use crate::bsdf::{Bsdf, Conductor};
use crate::camera::Projection;
use crate::error::Blame;
use crate::film::{Aov, Filter};
use crate::load::framing::Lens;
use crate::load::place::NormalsMode;
use crate::math::{DVec3, Rgb};
use crate::scene::{Compact, IntegratorKind};

const FILE: &str = "dir/scene.toml";

/// Reads `text` with `changes` put in and hands the plan to `look`.
fn with<T>(text: &str, changes: &[&str], look: impl FnOnce(Plan<'_>) -> T) -> Result<T> {
    let mut tree = tree::parse(text, Path::new(FILE))?;
    for change in changes {
        Override::parse(change)?.apply(&mut tree)?;
    }
    let home = Home { folder: Path::new("dir"), reach: &Reach::Anywhere };
    read(&tree, Path::new(FILE), &home, Settings::default()).map(look)
}

fn settings(text: &str, changes: &[&str]) -> Result<Settings> {
    with(text, changes, |plan| plan.settings)
}

fn error(text: &str, changes: &[&str]) -> Error {
    with(text, changes, |_| ()).expect_err(text)
}

#[test]
fn everything_in_its_section_arrives() {
    let text = r#"
[camera]
type = "orthographic"
position = [1, 2, 3]
look_at = [0, 0, 0]
height = 2.5
aperture = 0.25
focus_distance = 3
[film]
size = [320, 200]
filter = { type = "gaussian", radius = 2 }
crop = [10, 20, 30, 40]
aov = ["depth", "ids", "depth"]
[render]
integrator = { type = "ao", distance = 2.0 }
lights = "light"
roulette = false
split = 3
spp = 7
max_depth = 0
seed = "18446744073709551615"
sampler = "random"
backend = "bvh"
build = "high"
compact = true
[[mesh]]
file = "a.obj"
material = "red"
normals = "smooth"
crease = 60
transform = { scale = 2, translate = [1, 0, 0] }
[[mesh]]
file = "/b.obj"
[materials.red]
type = "diffuse"
reflectance = [0.5, 0, 0]
emission = 2
two_sided = false
[[light]]
type = "environment"
radiance = 0.5
[[light]]
type = "point"
position = [1e6, 0, 0]
intensity = [1, 2, 3]
"#;
    with(text, &[], |plan| {
        assert_eq!(plan.camera.projection, Projection::Orthographic);
        assert_eq!(plan.camera.position, Some(DVec3::new(1.0, 2.0, 3.0)));
        assert_eq!(plan.camera.lens, Lens::Height(2.5));
        assert_eq!((plan.camera.aperture.radius, plan.camera.focus_distance), (0.25, Some(3.0)));
        let s = &plan.settings;
        assert_eq!((s.size, s.crop), ([320, 200], Some([10, 20, 30, 40])));
        assert_eq!(s.filter, Filter::Gaussian { sigma: 0.5, radius: 2.0 });
        assert_eq!(s.aovs, [Aov::Depth, Aov::Ids]);
        assert_eq!(s.integrator, IntegratorKind::Ao { distance: 2.0 });
        assert_eq!(
            (s.roulette, s.split, s.spp, s.max_depth, s.seed, s.compact),
            (false, Some(3), 7, 0, u64::MAX, Compact::Yes)
        );
        assert_eq!(plan.meshes[0].file, Path::new("dir/a.obj"));
        assert_eq!(plan.meshes[1].file, Path::new("/b.obj"));
        assert_eq!(plan.meshes[0].normals, NormalsMode::Smooth { crease: 60.0 });
        assert_eq!(plan.lights[0], LightPlan::Constant(Rgb::splat(0.5)));
        let red = plan.materials["red"].apply(crate::load::materials::MaterialSpec::diffuse("red", Rgb::ONE));
        let red = red.unwrap();
        assert_eq!((red.emission, red.two_sided), (Rgb::splat(2.0), false));
    })
    .unwrap();
}

/// The rules of the notes, in all their spellings.
#[test]
fn rules_of_integration_are_read() {
    use crate::film::{PixelRule, rule::Grid};
    use crate::quadrature::hemisphere::{Cells, HemisphereRule, Measure};
    use crate::scene::Quantity;
    let settings = |text: &str, set: &[&str]| {
        let mut read = None;
        with(text, set, |plan| read = Some((plan.settings.clone(), plan.findings.count("spp-by-rule"))))
            .unwrap();
        read.unwrap()
    };
    let grid = |cells, per_cell| Grid { cells, per_cell };
    let (s, notes) =
        settings("[film]\nquantity = \"flux\"\nrule = { type = \"uniform\", grid = [3, 2] }", &[]);
    assert_eq!((s.quantity, s.rule, s.spp), (Quantity::Flux, PixelRule::Uniform(grid([3, 2], 0)), 6));
    assert_eq!(notes, 0, "nobody asked for another number of samples");
    let (s, notes) =
        settings("[render]\nspp = 9", &["film.rule={ type = \"stratified\", grid = [2, 2], per_cell = 5 }"]);
    assert_eq!((s.rule, s.spp, notes), (PixelRule::Stratified(grid([2, 2], 5)), 20, 1));
    let (s, notes) = settings("[render]\nspp = 8", &["film.rule=nonuniform"]);
    assert_eq!((s.rule, s.spp, notes), (PixelRule::Nonuniform(grid([4, 2], 0)), 8, 0));
    let (s, _) = settings("[render]\nspp = 8", &["film.rule=importance"]);
    assert_eq!((s.rule, s.spp), (PixelRule::Importance, 8));

    let integrator = |set: &[&str]| match settings("", set).0.integrator {
        IntegratorKind::Distribution { rule, directions } => {
            (rule, directions.cells().iter().map(|c: &Cells| (c.theta, c.phi)).collect::<Vec<_>>())
        }
        other => panic!("{other:?}"),
    };
    let word = "render.integrator=distribution";
    assert_eq!(integrator(&[word]), (HemisphereRule::Importance, vec![(4, 4), (1, 1)]));
    let mixed = integrator(&[word, "render.max_depth=3", "render.integrator.directions=[[8, 8], 8, 1]"]);
    assert_eq!(mixed.1, [(8, 8), (2, 4), (1, 1)]);
    assert_eq!(integrator(&[word, "render.max_depth=2", "render.integrator.directions=12"]).1, [(3, 4)]);
    let jittered = integrator(&[
        word,
        "render.integrator={ type = \"distribution\", rule = \"nonuniform\", per_cell = 2 }",
    ]);
    assert_eq!(jittered.0, HemisphereRule::Nonuniform { per_cell: 2 });
    let solid = integrator(&[word, "render.integrator.rule=random", "render.integrator.measure=solid-angle"]);
    assert_eq!(solid.0, HemisphereRule::Random { measure: Measure::SolidAngle });
}

#[test]
fn set_refines_shorthands_and_makes_what_is_missing() {
    let filter = |text: &str, changes: &[&str]| settings(text, changes).unwrap().filter;
    let gaussian = |sigma, radius| Filter::Gaussian { sigma, radius };
    assert_eq!(filter("", &["film.filter=gaussian"]), gaussian(0.5, 1.5));
    assert_eq!(filter("[film]\nfilter = \"gaussian\"", &["film.filter.radius=2"]), gaussian(0.5, 2.0));
    assert_eq!(filter("", &["film.filter=\"gaussian\"", "film.filter.sigma = 1"]), gaussian(1.0, 1.5));
    assert_eq!(filter("", &["film.filter={ type = 'gaussian', radius = 3 }"]), gaussian(0.5, 3.0));
    assert_eq!(filter("", &["film.filter.radius=1"]), Filter::Box { radius: 1.0 });
    assert_eq!(settings("[render]\nspp = 3", &["render.spp=5", "render.spp=9"]).unwrap().spp, 9);
    let text = "[[light]]\ntype = \"environment\"\nradiance = 1";
    let light = |change: &str| with(text, &[change], |plan| plan.lights).unwrap();
    assert_eq!(light("light.0.radiance=[1, 2, 3]"), [LightPlan::Constant(Rgb::new(1.0, 2.0, 3.0))]);
    assert_eq!(light("light.0.scale=2"), [LightPlan::Constant(Rgb::splat(2.0))]);
    let added = with("", &["light.0.type=environment", "light.0.radiance=3"], |plan| plan.lights).unwrap();
    assert_eq!(added, [LightPlan::Constant(Rgb::splat(3.0))]);
    let material = with("", &["materials.\"a.b\".emission=4"], |plan| plan.materials.into_keys().next());
    assert_eq!(material.unwrap().as_deref(), Some("a.b"));
}

#[test]
fn any_text_is_read_or_refused() {
    let good = "[camera]\nfov = 40\n[film]\nsize = [64, 64]\n[[mesh]]\nfile = \"ä.obj\"\n[materials.a]\nemission = 1\n";
    for (end, _) in good.char_indices() {
        let _ = with(&good[..end], &[], |_| ());
    }
    for text in [
        "film = 3",
        "mesh = 1",
        "mesh = [1]",
        "light = {}",
        "materials = []",
        "camera = \"x\"",
        "\u{0}",
        "[[[[[",
    ] {
        error(text, &[]);
    }
    // As deep as one likes: the parser stops before the stack does.
    error(&format!("a = {}", "[".repeat(100_000)), &[]);
}

#[test]
fn every_registered_model_and_filter_can_be_named() {
    for (name, _) in Bsdf::NAMES {
        let text = format!("[materials.m]\ntype = \"{name}\"");
        let base = crate::load::materials::MaterialSpec::diffuse("m", Rgb::ONE);
        let model = with(&text, &[], |plan| plan.materials["m"].apply(base).unwrap().model.name()).unwrap();
        assert_eq!(model, *name);
    }
    for (name, _) in Filter::NAMES {
        let shorthand = settings("", &[&format!("film.filter={name}")]).unwrap().filter;
        let table = settings("", &[&format!("film.filter={{ type = \"{name}\" }}")]).unwrap().filter;
        assert_eq!((shorthand.name(), shorthand), (*name, table));
    }
    for (name, _) in Projection::NAMES {
        with("", &[&format!("camera.type={name}")], |_| ()).unwrap();
    }
}

#[test]
fn without_a_type_only_the_keys_given_change() {
    let white = Reflectance::Constant(Rgb::splat(0.9));
    let metal = crate::load::materials::MaterialSpec {
        model: Bsdf::Conductor(Conductor::new(white, 0.04, true)),
        emission: Rgb::splat(3.0),
        ..crate::load::materials::MaterialSpec::diffuse("m", Rgb::ONE)
    };
    let patched = |text: &str| with(text, &[], |plan| plan.materials["m"].apply(metal.clone())).unwrap();
    let changed = patched("[materials.m]\nroughness = 0.5").unwrap();
    assert_eq!(changed.emission, metal.emission);
    assert_eq!(changed.model, Bsdf::Conductor(Conductor::new(white, 0.25, true)));
    assert_eq!(patched("[materials.m]\ntype = \"mirror\"").unwrap().model.name(), "mirror");
    let wrong = patched("[materials.m]\ncompensate = false\nexponent = 3").unwrap_err();
    assert_eq!((wrong.line, wrong.column), (Some(3), Some(12)));
}

/// Places multiply: a group of two in three places are six, each moved by its own transform, then by what is around it.
#[test]
fn groups_and_instances_become_meshes_in_their_places() {
    let text = r#"
[[groups.pair]]
file = "a.obj"
material = "own"
transform = { translate = [1, 0, 0] }
[[groups.pair]]
file = "b.obj"
motion = [{ time = 0 }, { time = 1, translate = [0, 1, 0] }]
[[mesh]]
group = "pair"
transform = { scale = 2 }
instance = true
instances = [{}, { translate = [0, 0, 5] }, { material = "other" }]
"#;
    with(text, &[], |plan| {
        let names: Vec<_> = plan.meshes.iter().map(|m| m.file.to_string_lossy().into_owned()).collect();
        assert_eq!(names, ["dir/a.obj", "dir/b.obj", "dir/a.obj", "dir/b.obj", "dir/a.obj", "dir/b.obj"]);
        let material = |i: usize| plan.meshes[i].material.as_ref().map(|m| m.text().unwrap());
        assert_eq!([0, 1, 4, 5].map(material), [Some("own"), None, Some("other"), Some("other")]);
        let at = |i: usize, time: f64| {
            let mesh = &plan.meshes[i];
            let stages = [crate::shape::Stage::Fixed(mesh.transform.affine())];
            let stages = stages.into_iter().chain(mesh.course.iter().cloned()).collect();
            crate::shape::Instance::new(0, None, stages).transform(time).translation
        };
        assert_eq!((at(0, 0.0), at(2, 0.0)), (DVec3::new(2.0, 0.0, 0.0), DVec3::new(2.0, 0.0, 5.0)));
        assert_eq!((at(3, 0.0), at(3, 0.5)), (DVec3::new(0.0, 0.0, 5.0), DVec3::new(0.0, 1.0, 5.0)));
        assert!(plan.meshes[0].course.is_empty() && plan.meshes.iter().all(|m| m.instance == Some(true)));
    })
    .unwrap();
}
