//! How things move while the shutter is open: poses at points of time, and what lies between them.
//!
//! Between two poses scale and translation go in straight lines, and the rotation turns at an even speed about one
//! axis: a wheel stays a wheel. (The straight line between two matrices would shrink it on the way.) Where both poses
//! state their rotation about the same axis, the angles are taken as they are, so that 720° are two turns; else the
//! shortest turn leads from one to the other. Before the first pose and after the last all is at rest.

use super::Bounds64;
use crate::error::{Error, Result};
use crate::math::{DMat4, DVec3};
use glam::{DAffine3, DMat3, DQuat};

/// Scale (or stretch along any axes), then a rotation, then a translation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    stretch: DMat3,
    /// Unit axis and degrees, of any number of turns; `None`: nothing is said.
    turn: Option<(DVec3, f64)>,
    translation: DVec3,
}

impl Pose {
    /// Everything stays where it is.
    pub const IDENTITY: Pose = Pose { stretch: DMat3::IDENTITY, turn: None, translation: DVec3::ZERO };

    /// Factors along the axes, a turn about the unit axis by so many degrees, then a shift in metres.
    pub fn new(scale: DVec3, turn: Option<(DVec3, f64)>, translation: DVec3) -> Pose {
        Pose { stretch: DMat3::from_diagonal(scale), turn, translation }
    }

    /// The parts of an affine matrix; `None` where it is not invertible.
    ///
    /// Polar decomposition: the mean of a matrix and its inverse transpose, again and again, leads to the rotation
    /// nearest to it (N. Higham, "Computing the Polar Decomposition", 1986); what is left is the stretch.
    pub fn of_matrix(matrix: DMat4) -> Option<Pose> {
        let linear = DMat3::from_mat4(matrix);
        let mirror = linear.determinant().signum();
        let mut rotation = linear * mirror;
        for _ in 0..64 {
            let inverse = rotation.transpose().inverse();
            // Scaled so that it converges in a few steps however large the matrix is.
            let scale = (norm(&inverse) / norm(&rotation)).sqrt();
            let next = (rotation * scale + inverse * (1.0 / scale)) * 0.5;
            let moved = norm(&(next - rotation));
            rotation = next;
            if moved <= 1e-15 {
                break;
            }
        }
        if !rotation.is_finite() {
            return None;
        }
        let turn = axis_and_angle(&rotation);
        let translation = matrix.w_axis.truncate();
        Some(Pose { stretch: rotation.transpose() * linear, turn: Some(turn), translation })
    }

    fn rotation(&self) -> DMat3 {
        self.turn.map_or(DMat3::IDENTITY, |(axis, degrees)| rotation(axis, degrees))
    }

    /// The whole as a transform.
    pub fn affine(&self) -> DAffine3 {
        DAffine3 { matrix3: self.rotation() * self.stretch, translation: self.translation }
    }

    /// True where lengths stay what they are.
    pub fn is_rigid(&self) -> bool {
        self.stretch.abs_diff_eq(DMat3::IDENTITY, 1e-9)
    }
}

/// Largest sum of magnitudes in a column.
fn norm(m: &DMat3) -> f64 {
    [m.x_axis, m.y_axis, m.z_axis].iter().map(|c| c.abs().element_sum()).fold(0.0, f64::max)
}

/// The axis and the angle in degrees, 0 to 180, of a rotation.
fn axis_and_angle(rotation: &DMat3) -> (DVec3, f64) {
    let q = DQuat::from_mat3(rotation);
    let q = if q.w < 0.0 { -q } else { q };
    let sin = q.xyz().length();
    let angle = 2.0 * libm::atan2(sin, q.w).to_degrees();
    (q.xyz().try_normalize().unwrap_or(DVec3::Y), angle)
}

/// Rodrigues' formula. Multiples of 90° are exact, and libm's functions are the same on every machine.
pub fn rotation(axis: DVec3, degrees: f64) -> DMat3 {
    let turn = degrees.rem_euclid(360.0);
    let (sin, cos) = match turn {
        0.0 => (0.0, 1.0),
        90.0 => (1.0, 0.0),
        180.0 => (0.0, -1.0),
        270.0 => (-1.0, 0.0),
        _ => (libm::sin(turn.to_radians()), libm::cos(turn.to_radians())),
    };
    let column = |v: DVec3| v * cos + axis.cross(v) * sin + axis * (axis.dot(v) * (1.0 - cos));
    DMat3::from_cols(column(DVec3::X), column(DVec3::Y), column(DVec3::Z))
}

/// From one pose to the next.
#[derive(Clone, Debug, PartialEq)]
struct Leg {
    begin: f64,
    end: f64,
    poses: [Pose; 2],
    /// The rotation at the beginning, and the turn that follows: unit axis, degrees.
    start: DMat3,
    axis: DVec3,
    degrees: f64,
}

/// Poses at points of time, at least one.
#[derive(Clone, Debug, PartialEq)]
pub struct Motion {
    first: Pose,
    legs: Vec<Leg>,
}

