//! Scenes of other kinds than S1 to S4, to see whether what helps there helps elsewhere: U1, rough metal on rough metal
//! below a lamp; U2, two lamps of very different size; U3, a scan of 3.5 million triangles; U4, a room whose only light
//! comes through a small opening.

use crate::Args;
use crate::scenes::{Bench, bumpy_sphere, scene_under_sky, write};
use drt::error::{Error, Result};
use std::collections::HashMap;
use std::io::Write;
use std::path::Path;

const SPHERE: &str = "bumpy-sphere-0.2M.obj";
const CAMERA: &str = "[camera]\nposition = [0.0, 1.6, 4.2]\nlook_at = [0.0, 0.65, 0.0]\nfov = 36.0\n";
const MATT: &str = "type = \"diffuse\"\nreflectance = 0.7";

/// Makes the scene of that name; `None` where it needs a dragon that is not there.
///
/// # Errors
/// Files that cannot be read or written.
pub fn make(name: &str, args: &Args) -> Result<Option<Bench>> {
    let sphere = args.dir.join(SPHERE);
    if name != "U3" && !sphere.exists() {
        write(&sphere, |out| bumpy_sphere(2e5, out))?;
    }
    let (name, max_depth, text) = match name {
        "U1" => {
            let panel = square("panel.obj", [0.0, 4.0, 1.0], 0.5, args)?;
            let metal = |alpha| {
                format!("type = \"conductor\"\nreflectance = 0.7\nalpha = {alpha}\ncompensate = false")
            };
            let lamp = lamp(panel, 20.0);
            let sky = "[[light]]\ntype = \"environment\"\nradiance = 0.3\n";
            ("U1", 4, format!("{}{lamp}{sky}", sphere_on_ground(&metal(0.15), &metal(0.25))))
        }
        "U2" => {
            // The same light each: the one has ten thousand times the area of the other.
            let (large, small) = ([-2.0, 3.5, 1.5], [2.0, 2.5, 1.5]);
            let lamps = [square("large.obj", large, 1.0, args)?, square("small.obj", small, 0.01, args)?];
            let lamps = lamp(lamps[0], 2.0) + &lamp(lamps[1], 20_000.0);
            ("U2", 4, sphere_on_ground(MATT, MATT) + &lamps)
        }
        "U3" => {
            let Some(dragon) = &args.dragon else { return Ok(None) };
            let scan = args.dir.join("scan-3.5M.obj");
            if !scan.exists() {
                quarter(dragon, &scan)?;
            }
            let scan = std::path::absolute(&scan).map_err(|e| Error::io("find", &scan, &e))?;
            ("U3", 4, scene_under_sky(&scan, MATT))
        }
        _ => {
            write(&args.dir.join("room.obj"), room)?;
            ("U4", 7, in_room())
        }
    };
    let file = args.dir.join(format!("{name}.toml"));
    write(&file, |out| out.write_all(text.as_bytes()))?;
    Ok(Some(Bench { name, file, max_depth, hides_lamp: false }))
}

fn sphere_on_ground(body: &str, ground: &str) -> String {
    format!(
        "{CAMERA}[[mesh]]\nfile = \"{SPHERE}\"\nmaterial = \"body\"\n\
         [[mesh]]\nfile = \"ground.obj\"\nmaterial = \"ground\"\n\
         [materials.body]\n{body}\n[materials.ground]\n{ground}\n"
    )
}

/// Lets the mesh `file` shine to the side of its normals.
fn lamp(file: &str, radiance: f64) -> String {
    format!(
        "[[mesh]]\nfile = \"{file}\"\nmaterial = \"{file}\"\n[materials.\"{file}\"]\ntype = \"diffuse\"\n\
         reflectance = 0.0\nemission = {radiance:?}\ntwo_sided = false\n"
    )
}

/// A level square that looks down, from `half` on both sides of its middle; the name of its file.
fn square<'a>(file: &'a str, [x, y, z]: [f64; 3], half: f64, args: &Args) -> Result<&'a str> {
    write(&args.dir.join(file), |out| {
        for (i, j) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
            writeln!(out, "v {} {y} {}", x + half * i, z + half * j)?;
        }
        writeln!(out, "f 1 2 3 4")
    })?;
    Ok(file)
}

/// The sphere in the room, seen from a corner.
fn in_room() -> String {
    let matt = |name: &str| format!("[materials.{name}]\n{MATT}\n");
    format!(
        "[camera]\nposition = [1.7, 1.7, 3.6]\nlook_at = [-0.4, 0.9, 0.0]\nfov = 60.0\n\
         [[mesh]]\nfile = \"{SPHERE}\"\nmaterial = \"body\"\n[[mesh]]\nfile = \"room.obj\"\nmaterial = \"walls\"\n\
         {}{}[[light]]\ntype = \"environment\"\nradiance = 40.0\n",
        matt("body"),
        matt("walls")
    )
}

