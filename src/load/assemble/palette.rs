//! Which materials a scene has: those of its files, changed by what the scene file says of them.

use crate::error::{Error, Result, unknown_word_advice};
use crate::load::auto;
use crate::load::materials::MaterialSpec;
use crate::load::object::Object;
use crate::load::place::rename_materials;
use crate::load::scene_file::{Field, MaterialPatch, MeshPlan};
use crate::math::Rgb;
use crate::shape::{FaceMaterials, Mesh};
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::sync::Arc;

/// How many mixtures may stand within each other: each is a call within the other's.
const DEEPEST_MIX: usize = 100;

/// A mesh's materials: scene ids by the file's ids, or one for all.
#[derive(Clone, PartialEq)]
pub enum Choice {
    /// This one.
    One(u32),
    /// By the file's ids; one list for all who choose it.
    ByFile(Arc<[u32]>),
}

impl Choice {
    /// What tells it from the other choices for a file's mesh.
    pub fn key(&self) -> Option<u32> {
        match self {
            Choice::One(id) => Some(*id),
            Choice::ByFile(_) => None,
        }
    }

    /// Gives a mesh with the file's ids those of the scene.
    pub fn dress(&self, mesh: &mut Mesh) {
        match self {
            Choice::One(id) => mesh.materials = FaceMaterials::Uniform(*id),
            Choice::ByFile(ids) => rename_materials(mesh, ids),
        }
    }
}

/// The scene's materials as they gather.
pub struct Palette<'p> {
    patches: &'p BTreeMap<String, MaterialPatch<'p>>,
    used: BTreeSet<&'p str>,
    /// The materials, by id.
    pub specs: Vec<MaterialSpec>,
    /// By file: scene ids of its materials, once they are in.
    of_file: Vec<Option<Arc<[u32]>>>,
    /// By file: where its materials are, by name; of several of one name the first.
    by_name: Vec<Option<HashMap<String, usize>>>,
    /// Scene ids of materials that meshes name, by name and the file they come from.
    named: BTreeMap<(String, Option<usize>), u32>,
}

impl<'p> Palette<'p> {
    /// An empty one for so many mesh files, with what the scene file says of materials.
    pub fn new(patches: &'p BTreeMap<String, MaterialPatch<'p>>, files: usize) -> Self {
        Palette {
            patches,
            used: BTreeSet::new(),
            specs: Vec::new(),
            of_file: vec![None; files],
            by_name: vec![None; files],
            named: BTreeMap::new(),
        }
    }

    /// Adds a material and returns its id.
    pub fn add(&mut self, spec: MaterialSpec) -> u32 {
        self.specs.push(spec);
        (self.specs.len() - 1) as u32
    }

