//! The legend beside the chart: the curves in the order of their right ends, each with its slope.

use super::mark::{self, Style};
use super::{Area, Drawn, FAINT_INK, FINE, FRAME, INK, at, font};
use crate::converge::report::slope_text;
use crate::converge::{Series, Study};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// Left end of the legend.
const LEFT: i32 = FRAME.2 + 44;
/// Height of an entry, when there is room for it.
const ROW: i32 = 38;

/// Draws an entry for each curve, the one that ends highest first.
pub(super) fn draw(area: &Area<'_>, study: &Study, styles: &[Style]) -> Drawn {
    let mut entries: Vec<(&Series, &Style)> = study.series.iter().zip(styles).collect();
    let end = |series: &Series| match series.points.iter().rev().find(|point| !point.is_exact) {
        _ if series.is_exact() => 0.0,
        Some(point) => point.rmse,
        None => 0.0,
    };
    entries.sort_by(|a, b| end(b.0).total_cmp(&end(a.0)));
    let row = ROW.min((FRAME.3 - FRAME.1) / entries.len().max(1) as i32);
    let left = Pos::new(HPos::Left, VPos::Center);
    for ((series, style), i) in entries.into_iter().zip(0..) {
        let y = FRAME.1 + 8 + row * i;
        let line = style.color.stroke_width((2 * FINE) as u32);
        area.draw(&PathElement::new([at(LEFT, y), at(LEFT + 28, y)], line))?;
        mark::draw(area, at(LEFT + 14, y), style, true)?;
        area.draw_text(series.name, &font(14, INK).pos(left), at(LEFT + 38, y))?;
        area.draw_text(&slope_text(series), &font(12, FAINT_INK).pos(left), at(LEFT + 38, y + 16))?;
    }
    Ok(())
}
