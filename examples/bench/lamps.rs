//! Scenes whose light is what is hard to find: L1, a picture of a sky with a sun half a degree wide; L2 and L3, 1,000
//! and 100,000 lamps. A bumpy sphere of 200,000 triangles stands on a plane; all is matt.

use crate::Args;
use crate::scenes::{Bench, bumpy_sphere, write};
use drt::error::Result;
use drt::film::Image;
use drt::output;
use std::f64::consts::TAU;
use std::io::Write;

const SPHERE: &str = "bumpy-sphere-0.2M.obj";

/// Makes the scene of that name.
///
/// # Errors
/// Files that cannot be written.
pub fn make(name: &str, args: &Args) -> Result<Bench> {
    let sphere = args.dir.join(SPHERE);
    if !sphere.exists() {
        write(&sphere, |out| bumpy_sphere(2e5, out))?;
    }
    let lamps = |n| -> Result<String> {
        let file = format!("lamps-{n}.obj");
        if !args.dir.join(&file).exists() {
            write(&args.dir.join(&file), |out| swarm(n, out))?;
        }
        Ok(format!(
            "[[mesh]]\nfile = \"{file}\"\nmaterial = \"lamp\"\n[materials.lamp]\ntype = \"diffuse\"\n\
             reflectance = 0.0\nemission = [9.0, 7.0, 5.0]\ntwo_sided = false\n"
        ))
    };
    let (name, light) = match name {
        "L1" => {
            let sky = args.dir.join("sky.pfm");
            output::write(&sky, &sky_with_sun(1024, 512), &output::Options::default())?;
            ("L1", "[[light]]\ntype = \"environment\"\nfile = \"sky.pfm\"\n".to_string())
        }
        "L2" => ("L2", lamps(1_000)?),
        _ => ("L3", lamps(100_000)?),
    };
    let file = args.dir.join(format!("{name}.toml"));
    write(&file, |out| {
        write!(
            out,
            "[camera]\nposition = [0.0, 1.6, 4.2]\nlook_at = [0.0, 0.65, 0.0]\nfov = 36.0\n\
             [[mesh]]\nfile = \"{SPHERE}\"\nmaterial = \"matt\"\n\
             [[mesh]]\nfile = \"ground.obj\"\nmaterial = \"matt\"\n\
             [materials.matt]\ntype = \"diffuse\"\nreflectance = 0.7\n{light}"
        )
    })?;
    Ok(Bench { name, file, max_depth: 4, hides_lamp: false })
}

/// Blue above, pale at the horizon, dim below, and a sun of one and a half texels' width that gives most of the light.
fn sky_with_sun(width: u32, height: u32) -> Image {
    let (sun_column, sun_row) = (width * 3 / 8, height / 4);
    let texel = |i: u32| {
        let (x, y) = (i % width, i / width);
        if (x == sun_column || x == sun_column + 1) && y == sun_row {
            return [4.0e4, 3.6e4, 3.0e4];
        }
        let up = (std::f32::consts::PI * (y as f32 + 0.5) / height as f32).cos();
        if up < 0.0 {
            return [0.1; 3];
        }
        let haze = (1.0 - up).powi(4);
        [0.15 + 0.5 * haze, 0.3 + 0.4 * haze, 0.6 + 0.2 * haze]
    };
    let pixels: Vec<[f32; 3]> = (0..width * height).map(texel).collect();
    Image::from_rgb(width, height, &pixels, String::new())
}

/// Two clouds of `n` triangular lamps beside what the camera sees, from the ground up, turned every way; one square
/// metre all together.
fn swarm(n: u32, out: &mut impl Write) -> std::io::Result<()> {
    let mut state = 1u64;
    let mut random = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f64 / (1u64 << 24) as f64
    };
    // Corners on a circle of radius r make a triangle of area r²·√27/4.
    let r = (4.0 / (27f64.sqrt() * f64::from(n))).sqrt();
    for i in 0..n {
        let z = 3.0 - 5.0 * random();
        // Half of what is seen at that depth, and a little more.
        let edge = 0.33 * (4.4 - z) + 0.15;
        let side = if i % 2 == 0 { 1.0 } else { -1.0 };
        let center = [side * (edge + 3.0 * random().powi(2)), 0.1 + 2.0 * random().powi(2), z];
        let [s, t] = turned([random(), random(), random()]);
        for k in 0..3 {
            let (sin, cos) = (TAU * f64::from(k) / 3.0).sin_cos();
            let [x, y, z] = [0, 1, 2].map(|i| center[i] + r * (cos * s[i] + sin * t[i]));
            writeln!(out, "v {x:.6} {y:.6} {z:.6}")?;
        }
    }
    (0..n).try_for_each(|i| writeln!(out, "f {} {} {}", 3 * i + 1, 3 * i + 2, 3 * i + 3))
}

/// Two columns of a random rotation (Shoemake 1992).
fn turned([a, b, c]: [f64; 3]) -> [[f64; 3]; 2] {
    let (r, s) = ((1.0 - a).sqrt(), a.sqrt());
    let ([x, y], [z, w]) =
        ([r * (TAU * b).sin(), r * (TAU * b).cos()], [s * (TAU * c).sin(), s * (TAU * c).cos()]);
    [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)],
        [2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + w * x)],
    ]
}
