//! `[film]`: size, filter, crop, layers.

use super::reader::{Field, Section, Shorthand};
use super::render::MOST_SPP;
use crate::error::{Finding, Result, Severity};
use crate::film::filter::FilterSampler;
use crate::film::rule::Grid;
use crate::film::{Aov, Filter, PixelPoints, PixelRule};
use crate::quadrature::hemisphere::Cells;
use crate::scene::{Quantity, Settings};

/// Pixels a side at most.
pub(crate) const LARGEST_SIDE: u32 = 1 << 20;
/// Pixels of a picture at most.
pub(crate) const MOST_PIXELS: u64 = 1 << 28;

/// Reads the section into `settings`; returns the key `rule` where it is there, whose grid is settled by
/// [`settle_grid`].
pub(super) fn read<'t>(mut film: Section<'t>, settings: &mut Settings) -> Result<Option<Field<'t>>> {
    if let Some(quantity) = film.read("quantity", |f| f.word(&[], Quantity::from_name))? {
        settings.quantity = quantity;
    }
    let rule = film.get("rule");
    if let Some(rule) = &rule {
        settings.rule = pixel_rule(rule.clone())?;
    }
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
    if let Some(clamp) = film.read("clamp", |f| f.number(1e-6..=1e18))? {
        settings.clamp = Some(clamp as f32);
    }
    if let Some(aovs) = film.read("aov", aovs)? {
        settings.aovs = aovs;
    }
    film.finish()?;
    Ok(rule)
}

/// A rule by name, or with its grid. A grid that is not given has no cells yet.
fn pixel_rule(field: Field<'_>) -> Result<PixelRule> {
    let mut table = match field.shorthand()? {
        Shorthand::Word(word) => return word.word(&[], PixelRule::from_name).map(|rule| rule.over(OPEN)),
        Shorthand::Table(table) => table,
    };
    let Some(rule) = table.read("type", |f| f.word(&[], PixelRule::from_name))? else {
        let known: Vec<&str> = PixelRule::TABLE.iter().map(|row| row.0).collect();
        return Err(field
            .error(format!("{} needs a type", field.name()))
            .advise(format!("known: {}", known.join(", "))));
    };
    if rule.grid().is_none() {
        table.finish()?;
        return Ok(rule);
    }
    let per_cell = table.read("per_cell", |f| f.integer32(1..=MOST_SPP))?.unwrap_or(0);
    let cells = table.read("grid", |f| f.integers(1..=MOST_SPP))?.unwrap_or(OPEN.cells);
    table.finish()?;
    Ok(rule.over(Grid { cells, per_cell }))
}

/// A grid that follows from the samples a pixel.
const OPEN: Grid = Grid { cells: [0, 0], per_cell: 0 };

/// Makes grid and samples a pixel agree, once both sections are read: a grid that was given settles the samples,
/// and a grid that was not is about as many cells wide as high. A finding where both were given and differ.
pub(super) fn settle_grid(
    rule: &Field<'_>,
    spp: Option<&Field<'_>>,
    file: &std::path::Path,
    settings: &mut Settings,
) -> Result<Option<Finding>> {
    let Some(grid) = settings.rule.grid() else { return Ok(None) };
    if grid.cells == OPEN.cells {
        let per_cell = grid.per_cell.max(1);
        if !settings.spp.is_multiple_of(per_cell) {
            return Err(rule
                .error(format!(
                    "{} samples a pixel do not make whole cells of {per_cell} points",
                    settings.spp
                ))
                .advise("say how many cells: grid = [M, N]"));
        }
        // Wider than high where it cannot be square.
        let Cells { theta: n, phi: m } = Cells::of(settings.spp / per_cell);
        settings.rule = settings.rule.over(Grid { cells: [m, n], ..grid });
        return Ok(None);
    }
    PixelPoints::new(settings.rule, FilterSampler::new(settings.filter)).map_err(|e| rule.locate(e))?;
    let points = u32::try_from(grid.points()).ok().filter(|p| *p <= MOST_SPP).ok_or_else(|| {
        rule.error(format!("{} makes {} points a pixel, more than {MOST_SPP}", rule.name(), grid.points()))
    })?;
    let asked = std::mem::replace(&mut settings.spp, points);
    Ok(spp.filter(|_| asked != points).map(|spp| Finding {
        file: file.to_path_buf(),
        line: spp.line(),
        kind: "spp-by-rule",
        message: format!("the points of {} make {points} samples a pixel, not {asked}", rule.name()),
        severity: Severity::Note,
    }))
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
