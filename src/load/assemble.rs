//! A plan and its mesh files become a [`Scene`].

mod lights;
mod palette;
mod parts;
mod places;
mod prototypes;
mod seen;

use super::auto::{self, Sky};
use super::framing::CameraPlan;
use super::materials::MaterialSpec;
use super::object::{MOST_COPIED, Object};
use super::open::Reach;
use super::scene_file::{LightPlan, MaterialPatch, MeshPlan, Plan};
use super::sky::{SkyPicture, SkySource};
use super::texture;
use super::{Loaded, Options, Reading, STDIN, cancelled};
use crate::error::{Error, Finding, Result, Severity, nearest, show_path};
use crate::math::DVec3;
use crate::scene::need::Need;
use crate::scene::{IntegratorKind, Scene, Settings};
use lights::{is_dark, lamp, moved, place_light};
use palette::{Choice, Palette};
use places::{Placement, Stock, place_all, scene_origin};
use seen::seen;
use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Reads the meshes of `plan` and puts everything in its place. `input`: the file to name in findings. `usual_sky`:
/// nobody asked for the sky, so that lights which the mesh brings replace it.
pub(super) fn assemble(
    mut plan: Plan<'_>,
    input: &Path,
    options: &Options<'_>,
    usual_sky: bool,
) -> Result<Loaded> {
    let (mut files, mut objects) = read_objects(&plan, options)?;
    let mesh_files = files.paths.len();
    let mut findings = std::mem::take(&mut plan.findings);
    let mut skipped_faces = 0;
    for object in objects.iter_mut().flatten() {
        findings.append(std::mem::take(&mut object.findings));
        skipped_faces += object.skipped_faces;
        files.paths.append(&mut object.libraries);
    }
    let mut palette = Palette::new(&plan.materials, objects.len());
    let choices: Result<Vec<Choice>> = plan
        .meshes
        .iter()
        .zip(&files.of_mesh)
        .map(|(mesh, file)| palette.choose(mesh, *file, objects.get(*file).and_then(Option::as_ref)))
        .collect();
    let placements: Vec<Placement> = plan
        .meshes
        .iter()
        .zip(&files.of_mesh)
        .zip(choices?)
        .map(|((mesh, file), choice)| Placement {
            file: *file,
            transform: mesh.transform,
            course: mesh.course.clone(),
            normals: mesh.normals,
            choice,
            instance: mesh.instance,
        })
        .collect();
    for (name, field) in palette.unused() {
        findings.push(Finding {
            file: input.to_path_buf(),
            line: field.line(),
            kind: "material-not-used",
            message: match nearest(name, palette.specs.iter().map(|spec| spec.name.as_str())) {
                Some(meant) => format!("no mesh has the material \"{name}\"; did you mean \"{meant}\"?"),
                None => format!("no mesh has the material \"{name}\""),
            },
            severity: Severity::Note,
        });
    }
    let brought = (&mut plan.lights, &mut plan.camera);
    take_from_files(brought, &placements, &objects, options, usual_sky);
    let of_file =
        |p: &Placement| objects.get(p.file).and_then(Option::as_ref).map_or(0, |o| o.counts.triangles);
    let in_files: u64 = placements.iter().map(of_file).sum();
    let open = plan.camera.shutter[0];
    let origin = scene_origin(&placements, &objects, open);
    let stock = Stock::new(&mut objects, &palette.specs, origin);
    let (mut meshes, mut instances) = place_all(&placements, stock, &plan.meshes, options)?;
    let of_files = meshes.len();
    let up = plan.camera.up.unwrap_or(DVec3::Y);
    let is_framed = plan.camera.position.is_none() || plan.camera.look_at.is_none();
    let seen = if is_framed || options.ground { seen(&meshes, &instances, open) } else { Vec::new() };
    let camera = plan.camera.frame(options.view.unwrap_or_default(), plan.settings.size, &seen, origin);
    if options.ground {
        let bounds = seen.iter().fold(crate::math::Aabb::EMPTY, |b, m| b.union(m.bounds()));
        let id = palette.add(MaterialSpec::diffuse("ground", auto::GROUND));
        meshes.push(Arc::new(auto::ground(&bounds, up, id)));
    }
    for light in &plan.lights {
        meshes.extend(lamp(light, origin, &mut palette).map(Arc::new));
    }
    let added = meshes.get(of_files..).unwrap_or_default();
    let triangles = in_files + added.iter().map(|m| m.indices.len() as u64).sum::<u64>();
    let forward = camera.look_at - camera.position;
    let lights = plan.lights.iter().flat_map(|light| place_light(light, origin, up, forward)).collect();
    for light in &plan.lights {
        if let LightPlan::Picture { picture, .. } = light {
            picture.finding().into_iter().for_each(|finding| findings.push(finding));
            files.paths.push(picture.file.clone());
        }
    }
    let job = texture::Job {
        reach: &options.reach,
        most_bytes: options.max_texture_bytes,
        progress: options.progress,
    };
    let specs = palette.specs();
    let textures = texture::StatedTexture::of(&specs, input);
    // Both kinds of meshes at once, so that a material's warnings are told once.
    let at_rest = meshes.len();
    meshes.append(&mut instances.meshes);
    let materials = texture::build(&specs, &mut meshes, &job, &mut findings)?;
    instances.meshes = meshes.split_off(at_rest);
    let scene = Scene { origin, meshes, instances, materials, lights, camera };
    crate::camera::Camera::new(&scene.camera, scene.origin).map_err(|e| e.at(input))?;
    if is_dark(&scene)
        && !matches!(plan.settings.integrator, IntegratorKind::Ao { .. } | IntegratorKind::Normals)
    {
        findings.push(Finding {
            file: input.to_path_buf(),
            line: 0,
            kind: "no-light",
            message: "no light in the scene, so the picture is black; add a [[light]] or --sky studio"
                .to_string(),
            severity: Severity::Note,
        });
    }
    let files = files.paths;
    let settings = plan.settings;
    Ok(Loaded { scene, settings, findings, skipped_faces, triangles, files, mesh_files, textures })
}

