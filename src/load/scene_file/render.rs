//! `[render]`: integrator, samples, seed, backend.

use super::reader::{Field, Section, Shorthand};
use crate::accel::{Backend, Quality};
use crate::error::Result;
use crate::quadrature::hemisphere::{Cells, Fan, HemisphereRule, Measure};
use crate::scene::{BuildQuality, Compact, Directions, IntegratorKind, LightSampling, SamplerKind, Settings};

/// Samples a pixel at most.
pub(crate) const MOST_SPP: u32 = 1 << 20;
/// Scattering events at most.
pub(crate) const DEEPEST: u32 = 65535;

/// Reads the section into `settings`; returns the key `spp` where it is there.
pub(super) fn read<'t>(mut render: Section<'t>, settings: &mut Settings) -> Result<Option<Field<'t>>> {
    let s = settings;
    let kind = render.get("integrator");
    assign(&mut s.integrator, kind.clone().map(integrator).transpose()?);
    assign(&mut s.lights, render.read("lights", |f| f.word(&[], LightSampling::from_name))?);
    assign(&mut s.roulette, render.read("roulette", |f| f.bool())?);
    assign(&mut s.split, render.read("split", split)?);
    let spp = render.get("spp");
    assign(&mut s.spp, spp.as_ref().map(|f| f.integer32(1..=MOST_SPP)).transpose()?);
    assign(&mut s.max_depth, render.read("max_depth", |f| f.integer32(0..=DEEPEST))?);
    if let (Some(field), IntegratorKind::Distribution { rule, directions }) = (kind, &s.integrator) {
        directions.check(*rule, s.max_depth).map_err(|e| field.locate(e))?;
    }
    assign(&mut s.seed, render.read("seed", |f| f.integer(0..=u64::MAX))?);
    assign(&mut s.sampler, render.read("sampler", |f| f.word(&[], SamplerKind::from_name))?);
    assign(&mut s.backend, render.read("backend", |f| f.word(&[], Backend::from_name))?);
    assign(&mut s.build, render.read("build", |f| f.word(&[], BuildQuality::from_name))?);
    assign(&mut s.compact, render.read("compact", compact)?);
    if (s.compact, s.build) == (Compact::Yes, BuildQuality::Auto) {
        // Low quality fills its leaves badly, and joins meshes in a copy: not what small is asked for.
        s.build = BuildQuality::Fixed(Quality::Medium);
    }
    render.finish()?;
    Ok(spp)
}

fn split(field: Field<'_>) -> Result<Option<u32>> {
    match field.text() {
        Ok("auto") => Ok(None),
        Ok(_) => {
            Err(field.must_be(&format!("a whole number from 1 to {} or \"auto\"", Settings::MOST_SPLITS)))
        }
        Err(_) => field.integer32(1..=Settings::MOST_SPLITS).map(Some),
    }
}

fn compact(field: Field<'_>) -> Result<Compact> {
    match (field.text(), field.bool()) {
        (Ok("auto"), _) => Ok(Compact::Auto),
        (_, Ok(true)) => Ok(Compact::Yes),
        (_, Ok(false)) => Ok(Compact::No),
        _ => Err(field.must_be("true, false or \"auto\"")),
    }
}

fn assign<T>(target: &mut T, value: Option<T>) {
    if let Some(value) = value {
        *target = value;
    }
}

fn integrator(field: Field<'_>) -> Result<IntegratorKind> {
    let mut table = match field.shorthand()? {
        Shorthand::Word(word) => return word.word(&[], IntegratorKind::from_name),
        Shorthand::Table(table) => table,
    };
    let kind = table.read("type", |f| f.word(&[], IntegratorKind::from_name))?;
    let mut kind = kind.unwrap_or(Settings::default().integrator);
    match &mut kind {
        IntegratorKind::Ao { distance } => {
            assign(distance, table.read("distance", |f| f.number(1e-18..=f64::INFINITY).map(|x| x as f32))?);
        }
        IntegratorKind::Distribution { rule, directions: by_depth } => {
            assign(rule, table.read("rule", |f| f.word(&[], HemisphereRule::from_name))?);
            hemisphere(&mut table, rule)?;
            assign(by_depth, table.read("directions", |f| directions(&f))?);
        }
        IntegratorKind::Path | IntegratorKind::Direct | IntegratorKind::Normals => (),
    }
    table.finish()?;
    Ok(kind)
}

/// The parameters that `rule` has; those of other rules stay unknown keys.
fn hemisphere(table: &mut Section<'_>, rule: &mut HemisphereRule) -> Result<()> {
    match rule {
        HemisphereRule::Stratified { per_cell, .. } | HemisphereRule::Nonuniform { per_cell } => {
            assign(per_cell, table.read("per_cell", |f| f.integer32(1..=Fan::MOST))?);
        }
        _ => (),
    }
    match rule {
        HemisphereRule::Random { measure }
        | HemisphereRule::Stratified { measure, .. }
        | HemisphereRule::Sobol { measure } => {
            assign(measure, table.read("measure", |f| f.word(&[], Measure::from_name))?);
        }
        _ => (),
    }
    Ok(())
}

/// One entry a depth: [M, N] cells in θ × φ, or a number of directions.
fn directions(field: &Field<'_>) -> Result<Directions> {
    let what =
        "a list with an entry for every depth: [M, N] cells in theta and phi, or a number of directions";
    if let Ok(count) = field.integer32(1..=Fan::MOST) {
        return Directions::new(&[Cells::of(count)]);
    }
    let mut cells = Vec::new();
    for entry in field.list(what)? {
        cells.push(if entry.list("").is_ok() {
            let [theta, phi] = entry.integers(1..=Fan::MOST).map_err(|e| e.advise(what))?;
            Cells { theta, phi }
        } else {
            let count = entry.integer32(1..=Fan::MOST);
            Cells::of(count.map_err(|e| e.advise("or [M, N] cells in theta and phi"))?)
        });
    }
    Directions::new(&cells).map_err(|e| field.locate(e))
}
