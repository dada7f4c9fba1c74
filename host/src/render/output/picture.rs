//! Picture of a film: colours as a camera would see them, or false colours with a legend.

use super::tone::{exposure_of, percentile, to_srgb};
use crate::render::film::{Film, Pixel};
use crate::report::{
    Canvas, Colour, ColourScale, NIGHT, draw_legend, has_room_for_text, heat, short_number,
};

/// Quantity of a picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Quantity {
    /// Radiance towards the eye: light that surfaces reflect and emit.
    #[default]
    Radiance,
    /// Irradiance of surfaces: light that falls on them, whether they reflect it or not.
    Irradiance,
}

/// Unit of false colours.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Unit {
    /// Watts.
    #[default]
    Watts,
    /// Lumens: watts times the lumens of a watt.
    Lumens(f32),
}

/// Range of false colours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// Value of the brightest colour, in the unit of the picture; `None` is the 99th percentile.
    pub largest: Option<f32>,
    /// Decades of a logarithmic scale; `None` is a linear one.
    pub decades: Option<f32>,
}

/// Presentation of a film: quantity, unit and colours.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Look {
    /// Quantity that is shown.
    pub quantity: Quantity,
    /// Unit of false colours.
    pub unit: Unit,
    /// Factor of the values in natural colours, after which 1 is white. `None` is automatic.
    pub exposure: Option<f32>,
    /// False colours instead of natural ones.
    pub false_colour: Option<Range>,
}

impl Look {
    /// Returns the unit's name.
    pub fn unit_name(&self) -> &'static str {
        match (self.unit, self.quantity) {
            (Unit::Watts, Quantity::Irradiance) => "W/m2",
            (Unit::Watts, Quantity::Radiance) => "W/(m2 sr)",
            (Unit::Lumens(_), Quantity::Irradiance) => "lx",
            (Unit::Lumens(_), Quantity::Radiance) => "cd/m2",
        }
    }

    /// Returns the quantity's values of red, green and blue at a pixel, in watts.
    pub fn colours(&self, pixel: &Pixel) -> [f32; 3] {
        match self.quantity {
            Quantity::Radiance => pixel.radiance(),
            Quantity::Irradiance => pixel.irradiance,
        }
    }

    /// Returns the mean of the three values at a pixel, in the unit.
    pub fn value(&self, pixel: &Pixel) -> f32 {
        let [red, green, blue] = self.colours(pixel);
        let factor = match self.unit {
            Unit::Watts => 1.0,
            Unit::Lumens(efficacy) => efficacy,
        };
        (red + green + blue) / 3.0 * factor
    }

    /// Computes the least, mean and largest value over the pixels where surfaces are; `None` if there are none.
    pub fn extrema(&self, film: &Film) -> Option<[f32; 3]> {
        let (mut least, mut largest, mut sum, mut count) = (f32::INFINITY, 0.0_f32, 0.0_f64, 0_u32);
        for pixel in film.pixels().iter().filter(|pixel| pixel.is_hit()) {
            let value = self.value(pixel);
            least = least.min(value);
            largest = largest.max(value);
            sum += f64::from(value);
            count += 1;
        }
        (count > 0).then(|| [least, (sum / f64::from(count)) as f32, largest])
    }
}

/// Paints a film.
pub fn paint(film: &Film, look: &Look) -> Canvas {
    let (width, height) = film.size();
    let mut canvas = Canvas::new(width, height);
    if let Some(range) = look.false_colour {
        paint_false_colours(&mut canvas, film, look, range);
        return canvas;
    }
    let exposure = look.exposure.unwrap_or_else(|| match look.quantity {
        Quantity::Radiance => exposure_of(film),
        Quantity::Irradiance => 1.0 / largest_of(film, look),
    });
    for (colour, pixel) in canvas.pixels_mut().iter_mut().zip(film.pixels()) {
        // A level over 255 becomes that level again in the file.
        let level = |value: f32| f32::from(to_srgb(value * exposure)) / 255.0;
        let [red, green, blue] = look.colours(pixel).map(level);
        *colour = Colour(red, green, blue);
    }
    canvas
}

/// Returns the 99th percentile of the values; 1 if that is 0.
fn largest_of(film: &Film, look: &Look) -> f32 {
    let hit = film.pixels().iter().filter(|pixel| pixel.is_hit());
    let largest = percentile(hit.map(|pixel| look.value(pixel)).collect(), 0.99);
    if largest > 0.0 { largest } else { 1.0 }
}

fn paint_false_colours(canvas: &mut Canvas, film: &Film, look: &Look, range: Range) {
    let largest = f64::from(range.largest.unwrap_or_else(|| largest_of(film, look)));
    let scale = match range.decades {
        None => ColourScale::Linear(largest),
        Some(decades) => ColourScale::Logarithmic { largest, decades: f64::from(decades) },
    };
    for (colour, pixel) in canvas.pixels_mut().iter_mut().zip(film.pixels()) {
        let place = scale.place(f64::from(look.value(pixel)));
        *colour = if pixel.is_hit() {
            NIGHT.mixed(heat(place), pixel.coverage.clamp(0.0, 1.0))
        } else {
            NIGHT
        };
    }
    if has_room_for_text(canvas) {
        draw_legend(canvas, &scale, look.unit_name(), Colour::PAPER, NIGHT);
        if let Some([least, mean, largest]) = look.extrema(film) {
            let [least, mean, largest] =
                [least, mean, largest].map(|value| short_number(f64::from(value)));
            let name = match (look.unit, look.quantity) {
                (Unit::Watts, Quantity::Radiance) => "radiance",
                (Unit::Watts, Quantity::Irradiance) => "irradiance",
                (Unit::Lumens(_), Quantity::Radiance) => "luminance",
                (Unit::Lumens(_), Quantity::Irradiance) => "illuminance",
            };
            let unit = look.unit_name();
            let text = format!("{name}: least {least}, mean {mean}, largest {largest} {unit}");
            canvas.text((10, 10), &text, Colour::PAPER, NIGHT);
        }
    }
}
