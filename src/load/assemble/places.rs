//! Meshes take their places: each its own copy in scene coordinates, or one mesh with many instances.
//!
//! What stands once and at rest is worked into the scene's coordinates, which is fastest. What moves is an instance, and
//! so is what stands in several places where copies would take much memory. Meshes that emit light and are at rest
//! are copies, whose light samples are the cheapest; but those that a file itself shows again and again are not.

use super::palette::Choice;
use super::parts::place_parts;
use super::prototypes::Prototypes;
use crate::bsdf::Parameter;
use crate::error::{Error, Result};
use crate::load::materials::MaterialSpec;
use crate::load::object::{MOST_COPIED, Object, Part};
use crate::load::place::{NormalsMode, Transform, origin_for, place};
use crate::load::scene_file::MeshPlan;
use crate::load::texture::Slot;
use crate::load::{Options, cancelled};
use crate::math::{DVec3, Rgb};
use crate::shape::{Bounds64, Instance, Instances, Mesh, Stage};
use glam::DAffine3;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Where a file's mesh stands, and how.
pub struct Placement {
    pub file: usize,
    /// Of the plan.
    pub transform: Transform,
    /// Of the plan: what moves it afterwards.
    pub course: Vec<Stage>,
    pub normals: NormalsMode,
    pub choice: Choice,
    pub instance: Option<bool>,
}

impl Placement {
    /// The transform at a time.
    fn at(&self, time: f64) -> Transform {
        if self.course.is_empty() {
            return self.transform;
        }
        let mut stages = vec![Stage::Fixed(self.transform.affine())];
        stages.extend(self.course.iter().cloned());
        Transform::of_affine(&Instance::new(0, None, stages).transform(time)).unwrap_or(self.transform)
    }

    pub fn mesh<'o>(&self, objects: &'o [Option<Object>]) -> Option<&'o Object> {
        objects.get(self.file).and_then(Option::as_ref)
    }
}

/// The origin that all meshes share, where they do and nothing moves them; else by the scene's extent at `time`.
pub fn scene_origin(placements: &[Placement], objects: &[Option<Object>], time: f64) -> DVec3 {
    let stays = |p: &Placement| p.transform == Transform::IDENTITY && p.course.is_empty();
    let own = placements.iter().map(|p| p.mesh(objects).filter(|_| stays(p)).map(|o| o.origin));
    let own: Option<Vec<DVec3>> = own.collect();
    if let Some([first, rest @ ..]) = own.as_deref()
        && rest.iter().all(|o| o == first)
    {
        return *first;
    }
    let parts = |o: &Object| o.parts.iter().fold(Bounds64::EMPTY, |sum, part| sum.union(&part.bounds()));
    let bounds = objects.iter().map(|o| o.as_ref().map(|o| (o.mesh.bounds(), o.origin, parts(o))));
    let bounds: Vec<_> = bounds.collect();
    let extent = placements.iter().fold(Bounds64::EMPTY, |sum, p| match bounds.get(p.file) {
        Some(Some((bounds, origin, parts))) => {
            let transform = p.at(time);
            sum.union(&transform.extent(bounds, *origin)).union(&parts.moved(&transform.affine()))
        }
        _ => sum,
    });
    origin_for(&extent)
}

/// What a placement stands with: file and normals.
pub type Kind = (usize, [u64; 2]);

pub fn kind(p: &Placement) -> Kind {
    let normals = match p.normals {
        NormalsMode::File => [0, 0],
        NormalsMode::Flat => [1, 0],
        NormalsMode::Smooth { crease } => [2, crease.to_bits()],
    };
    (p.file, normals)
}

/// Which placements become instances.
fn instanced(placements: &[Placement], objects: &[Option<Object>], specs: &[MaterialSpec]) -> Vec<bool> {
    let mut places: BTreeMap<Kind, u64> = BTreeMap::new();
    placements.iter().for_each(|p| *places.entry(kind(p)).or_default() += 1);
    let pays = |p: &Placement| {
        let triangles = p.mesh(objects).map_or(0, |o| o.mesh.indices.len() as u64);
        let copies = places.get(&kind(p)).map_or(0, |count| count - 1);
        triangles.saturating_mul(copies) > MOST_COPIED
    };
    let mut shining: BTreeMap<(usize, Option<u32>), bool> = BTreeMap::new();
    let mut shines =
        |p: &Placement| *shining.entry((p.file, p.choice.key())).or_insert_with(|| emits(&p.choice, specs));
    let decide = |p: &Placement| match p.course.as_slice() {
        [] if shines(p) => false,
        [] => p.instance.unwrap_or_else(|| pays(p)),
        _ => true,
    };
    placements.iter().map(decide).collect()
}

fn emits(choice: &Choice, specs: &[MaterialSpec]) -> bool {
    let shines = |id: &u32| {
        specs.get(*id as usize).is_some_and(|spec| {
            let pictured = spec.maps.iter().any(|map| map.slot == Slot::Parameter(Parameter::Emission));
            spec.emission != Rgb::ZERO || pictured
        })
    };
    match choice {
        Choice::One(id) => shines(id),
        Choice::ByFile(ids) => ids.iter().any(shines),
    }
}

/// What is placed: the objects, and the scene's materials by now.
pub struct Stock<'a> {
    pub objects: &'a mut [Option<Object>],
    pub specs: &'a [MaterialSpec],
    pub origin: DVec3,
    /// How many meshes each file still has to give.
    left: Vec<usize>,
}

