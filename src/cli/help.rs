//! What `--help` and `--version` say; lists of names come from the code that owns them.

use drt::accel::Backend;
use drt::bsdf::{Bsdf, Mix, metals::METALS};
use drt::camera::Projection;
use drt::converge::integrals::INTEGRALS;
use drt::converge::report;
use drt::converge::scene::Subject;
use drt::film::{Aov, Filter, PixelRule};
use drt::light::Light;
use drt::load::FORMATS as MESH_FORMATS;
use drt::load::auto::{Sky, Up, View};
use drt::math::isa::Isa;
use drt::output::{FORMATS, ToneMap};
use drt::quadrature::hemisphere::{HemisphereRule, Measure};
use drt::scene::{IntegratorKind, LightSampling, Quantity, SamplerKind};
use drt::texture;
use std::fmt::Write;

/// Below the short help.
pub const SHORT: &str =
    "`drt --help` says more, with examples and every name that a flag or scene key may take.";

const EXAMPLES: &str = "\
EXAMPLES
  drt bunny.obj
      bunny.png: the mesh framed, in studio light
  drt scan.obj --up z --view iso --ground --size 1920x1080 --spp 256 -o scan.exr -o scan.png
      z is up; linear radiance for later, and a picture to look at
  drt part.obj --integrator ao --sky white
      how open each place is to its surroundings
  drt kitchen.toml --set camera.fov=60 --set light.0.radiance=2
      a scene file with two of its keys changed
  drt bunny.obj --ground --sky evening.hdr
      lit by a picture of all directions
  drt kitchen.toml --set camera.aperture=0.02 --focus 320,200
      a lens, focused on what that pixel sees
  drt kitchen.toml --crop 600,200,128,128 --spp 4096
      a part of the picture at full quality, with the pixels of the whole
  drt bunny.obj --turntable 36 -o turn-##.png
      36 pictures from all around; --frames 0..47 for a scene that moves
  zcat scan.ply.gz | drt - -o scan.png
      a mesh from standard input; .obj, .ply, .stl, .gltf and .glb, also in .gz and .zst (docs/formats.md)
  drt kitchen.toml --spp 4096 -o night.exr --checkpoint night.checkpoint --resume
      a long render: after Ctrl-C, a kill or a power cut the same command goes on, with the same bytes in the end
  drt check scan.obj
      what is in the file and what is wrong with it; --json for programs, --strict to fail on warnings
  drt converge scenes/cornell-box.toml -o cornell.svg
      error against the number of samples, for each way to choose them; drt converge --help lists them
  drt diff-backends scan.obj
      the same rays through every backend and instruction set: who differs, who is wrong, how fast each is
  drt bunny.obj -q --stats - | jq .seconds
      what took how long

A SCENE FILE
  [camera]
  position = [0, 1, 5]
  look_at = [0, 1, 0]
  fov = 40                      # vertical, in degrees

  [film]
  size = [640, 480]
  filter = \"gaussian\"           # or { type = \"gaussian\", sigma = 0.5, radius = 1.5 }

  [[mesh]]
  file = \"bunny.obj\"            # relative to this file
  material = \"gold\"             # without it the MTL decides
  transform = { scale = 2, rotate = { axis = [0, 1, 0], angle = 30 }, translate = [0, 1, 0] }
  # instances = [ {}, { translate = [3, 0, 0], material = \"clay\" } ]    # the same mesh in several places
  # motion = [ { time = 0 }, { time = 1, translate = [1, 0, 0] } ]      # with shutter = [0, 1] in [camera]

  [materials.gold]
  type = \"conductor\"
  metal = \"gold\"
  roughness = 0.3               # any number or colour may be a picture:
  # roughness = { texture = \"rust.png\", filter = \"nearest\", wrap = \"clamp\", scale = [2, 2], channel = \"g\" }
  # of every material: opacity, emission, normal_map = { texture = … }, bump = { texture = …, height = 0.01 }

  [[light]]
  type = \"environment\"
  radiance = [1, 1, 1]

  Right-handed, y up, metres, degrees, linear Rec.709. An unknown key is an error, never ignored.
";

const EXIT_CODES: &str = "\
EXIT CODES
  0 done, 1 failed, 2 wrong usage, 130 and 143 stopped by SIGINT or SIGTERM. A stopped render writes the
  samples done; a second signal ends at once. An error is one line that begins with `error:`.
";

