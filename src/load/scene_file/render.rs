//! `[render]`: integrator, samples, seed, backend.

use super::reader::{Field, Section, Shorthand};
use crate::accel::Backend;
use crate::error::Result;
use crate::scene::{BuildQuality, IntegratorKind, LightSampling, SamplerKind, Settings};

/// Samples a pixel at most.
pub(crate) const MOST_SPP: u32 = 1 << 20;
/// Scattering events at most.
pub(crate) const DEEPEST: u32 = 65535;

/// Reads the section into `settings`.
pub(super) fn read(mut render: Section<'_>, settings: &mut Settings) -> Result<()> {
    let s = settings;
    assign(&mut s.integrator, render.read("integrator", integrator)?);
    assign(&mut s.lights, render.read("lights", |f| f.word(&[], LightSampling::from_name))?);
    assign(&mut s.roulette, render.read("roulette", |f| f.bool())?);
    assign(&mut s.spp, render.read("spp", |f| f.integer32(1..=MOST_SPP))?);
    assign(&mut s.max_depth, render.read("max_depth", |f| f.integer32(0..=DEEPEST))?);
    assign(&mut s.seed, render.read("seed", |f| f.integer(0..=u64::MAX))?);
    assign(&mut s.sampler, render.read("sampler", |f| f.word(&["halton"], SamplerKind::from_name))?);
    assign(&mut s.backend, render.read("backend", |f| f.word(&[], Backend::from_name))?);
    assign(&mut s.build, render.read("build", |f| f.word(&[], BuildQuality::from_name))?);
    assign(&mut s.compact, render.read("compact", |f| f.bool())?);
    render.finish()
}

fn assign<T>(target: &mut T, value: Option<T>) {
    if let Some(value) = value {
        *target = value;
    }
}

fn integrator(field: Field<'_>) -> Result<IntegratorKind> {
    const LATER: &[&str] = &["distribution"];
    let mut table = match field.shorthand()? {
        Shorthand::Word(word) => return word.word(LATER, IntegratorKind::from_name),
        Shorthand::Table(table) => table,
    };
    let kind = table.read("type", |f| f.word(LATER, IntegratorKind::from_name))?;
    let mut kind = kind.unwrap_or(Settings::default().integrator);
    if let IntegratorKind::Ao { distance } = &mut kind {
        assign(distance, table.read("distance", |f| f.number(1e-18..=f64::INFINITY).map(|x| x as f32))?);
    }
    table.finish()?;
    Ok(kind)
}
