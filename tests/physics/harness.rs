//! Renders a scene given as text, and judges means against exact answers.

use drt::accel::{Backend, Intersector};
use drt::film::Image;
use drt::load::{self, Override};
use drt::math::DVec3;
use drt::render::{Hooks, RenderStats, build, render};
use drt::sampler::{PREVIEW, Splits};
use drt::scene::{Scene, Settings};
use std::fmt::Write as _;
use std::path::Path;

/// A white sky of radiance 1.
pub const SKY: &str = "[[light]]\ntype = \"environment\"\nradiance = 1.0\n";

/// A square at z = 0 with the material `m`, seen under `degrees` from its normal.
pub fn sheet(degrees: f64, spp: u32, depth: u32, rest: &str) -> String {
    let (s, c) = degrees.to_radians().sin_cos();
    format!(
        "[camera]\ntype = \"orthographic\"\nposition = [{}, 0, {}]\nlook_at = [0, 0, 0]\nup = [0, 1, 0]\nheight = 1e-3\n\
         [film]\nsize = [8, 8]\n[render]\nspp = {spp}\nmax_depth = {depth}\n\
         [[mesh]]\nfile = \"sheet.obj\"\nmaterial = \"m\"\n{rest}",
        5.0 * s,
        5.0 * c
    )
}

/// A square at height `z`, from −`half` to `half`, as OBJ.
pub fn square(half: f64, z: f64) -> String {
    obj(&[vec![[-half, -half, z], [half, -half, z], [half, half, z], [-half, half, z]]])
}

/// A scene read and built on one backend.
pub struct Stage {
    pub scene: Scene,
    pub settings: Settings,
    accel: Box<dyn Intersector>,
}

/// Reads a scene file whose text is `toml`, beside the files `files`, with `--set` overrides.
pub fn stage(toml: &str, files: &[(&str, String)], backend: Backend, set: &[&str]) -> Stage {
    stage_files(toml, files, |_| (), backend, set)
}

/// The same beside files of any bytes.
pub fn stage_bytes(toml: &str, files: &[(&str, Vec<u8>)], backend: Backend, set: &[&str]) -> Stage {
    stage_files(toml, files, |_| (), backend, set)
}

/// [`stage`] with other files that `prepare` writes into the scene's folder.
pub fn stage_with(
    toml: &str,
    files: &[(&str, String)],
    prepare: impl Fn(&Path),
    backend: Backend,
    set: &[&str],
) -> Stage {
    stage_files(toml, files, prepare, backend, set)
}

fn stage_files<T: AsRef<[u8]>>(
    toml: &str,
    files: &[(&str, T)],
    prepare: impl Fn(&Path),
    backend: Backend,
    set: &[&str],
) -> Stage {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in files {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    prepare(folder.path());
    let path = folder.path().join("scene.toml");
    std::fs::write(&path, toml).unwrap();
    stage_of(&path, backend, set)
}

/// A scene file on disk with `--set` overrides.
pub fn stage_of(path: &Path, backend: Backend, set: &[&str]) -> Stage {
    let mut overrides = vec![Override::parse(&format!("render.backend={}", backend.name())).unwrap()];
    overrides.extend(set.iter().map(|s| Override::parse(s).unwrap()));
    let loaded = load::scene(path, load::Options { overrides, ..Default::default() }).unwrap();
    let accel = build(&loaded.scene, &loaded.settings, None, &Hooks::NONE).unwrap();
    Stage { scene: loaded.scene, settings: loaded.settings, accel }
}

impl Stage {
    pub fn accel(&self) -> &dyn Intersector {
        self.accel.as_ref()
    }

    pub fn render(&self, change: impl FnOnce(&mut Settings)) -> (Image, RenderStats) {
        let mut settings = self.settings.clone();
        change(&mut settings);
        let r = render(&self.scene, &settings, self.accel.as_ref(), None, &Hooks::NONE).unwrap();
        assert!(r.complete);
        assert_eq!(r.stats.invalid_samples, 0, "a sample was NaN, infinite or negative");
        assert_eq!(r.stats.rejected_rays, 0, "a ray was not finite");
        (r.image, r.stats)
    }

    /// The mean of 64 seeds' image means, with its standard error, in the green channel. Half of the paths that a sample
    /// gets below a sky are enough for that.
    pub fn statistics(&self) -> Statistics {
        let split = match self.settings.splits(&self.scene) {
            Splits::Later(n) if self.settings.spp > PREVIEW => Some(n / 2),
            _ => self.settings.split,
        };
        let means: Vec<f64> = (0..64)
            .map(|seed| {
                let (image, _) = self.render(|s| (s.seed, s.split) = (seed, split));
                let green = image.f32_channel("G").unwrap();
                green.iter().map(|v| f64::from(*v)).sum::<f64>() / green.len() as f64
            })
            .collect();
        Statistics::of(&means)
    }
}

#[derive(Clone, Copy, Debug)]
pub struct Statistics {
    pub mean: f64,
    pub error: f64,
}

impl Statistics {
    pub fn of(values: &[f64]) -> Statistics {
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0);
        Statistics { mean, error: (variance / n).sqrt() }
    }

    /// `model`: relative error of the scene itself (facets instead of a sphere), `power`: relative bias that
    /// must be caught.
    pub fn verdict(&self, exact: f64, model: f64, power: f64) -> Result<(), String> {
        if self.error > power * exact / 9.46 {
            return Err(format!("standard error {:e} is too wide: raise spp", self.error));
        }
        // Noiseless answers still carry the rounding of f32.
        let allowed = (6.37 * self.error).max(model * exact).max(2e-6 * exact);
        if (self.mean - exact).abs() > allowed {
            return Err(format!("mean {} is not {exact} ± {allowed:e}", self.mean));
        }
        Ok(())
    }

    /// Passes when the answer is right and would not have passed one percent off either way.
    #[track_caller]
    pub fn expect(&self, what: &str, exact: f64, model: f64) {
        if let Err(why) = self.verdict(exact, model, 0.01) {
            panic!("{what}: {why}");
        }
        for wrong in [exact * 1.01, exact / 1.01] {
            assert!(self.verdict(wrong, model, 0.01).is_err(), "{what}: the check would accept {wrong}");
        }
    }
}

