//! `[[mesh]]` and `[[groups.NAME]]`: files, where they stand, and what they are made of.

use super::reader::{Field, Section};
use super::transform::{motion, transform, transform_in};
use crate::error::{Error, Result, unknown_word_advice};
use crate::load::format::Format;
use crate::load::input::STDIN;
use crate::load::place::{NormalsMode, Transform};
use crate::shape::{Motion, Stage};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// More meshes in their places than this are taken for a mistake.
pub(crate) const MOST_PLACES: usize = 10_000_000;

/// A mesh in one of its places, as the scene file says it.
#[derive(Clone)]
pub(crate) struct MeshPlan<'t> {
    /// The file, relative to the scene file's folder resolved.
    pub file: PathBuf,
    /// The value that names the file, for errors.
    pub field: Field<'t>,
    /// From the file's coordinates to the scene file's, or to where its motion begins.
    pub transform: Transform,
    /// What moves it afterwards; empty where nothing does.
    pub course: Vec<Stage>,
    /// The material's name, instead of the file's own materials.
    pub material: Option<Field<'t>>,
    /// Which shading normals.
    pub normals: NormalsMode,
    /// Whether its triangles are kept once for all its places; `None`: where that saves much.
    pub instance: Option<bool>,
}

impl MeshPlan<'_> {
    /// Moved further, by what stands in `field`.
    fn then(&mut self, outer: &Transform, field: &Field<'_>) -> Result<()> {
        if !self.course.is_empty() {
            self.course.push(Stage::Fixed(outer.affine()));
            return Ok(());
        }
        self.transform = self.transform.then(outer).ok_or_else(|| {
            field
                .error(format!(
                    "{} leaves the range of numbers together with the other transforms",
                    field.name()
                ))
                .advise("use smaller numbers")
        })?;
        Ok(())
    }

    /// Moved by time.
    fn then_moving(&mut self, motion: &Option<Arc<Motion>>) {
        self.course.extend(motion.iter().cloned().map(Stage::Moving));
    }
}

/// Groups of meshes by their names.
pub(super) type Groups<'t> = BTreeMap<&'t str, Vec<MeshPlan<'t>>>;

/// Reads `[[groups.NAME]]`: lists of meshes that stand together.
pub(super) fn read_groups<'t>(field: &Field<'t>, folder: &Path) -> Result<Groups<'t>> {
    let none = Groups::new();
    let group = |(name, field): (&'t str, Field<'t>)| {
        let items = field.list("a list of tables, [[groups.NAME]]")?;
        let mut meshes = Vec::new();
        for item in items {
            let mut table = item.section()?;
            if let Some(inner) = table.get("group") {
                return Err(inner
                    .error(format!("{}: groups do not stand in groups", inner.name()))
                    .advise("name the files here"));
            }
            read(table, &item, folder, &none, &mut meshes)?;
        }
        Ok((name, meshes))
    };
    field.section()?.all().into_iter().map(group).collect()
}

/// Reads every mesh; relative paths are relative to `folder`.
pub(super) fn read_all<'t>(
    field: &Field<'t>,
    folder: &Path,
    groups: &Groups<'t>,
) -> Result<Vec<MeshPlan<'t>>> {
    let mut meshes = Vec::new();
    for item in field.list("a list of tables, [[mesh]]")? {
        read(item.section()?, &item, folder, groups, &mut meshes)?;
    }
    Ok(meshes)
}

/// Adds the mesh or group of one table in all its places.
fn read<'t>(
    mut mesh: Section<'t>,
    field: &Field<'t>,
    folder: &Path,
    groups: &Groups<'t>,
    into: &mut Vec<MeshPlan<'t>>,
) -> Result<()> {
    let group = mesh.get("group");
    let mut plans = match &group {
        Some(group) => members(group, groups)?,
        None => vec![of_file(&mut mesh, field, folder)?],
    };
    let material = text(&mut mesh, "material")?;
    let transform = mesh.get("transform").map(|f| Ok((transform(f.clone())?, f))).transpose()?;
    let motion = mesh.read("motion", motion)?;
    let instance = mesh.read("instance", |f| f.bool())?;
    let places = mesh.get("instances");
    mesh.finish()?;
    for plan in &mut plans {
        if let Some((transform, field)) = &transform {
            plan.then(transform, field)?;
        }
        plan.then_moving(&motion);
        plan.instance = instance.or(plan.instance);
        plan.material = material.clone().or(plan.material.take());
    }
    match places {
        None => into.append(&mut plans),
        Some(places) => place(&plans, &places, into)?,
    }
    if into.len() > MOST_PLACES {
        return Err(field.error(format!("more than {MOST_PLACES} meshes in their places")));
    }
    Ok(())
}