impl<'a> Stock<'a> {
    pub fn new(objects: &'a mut [Option<Object>], specs: &'a [MaterialSpec], origin: DVec3) -> Self {
        Stock { left: vec![0; objects.len()], objects, specs, origin }
    }

    /// A file's mesh with its materials; the last one takes the file's memory over.
    fn take(&mut self, p: &Placement) -> Result<(Mesh, DVec3)> {
        let gone = || Error::new("a mesh was placed after its last use");
        let left = self.left.get_mut(p.file).ok_or_else(gone)?;
        *left = left.saturating_sub(1);
        let slot = self.objects.get_mut(p.file).ok_or_else(gone)?;
        let taken = if *left == 0 { slot.take().map(|o| (o.mesh, o.origin)) } else { None };
        let own = taken.or_else(|| slot.as_ref().map(|o| (o.mesh.clone(), o.origin)));
        let (mut mesh, from) = own.ok_or_else(gone)?;
        p.choice.dress(&mut mesh);
        Ok((mesh, from))
    }

    fn needs(&mut self, file: usize) {
        if let Some(left) = self.left.get_mut(file) {
            *left += 1;
        }
    }
}

/// Everything in its place: what is copied in the order of the placements, and what is instanced in theirs.
pub fn place_all(
    placements: &[Placement],
    mut stock: Stock<'_>,
    plans: &[MeshPlan<'_>],
    options: &Options<'_>,
) -> Result<(Vec<Arc<Mesh>>, Instances)> {
    let is_instance = instanced(placements, stock.objects, stock.specs);
    let parts = stock.objects.iter_mut().map(|o| o.as_mut().map(|o| std::mem::take(&mut o.parts)));
    let mut parts: Vec<Vec<Part>> = parts.map(Option::unwrap_or_default).collect();
    let ranks = |which: bool| {
        let all = placements.iter().zip(&is_instance).enumerate();
        all.filter(move |(_, (_, is))| **is == which).map(|(i, (p, _))| (i, p))
    };
    let (firsts, shared) = same_places(ranks(false));
    let prototypes = Prototypes::new(ranks(true), &stock);
    firsts.iter().for_each(|(_, p)| stock.needs(p.file));
    prototypes.of.iter().for_each(|p| stock.needs(p.file));
    let blame = |i: usize, e: Error| plans.get(i).map_or(e.clone(), |plan| plan.field.locate(e));
    let go_on = || if (options.progress)(1.0) { Ok(()) } else { Err(cancelled()) };

    let mut own: Vec<Arc<Mesh>> = Vec::with_capacity(firsts.len());
    for (i, p) in &firsts {
        go_on()?;
        let (mesh, from) = stock.take(p)?;
        let placed = place(mesh, from, stock.origin, &p.transform, p.normals).map_err(|e| blame(*i, e))?;
        own.push(Arc::new(placed));
    }
    let meshes = shared.iter().filter_map(|at| own.get(*at).cloned()).collect();

    let mut instances = Instances::default();
    let mut origins = Vec::with_capacity(prototypes.of.len());
    for p in &prototypes.of {
        go_on()?;
        let (mesh, from) = stock.take(p)?;
        let mesh = place(mesh, from, from, &Transform::IDENTITY, p.normals)?;
        instances.meshes.push(Arc::new(mesh));
        origins.push(from);
    }
    for ((_, p), (mesh, material)) in ranks(true).zip(&prototypes.uses) {
        let from = origins.get(*mesh).copied().unwrap_or(DVec3::ZERO);
        let first = p.transform.affine() * DAffine3::from_translation(from);
        let last = DAffine3::from_translation(-stock.origin);
        let stages = [Stage::Fixed(first)].into_iter().chain(p.course.iter().cloned());
        let stages = stages.chain([Stage::Fixed(last)]).collect();
        instances.places.push(Instance::new(*mesh as u32, *material, stages));
    }
    let mut by_file: BTreeMap<usize, Vec<(usize, &Placement)>> = BTreeMap::new();
    for (i, p) in placements.iter().enumerate().filter(|(_, p)| !parts[p.file].is_empty()) {
        by_file.entry(p.file).or_default().push((i, p));
    }
    for (file, placements) in by_file {
        go_on()?;
        let (first, parts) = (placements[0].0, std::mem::take(&mut parts[file]));
        place_parts(parts, placements.iter().map(|(_, p)| *p), stock.origin, &mut instances)
            .map_err(|e| blame(first, e))?;
    }
    Ok((meshes, instances))
}

/// Equal placements share one mesh: the first of each, and for every placement which of these it is.
fn same_places<'p>(
    placements: impl Iterator<Item = (usize, &'p Placement)>,
) -> (Vec<(usize, &'p Placement)>, Vec<usize>) {
    let mut known: BTreeMap<(Kind, [u64; 16], Option<u32>), usize> = BTreeMap::new();
    let (mut firsts, mut shared) = (Vec::new(), Vec::new());
    for (i, p) in placements {
        let at = *known.entry((kind(p), p.transform.bits(), p.choice.key())).or_insert_with(|| {
            firsts.push((i, p));
            firsts.len() - 1
        });
        shared.push(at);
    }
    (firsts, shared)
}
