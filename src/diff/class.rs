//! The classes of disagreements.

/// What a disagreement is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Class {
    /// Two triangles at one distance, or a hit within rounding of an end of the interval.
    Tie,
    /// The ray passes an edge within rounding.
    Edge,
    /// The ray passes a vertex within rounding.
    Vertex,
    /// The ray runs along the triangle, within rounding of its plane over its whole size, or nearly along one of its edges,
    /// so that rounding displaces that edge farther than others.
    Graze,
    /// The triangle, as the ray sees it, is no wider than rounding.
    Sliver,
    /// An answer is wrong.
    Real,
}

impl Class {
    /// Every class, in the order of the report.
    pub const ALL: [Class; 6] =
        [Class::Tie, Class::Edge, Class::Vertex, Class::Graze, Class::Sliver, Class::Real];

    /// Its name in the report.
    pub fn name(self) -> &'static str {
        match self {
            Class::Tie => "tie",
            Class::Edge => "edge",
            Class::Vertex => "vertex",
            Class::Graze => "graze",
            Class::Sliver => "sliver",
            Class::Real => "real",
        }
    }
}

/// A disagreement, judged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Finding {
    /// What it is about.
    pub class: Class,
    /// One answer went through a crack: on all sides of the ray there is a surface.
    pub leak: bool,
    /// Which of the two answers f64 refutes.
    pub wrong: [bool; 2],
}
