//! Material of a part of a scene file: what it reflects and emits.

/// Reflectance of surfaces without a material.
pub const DEFAULT_REFLECTANCE: f32 = 0.5;

/// Diffuse surface, which may emit light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::scene) struct Material {
    /// Share of light that is reflected: the mean of the colour as the file has it, clamped to 0 to 1.
    pub reflectance: f32,
    /// Shares of red, green and blue, each clamped to 0 to 1.
    pub colour: [f32; 3],
    /// Radiance of red, green and blue in W/(m2 sr).
    pub radiance: [f32; 3],
}

impl Material {
    /// Surface without a material.
    pub const DEFAULT: Self = Self {
        reflectance: DEFAULT_REFLECTANCE,
        colour: [DEFAULT_REFLECTANCE; 3],
        radiance: [0.0; 3],
    };

    /// Creates a material that reflects a colour and emits nothing.
    pub fn of_colour(colour: [f32; 3]) -> Self {
        let [red, green, blue] = colour.map(f64::from);
        let reflectance = (((red + green + blue) / 3.0) as f32).clamp(0.0, 1.0);
        Self { reflectance, colour: colour.map(|share| share.clamp(0.0, 1.0)), ..Self::DEFAULT }
    }

    /// Tells whether the three colours are reflected alike.
    pub fn is_grey(&self) -> bool {
        self.colour == [self.reflectance; 3]
    }

    /// Tells whether the material emits light.
    pub fn emits(&self) -> bool {
        self.radiance.iter().any(|&part| part > 0.0)
    }
}
