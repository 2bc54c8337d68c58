//! What tells curves apart: colours that the colour-blind can tell too, and marks of different shapes.

use super::{Area, Drawn, FINE};
use plotters::prelude::*;

/// A curve's colour and mark.
pub(super) struct Style {
    /// The colour of the line and the marks.
    pub color: RGBColor,
    /// The mark's corners around its middle, in tenths of a point.
    shape: &'static [(i32, i32)],
}

/// The palette of Okabe and Ito (2008) without its yellow, which is too faint on white; the most used first.
const COLORS: [RGBColor; 7] = [
    RGBColor(0x00, 0x72, 0xb2),
    RGBColor(0xd5, 0x5e, 0x00),
    RGBColor(0x00, 0x9e, 0x73),
    RGBColor(0xcc, 0x79, 0xa7),
    RGBColor(0xe6, 0x9f, 0x00),
    RGBColor(0x56, 0xb4, 0xe9),
    RGBColor(0x00, 0x00, 0x00),
];

/// Octagon, square, triangle, diamond, triangle, plus, star, cross, bars. Ten and seven have no common divisor, so
/// seventy curves differ.
const SHAPES: [&[(i32, i32)]; 10] = [
    &[(18, 43), (43, 18), (43, -18), (18, -43), (-18, -43), (-43, -18), (-43, 18), (-18, 43)],
    &[(-38, -38), (38, -38), (38, 38), (-38, 38)],
    &[(0, -52), (48, 34), (-48, 34)],
    &[(0, -55), (55, 0), (0, 55), (-55, 0)],
    &[(0, 52), (48, -34), (-48, -34)],
    &[
        (-17, -50),
        (17, -50),
        (17, -17),
        (50, -17),
        (50, 17),
        (17, 17),
        (17, 50),
        (-17, 50),
        (-17, 17),
        (-50, 17),
        (-50, -17),
        (-17, -17),
    ],
    &[
        (0, -60),
        (16, -20),
        (58, -18),
        (25, 8),
        (36, 48),
        (0, 25),
        (-36, 48),
        (-25, 8),
        (-58, -18),
        (-16, -20),
    ],
    &[
        (-24, -48),
        (0, -24),
        (24, -48),
        (48, -24),
        (24, 0),
        (48, 24),
        (24, 48),
        (0, 24),
        (-24, 48),
        (-48, 24),
        (-24, 0),
        (-48, -24),
    ],
    &[(-55, -20), (55, -20), (55, 20), (-55, 20)],
    &[(-20, -55), (20, -55), (20, 55), (-20, 55)],
];

impl Style {
    /// The style of curve `i`.
    pub fn numbered(i: usize) -> Style {
        Style { color: COLORS[i % COLORS.len()], shape: SHAPES[i % SHAPES.len()] }
    }
}

/// Draws a mark: full, or hollow where the point was not fitted. A thin white edge keeps marks apart that lie on
/// each other.
pub(super) fn draw(area: &Area<'_>, place: (i32, i32), style: &Style, is_full: bool) -> Drawn {
    let corner = |(x, y): &(i32, i32)| (place.0 + x * FINE / 10, place.1 + y * FINE / 10);
    let corners: Vec<(i32, i32)> = style.shape.iter().map(corner).collect();
    let outline: Vec<(i32, i32)> = corners.iter().chain(&corners[..2]).copied().collect();
    let (inside, edge) = if is_full { (style.color, WHITE) } else { (WHITE, style.color) };
    let width = if is_full { FINE * 8 / 10 } else { FINE * 15 / 10 } as u32;
    area.draw(&Polygon::new(corners, inside.filled()))?;
    area.draw(&PathElement::new(outline, edge.stroke_width(width)))
}
