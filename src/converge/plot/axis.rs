//! The log axes: their ranges, the grid, the numbers at it.

use super::{Area, Chart, Drawn, FINE, FINE_GRID, FRAME, GRID, INK, font};
use crate::converge::Study;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// An axis in decades: log₁₀ of what it shows.
pub(super) struct Axis {
    /// The lower end.
    pub low: f64,
    /// The upper end.
    pub high: f64,
}

impl Axis {
    /// Around `values`, with room for the marks; an axis of nothing shows 0.1 to 1.
    fn around(values: impl Iterator<Item = f64>, room: f64) -> Axis {
        let (low, high) = values
            .map(libm::log10)
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (v.min(low), v.max(high)));
        let (low, high) = if low <= high { (low, high) } else { (-1.0, 0.0) };
        // A flat curve needs some height as well.
        let room = (room * (high - low)).max(0.12);
        Axis { low: low - room, high: high + room }
    }

    /// The axis of N.
    pub fn of_samples(study: &Study) -> Axis {
        Axis::around(study.plan.numbers().map(|n| n as f64), 0.04)
    }

    /// The axis of the errors.
    pub fn of_errors(study: &Study) -> Axis {
        let points = study.series.iter().flat_map(|series| &series.points).filter(|point| !point.is_exact);
        let errors: Vec<f64> = points.map(|point| point.rmse).collect();
        let lowest = errors.iter().copied().fold(f64::INFINITY, f64::min);
        // The reference's own error is shown where it is not far below.
        let own = Some(study.reference.rmse).filter(|own| *own > 0.0 && *own > 0.2 * lowest);
        Axis::around(errors.into_iter().chain(own), 0.06)
    }

    /// The numbers m·10ᵏ inside, with their decade k.
    fn inside(&self, factors: &'static [i32]) -> Vec<(i32, i32, f64)> {
        let decades = self.low.floor() as i32..=self.high.ceil() as i32;
        let all = decades
            .flat_map(|k| factors.iter().map(move |&m| (m, k, f64::from(k) + libm::log10(f64::from(m)))));
        all.filter(|(_, _, place)| *place >= self.low && *place <= self.high).collect()
    }

    /// What is written at the axis: decades, every so many where they are many, and with fewer than two of them
    /// twice and five times those as well.
    fn labels(&self) -> Vec<(i32, i32, f64)> {
        let decades = self.inside(&[1]);
        match decades.len() {
            0..2 => self.inside(&[1, 2, 5]),
            2 => self.inside(&[1, 3]),
            count => {
                let every = count as i32 / 9 + 1;
                decades.into_iter().filter(|(_, k, _)| k % every == 0).collect()
            }
        }
    }
}

/// The grid with its numbers, and the frame.
pub(super) fn draw(area: &Area<'_>, chart: &mut Chart<'_>, x: &Axis, y: &Axis) -> Drawn {
    let hair = |color: RGBColor| color.stroke_width(FINE as u32 * 8 / 10);
    for (factors, color) in [(&[2, 3, 4, 5, 6, 7, 8, 9][..], FINE_GRID), (&[1][..], GRID)] {
        // Beyond eight decades lines between them would be a grey surface.
        let is_fine = factors.len() > 1;
        for (_, _, place) in x.inside(factors).into_iter().filter(|_| !is_fine || x.high - x.low < 8.0) {
            chart.draw_series([PathElement::new([(place, y.low), (place, y.high)], hair(color))])?;
        }
        for (_, _, place) in y.inside(factors).into_iter().filter(|_| !is_fine || y.high - y.low < 8.0) {
            chart.draw_series([PathElement::new([(x.low, place), (x.high, place)], hair(color))])?;
        }
    }
    // Plain numbers from 0.01 to 9000, else powers, and one of the two along an axis.
    let is_plain = |labels: &[(i32, i32, f64)]| labels.iter().all(|(_, k, _)| (-2..=3).contains(k));
    let (of_x, of_y) = (x.labels(), y.labels());
    for &(m, k, place) in &of_x {
        let (px, _) = chart.backend_coord(&(place, y.low));
        let right = (px + 9 * FINE, (FRAME.3 + 17) * FINE);
        if is_plain(&of_x) {
            plain(area, m, k, (px, right.1), HPos::Center)?
        } else {
            power(area, m, k, right)?
        }
    }
    for &(m, k, place) in &of_y {
        let right = ((FRAME.0 - 8) * FINE, chart.backend_coord(&(x.low, place)).1);
        if is_plain(&of_y) { plain(area, m, k, right, HPos::Right)? } else { power(area, m, k, right)? }
    }
    let corners = [(x.low, y.high), (x.low, y.low), (x.high, y.low)];
    chart.draw_series([PathElement::new(corners, INK.stroke_width(FINE as u32 * 12 / 10))])?;
    Ok(())
}

/// m·10ᵏ in full.
fn plain(area: &Area<'_>, m: i32, k: i32, place: (i32, i32), side: HPos) -> Drawn {
    let text = match k {
        0.. => (i64::from(m) * 10_i64.pow(k.unsigned_abs())).to_string(),
        _ => format!("{:.*}", k.unsigned_abs() as usize, f64::from(m) * libm::exp10(f64::from(k))),
    };
    area.draw_text(&text, &font(13, INK).pos(Pos::new(side, VPos::Center)), place)
}

/// m·10ᵏ as a power, ending at `right`. The exponent is a text of its own, since not every font has raised digits.
fn power(area: &Area<'_>, m: i32, k: i32, right: (i32, i32)) -> Drawn {
    let exponent = format!("{}{}", if k < 0 { "−" } else { "" }, k.unsigned_abs());
    let base = if m == 1 { "10".to_string() } else { format!("{m}·10") };
    // A digit of this size is some six points wide; the minus sign is wider.
    let width = 6 * FINE * exponent.chars().count() as i32 + if k < 0 { 2 * FINE } else { 0 };
    let style = font(13, INK).pos(Pos::new(HPos::Right, VPos::Center));
    area.draw_text(&base, &style, (right.0 - width, right.1))?;
    let raised = font(10, INK).pos(Pos::new(HPos::Left, VPos::Center));
    area.draw_text(&exponent, &raised, (right.0 - width + FINE, right.1 - 6 * FINE))
}