/// The distinct files, and which of them each mesh is in.
struct Files {
    paths: Vec<PathBuf>,
    of_mesh: Vec<usize>,
}

/// Refuses a mesh file that cannot be opened, at the place that names it and before the first one is read.
fn check_files(meshes: &[MeshPlan<'_>], reach: &Reach) -> Result<()> {
    let mut seen = HashSet::from([Path::new(STDIN)]);
    for mesh in meshes.iter().filter(|mesh| seen.insert(&mesh.file)) {
        if let Err(why) = reach.open(&mesh.file) {
            let mut error = mesh.field.error(format!("{}: {}", show_path(&mesh.file), why.message));
            let relative = "a relative path starts in the scene file's folder";
            error.advice = why.advice.or_else(|| mesh.file.is_relative().then(|| relative.to_string()));
            return Err(error);
        }
    }
    Ok(())
}

/// Refuses what will not fit into the memory that is left, from a look at each file.
fn check_memory(paths: &[PathBuf], options: &Options<'_>, settings: &Settings) -> Result<()> {
    let mut need = Need::default();
    for path in paths {
        if let Some((extent, meshes)) = super::format::forecast(path, &options.opening, &options.reach)? {
            need.add(extent, meshes);
        }
    }
    need.check(settings, (options.memory)())
}

/// Reads every file once.
fn read_objects(plan: &Plan<'_>, options: &Options<'_>) -> Result<(Files, Vec<Option<Object>>)> {
    let meshes = &plan.meshes;
    check_files(meshes, &options.reach)?;
    let (mut paths, mut firsts): (Vec<PathBuf>, Vec<usize>) = Default::default();
    // By path, and by what it leads to: a file has many names and is read once.
    let mut by_path: HashMap<&Path, usize> = HashMap::new();
    let mut by_file: HashMap<PathBuf, usize> = HashMap::new();
    let of_mesh = meshes.iter().enumerate().map(|(m, mesh)| {
        *by_path.entry(&mesh.file).or_insert_with(|| {
            *by_file.entry(super::open::real(&mesh.file)).or_insert_with(|| {
                paths.push(mesh.file.clone());
                firsts.push(m);
                paths.len() - 1
            })
        })
    });
    let of_mesh: Vec<usize> = of_mesh.collect();
    check_memory(&paths, options, &plan.settings)?;
    let count = paths.len() as f64;
    let objects: Result<Vec<Option<Object>>> = paths
        .iter()
        .enumerate()
        .map(|(i, path)| {
            let progress = |share: f64| (options.progress)((i as f64 + share) / count);
            if !progress(0.0) {
                return Err(cancelled());
            }
            let is_whole = |name: &[u8]| {
                let name = std::str::from_utf8(name).ok();
                name.and_then(|name| plan.materials.get(name)).is_some_and(MaterialPatch::is_whole)
            };
            let (opening, reach, cache) = (options.opening, &options.reach, options.cache);
            // Of a file that is in several meshes the first one says it.
            let most_copied = match meshes.get(firsts[i]).and_then(|mesh| mesh.instance) {
                None => MOST_COPIED,
                Some(true) => 0,
                Some(false) => u64::MAX,
            };
            let usual = Reading::new(&progress);
            let reading = Reading { opening, reach, most_copied, defined: &is_whole, cache, ..usual };
            super::read(path, &reading).map(Some)
        })
        .collect();
    Ok((Files { paths, of_mesh }, objects?))
}

/// The lights that mesh files bring, and the first of their cameras where the scene places none.
fn take_from_files(
    (lights, scene_camera): (&mut Vec<LightPlan>, &mut CameraPlan),
    placements: &[Placement],
    objects: &[Option<Object>],
    options: &Options<'_>,
    usual_sky: bool,
) {
    for placement in placements {
        let Some(object) = objects.get(placement.file).and_then(Option::as_ref) else { continue };
        if usual_sky && !object.lights.is_empty() {
            lights.retain(|light| !light.is_environment());
        }
        lights.extend(object.lights.iter().map(|light| moved(light, placement.transform.matrix())));
        if let Some(camera) = object.camera.filter(|_| options.view.is_none()) {
            scene_camera.take(&camera, placement.transform.matrix());
        }
    }
}

/// What `--view`, `--sky` and the like add to a plan; whether that is a sky that nobody asked for.
pub(super) fn apply_look(plan: &mut Plan<'_>, is_bare: bool, options: &Options<'_>) -> Result<bool> {
    if let Some(up) = options.up {
        if plan.camera.up.is_some() {
            return Err(Error::usage("--up: the scene sets camera.up").advise("use --set camera.up=[0,0,1]"));
        }
        plan.camera.up = Some(up.vector());
        for light in &mut plan.lights {
            light.set_up(up.vector());
        }
    }
    if options.view.is_some() && plan.camera.position.is_some() {
        return Err(Error::usage("--view: the scene places the camera")
            .advise("leave --view out, or move the camera with --set camera.position=[x,y,z]"));
    }
    let usual = (is_bare && plan.lights.is_empty()).then_some(SkySource::BuiltIn(Sky::Studio));
    let is_usual = options.sky.is_none() && usual.is_some();
    let Some(sky) = options.sky.clone().or(usual) else { return Ok(false) };
    plan.lights.retain(|light| !light.is_environment());
    plan.lights.push(match sky {
        SkySource::BuiltIn(sky) => LightPlan::Sky { sky, up: None, scale: 1.0 },
        SkySource::Picture(file) => {
            let picture = SkyPicture::read(&file, &Reach::Anywhere)?;
            LightPlan::Picture { picture, scale: 1.0, rotate: 0.0, up: options.up.map(auto::Up::vector) }
        }
    });
    Ok(is_usual)
}