    /// The material `name` of the file `file`, whose materials are `own`.
    fn in_file<'o>(&mut self, name: &str, own: &'o [MaterialSpec], file: usize) -> Option<&'o MaterialSpec> {
        let names = self.by_name.get_mut(file)?.get_or_insert_with(|| {
            let all = own.iter().enumerate().rev();
            all.map(|(i, spec)| (spec.name.clone(), i)).collect()
        });
        own.get(*names.get(name)?)
    }

    fn patched(&mut self, spec: MaterialSpec) -> Result<MaterialSpec> {
        match self.patches.get_key_value(&spec.name) {
            None => Ok(spec),
            Some((name, patch)) => {
                self.used.insert(name);
                patch.apply(spec)
            }
        }
    }

    /// Adds a material, and before it the parts of which it is mixed: `own` are those of its mesh file. `within`: the
    /// mixtures that it is a part of.
    fn add_whole(
        &mut self,
        mut spec: MaterialSpec,
        own: &[MaterialSpec],
        file: usize,
        within: &[&str],
    ) -> Result<u32> {
        if let Some(mut mix) = spec.mix.take() {
            for (name, id) in mix.names.iter().zip(&mut mix.ids) {
                *id = self.part(name, &spec.name, own, file, within)?;
            }
            let emission = mix.ids.map(|id| self.specs.get(id as usize).map_or(Rgb::ZERO, |s| s.emission));
            if spec.emission == Rgb::ZERO {
                spec.emission = emission[0].lerp(emission[1], mix.amount);
            }
            spec.mix = Some(mix);
        }
        Ok(self.add(spec))
    }

    /// The id of the part `name` of the mixture `whole`.
    fn part(
        &mut self,
        name: &str,
        whole: &str,
        own: &[MaterialSpec],
        file: usize,
        within: &[&str],
    ) -> Result<u32> {
        let within: Vec<&str> = within.iter().copied().chain([whole]).collect();
        let patches = self.patches;
        // Only a patch makes a mixture, so there is one to blame.
        let blame = || patches.get(whole).map(|patch| patch as &MaterialPatch<'_>);
        if within.contains(&name) {
            return Err(blame().map_or_else(|| Error::new("a mixture of itself"), MaterialPatch::own_part));
        }
        if within.len() > DEEPEST_MIX {
            return Err(blame().map_or_else(|| Error::new("too many mixtures"), MaterialPatch::too_deep));
        }
        let in_file = self.in_file(name, own, file);
        if in_file.is_none() && !patches.contains_key(name) {
            let known: Vec<&str> = patches.keys().map(String::as_str).filter(|n| *n != whole).collect();
            let message = || Error::new(format!("unknown material \"{name}\""));
            return Err(blame().map_or_else(message, |patch| patch.missing_part(name, &known)));
        }
        let key = (name.to_string(), in_file.map(|_| file));
        if let Some(id) = self.named.get(&key) {
            return Ok(*id);
        }
        let base = in_file.cloned().unwrap_or_else(|| MaterialSpec::diffuse(name, auto::CLAY));
        let spec = self.patched(base)?;
        let id = self.add_whole(spec, own, file, &within)?;
        self.named.insert(key, id);
        Ok(id)
    }

    /// The materials of a mesh: the one it names, or the file's own.
    pub fn choose(&mut self, mesh: &MeshPlan<'_>, file: usize, object: Option<&Object>) -> Result<Choice> {
        let own: &[MaterialSpec] = object.map_or(&[], |o| &o.materials);
        let Some(field) = &mesh.material else { return self.own(own, file).map(Choice::ByFile) };
        let name = field.text()?;
        let in_file = self.in_file(name, own, file);
        if in_file.is_none() && !self.patches.contains_key(name) {
            let names = self.patches.keys().map(String::as_str).chain(own.iter().map(|m| m.name.as_str()));
            let known: Vec<&str> = names.filter(|n| !n.is_empty()).collect();
            let advice = match known.as_slice() {
                [] => format!("add [materials.{name}] with its type"),
                known => unknown_word_advice(name, known),
            };
            return Err(field.error(format!("unknown material \"{name}\"")).advise(advice));
        }
        let key = (name.to_string(), in_file.map(|_| file));
        if let Some(id) = self.named.get(&key) {
            return Ok(Choice::One(*id));
        }
        let base = in_file.cloned().unwrap_or_else(|| MaterialSpec::diffuse(name, auto::CLAY));
        let spec = self.patched(base)?;
        let id = self.add_whole(spec, own, file, &[])?;
        self.named.insert(key, id);
        Ok(Choice::One(id))
    }

    fn own(&mut self, own: &[MaterialSpec], file: usize) -> Result<Arc<[u32]>> {
        if let Some(ids) = self.of_file.get(file).and_then(Option::as_ref) {
            return Ok(ids.clone());
        }
        let mut ids = Vec::with_capacity(own.len());
        for spec in own {
            let spec = self.patched(spec.clone())?;
            ids.push(self.add_whole(spec, own, file, &[])?);
        }
        let ids: Arc<[u32]> = ids.into();
        if let Some(slot) = self.of_file.get_mut(file) {
            *slot = Some(ids.clone());
        }
        Ok(ids)
    }

    /// What the scene file says of materials that no mesh has, and where.
    pub fn unused(&self) -> Vec<(&'p str, &'p Field<'p>)> {
        let patches = self.patches.iter().filter(|(name, _)| !self.used.contains(name.as_str()));
        patches.map(|(name, patch)| (name.as_str(), &patch.field)).collect()
    }

    /// Every face has a material, so there is at least one.
    pub fn specs(mut self) -> Vec<MaterialSpec> {
        if self.specs.is_empty() {
            self.specs.push(MaterialSpec::diffuse("", auto::CLAY));
        }
        self.specs
    }
}