/// Runs `check` on every backend that this build has.
pub fn on_every_backend(check: impl Fn(Backend)) {
    for &backend in Backend::ALL {
        check(backend);
    }
}

/// A PNG of 8-bit colours, row by row from the top.
pub fn picture(width: u32, colors: &[[u8; 3]]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, colors.len() as u32 / width);
    encoder.set_color(png::ColorType::Rgb);
    encoder.write_header().unwrap().write_image_data(colors.as_flattened()).unwrap();
    bytes
}

/// An OBJ text from polygons.
pub fn obj(polygons: &[Vec<[f64; 3]>]) -> String {
    let mut text = String::new();
    for polygon in polygons {
        for [x, y, z] in polygon {
            writeln!(text, "v {x} {y} {z}").unwrap();
        }
        let corners: Vec<String> = (1..=polygon.len()).rev().map(|i| format!("-{i}")).collect();
        writeln!(text, "f {}", corners.join(" ")).unwrap();
    }
    text
}

/// The cube [−1, 1]³, wound outwards.
pub fn cube() -> String {
    let mut faces = Vec::new();
    for axis in 0..3 {
        for sign in [-1.0, 1.0] {
            let corner = |a: f64, b: f64| {
                let mut p = [0.0; 3];
                p[axis] = sign;
                p[(axis + 1) % 3] = a * sign;
                p[(axis + 2) % 3] = b;
                p
            };
            faces.push(vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)]);
        }
    }
    obj(&faces)
}

/// A closed surface with shared vertices from a map of the torus or of the sphere (`pole`s closed).
fn grid(rows: usize, columns: usize, poles: bool, at: impl Fn(f64, f64) -> DVec3) -> String {
    let mut text = String::new();
    let rings = if poles { rows + 1 } else { rows };
    for r in 0..rings {
        for c in 0..columns {
            let p = at(r as f64 / rows as f64, c as f64 / columns as f64);
            writeln!(text, "v {} {} {}", p.x, p.y, p.z).unwrap();
        }
    }
    let id = |r: usize, c: usize| (r % rings) * columns + c % columns + 1;
    for r in 0..rows {
        for c in 0..columns {
            let [a, b, d, e] = [id(r, c), id(r + 1, c), id(r + 1, c + 1), id(r, c + 1)];
            writeln!(text, "f {a} {b} {d}\nf {a} {d} {e}").unwrap();
        }
    }
    text
}

/// A unit sphere of 2·rows·columns facets.
pub fn sphere(rows: usize, columns: usize) -> String {
    use std::f64::consts::{PI, TAU};
    // Poles are rings of one point, so that every ring has the same number of vertices.
    grid(rows, columns, true, |v, u| {
        let (st, ct) = (PI * v).sin_cos();
        let st = if v == 0.0 || v == 1.0 { 0.0 } else { st };
        let (sp, cp) = (TAU * u).sin_cos();
        DVec3::new(st * sp, ct, st * cp)
    })
}

/// A torus with a bumpy tube: closed and not convex.
pub fn torus(rows: usize, columns: usize) -> String {
    use std::f64::consts::TAU;
    grid(rows, columns, false, |v, u| {
        let (sv, cv) = (TAU * v).sin_cos();
        let (su, cu) = (TAU * u).sin_cos();
        let tube = 0.4 + 0.05 * (9.0 * TAU * u).sin() * (5.0 * TAU * v).cos();
        let ring = 1.0 + tube * cu;
        DVec3::new(ring * sv, tube * su, ring * cv)
    })
}