/// The long help below the flags.
pub fn topics() -> String {
    let mut text = format!("{EXAMPLES}\nNAMES\n");
    let mut list = |title: &str, rows: &mut dyn Iterator<Item = (&str, &str)>| {
        let _ = writeln!(text, "  {title}");
        for (name, meaning) in rows {
            let _ = writeln!(text, "    {name:<14} {meaning}");
        }
    };
    list("integrator", &mut IntegratorKind::TABLE.iter().map(|r| (r.0, r.1)));
    list("sampler", &mut SamplerKind::TABLE.iter().map(|r| (r.0, r.1)));
    list("lights", &mut LightSampling::TABLE.iter().map(|r| (r.0, r.1)));
    list("filter", &mut Filter::NAMES.iter().copied());
    list("film.rule", &mut PixelRule::TABLE.iter().map(|r| (r.0, r.1)));
    list("quantity", &mut Quantity::TABLE.iter().map(|r| (r.0, r.1)));
    list("rule of the distribution integrator", &mut HemisphereRule::TABLE.iter().map(|r| (r.0, r.1)));
    list("measure of its random directions", &mut Measure::TABLE.iter().map(|r| (r.0, r.1)));
    list("camera", &mut Projection::NAMES.iter().copied());
    list("material", &mut Bsdf::NAMES.iter().copied().chain([Mix::NAME]));
    list("texture filter", &mut texture::Filter::TABLE.iter().map(|r| (r.0, r.1)));
    list("texture wrap", &mut texture::Wrap::TABLE.iter().map(|r| (r.0, r.1)));
    list("light", &mut Light::NAMES.iter().copied());
    list("sky", &mut Sky::TABLE.iter().map(|r| (r.0, r.1)));
    list("view", &mut View::TABLE.iter().map(|r| (r.0, r.1)));
    list("up", &mut Up::TABLE.iter().map(|r| (r.0, r.1)));
    let words: [(&str, Vec<&str>); 5] = [
        ("metal", METALS.iter().map(|m| m.0).collect()),
        ("aov", Aov::ALL.map(Aov::name).to_vec()),
        ("tone-map", ToneMap::NAMES.map(|n| n.0).to_vec()),
        ("backend", Backend::ALL.iter().map(|b| b.name()).collect()),
        ("output", FORMATS.iter().flat_map(|f| f.extensions).copied().collect()),
    ];
    for format in MESH_FORMATS {
        let _ = writeln!(
            text,
            "  mesh {:<10} {}: .{}",
            format.name,
            format.meaning,
            format.extensions.join(", .")
        );
    }
    for (title, names) in words {
        let _ = writeln!(text, "  {title:<15} {}", names.join(", "));
    }
    format!("{text}\n{EXIT_CODES}")
}

/// Below the flags of `drt converge`.
pub fn converge() -> String {
    let row = |indent: &str, name: &str, meaning: &str| format!("{indent}{name:<18} {meaning}\n");
    let mut text = "INTEGRALS with known answers, and their rules\n".to_string();
    // Neighbours with the same rules share a list of them.
    let rules_of = |i: usize| INTEGRALS.get(i).and_then(|integral| integral.rules().ok()).unwrap_or_default();
    let names_of = |i: usize| rules_of(i).iter().map(|rule| rule.name).collect::<Vec<_>>();
    for (i, integral) in INTEGRALS.iter().enumerate() {
        text += &row("  ", integral.name, integral.meaning);
        if names_of(i) != names_of(i + 1) {
            text.extend(rules_of(i).iter().map(|rule| row("    ", rule.name, rule.meaning)));
        }
    }
    text.push_str("\nSCENES, by --vary, and their rules\n");
    for (name, meaning, subject) in Subject::TABLE {
        text += &row("  ", name, meaning);
        text.extend(subject.rules.iter().map(|rule| row("    ", rule.name, rule.meaning)));
    }
    text.push_str("\nOUTPUTS\n");
    text.extend(report::FORMATS.iter().map(|format| row("  .", format.0, format.1)));
    format!(
        "{text}\nRMSE is over all pixels, colours and runs; relMSE is that of drt compare. Ctrl-C writes what is finished.\n"
    )
}

/// Below the flags of `drt diff-backends`.
pub const DIFF: &str = "\
WHAT THE TABLE SAYS
  Every contestant's answers are compared with the first one's. f64 and all triangles near the ray decide:
    tie       two triangles at one distance, or a hit within rounding of an end of the ray
    edge      the ray passes an edge within rounding
    vertex    the ray passes a vertex within rounding
    graze     the ray runs along the triangle, within rounding of its plane
    sliver    the triangle is no wider than rounding
    real      one of the two is wrong: exit code 1, and a reproducer (case-N.toml, case-N.obj) is written
  hit/miss counts those where one hits and the other does not, leaks those where one slips through a closed
  surface at an edge or a vertex. Speeds are of wall time, on all threads. embree-fast is Embree without its
  robust flag: shown for comparison, and no reason to fail.

EXAMPLES
  drt diff-backends scan.obj --rays 1000000 -o found
  drt diff-backends scan.obj --contestants bvh-medium,embree-avx2
  drt diff-backends found/case-1.toml
";

/// What `--version` prints.
pub fn version() -> String {
    let embree = match (env!("DRT_EMBREE_VERSION"), cfg!(feature = "embree")) {
        (_, false) => "without Embree".to_string(),
        ("", true) => "with Embree".to_string(),
        (version, true) => format!("Embree {version}"),
    };
    let backends: Vec<&str> = Backend::ALL.iter().map(|b| b.name()).collect();
    let known: Vec<&str> = Isa::ALL.into_iter().filter(|isa| *isa <= Isa::best()).map(Isa::name).collect();
    format!(
        "drt {}\n{embree}\nbackends: {}\ninstruction sets of this machine: {} (best: {})\n",
        env!("CARGO_PKG_VERSION"),
        backends.join(", "),
        known.join(", "),
        Isa::best().name()
    )
}
