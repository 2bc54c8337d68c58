//! The figure: error against N on log axes, as SVG.
//!
//! Lengths are in points of the finished figure; ten of the backend's units make one, since the backend knows whole
//! numbers only. Nobody can measure text here (fonts are the viewer's), so every place for text has room to spare.

mod axis;
mod legend;
mod mark;

use super::{Point, Series, Study};
use crate::error::{Error, Result};
use axis::Axis;
use mark::Style;
use plotters::coord::Shift;
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// Backend units in a point.
const FINE: i32 = 10;
/// Width and height of the figure.
const SIZE: (i32, i32) = (860, 540);
/// The frame of the chart: left, top, right, bottom.
const FRAME: (i32, i32, i32, i32) = (86, 66, 586, 426);

const INK: RGBColor = RGBColor(0x22, 0x22, 0x22);
const FAINT_INK: RGBColor = RGBColor(0x5f, 0x5f, 0x5f);
const GRID: RGBColor = RGBColor(0xd4, 0xd4, 0xd4);
const FINE_GRID: RGBColor = RGBColor(0xee, 0xee, 0xee);
const GUIDE: RGBColor = RGBColor(0x9a, 0x9a, 0x9a);

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Chart<'a> = ChartContext<'a, SVGBackend<'a>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;
type Drawn = Result<(), DrawingAreaErrorKind<std::io::Error>>;

/// The study as an SVG document.
///
/// # Errors
/// None that a study can cause: the document is text in memory.
pub fn svg(study: &Study) -> Result<String> {
    let mut text = String::new();
    draw(study, &mut text).map_err(|e| Error::new(format!("cannot draw the figure: {e}")))?;
    let fine = format!("width=\"{}\" height=\"{}\"", SIZE.0 * FINE, SIZE.1 * FINE);
    Ok(text.replacen(&fine, &format!("width=\"{}\" height=\"{}\"", SIZE.0, SIZE.1), 1))
}

fn draw(study: &Study, text: &mut String) -> Drawn {
    let size = ((SIZE.0 * FINE) as u32, (SIZE.1 * FINE) as u32);
    let area = SVGBackend::with_string(text, size).into_drawing_area();
    area.fill(&WHITE)?;
    let (x, y) = (Axis::of_samples(study), Axis::of_errors(study));
    let mut chart = ChartBuilder::on(&area)
        .margin_left(FRAME.0 * FINE)
        .margin_top(FRAME.1 * FINE)
        .margin_right((SIZE.0 - FRAME.2) * FINE)
        .margin_bottom((SIZE.1 - FRAME.3) * FINE)
        .build_cartesian_2d(x.low..x.high, y.low..y.high)?;
    axis::draw(&area, &mut chart, &x, &y)?;
    guides(&mut chart, &area, study, &x, &y)?;
    let styles: Vec<Style> = (0..study.series.len()).map(Style::numbered).collect();
    for (series, style) in study.series.iter().zip(&styles) {
        curve(&mut chart, &area, series, style)?;
    }
    let middle = (FRAME.0 + FRAME.2) / 2;
    let centred = Pos::new(HPos::Center, VPos::Center);
    area.draw_text(study.labels.samples, &font(15, INK).pos(centred), at(middle, FRAME.3 + 42))?;
    let turned = TextStyle::from(("sans-serif", size_of(15)).into_font().transform(FontTransform::Rotate270));
    let place = at(24, (FRAME.1 + FRAME.3) / 2);
    area.draw_text("root mean square error", &turned.color(&INK).pos(centred), place)?;
    legend::draw(&area, study, &styles)?;
    words(&area, study, &y)?;
    area.present()
}

