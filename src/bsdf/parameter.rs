//! The numbers of materials by name: what a scene file sets once, and what a texture sets at every hit.

use crate::math::Rgb;

/// A number or colour of a material. [`super::Scatter::set`] gives it a value; a model has some of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Parameter {
    /// Share of light sent back.
    Reflectance,
    /// Share of light that leaves a sheet's other side.
    Transmittance,
    /// Phong's diffuse share.
    Diffuse,
    /// Phong's highlight, or the strength of a principled material's.
    Specular,
    /// Phong's exponent.
    Exponent,
    /// Perceptual roughness; GGX α is its square.
    Roughness,
    /// GGX α itself.
    Alpha,
    /// How much longer highlights are across the grain than along it.
    Anisotropy,
    /// Index of refraction of the inside.
    Ior,
    /// Colour of the light that passes a boundary.
    Tint,
    /// Colour of a principled material.
    BaseColor,
    /// How much of a principled material is metal.
    Metallic,
    /// How much of what is no metal lets light through.
    Transmission,
    /// Strength of the clear coat.
    Coat,
    /// Roughness of the clear coat.
    CoatRoughness,
    /// Strength of the sheen at grazing angles.
    Sheen,
    /// How much the sheen takes the base colour.
    SheenTint,
    /// Width of the sheen.
    SheenRoughness,
    /// Emitted radiance; the material's own, no BSDF has it.
    Emission,
    /// The share of hits that count; the material's own, no BSDF has it.
    Opacity,
}

/// Whether a parameter has three channels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Channels {
    /// A colour: linear RGB; 8-bit pictures of it are sRGB.
    Color,
    /// One number: the first channel of its value; pictures of it are linear.
    Number,
}

impl Parameter {
    /// Every parameter with its key in scene files, its channels and its range.
    pub const NAMES: &'static [(Parameter, &'static str, Channels, [f64; 2])] = &[
        (Parameter::Reflectance, "reflectance", Channels::Color, [0.0, 1.0]),
        (Parameter::Transmittance, "transmittance", Channels::Color, [0.0, 1.0]),
        (Parameter::Diffuse, "diffuse", Channels::Color, [0.0, 1.0]),
        (Parameter::Specular, "specular", Channels::Color, [0.0, 1.0]),
        (Parameter::Exponent, "exponent", Channels::Number, [0.0, 1e6]),
        (Parameter::Roughness, "roughness", Channels::Number, [0.0, 1.0]),
        (Parameter::Alpha, "alpha", Channels::Number, [0.0, 1.0]),
        (Parameter::Anisotropy, "anisotropy", Channels::Number, [-1.0, 1.0]),
        (Parameter::Ior, "ior", Channels::Number, [0.1, 10.0]),
        (Parameter::Tint, "tint", Channels::Color, [0.0, 1.0]),
        (Parameter::BaseColor, "base_color", Channels::Color, [0.0, 1.0]),
        (Parameter::Metallic, "metallic", Channels::Number, [0.0, 1.0]),
        (Parameter::Transmission, "transmission", Channels::Number, [0.0, 1.0]),
        (Parameter::Coat, "coat", Channels::Number, [0.0, 1.0]),
        (Parameter::CoatRoughness, "coat_roughness", Channels::Number, [0.0, 1.0]),
        (Parameter::Sheen, "sheen", Channels::Number, [0.0, 1.0]),
        (Parameter::SheenTint, "sheen_tint", Channels::Number, [0.0, 1.0]),
        (Parameter::SheenRoughness, "sheen_roughness", Channels::Number, [0.0, 1.0]),
        (Parameter::Emission, "emission", Channels::Color, [0.0, 1e12]),
        (Parameter::Opacity, "opacity", Channels::Number, [0.0, 1.0]),
    ];

    /// The parameter of that key.
    pub fn named(key: &str) -> Option<Parameter> {
        Parameter::NAMES.iter().find(|row| row.1 == key).map(|row| row.0)
    }

    /// The parameter's line of [`Parameter::NAMES`], which are in the order of the variants.
    #[inline(always)]
    fn row(self) -> &'static (Parameter, &'static str, Channels, [f64; 2]) {
        &Parameter::NAMES[self as usize]
    }

    /// Its key in scene files.
    pub fn key(self) -> &'static str {
        self.row().1
    }

    /// Colour or number.
    pub fn channels(self) -> Channels {
        self.row().2
    }

    /// The values that it takes.
    pub fn range(self) -> [f32; 2] {
        self.row().3.map(|end| end as f32)
    }

    /// `value` brought into the range; what is not a number becomes the lower end.
    #[inline(always)]
    pub fn clamp(self, value: Rgb) -> Rgb {
        let [low, high] = self.range();
        // f32::max takes the number where the other is none.
        let one = |x: f32| x.max(low).min(high);
        Rgb::new(one(value.x), one(value.y), one(value.z))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_in_the_order_of_the_variants() {
        for (i, row) in Parameter::NAMES.iter().enumerate() {
            assert_eq!(row.0 as usize, i, "{}", row.1);
            assert_eq!(Parameter::named(row.1), Some(row.0));
            assert_eq!(row.0.key(), row.1);
        }
    }

    #[test]
    fn values_are_brought_into_their_range() {
        let value = Rgb::new(f32::NAN, -1.0, f32::INFINITY);
        assert_eq!(Parameter::Reflectance.clamp(value), Rgb::new(0.0, 0.0, 1.0));
        assert_eq!(Parameter::Anisotropy.clamp(value), Rgb::new(-1.0, -1.0, 1.0));
    }
}
