//! Chunks of rays and of hits, structure of arrays, and the gate that every ray passes.

use crate::math::Vec3;

/// Rays in a chunk.
pub const LANES: usize = 16;

/// One bit a lane of a chunk, lane 0 the lowest.
pub type Mask = u16;

/// Each of `lanes`, the lowest first. A loop over them has no closure, which a compiler may leave as a function of its own,
/// compiled for the least of all machines.
#[inline(always)]
pub(crate) fn lanes_of(lanes: Mask) -> LanesOf {
    LanesOf(lanes)
}

/// See [`lanes_of`].
pub(crate) struct LanesOf(Mask);

impl Iterator for LanesOf {
    type Item = usize;

    #[inline(always)]
    fn next(&mut self) -> Option<usize> {
        let lane = self.0.trailing_zeros() as usize;
        let some = self.0 != 0;
        self.0 &= self.0.wrapping_sub(1);
        some.then_some(lane % LANES)
    }
}

/// In [`Hits::mesh`]: nothing was hit.
pub const MISS: u32 = u32::MAX;

/// The largest magnitude that a component of a ray may have (Embree's own limit is 1.844e18).
pub const LARGEST: f32 = 1e18;

/// A chunk of rays, structure of arrays.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub struct Rays {
    /// Origins, x.
    pub ox: [f32; LANES],
    /// Origins, y.
    pub oy: [f32; LANES],
    /// Origins, z.
    pub oz: [f32; LANES],
    /// Start of the interval, in multiples of the direction's length; not negative.
    pub tmin: [f32; LANES],
    /// Directions, x; need not be unit.
    pub dx: [f32; LANES],
    /// Directions, y.
    pub dy: [f32; LANES],
    /// Directions, z.
    pub dz: [f32; LANES],
    /// End of the interval; [`f32::INFINITY`] is allowed here and only here.
    pub tmax: [f32; LANES],
}

impl Default for Rays {
    /// Sixteen rays that hit nothing: zero origin and direction, empty interval.
    fn default() -> Self {
        let zero = [0.0; LANES];
        Rays { ox: zero, oy: zero, oz: zero, tmin: [1.0; LANES], dx: zero, dy: zero, dz: zero, tmax: zero }
    }
}

impl Rays {
    /// Sets one lane.
    #[inline]
    pub fn set(&mut self, lane: usize, o: Vec3, d: Vec3, tmin: f32, tmax: f32) {
        (self.ox[lane], self.oy[lane], self.oz[lane]) = (o.x, o.y, o.z);
        (self.dx[lane], self.dy[lane], self.dz[lane]) = (d.x, d.y, d.z);
        (self.tmin[lane], self.tmax[lane]) = (tmin, tmax);
    }

    /// One lane's origin.
    #[inline]
    pub fn o(&self, lane: usize) -> Vec3 {
        Vec3::new(self.ox[lane], self.oy[lane], self.oz[lane])
    }

    /// One lane's direction.
    #[inline]
    pub fn d(&self, lane: usize) -> Vec3 {
        Vec3::new(self.dx[lane], self.dy[lane], self.dz[lane])
    }

    /// The gate: keeps those lanes of `active` whose numbers a backend may see. A lane is refused when a
    /// component of origin or direction or an end of the interval is NaN or beyond [`LARGEST`] in
    /// magnitude (`tmax = +∞` passes), or when `tmin` is negative (Embree asserts that it is not).
    #[inline]
    pub fn check(&self, active: Mask) -> Checked<'_> {
        let mut sound = 0;
        for lane in 0..LANES {
            // NaN fails every comparison, so it needs no test of its own.
            let ok = (self.ox[lane].abs() <= LARGEST)
                & (self.oy[lane].abs() <= LARGEST)
                & (self.oz[lane].abs() <= LARGEST)
                & (self.dx[lane].abs() <= LARGEST)
                & (self.dy[lane].abs() <= LARGEST)
                & (self.dz[lane].abs() <= LARGEST)
                & ((self.tmin[lane] >= 0.0) & (self.tmin[lane] <= LARGEST))
                & ((self.tmax[lane].abs() <= LARGEST) | (self.tmax[lane] == f32::INFINITY));
            sound |= (ok as Mask) << lane;
        }
        Checked {
            rays: self,
            active: active & sound,
            rejected: (active & !sound).count_ones(),
            times: &OPENING,
        }
    }
}

/// The times of rays that leave when the shutter opens.
static OPENING: [f32; LANES] = [0.0; LANES];

/// Rays that passed [`Rays::check`]; every active lane is finite.
#[derive(Clone, Copy, Debug)]
pub struct Checked<'a> {
    rays: &'a Rays,
    active: Mask,
    rejected: u32,
    times: &'a [f32; LANES],
}

impl<'a> Checked<'a> {
    /// The rays. Lanes that are not active may hold anything, NaN included.
    #[inline]
    pub fn rays(&self) -> &'a Rays {
        self.rays
    }

    /// The lanes to trace.
    #[inline]
    pub fn active(&self) -> Mask {
        self.active
    }

    /// The same rays, of which only those in `lanes` are traced.
    #[cfg(feature = "embree")]
    #[inline]
    #[must_use]
    pub(crate) fn only(self, lanes: Mask) -> Checked<'a> {
        Checked { active: self.active & lanes, ..self }
    }

    /// The same rays, each at a time: 0 when the shutter opens, 1 when it closes. Matters where things move alone.
    #[inline]
    #[must_use]
    pub fn at(self, times: &'a [f32; LANES]) -> Checked<'a> {
        Checked { times, ..self }
    }

    /// When the rays are under way; as the shutter opens, unless they were said to be [`Checked::at`] other times.
    #[inline]
    pub fn times(&self) -> &'a [f32; LANES] {
        self.times
    }

    /// How many lanes the gate refused.
    #[inline]
    pub fn rejected(&self) -> u32 {
        self.rejected
    }
}

/// The closest hits of a chunk, structure of arrays. Lanes that were not active are left as they were.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub struct Hits {
    /// Distance in multiples of the ray direction's length.
    pub t: [f32; LANES],
    /// Barycentric weight of the second corner.
    pub u: [f32; LANES],
    /// Barycentric weight of the third corner.
    pub v: [f32; LANES],
    /// Index of the mesh; [`MISS`] where nothing was hit. Instances go on counting after the meshes ([`super::Geometry`]).
    pub mesh: [u32; LANES],
    /// Index of the triangle in its mesh.
    pub triangle: [u32; LANES],
}

impl Default for Hits {
    /// Sixteen misses.
    fn default() -> Self {
        Hits {
            t: [f32::INFINITY; LANES],
            u: [0.0; LANES],
            v: [0.0; LANES],
            mesh: [MISS; LANES],
            triangle: [MISS; LANES],
        }
    }
}

impl Hits {
    /// One lane's hit; `None` where nothing was hit.
    #[inline]
    pub fn get(&self, lane: usize) -> Option<Hit> {
        let (mesh, triangle) = (self.mesh[lane], self.triangle[lane]);
        (mesh != MISS).then(|| Hit { t: self.t[lane], u: self.u[lane], v: self.v[lane], mesh, triangle })
    }
}

/// What one ray hit; the fields are those of [`Hits`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance in multiples of the ray direction's length.
    pub t: f32,
    /// Barycentric weight of the second corner.
    pub u: f32,
    /// Barycentric weight of the third corner.
    pub v: f32,
    /// Index of the mesh.
    pub mesh: u32,
    /// Index of the triangle in its mesh.
    pub triangle: u32,
}
