//! Options of the lights: `--light`, an area light in ten numbers, and `--two-sided-lights`.

use arboleda::Vec3;
use clap::Args;

use crate::photon::Emitter;
use crate::scene::{AreaLight, Model, UpAxis};

/// Lights of a scene: those of the command line, else those of the scene file, else one above.
#[derive(Args, Clone)]
pub struct LightArguments {
    /// An area light that replaces the scene's lights: a corner, two edges, and the flux in watts. The light shines to
    /// the side of the cross product of the edges. Coordinates are those of the scene's file, with `--origin` too. May
    /// be given several times
    #[arg(long, value_name = "CX,CY,CZ,UX,UY,UZ,VX,VY,VZ,FLUX", value_parser = light, allow_hyphen_values = true)]
    light: Vec<GivenLight>,
    /// Let faces that emit light (`Ke` of a material file) emit on both sides, not only on the side from which their
    /// corners are seen counter-clockwise
    #[arg(long, conflicts_with = "light")]
    two_sided_lights: bool,
}

impl LightArguments {
    /// Gives a model its lights. A model that has none gets one above; `up` says where that is.
    pub fn lit(&self, mut model: Model, up: UpAxis) -> Model {
        if !self.light.is_empty() {
            model
                .replace_lights(self.light.iter().map(|light| light.place(model.origin)).collect());
        } else if !model.emitters.is_empty() {
            if self.two_sided_lights {
                model = model.with_two_sided_lights();
            }
            let emitter = Emitter::of(&model);
            log::info!("{} faces emit {:.6} W", model.emitters.len(), emitter.total_flux());
        }
        model.with_default_light(up)
    }
}

/// A light of the command line, in the coordinates of the scene's file.
#[derive(Clone, Copy)]
struct GivenLight([f64; 10]);

/// Parses a light. Refuses a light that emits nothing, because shooting from it would silently shoot no photons.
fn light(text: &str) -> Result<GivenLight, String> {
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
    fn place(self, origin: [f64; 3]) -> AreaLight {
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
