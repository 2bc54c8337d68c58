//! Environments from pictures: an equirectangular map of all directions.
//!
//! In the map's own axes u = atan2(x, −z)/2π mod 1 and v = arccos(y)/π: the middle of the picture lies at +z, its left
//! border at −z, +x a quarter from the left, and the zenith, +y, is its upper border. Between the middles of its texels
//! the map is bilinear; it goes round in u and stays as it is beyond the outermost rows.

use crate::math::approx::{angle, sin_cos_turn};
use crate::math::digest::Digest;
use crate::math::distribution::GridTable;
use crate::math::{DVec3, Rgb, Vec3, luminance};
use rayon::prelude::*;
use std::f32::consts::{FRAC_1_PI, PI};
use std::sync::OnceLock;

/// The highest radiance that a texel may have; scene files have the same limit.
pub const HIGHEST: f32 = 1e12;

/// A map of the radiance from all directions.
#[derive(Clone, Debug, PartialEq)]
pub struct Panorama {
    size: [usize; 2],
    /// Row by row from the top.
    texels: Vec<[f32; 3]>,
    /// The map's x, y and z axes in scene coordinates.
    axes: [Vec3; 3],
    /// Mean over the sphere.
    mean: Rgb,
    /// Sampling tables, made when they are first needed: with and without MIS compensation.
    tables: [OnceLock<Option<Density>>; 2],
}

/// What a picture held that no radiance can be.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Repairs {
    /// Components that were not numbers; black now.
    pub nan: usize,
    /// Negative components; black now.
    pub negative: usize,
    /// Components beyond [`HIGHEST`]; that now. Infinite ones: the picture's highest.
    pub huge: usize,
}

/// How directions are chosen: with a density per area of the map that is itself bilinear between the texels' weights.
#[derive(Clone, Debug, PartialEq)]
struct Density {
    table: GridTable,
    /// What is taken off a texel's luminance.
    floor: f32,
    /// Texels over the sum of weights: a weight's density per area of the map.
    norm: f32,
}

/// Makes texels radiances, and says what was wrong with them.
pub fn repair(texels: &mut [[f32; 3]]) -> Repairs {
    let values = texels.iter().flatten().copied();
    let highest = values.filter(|v| v.is_finite()).fold(0.0, f32::max).min(HIGHEST);
    let mut repairs = Repairs::default();
    for value in texels.iter_mut().flatten() {
        let (count, sound) = match *value {
            v if v.is_nan() => (&mut repairs.nan, 0.0),
            v if v < 0.0 => (&mut repairs.negative, 0.0),
            f32::INFINITY => (&mut repairs.huge, highest),
            v if v > HIGHEST => (&mut repairs.huge, HIGHEST),
            _ => continue,
        };
        *count += 1;
        *value = sound;
    }
    repairs
}

/// The axes of a map whose zenith is `up`, turned by `degrees` about it, counter-clockwise seen from above. With `up` = +y
/// and no turn they are the scene's own; else the map's +z is where the front of a scene with that `up` is.
pub fn axes(up: DVec3, front: DVec3, degrees: f64) -> [Vec3; 3] {
    let x = up.cross(front);
    let (s, c) = if degrees % 360.0 == 0.0 {
        (0.0, 1.0)
    } else {
        (libm::sin(degrees.to_radians()), libm::cos(degrees.to_radians()))
    };
    [x * c - front * s, up, front * c + x * s].map(|a| a.as_vec3())
}

impl Panorama {
    /// A map of `size` = [width, height] texels, row by row from the top, which [`repair`] has passed. `None` when there
    /// are not as many, or none.
    pub fn new(size: [usize; 2], texels: Vec<[f32; 3]>, axes: [Vec3; 3]) -> Option<Panorama> {
        if texels.is_empty() || size[0].checked_mul(size[1]) != Some(texels.len()) {
            return None;
        }
        let mut map = Panorama { size, texels, axes, mean: Rgb::ZERO, tables: Default::default() };
        map.mean = map.average();
        Some(map)
    }

    /// Adds the map to `digest`.
    pub fn digest(&self, digest: &mut Digest) {
        // The mean and the tables follow from the texels.
        let Panorama { size, texels, axes, mean: _, tables: _ } = self;
        digest.value(&(size, axes));
        digest.floats(texels);
    }

    /// The mean radiance over the sphere.
    pub fn mean(&self) -> Rgb {
        self.mean
    }

    /// ∫L dω/4π with every row weighted by its share of the sphere, (cos θ₀ − cos θ₁)/2.
    fn average(&self) -> Rgb {
        let [width, height] = self.size;
        let cos = |y: usize| libm::cos(std::f64::consts::PI * y as f64 / height as f64);
        let row = |(y, row): (usize, &[[f32; 3]])| {
            let sum: DVec3 = row.iter().map(|t| DVec3::from(t.map(f64::from))).sum();
            sum * (0.5 * (cos(y) - cos(y + 1)) / width as f64)
        };
        let rows: Vec<DVec3> = self.texels.par_chunks(width).enumerate().map(row).collect();
        rows.into_iter().sum::<DVec3>().as_vec3()
    }

    /// Where a unit direction lies on the map.
    #[inline(always)]
    fn place(&self, d: Vec3) -> [f32; 2] {
        let [x, y, z] = self.axes.map(|a| a.dot(d));
        let turn = angle(x.abs(), -z) * (0.5 * FRAC_1_PI);
        [if x < 0.0 { 1.0 - turn } else { turn }, angle((x * x + z * z).sqrt(), y) * FRAC_1_PI]
    }

