//! The option `--light`: an area light in ten numbers.

use arboleda::Vec3;

use crate::photon::Emitter;
use crate::scene::AreaLight;

/// A light of the command line, in the coordinates of the scene's file.
#[derive(Clone, Copy)]
pub struct GivenLight([f64; 10]);

/// Parses a light. Refuses a light that emits nothing, because shooting from it would silently shoot no photons.
pub fn light(text: &str) -> Result<GivenLight, String> {
    const NAMES: [&str; 10] = ["CX", "CY", "CZ", "UX", "UY", "UZ", "VX", "VY", "VZ", "FLUX"];
    let parts: Vec<&str> = text.split(',').map(str::trim).collect();
    let mut numbers = [0.0_f64; 10];
    if parts.len() != numbers.len() {
        return Err(format!("ten numbers are needed, {} were given", parts.len()));
    }
    for ((part, name), number) in parts.into_iter().zip(NAMES).zip(&mut numbers) {
        *number = part.parse().map_err(|_| format!("{name} is `{part}`, which is not a number"))?;
        if !(*number as f32).is_finite() {
            return Err(format!("{name} is `{part}`, which is not finite as a 32-bit number"));
        }
    }
    let light = GivenLight(numbers);
    let placed = light.place([0.0; 3]);
    if placed.flux <= 0.0 {
        return Err(format!("FLUX is {}; it must be above 0", placed.flux));
    }
    if Emitter::new(&[placed]).is_dark() {
        return Err("the light has no area: its edges (UX,UY,UZ) and (VX,VY,VZ) are parallel or 0"
            .to_owned());
    }
    Ok(light)
}

impl GivenLight {
    /// Converts to a light of the scene: subtracts the scene's origin from the corner.
    pub fn place(self, origin: [f64; 3]) -> AreaLight {
        let at = |first: usize| [0, 1, 2].map(|axis| self.0[first + axis]);
        let rounded = |point: [f64; 3]| Vec3::from_array(point.map(|x| x as f32));
        let corner = at(0);
        AreaLight {
            corner: rounded([0, 1, 2].map(|axis| corner[axis] - origin[axis])),
            edge_u: rounded(at(3)),
            edge_v: rounded(at(6)),
            flux: self.0[9] as f32,
        }
    }
}