impl Motion {
    /// The motion through `poses`, each at its time in seconds.
    ///
    /// # Errors
    /// No pose, times that do not ascend, or a body that would turn inside out between two of them.
    pub fn new(poses: &[(f64, Pose)]) -> Result<Motion> {
        let Some((_, first)) = poses.first() else { return Err(Error::new("no pose")) };
        let legs = poses.iter().zip(poses.iter().skip(1)).map(|(a, b)| Leg::new(*a, *b));
        Ok(Motion { first: *first, legs: legs.collect::<Result<_>>()? })
    }

    /// Where things are at a time.
    pub fn at(&self, time: f64) -> DAffine3 {
        let after = self.legs.partition_point(|leg| leg.begin <= time);
        match after.checked_sub(1).and_then(|i| self.legs.get(i)) {
            None => self.first.affine(),
            Some(leg) => leg.at(time),
        }
    }

    /// True when nothing moves between the two times.
    pub fn rests(&self, [open, close]: [f64; 2]) -> bool {
        self.legs.iter().all(|leg| leg.end <= open || leg.begin >= close || leg.poses[0] == leg.poses[1])
            || open >= close
    }

    /// True when every pose keeps lengths.
    pub fn is_rigid(&self) -> bool {
        self.first.is_rigid() && self.legs.iter().all(|leg| leg.poses[1].is_rigid())
    }

    /// A box around everything in `bounds` at all times from `open` to `close`.
    pub fn bounds(&self, bounds: &Bounds64, [open, close]: [f64; 2]) -> Bounds64 {
        let mut swept = bounds.moved(&self.at(open)).union(&bounds.moved(&self.at(close)));
        for leg in self.legs.iter().filter(|leg| leg.begin < close && leg.end > open) {
            swept = swept.union(&leg.bounds(bounds, [leg.begin.max(open), leg.end.min(close)]));
        }
        swept
    }
}

impl Leg {
    fn new((begin, a): (f64, Pose), (end, b): (f64, Pose)) -> Result<Leg> {
        if begin.partial_cmp(&end) != Some(std::cmp::Ordering::Less) {
            return Err(Error::new(format!("time {end} does not come after {begin}"))
                .advise("list the poses by ascending time"));
        }
        // Linear interpolation keeps a definite stretch definite, so these are all that could go wrong.
        let flips = |m: &DMat3| [m.x_axis.x, m.y_axis.y, m.z_axis.z].map(f64::signum);
        if flips(&a.stretch) != flips(&b.stretch) {
            return Err(Error::new(format!("the scale passes 0 between the times {begin} and {end}"))
                .advise("keep the signs of the scales"));
        }
        let (start, (axis, degrees)) = (a.rotation(), turn(&a, &b));
        Ok(Leg { begin, end, poses: [a, b], start, axis, degrees })
    }

    fn share(&self, time: f64) -> f64 {
        ((time - self.begin) / (self.end - self.begin)).clamp(0.0, 1.0)
    }

    fn at(&self, time: f64) -> DAffine3 {
        let s = self.share(time);
        let [a, b] = &self.poses;
        if s == 0.0 || s == 1.0 {
            return if s == 0.0 { a.affine() } else { b.affine() };
        }
        let stretch = a.stretch * (1.0 - s) + b.stretch * s;
        let turned = rotation(self.axis, self.degrees * s) * self.start;
        DAffine3 { matrix3: turned * stretch, translation: a.translation.lerp(b.translation, s) }
    }

    /// A box around `bounds` over a part of the leg: those at points of time so near to each other that they turn by
    /// at most 0.1 radian in between, made larger by what a path can stray from its chord. Over a step h that is
    /// h²/8·|x″|, and of x = T + R·S·p with T and S linear and R turning at ω, |x″| ≤ ω²·|S·p| + 2·ω·|S′·p|.
    fn bounds(&self, bounds: &Bounds64, [open, close]: [f64; 2]) -> Bounds64 {
        let part = self.share(close) - self.share(open);
        let angle = self.degrees.abs().to_radians() * part;
        let steps = (angle / 0.1).ceil().clamp(1.0, 4096.0);
        let [a, b] = &self.poses;
        let farthest =
            |m: &DMat3| bounds.corners().map(|p| (*m * p).length()).into_iter().fold(0.0, f64::max);
        let reach = farthest(&a.stretch).max(farthest(&b.stretch));
        let stray = (angle * angle * reach + 2.0 * angle * part * farthest(&(b.stretch - a.stretch)))
            / (8.0 * steps * steps);
        let at = |i: u32| bounds.moved(&self.at(open + (close - open) * f64::from(i) / steps));
        let swept = (0..=steps as u32).map(at).fold(Bounds64::EMPTY, |sum, b| sum.union(&b));
        swept.grown(stray.min(2.0 * reach))
    }
}

/// The turn from one pose to the next, about a unit axis, in degrees.
fn turn(a: &Pose, b: &Pose) -> (DVec3, f64) {
    match (a.turn, b.turn) {
        (None, None) => (DVec3::Y, 0.0),
        (None, Some((axis, to))) => (axis, to),
        (Some((axis, from)), None) => (axis, -from),
        (Some((axis, from)), Some((other, to))) if axis.dot(other).abs() > 1.0 - 1e-12 => {
            (axis, to * axis.dot(other).signum() - from)
        }
        _ => axis_and_angle(&(b.rotation() * a.rotation().transpose())),
    }
}

#[cfg(test)]
mod tests;