    /// The four texels around a place, and the shares of the right and of the lower ones.
    #[inline(always)]
    fn around(&self, [u, v]: [f32; 2]) -> ([[usize; 2]; 2], [f32; 2]) {
        let [width, height] = self.size;
        let (x, y) = (u * width as f32 - 0.5, v * height as f32 - 0.5);
        let (x0, y0) = (x.floor(), y.floor());
        let column = |i: isize| i.rem_euclid(width as isize) as usize;
        let row = |i: isize| i.clamp(0, height as isize - 1) as usize;
        let (i, j) = (x0 as isize, y0 as isize);
        ([[column(i), column(i + 1)], [row(j), row(j + 1)]], [x - x0, y - y0])
    }

    #[inline(always)]
    fn texel(&self, x: usize, y: usize) -> Rgb {
        Rgb::from(self.texels[y * self.size[0] + x])
    }

    /// Radiance that arrives from the unit direction `d`.
    #[inline]
    pub fn le(&self, d: Vec3) -> Rgb {
        self.le_at(self.place(d))
    }

    #[inline(always)]
    fn le_at(&self, place: [f32; 2]) -> Rgb {
        let ([[x0, x1], [y0, y1]], [s, t]) = self.around(place);
        // a + (b − a)·s is exact where both are equal, so a constant map is that constant.
        let mix = |a: Rgb, b: Rgb, s: f32| a + (b - a) * s;
        let above = mix(self.texel(x0, y0), self.texel(x1, y0), s);
        mix(above, mix(self.texel(x0, y1), self.texel(x1, y1), s), t)
    }

    /// A texel's weight: its luminance above `floor`, times the sine of its row, for texels near a pole are small.
    #[inline(always)]
    fn weight(&self, floor: f32, x: usize, y: usize) -> f32 {
        let (sin, _) = sin_cos_turn((y as f32 + 0.5) / (2.0 * self.size[1] as f32));
        (luminance(self.texel(x, y)) - floor).max(0.0) * sin
    }

    /// The density for light samples, compensated for the BSDF samples beside them or not; `None` where all weights are
    /// zero: a black map, or a compensated one that is everywhere about the same.
    ///
    /// Compensation (Karlík et al. 2019, "MIS Compensation") takes the mean off the weights: what is no brighter than
    /// that is found by BSDF samples, and light samples go where they are needed.
    fn density(&self, compensated: bool) -> Option<&Density> {
        self.tables[usize::from(compensated)]
            .get_or_init(|| {
                // A hair more than the mean, so that rounding makes no light of a constant map.
                let floor = if compensated { luminance(self.mean) * 1.001 } else { 0.0 };
                let [width, height] = self.size;
                let mut weights = vec![0.0; width * height];
                weights.par_chunks_mut(width).enumerate().for_each(|(y, row)| {
                    row.iter_mut().enumerate().for_each(|(x, w)| *w = self.weight(floor, x, y));
                });
                let table = GridTable::new(width, &weights)?;
                let norm = ((width * height) as f64 / table.total) as f32;
                norm.is_finite().then_some(Density { table, floor, norm })
            })
            .as_ref()
    }

    /// True when [`Panorama::sample`] finds something.
    pub fn has_density(&self, compensated: bool) -> bool {
        self.density(compensated).is_some()
    }

    /// Density per solid angle at a place, whose polar angle has the sine `sin`: per area of the map over 2π²·sin θ.
    #[inline(always)]
    fn pdf_at(&self, density: &Density, place: [f32; 2], sin: f32) -> f32 {
        let ([[x0, x1], [y0, y1]], [s, t]) = self.around(place);
        let w = |x: usize, y: usize| self.weight(density.floor, x, y);
        let mix = |a: f32, b: f32, s: f32| a + (b - a) * s;
        let weight = mix(mix(w(x0, y0), w(x1, y0), s), mix(w(x0, y1), w(x1, y1), s), t);
        weight * density.norm / (2.0 * PI * PI * sin.max(1e-12))
    }

    /// A direction by importance, its density per solid angle and the radiance from there: a texel is chosen, and in the
    /// tent around its middle a place, so that the density is bilinear as the map itself is.
    #[inline]
    pub fn sample(&self, compensated: bool, u: [f32; 2]) -> Option<(Vec3, f32, Rgb)> {
        let density = self.density(compensated)?;
        let ([x, y], rest) = density.table.sample(u);
        let [width, height] = self.size.map(|n| n as f32);
        let column = (x as f32 + 0.5 + tent(rest[0])) / width;
        // Beyond the outermost rows the tent is folded back: there the map stays as it is.
        let row = (y as f32 + 0.5 + tent(rest[1])) / height;
        let row = if row < 0.0 { -row } else { row };
        let row = if row > 1.0 { 2.0 - row } else { row };
        let place = [(column - column.floor()).min(1.0 - 0.5 * f32::EPSILON), row];
        let (sin, cos) = sin_cos_turn(0.5 * row);
        let (s, c) = sin_cos_turn(place[0]);
        let [ax, ay, az] = self.axes;
        let wi = ax * (sin * s) + ay * cos - az * (sin * c);
        Some((wi, self.pdf_at(density, place, sin), self.le_at(place)))
    }

    /// Density of [`Panorama::sample`] per solid angle.
    #[inline]
    pub fn pdf(&self, compensated: bool, wi: Vec3) -> f32 {
        let Some(density) = self.density(compensated) else { return 0.0 };
        self.pdf_at(density, self.place(wi), wi.cross(self.axes[1]).length())
    }
}

/// A number in [−1, 1] with density 1 − |t|.
#[inline(always)]
fn tent(u: f32) -> f32 {
    if u < 0.5 { (2.0 * u).sqrt() - 1.0 } else { 1.0 - (2.0 - 2.0 * u).sqrt() }
}

#[cfg(test)]
#[path = "panorama_tests.rs"]
mod tests;