/// Title above, the reference and what was fitted below.
fn words(area: &Area<'_>, study: &Study, y: &Axis) -> Drawn {
    let bold = ("sans-serif", size_of(18), FontStyle::Bold).into_font();
    area.draw_text(&short(&study.labels.title, 60), &TextStyle::from(bold).color(&INK), at(FRAME.0, 14))?;
    area.draw_text(&short(&study.labels.subtitle, 100), &font(14, FAINT_INK), at(FRAME.0, 39))?;
    let mut lines = vec![format!("Reference: {}.", short(&study.reference.description, 110))];
    let own = study.reference.rmse;
    if own > 0.0 {
        let points = study.series.iter().flat_map(|series| &series.points);
        let dotted = if libm::log10(own) > y.low { " (dotted)" } else { "" };
        let hollow = match points.filter(|point| !point.is_exact && !point.is_fitted).count() {
            0 => "",
            _ => "; hollow points, less than twice above it, are not fitted",
        };
        lines.push(format!("Its own error is about {own:.1e}{dotted}{hollow}."));
    }
    let runs = match study.plan.seeds {
        1 => "one run a point".to_string(),
        seeds => format!("{seeds} runs a point of a random rule"),
    };
    let partial = if study.complete { "" } else { " Stopped before the end." };
    lines.push(format!("Slopes: least squares with 95 % confidence; {runs}.{partial}"));
    for (line, row) in lines.iter().zip(0..) {
        area.draw_text(line, &font(12, FAINT_INK), at(FRAME.0 - 62, FRAME.3 + 58 + 15 * row))?;
    }
    Ok(())
}

/// The curve of a rule, point by point; what is exact has no place on a log axis.
fn curve(chart: &mut Chart<'_>, area: &Area<'_>, series: &Series, style: &Style) -> Drawn {
    let points: Vec<&Point> = series.points.iter().filter(|point| !point.is_exact).collect();
    let place = |point: &Point| (libm::log10(point.n as f64), libm::log10(point.rmse));
    let line = style.color.stroke_width((2 * FINE) as u32);
    chart.draw_series(LineSeries::new(points.iter().map(|point| place(point)), line))?;
    for point in points {
        mark::draw(area, chart.backend_coord(&place(point)), style, point.is_fitted)?;
    }
    Ok(())
}

/// Thin dashed lines of the orders that theory knows, from the largest error at N = 1 on, and the reference's error.
fn guides(chart: &mut Chart<'_>, area: &Area<'_>, study: &Study, x: &Axis, y: &Axis) -> Drawn {
    let first = study.series.iter().filter_map(|series| series.points.first());
    let top = first.map(|point| point.rmse).fold(0.0, f64::max);
    let steepest = study.series.iter().filter_map(|series| series.slope).map(|slope| slope.value);
    let steepest = steepest.fold(-1.0, f64::min);
    let thin = GUIDE.stroke_width(FINE as u32);
    let orders = [(-0.5, "−1/2"), (-1.0, "−1"), (-1.5, "−3/2"), (-2.0, "−2")];
    for (slope, name) in orders.into_iter().filter(|order| top > 0.0 && order.0 > steepest - 0.25) {
        let (x0, y0) = (0.0, libm::log10(top));
        // To the frame, at its right side or its bottom.
        let x1 = (x0 + (y.low - y0) / slope).min(x.high);
        let end = (x1, y0 + slope * (x1 - x0));
        chart.draw_series(DashedLineSeries::new([(x0, y0), end], 5 * FINE as u32, 4 * FINE as u32, thin))?;
        let (px, py) = chart.backend_coord(&end);
        // Beside the frame, where no curve is; above it for what leaves through the bottom.
        let above = if x1 < x.high { 9 * FINE } else { 0 };
        let pos = Pos::new(HPos::Left, VPos::Center);
        area.draw_text(name, &font(12, FAINT_INK).pos(pos), (px + 5 * FINE, py - above))?;
    }
    let own = libm::log10(study.reference.rmse);
    if own > y.low && own < y.high {
        let dots = [(x.low, own), (x.high, own)];
        chart.draw_series(DashedLineSeries::new(dots, FINE as u32, 3 * FINE as u32, thin))?;
    }
    Ok(())
}

/// `text`, cut where it would leave the figure.
fn short(text: &str, most: usize) -> String {
    match text.char_indices().nth(most) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text.to_string(),
    }
}

/// A place in backend units.
fn at(x: i32, y: i32) -> (i32, i32) {
    (x * FINE, y * FINE)
}

/// The backend divides sizes by 1.24.
fn size_of(points: i32) -> i32 {
    points * FINE * 124 / 100
}

fn font(points: i32, color: RGBColor) -> TextStyle<'static> {
    let plain = TextStyle::from(("sans-serif", size_of(points)).into_font());
    TextStyle { color: color.to_backend_color(), ..plain }
}
