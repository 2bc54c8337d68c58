//! The four scenes, made from public parts.

use crate::{Args, lamps, various};
use drt::error::{Error, Result};
use std::f64::consts::{PI, TAU};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

/// A scene to measure.
#[derive(Clone, Debug)]
pub struct Bench {
    /// S1 to S4, L1 to L3, U1 to U4.
    pub name: &'static str,
    /// The scene file.
    pub file: PathBuf,
    /// Scattering events of a path at most.
    pub max_depth: u32,
    /// The error leaves out a lamp in the picture and its rim.
    pub hides_lamp: bool,
}

impl Bench {
    /// Makes what the scene `name` needs; `None` without the dragon.
    ///
    /// # Errors
    /// An unknown name, or files that cannot be written.
    pub fn make(name: &str, args: &Args) -> Result<Option<Bench>> {
        let under_sky = |name, mesh: &Path, material| {
            let file = args.dir.join(format!("{name}.toml"));
            let mesh = std::path::absolute(mesh).map_err(|e| Error::io("find", mesh, &e))?;
            write(&file, |out| write!(out, "{}", scene_under_sky(&mesh, material)))?;
            Ok(Some(Bench { name, file, max_depth: 4, hides_lamp: false }))
        };
        match (name, &args.dragon) {
            ("S1", _) => {
                let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/cornell-box.toml");
                Ok(Some(Bench { name: "S1", file, max_depth: 7, hides_lamp: true }))
            }
            ("S3", _) => {
                let mesh = args.dir.join(format!("bumpy-sphere-{}M.obj", args.millions));
                if !mesh.exists() {
                    write(&mesh, |out| bumpy_sphere(args.millions * 1e6, out))?;
                }
                under_sky("S3", &mesh, DIFFUSE)
            }
            ("S2", Some(dragon)) => under_sky("S2", dragon, DIFFUSE),
            ("S4", Some(dragon)) => under_sky("S4", dragon, METAL),
            ("S2" | "S4", None) => Ok(None),
            ("L1" | "L2" | "L3", _) => lamps::make(name, args).map(Some),
            ("U1" | "U2" | "U3" | "U4", _) => various::make(name, args),
            _ => Err(Error::usage(format!("there is no scene {name}: S1 to S4, L1 to L3, U1 to U4"))),
        }
    }
}

const DIFFUSE: &str = "type = \"diffuse\"\nreflectance = 0.7";
const METAL: &str = "type = \"conductor\"\nreflectance = 0.7\nalpha = 0.2\ncompensate = false";

/// A mesh two metres long on a large plane under a white sky.
pub fn scene_under_sky(mesh: &Path, material: &str) -> String {
    format!(
        "[camera]\nposition = [0.0, 1.6, 4.2]\nlook_at = [0.0, 0.65, 0.0]\nfov = 36.0\n\
         [[mesh]]\nfile = {mesh:?}\nmaterial = \"body\"\n\
         [[mesh]]\nfile = \"ground.obj\"\nmaterial = \"ground\"\n\
         [materials.body]\n{material}\n[materials.ground]\n{DIFFUSE}\n\
         [[light]]\ntype = \"environment\"\nradiance = 1.0\n"
    )
}

/// Writes a file in a folder that is made where it is missing; never half a file under its name.
pub fn write(
    path: &Path,
    text: impl FnOnce(&mut BufWriter<std::fs::File>) -> std::io::Result<()>,
) -> Result<()> {
    let failed = |e: std::io::Error| Error::io("write", path, &e);
    let folder = path.parent().unwrap_or(Path::new("."));
    std::fs::create_dir_all(folder).map_err(failed)?;
    let ground = folder.join("ground.obj");
    if !ground.exists() {
        std::fs::write(&ground, "v -50 0 -50\nv -50 0 50\nv 50 0 50\nv 50 0 -50\nf 1 2 3 4\n")
            .map_err(failed)?;
    }
    let unfinished = path.with_extension("unfinished");
    let mut out = BufWriter::with_capacity(1 << 20, std::fs::File::create(&unfinished).map_err(failed)?);
    text(&mut out).and_then(|()| out.flush()).map_err(failed)?;
    std::fs::rename(&unfinished, path).map_err(failed)
}

/// A sphere with bumps of four sizes and about as many triangles, two metres high, as an OBJ with normals.
pub fn bumpy_sphere(triangles: f64, out: &mut impl Write) -> std::io::Result<()> {
    let columns = triangles.sqrt().round().max(3.0) as u64;
    let rows = (triangles / (2.0 * columns as f64)).round().max(2.0) as u64;
    let point = |theta: f64, phi: f64| {
        let d = [theta.sin() * phi.cos(), theta.cos(), theta.sin() * phi.sin()];
        let waves = |f: [f64; 3], shift: [f64; 3]| -> f64 {
            (0..3).map(|i| (f[i] * d[i] + shift[i]).sin()).product()
        };
        let r = 1.0
            + 0.1 * waves([5.0, 6.0, 5.0], [1.0, 0.0, 2.0])
            + 0.03 * waves([23.0, 21.0, 25.0], [0.0, 1.0, 0.0])
            + 0.008 * waves([90.0, 95.0, 88.0], [2.0, 0.0, 0.0])
            + 0.002 * waves([400.0, 390.0, 410.0], [0.0, 1.0, 0.0]);
        d.map(|c| c * r * 0.95)
    };
    let angles = |row: u64, column: u64| {
        let theta = 1e-3 + (PI - 2e-3) * row as f64 / rows as f64;
        (theta, TAU * column as f64 / columns as f64)
    };
    for (row, column) in (0..=rows).flat_map(|r| (0..columns).map(move |c| (r, c))) {
        let (theta, phi) = angles(row, column);
        let [x, y, z] = point(theta, phi);
        writeln!(out, "v {x:.6} {:.6} {z:.6}", y + 1.0)?;
        // The cross product of the surface's two slopes, by small differences.
        let slope = |dt: f64, dp: f64| {
            let (a, b) = (point(theta + dt, phi + dp), point(theta - dt, phi - dp));
            [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
        };
        let (t, p) = (slope(1e-5, 0.0), slope(0.0, 1e-5));
        let n = [p[1] * t[2] - p[2] * t[1], p[2] * t[0] - p[0] * t[2], p[0] * t[1] - p[1] * t[0]];
        let length = n.iter().map(|c| c * c).sum::<f64>().sqrt();
        writeln!(out, "vn {:.4} {:.4} {:.4}", n[0] / length, n[1] / length, n[2] / length)?;
    }
    for (row, column) in (0..rows).flat_map(|r| (0..columns).map(move |c| (r, c))) {
        let (a, b) = (row * columns + column + 1, row * columns + (column + 1) % columns + 1);
        let (c, d) = (a + columns, b + columns);
        writeln!(out, "f {a}//{a} {b}//{b} {c}//{c}\nf {b}//{b} {d}//{d} {c}//{c}")?;
    }
    Ok(())
}
