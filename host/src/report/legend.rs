//! Scale of colours: from values to colours, and the bar that explains it.

use super::Canvas;
use super::canvas::TEXT_HEIGHT;
use super::colour::{Colour, heat};
use super::number::short_number;

/// Pixels between the border and text.
const MARGIN: i64 = 10;
/// Longest bar in pixels.
const LONGEST: i64 = 480;

/// Scale from values to the colours of [`heat`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ColourScale {
    /// By the square root of the value, which is about how bright it looks, from 0 to the largest.
    Root(f64),
    /// In proportion, from 0 to the largest.
    Linear(f64),
    /// By the logarithm, over some decades below the largest.
    Logarithmic {
        /// Value of the brightest colour.
        largest: f64,
        /// Powers of ten between the darkest and the brightest colour, above 0.
        decades: f64,
    },
}

impl ColourScale {
    /// Returns the place of a value on the scale, 0 to 1.
    pub fn place(&self, value: f64) -> f32 {
        let place = match *self {
            Self::Root(largest) => (value / largest).max(0.0).sqrt(),
            Self::Linear(largest) => value / largest,
            Self::Logarithmic { largest, decades } => 1.0 + libm::log10(value / largest) / decades,
        };
        // A scale from 0 to 0 has no places.
        if place.is_nan() { 0.0 } else { place.clamp(0.0, 1.0) as f32 }
    }

    /// Returns the value at a place of the scale, 0 to 1.
    pub fn value(&self, place: f64) -> f64 {
        match *self {
            Self::Root(largest) => largest * place * place,
            Self::Linear(largest) => largest * place,
            Self::Logarithmic { largest, decades } => {
                largest * libm::pow(10.0, (place - 1.0) * decades)
            }
        }
    }

    /// Returns the numbers to write below the bar, as places.
    fn ticks(&self) -> i32 {
        match self {
            Self::Logarithmic { decades, .. } => (decades.round() as i32).clamp(2, 6),
            _ => 4,
        }
    }
}

/// Draws the bar of colours at the lower left, with numbers, and the unit after the last.
pub fn draw_legend(
    canvas: &mut Canvas,
    scale: &ColourScale,
    unit: &str,
    ink: Colour,
    ground: Colour,
) {
    let width = (i64::from(canvas.width()) - 2 * MARGIN).min(LONGEST);
    let bottom = i64::from(canvas.height()) - MARGIN;
    let top = bottom - 2 * TEXT_HEIGHT;
    for x in 0..width {
        let colour = heat(x as f32 / width as f32);
        for y in top..top + TEXT_HEIGHT - 4 {
            canvas.blend(MARGIN + x, y, colour, 1.0);
        }
    }
    let ticks = scale.ticks();
    for tick in 0..=ticks {
        let value = short_number(scale.value(f64::from(tick) / f64::from(ticks)));
        let text = if tick == ticks { format!("{value} {unit}") } else { value };
        let x = MARGIN + (width - 1) * i64::from(tick) / i64::from(ticks);
        canvas.text((x, bottom - TEXT_HEIGHT), &text, ink, ground);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_and_values_are_inverse() {
        let logarithmic = ColourScale::Logarithmic { largest: 1000.0, decades: 3.0 };
        for scale in [ColourScale::Root(7.0), ColourScale::Linear(7.0), logarithmic] {
            for step in 0..=10 {
                let place = f64::from(step) / 10.0;
                assert!((f64::from(scale.place(scale.value(place))) - place).abs() < 1e-6);
            }
            assert_eq!((scale.place(-1.0), scale.place(f64::INFINITY)), (0.0, 1.0));
            assert_eq!(scale.place(f64::NAN), 0.0);
        }
        assert_eq!(ColourScale::Linear(0.0).place(0.0), 0.0);
        assert_eq!(logarithmic.place(0.0), 0.0);
    }
}