/// Adds `plans` once for every place of the list.
fn place<'t>(plans: &[MeshPlan<'t>], places: &Field<'t>, into: &mut Vec<MeshPlan<'t>>) -> Result<()> {
    let items = places.list("a list of places, [{ translate = [1, 0, 0] }, …]")?;
    if items.is_empty() {
        return Err(places.error(format!("{} is empty, so the mesh would be nowhere", places.name())));
    }
    for item in items {
        let mut table = item.section()?;
        let transform = transform_in(&mut table, &item)?;
        let material = text(&mut table, "material")?;
        table.finish()?;
        for plan in plans {
            let mut plan = plan.clone();
            plan.then(&transform, &item)?;
            plan.material = material.clone().or(plan.material);
            into.push(plan);
        }
    }
    Ok(())
}

/// The meshes of the group that `name` names.
fn members<'t>(name: &Field<'t>, groups: &Groups<'t>) -> Result<Vec<MeshPlan<'t>>> {
    let word = name.text()?;
    groups.get(word).cloned().ok_or_else(|| {
        let known: Vec<&str> = groups.keys().copied().collect();
        let advice = match known.as_slice() {
            [] => format!("add [[groups.{word}]] with its meshes"),
            known => unknown_word_advice(word, known),
        };
        name.error(format!("unknown group \"{word}\"")).advise(advice)
    })
}

/// The file of a table with its normals; the rest is read by [`read`].
fn of_file<'t>(mesh: &mut Section<'t>, field: &Field<'t>, folder: &Path) -> Result<MeshPlan<'t>> {
    let file = mesh.get("file").ok_or_else(|| {
        let error = mesh.missing(field, "file");
        if error.advice.is_some() { error } else { error.advise("e.g. file = \"bunny.obj\"") }
    })?;
    check_name(&file)?;
    let normals = mesh.read("normals", normals_word)?;
    let crease = mesh.get("crease");
    let normals = match (normals.unwrap_or(NormalsMode::File), crease) {
        (NormalsMode::Smooth { .. }, Some(crease)) => {
            NormalsMode::Smooth { crease: crease.number(0.0..=180.0)? }
        }
        (_, Some(crease)) => {
            return Err(crease.error(format!("{} goes with normals = \"smooth\"", crease.name())));
        }
        (normals, None) => normals,
    };
    Ok(MeshPlan {
        file: folder.join(file.text()?),
        field: file,
        transform: Transform::IDENTITY,
        course: Vec::new(),
        material: None,
        normals,
        instance: None,
    })
}

/// A key whose value is text.
fn text<'t>(table: &mut Section<'t>, key: &'static str) -> Result<Option<Field<'t>>> {
    let field = table.get(key);
    if let Some(field) = &field {
        field.text()?;
    }
    Ok(field)
}

/// Refuses what cannot be a mesh by its name, as the command line does.
fn check_name(file: &Field<'_>) -> Result<()> {
    let name = Path::new(file.text()?);
    let known = Format::all_extensions().join(", ");
    match name.extension().map(|e| e.to_string_lossy().to_lowercase()) {
        _ if name.as_os_str().is_empty() => {
            Err(file.error(format!("{} is empty", file.name())).advise("e.g. file = \"bunny.obj\""))
        }
        _ if name == Path::new(STDIN) && file.line() > 0 => Err(file
            .error("a scene file reads no standard input")
            .advise("give the mesh on the command line, or write \"./-\" for a file of that name")),
        Some(kind)
            if matches!(kind.as_str(), "fbx" | "dae" | "3ds" | "usd" | "usdz" | "blend" | "off" | "toml") =>
        {
            Err(file
                .error(format!("cannot read meshes of the kind \".{kind}\""))
                .advise(format!("convert it to one of {known}")))
        }
        _ => Ok(()),
    }
}

fn normals_word(field: Field<'_>) -> Result<NormalsMode> {
    field.word(&[], |word| match word {
        "file" => Ok(NormalsMode::File),
        "flat" => Ok(NormalsMode::Flat),
        "smooth" => Ok(NormalsMode::Smooth { crease: 180.0 }),
        _ => Err(Error::new(format!("unknown normals \"{word}\""))
            .advise(unknown_word_advice(word, &["file", "flat", "smooth"]))),
    })
}