/// A room of 4 × 3 × 8 metres; the wall at x = −2 has a window of 0.5 × 0.8 metres beside the camera.
fn room(out: &mut impl Write) -> std::io::Result<()> {
    let ([x0, x1], [y0, y1], [z0, z1]) = ([-2.0, 2.0], [0.0, 3.0], [-4.0, 4.0]);
    let (low, high, left, right) = (1.4, 2.2, 2.1, 2.6);
    let wall =
        |[y, top]: [f64; 2], [z, end]: [f64; 2]| [[x0, y, z], [x0, top, z], [x0, top, end], [x0, y, end]];
    let quads = [
        [[x0, y0, z0], [x0, y0, z1], [x1, y0, z1], [x1, y0, z0]],
        [[x0, y1, z0], [x1, y1, z0], [x1, y1, z1], [x0, y1, z1]],
        [[x0, y0, z0], [x1, y0, z0], [x1, y1, z0], [x0, y1, z0]],
        [[x0, y0, z1], [x0, y1, z1], [x1, y1, z1], [x1, y0, z1]],
        [[x1, y0, z0], [x1, y0, z1], [x1, y1, z1], [x1, y1, z0]],
        wall([y0, low], [z0, z1]),
        wall([high, y1], [z0, z1]),
        wall([low, high], [z0, left]),
        wall([low, high], [right, z1]),
    ];
    for [x, y, z] in quads.iter().flatten() {
        writeln!(out, "v {x} {y} {z}")?;
    }
    let corners = |i: usize| [1, 2, 3, 4].map(|k| 4 * i + k);
    (0..quads.len()).map(corners).try_for_each(|[a, b, c, d]| writeln!(out, "f {a} {b} {c} {d}"))
}

/// The mesh of an OBJ as `peers.py dragon` writes it (positions, as many normals, triangles `a//a b//b c//c`), with every
/// triangle cut in four at the middles of its edges.
fn quarter(mesh: &Path, into: &Path) -> Result<()> {
    let text = std::fs::read_to_string(mesh).map_err(|e| Error::io("read", mesh, &e))?;
    let odd = || Error::new("not an OBJ of \"v\", \"vn\" and triangles \"f a//a b//b c//c\"").at(mesh);
    let (mut points, mut normals, mut faces) = (Vec::new(), Vec::new(), Vec::new());
    for line in text.lines() {
        let mut words = line.split_ascii_whitespace();
        let key = words.next();
        let mut three = || -> Option<[&str; 3]> { Some([words.next()?, words.next()?, words.next()?]) };
        let vector = |w: [&str; 3]| -> Option<[f64; 3]> {
            let [x, y, z] = w.map(|w| w.parse().ok());
            Some([x?, y?, z?])
        };
        let index = |w: &str| w.split('/').next()?.parse::<usize>().ok()?.checked_sub(1);
        match key {
            Some("v") => points.push(three().and_then(vector).ok_or_else(odd)?),
            Some("vn") => normals.push(three().and_then(vector).ok_or_else(odd)?),
            Some("f") => {
                let [a, b, c] = three().ok_or_else(odd)?.map(index);
                faces.push([a.ok_or_else(odd)?, b.ok_or_else(odd)?, c.ok_or_else(odd)?]);
            }
            _ => (),
        }
    }
    if normals.len() != points.len() || faces.iter().flatten().any(|i| *i >= points.len()) {
        return Err(odd());
    }
    let mut middles = HashMap::new();
    let mut quarters = Vec::with_capacity(4 * faces.len());
    for [a, b, c] in faces {
        let mut middle = |i: usize, j: usize| {
            *middles.entry((i.min(j), i.max(j))).or_insert_with(|| {
                let half = |of: &[[f64; 3]]| [0, 1, 2].map(|k| (of[i][k] + of[j][k]) / 2.0);
                let (point, normal) = (half(&points), half(&normals));
                points.push(point);
                normals.push(normal);
                points.len() - 1
            })
        };
        let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
        quarters.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
    }
    write(into, |out| {
        points.iter().try_for_each(|[x, y, z]| writeln!(out, "v {x:.6} {y:.6} {z:.6}"))?;
        normals.iter().try_for_each(|[x, y, z]| writeln!(out, "vn {x:.4} {y:.4} {z:.4}"))?;
        quarters
            .iter()
            .map(|t| t.map(|i| i + 1))
            .try_for_each(|[a, b, c]| writeln!(out, "f {a}//{a} {b}//{b} {c}//{c}"))
    })
}
