//! `[film]`: size, filter, crop, layers.

use super::reader::{Field, Section, Shorthand};
use crate::error::Result;
use crate::film::{Aov, Filter};
use crate::scene::Settings;

/// Pixels a side at most.
pub(crate) const LARGEST_SIDE: u32 = 1 << 20;
/// Pixels of a picture at most.
pub(crate) const MOST_PIXELS: u64 = 1 << 28;

/// Reads the section into `settings`.
pub(super) fn read(mut film: Section<'_>, settings: &mut Settings) -> Result<()> {
    film.not_yet_unless("quantity", "radiance")?;
    film.not_yet_unless("rule", "sampler")?;
    if let Some(size) = film.get("size") {
        settings.size = size.integers(1..=LARGEST_SIDE)?;
        let pixels = u64::from(settings.size[0]) * u64::from(settings.size[1]);
        if pixels > MOST_PIXELS {
            return Err(size
                .error(format!("{} is {pixels} pixels, more than the limit of {MOST_PIXELS}", size.name())));
        }
    }
    if let Some(crop) = film.read("crop", |f| crop(&f, settings.size))? {
        settings.crop = Some(crop);
    }
    if let Some(filter) = film.read("filter", filter)? {
        settings.filter = filter;
    }
    if let Some(aovs) = film.read("aov", aovs)? {
        settings.aovs = aovs;
    }
    film.finish()
}

/// x, y, width, height inside the picture.
fn crop(field: &Field<'_>, size: [u32; 2]) -> Result<[u32; 4]> {
    let crop: [u32; 4] = field.integers(0..=LARGEST_SIDE)?;
    let [x, y, w, h] = crop;
    let inside = w > 0 && h > 0 && x + w <= size[0] && y + h <= size[1];
    if !inside {
        return Err(field.error(format!(
            "{} = X,Y,WIDTH,HEIGHT must lie inside the {}x{} picture and not be empty, not {x},{y},{w},{h}",
            field.name(),
            size[0],
            size[1]
        )));
    }
    Ok(crop)
}

fn filter(field: Field<'_>) -> Result<Filter> {
    let mut table = match field.shorthand()? {
        Shorthand::Word(word) => return word.word(&[], Filter::from_name),
        Shorthand::Table(table) => table,
    };
    let kind = table.read("type", |f| f.word(&[], Filter::from_name))?;
    let mut filter = kind.unwrap_or(Settings::default().filter);
    // 32 pixels to each side is far beyond any use, and keeps offsets small against the film.
    let length = |f: Field<'_>| f.number(0.01..=32.0).map(|x| x as f32);
    match &mut filter {
        Filter::Box { radius } | Filter::Tent { radius } | Filter::BlackmanHarris { radius } => {
            *radius = table.read("radius", length)?.unwrap_or(*radius);
        }
        Filter::Gaussian { sigma, radius } => {
            *sigma = table.read("sigma", length)?.unwrap_or(*sigma);
            *radius = table.read("radius", length)?.unwrap_or(*radius);
        }
        Filter::Mitchell { radius, b, c } => {
            // Beyond this range the cubic is no filter any more.
            let share = |f: Field<'_>| f.number(0.0..=1.0).map(|x| x as f32);
            *radius = table.read("radius", length)?.unwrap_or(*radius);
            *b = table.read("b", share)?.unwrap_or(*b);
            *c = table.read("c", share)?.unwrap_or(*c);
        }
    }
    table.finish()?;
    Ok(filter)
}

/// Layer names; each once, in the order given.
fn aovs(field: Field<'_>) -> Result<Vec<Aov>> {
    let mut aovs = Vec::new();
    for item in field.list("a list of layer names")? {
        let aov = item.word(&[], Aov::from_name)?;
        if !aovs.contains(&aov) {
            aovs.push(aov);
        }
    }
    Ok(aovs)
}

impl Section<'_> {
    /// A key of which this version has one value only, the default.
    fn not_yet_unless(&mut self, key: &'static str, only: &str) -> Result<()> {
        match self.get(key) {
            Some(field) if field.text().is_ok_and(|word| word == only) => Ok(()),
            Some(field) => Err(field
                .error(format!("this value of {} is not supported by this version", field.name()))
                .advise(format!("use \"{only}\""))),
            None => Ok(()),
        }
    }
}
