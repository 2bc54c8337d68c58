//! Normal and height maps: the shading normal is turned, the surface stays where it is.

use super::Texture;
use crate::math::{Vec2, Vec3};
use crate::shape::Mesh;

/// How a triangle carries texture coordinates.
#[derive(Clone, Copy, Debug)]
pub struct Tangents {
    /// The point's derivative by u, in metres a unit of texture coordinates.
    pub dpdu: Vec3,
    /// The same by v.
    pub dpdv: Vec3,
}

impl Tangents {
    /// Of a triangle with texture coordinates `uvs`; `None` where they or the corners are on one line.
    pub fn new(mesh: &Mesh, triangle: usize, uvs: [Vec2; 3]) -> Option<Tangents> {
        let [a, b, c] = mesh.triangle(triangle);
        let (e1, e2) = (b - a, c - a);
        let (d1, d2) = (uvs[1] - uvs[0], uvs[2] - uvs[0]);
        let area = d1.x * d2.y - d1.y * d2.x;
        let dpdu = (e1 * d2.y - e2 * d1.y) / area;
        let dpdv = (e2 * d1.x - e1 * d2.x) / area;
        let sound = dpdu.is_finite() && dpdv.is_finite() && dpdu.cross(dpdv).length_squared() > 0.0;
        sound.then_some(Tangents { dpdu, dpdv })
    }

    /// Unit vectors along growing u and, at right angles to it, on the side of growing v, both at right angles to the unit
    /// normal `n`; `None` where u grows along the normal.
    pub fn around(&self, n: Vec3) -> Option<[Vec3; 2]> {
        let t = (self.dpdu - n * n.dot(self.dpdu)).try_normalize()?;
        // Mirrored texture coordinates have their v on the other side.
        let b = n.cross(t);
        Some([t, b * 1.0f32.copysign(b.dot(self.dpdv))])
    }
}

/// What a relief's picture holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// Normals: red along growing u, green along growing v, blue outwards; the middle code is zero. The number
    /// multiplies the tilt.
    Normal(f32),
    /// Heights. The number is how far white stands above black, in widths of the picture on the surface.
    Height(f32),
}

/// A relief.
#[derive(Clone, Debug, PartialEq)]
pub struct Relief {
    /// The picture.
    pub map: Texture,
    /// What it holds.
    pub shape: Shape,
}

impl Relief {
    /// The shading normal `ns` (unit, on the side of `ng`) as the relief turns it; unit and on the side of `ng`.
    pub fn normal(&self, ns: Vec3, ng: Vec3, tangents: &Tangents, uv: Vec2) -> Vec3 {
        let turned = match self.shape {
            Shape::Normal(strength) => self.mapped(ns, tangents, uv, strength),
            Shape::Height(height) => self.raised(ns, tangents, uv, height),
        };
        let turned = turned.try_normalize().unwrap_or(ns);
        // A normal that looks into the surface is bent back until it is just outside.
        const GRAZING: f32 = 1e-3;
        let front = turned.dot(ng);
        if front >= GRAZING { turned } else { (turned + ng * (GRAZING - front)).normalize_or(ns) }
    }

    /// The picture's normal in the frame of the texture's directions.
    fn mapped(&self, ns: Vec3, tangents: &Tangents, uv: Vec2, strength: f32) -> Vec3 {
        let middle = self.map.texels().middle();
        let n = (self.map.rgb(uv) - middle) / (1.0 - middle);
        let Some([t, b]) = tangents.around(ns) else { return ns };
        (t * n.x + b * n.y) * strength + ns * n.z
    }

    /// The normal of the surface moved by the height along `ns`: ns − ∇h (Mikkelsen 2010, "Bump Mapping Unparametrized
    /// Surfaces on the GPU", eq. 4), where the height's gradient is a difference over one texel.
    fn raised(&self, ns: Vec3, tangents: &Tangents, uv: Vec2, height: f32) -> Vec3 {
        let scale = self.map.mapping().scale;
        let [width, rows] = self.map.texels().size();
        let step = |scale: f32, texels: u32| 1.0 / (scale.abs().max(1e-6) * texels as f32);
        let (du, dv) = (Vec2::new(step(scale[0], width), 0.0), Vec2::new(0.0, step(scale[1], rows)));
        let slope = |d: Vec2| (self.map.number(uv + d * 0.5) - self.map.number(uv - d * 0.5)) / (d.x + d.y);
        let (hu, hv) = (slope(du), slope(dv));
        let normal = tangents.dpdu.cross(tangents.dpdv);
        // Metres a width of the picture: the root of the area that it covers.
        let metres = (normal.length() / (scale[0] * scale[1]).abs().max(1e-12)).sqrt();
        let gradient = (tangents.dpdv.cross(ns) * hu + ns.cross(tangents.dpdu) * hv) / ns.dot(normal);
        let turned = ns - gradient * (height * metres);
        if turned.is_finite() { turned } else { ns }
    }
}
