//! A plan and its mesh files become a [`Scene`].

mod lights;
mod palette;

use super::auto::{self, Sky};
use super::materials::MaterialSpec;
use super::object::{self, Object};
use super::place::{Extent, NormalsMode, Transform, place, rename_materials};
use super::scene_file::{LightPlan, MaterialPatch, MeshPlan, Plan};
use super::sky::{SkyPicture, SkySource};
use super::texture;
use super::{Loaded, Options, cancelled};
use crate::error::{Error, Finding, Result, Severity, nearest, show_path};
use crate::math::DVec3;
use crate::scene::{IntegratorKind, Scene};
use crate::shape::{FaceMaterials, Mesh};
use lights::{is_dark, lamp, place_light};
use palette::{Choice, Palette};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Reads the meshes of `plan` and puts everything in its place. `input`: the file to name in findings.
pub(super) fn assemble(mut plan: Plan<'_>, input: &Path, options: &Options<'_>) -> Result<Loaded> {
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
            normals: mesh.normals,
            choice,
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
    let of_file =
        |p: &Placement| objects.get(p.file).and_then(Option::as_ref).map_or(0, |o| o.counts.triangles);
    let in_files: u64 = placements.iter().map(of_file).sum();
    let origin = scene_origin(&placements, &objects);
    let mut meshes = place_all(&placements, &mut objects, origin, &plan.meshes, options)?;
    let up = plan.camera.up.unwrap_or(DVec3::Y);
    let camera = plan.camera.frame(options.view.unwrap_or_default(), plan.settings.size, &meshes, origin);
    if options.ground {
        let bounds = meshes.iter().fold(crate::math::Aabb::EMPTY, |b, m| b.union(m.bounds()));
        let id = palette.add(MaterialSpec::diffuse("ground", auto::GROUND));
        meshes.push(Arc::new(auto::ground(&bounds, up, id)));
    }
    for light in &plan.lights {
        meshes.extend(lamp(light, origin, &mut palette).map(Arc::new));
    }
    let added = meshes.get(placements.len()..).unwrap_or_default();
    let triangles = in_files + added.iter().map(|m| m.indices.len() as u64).sum::<u64>();
    let forward = camera.look_at - camera.position;
    let lights = plan.lights.iter().flat_map(|light| place_light(light, origin, up, forward)).collect();
    for light in &plan.lights {
        if let LightPlan::Picture { picture, .. } = light {
            picture.finding().into_iter().for_each(|finding| findings.push(finding));
            files.paths.push(picture.file.clone());
        }
    }
    let job = texture::Job { most_bytes: options.max_texture_bytes, progress: options.progress };
    let specs = palette.specs();
    let textures = texture::StatedTexture::of(&specs, input);
    let materials = texture::build(&specs, &mut meshes, &job, &mut findings)?;
    let scene = Scene { origin, meshes, materials, lights, camera };
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
fn check_files(meshes: &[MeshPlan<'_>]) -> Result<()> {
    for mesh in meshes {
        if let Err(why) = super::open::open_regular(&mesh.file) {
            let mut error = mesh.field.error(format!("{}: {}", show_path(&mesh.file), why.message));
            let relative = "a relative path starts in the scene file's folder";
            error.advice = why.advice.or_else(|| mesh.file.is_relative().then(|| relative.to_string()));
            return Err(error);
        }
    }
    Ok(())
}

/// Reads every file once.
fn read_objects(plan: &Plan<'_>, options: &Options<'_>) -> Result<(Files, Vec<Option<Object>>)> {
    let meshes = &plan.meshes;
    check_files(meshes)?;
    let mut paths: Vec<PathBuf> = Vec::new();
    let of_mesh = meshes.iter().map(|mesh| {
        paths.iter().position(|p| *p == mesh.file).unwrap_or_else(|| {
            paths.push(mesh.file.clone());
            paths.len() - 1
        })
    });
    let of_mesh: Vec<usize> = of_mesh.collect();
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
            object::read(path, &progress, &is_whole).map(Some)
        })
        .collect();
    Ok((Files { paths, of_mesh }, objects?))
}

/// Where a file's mesh stands, and how.
#[derive(Clone, PartialEq)]
struct Placement {
    file: usize,
    transform: Transform,
    normals: NormalsMode,
    choice: Choice,
}

/// The origin that all meshes share, where they do and nothing moves them; else by the scene's extent.
fn scene_origin(placements: &[Placement], objects: &[Option<Object>]) -> DVec3 {
    let object = |p: &Placement| objects.get(p.file).and_then(Option::as_ref);
    let own: Option<Vec<DVec3>> = placements
        .iter()
        .map(|p| object(p).filter(|_| p.transform == Transform::IDENTITY).map(|o| o.origin))
        .collect();
    if let Some([first, rest @ ..]) = own.as_deref()
        && rest.iter().all(|o| o == first)
    {
        return *first;
    }
    let extent = placements.iter().fold(Extent::EMPTY, |sum, p| match object(p) {
        Some(o) => sum.add(&o.mesh.bounds(), o.origin, &p.transform),
        None => sum,
    });
    extent.origin()
}

/// Every mesh in its place. Equal placements share one mesh; the last use of a file takes its memory over.
fn place_all(
    placements: &[Placement],
    objects: &mut [Option<Object>],
    origin: DVec3,
    plans: &[MeshPlan<'_>],
    options: &Options<'_>,
) -> Result<Vec<Arc<Mesh>>> {
    let mut meshes: Vec<Arc<Mesh>> = Vec::with_capacity(placements.len());
    for (i, placement) in placements.iter().enumerate() {
        if !(options.progress)(1.0) {
            return Err(cancelled());
        }
        let before = placements.get(..i).unwrap_or_default();
        if let Some(shared) = before.iter().position(|p| p == placement).and_then(|at| meshes.get(at)) {
            meshes.push(shared.clone());
            continue;
        }
        let later = placements.get(i + 1..).unwrap_or_default();
        let is_last = later.iter().all(|p| p.file != placement.file || *p == *placement);
        let Some(slot) = objects.get_mut(placement.file) else { continue };
        let taken = if is_last { slot.take().map(|o| (o.mesh, o.origin)) } else { None };
        let Some((mut mesh, from)) = taken.or_else(|| slot.as_ref().map(|o| (o.mesh.clone(), o.origin)))
        else {
            return Err(Error::new("a mesh was placed after its last use"));
        };
        match &placement.choice {
            Choice::One(id) => mesh.materials = FaceMaterials::Uniform(*id),
            Choice::ByFile(ids) => rename_materials(&mut mesh, ids),
        }
        let placed = place(mesh, from, origin, &placement.transform, placement.normals);
        let placed = placed.map_err(|e| plans.get(i).map_or(e.clone(), |plan| plan.field.locate(e)))?;
        meshes.push(Arc::new(placed));
    }
    Ok(meshes)
}

/// What `--view`, `--sky` and the like add to a plan.
pub(super) fn apply_look(plan: &mut Plan<'_>, is_bare: bool, options: &Options<'_>) -> Result<()> {
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
    let Some(sky) = options.sky.clone().or(usual) else { return Ok(()) };
    plan.lights.retain(|light| !light.is_environment());
    plan.lights.push(match sky {
        SkySource::BuiltIn(sky) => LightPlan::Sky { sky, up: None, scale: 1.0 },
        SkySource::Picture(file) => {
            let picture = SkyPicture::read(&file)?;
            LightPlan::Picture { picture, scale: 1.0, rotate: 0.0, up: options.up.map(auto::Up::vector) }
        }
    });
    Ok(())
}
