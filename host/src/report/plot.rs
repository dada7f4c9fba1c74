//! Line plots as SVG, to stand in a page.
//!
//! The text keeps a readable size on narrow screens because the drawing is only 480 units wide; the legend
//! is left to the page, where it can wrap.

use std::fmt::Write;

use super::Colour;
use super::picture::cluster_colour;

/// How values map to places.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// Evenly.
    Linear,
    /// By their logarithm; values must be above 0, others are left out.
    Logarithmic,
}

/// A line of a plot.
pub struct Series {
    /// For the legend.
    pub label: String,
    /// A colour by number; see [`line_colour`].
    pub colour: usize,
    /// Whether the line is dashed.
    pub stroke: Stroke,
    /// Where it goes.
    pub points: Vec<(f64, f64)>,
}

/// How a line is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stroke {
    /// Through.
    Solid,
    /// With gaps.
    Dashed,
}

/// A plot.
pub struct Plot {
    /// Above it.
    pub title: String,
    /// What goes right, and its unit.
    pub x_label: String,
    /// What goes up, and its unit.
    pub y_label: String,
    /// How x maps.
    pub x_scale: Scale,
    /// How y maps.
    pub y_scale: Scale,
    /// Ticks along x, where those found are not wanted, with their labels.
    pub x_ticks: Vec<(f64, String)>,
    /// The lines.
    pub series: Vec<Series>,
}

const WIDTH: f64 = 480.0;
const HEIGHT: f64 = 330.0;
const LEFT: f64 = 58.0;
const RIGHT: f64 = 14.0;
const TOP: f64 = 14.0;
const BOTTOM: f64 = 46.0;
/// About as many ticks along an axis.
const TICKS: f64 = 6.0;

/// A colour for a line, dark enough on white, as CSS. After eight, hues come close to one another again, and the next
/// eight are darker.
pub fn line_colour(number: usize) -> String {
    let light = [0.78, 0.4][number / 8 % 2];
    let Colour(red, green, blue) = cluster_colour(number as u32).times(light);
    let byte = |part: f32| (part.clamp(0.0, 1.0) * 255.0) as u8;
    format!("#{:02x}{:02x}{:02x}", byte(red), byte(green), byte(blue))
}

impl Plot {
    /// The drawing, and below it the legend, as HTML.
    pub fn to_html(&self) -> String {
        let x_axis = Axis::of(self.x_scale, self.points().map(|(x, _)| x));
        let y_axis = Axis::of(self.y_scale, self.points().map(|(_, y)| y));
        let x_place = |x: f64| LEFT + x_axis.share(x) * (WIDTH - LEFT - RIGHT);
        let y_place = |y: f64| HEIGHT - BOTTOM - y_axis.share(y) * (HEIGHT - TOP - BOTTOM);
        // Writing to a string cannot fail.
        let mut text = format!(
            "<figure class=\"plot\"><h3>{}</h3><svg viewBox=\"0 0 {WIDTH} {HEIGHT}\" role=\"img\">",
            escape(&self.title)
        );

        // 1. The grid, with its numbers.
        for (y, label) in y_axis.ticks() {
            let place = y_place(y);
            let zero =
                if y == 0.0 && y_axis.scale == Scale::Linear { " class=\"zero\"" } else { "" };
            let _ = write!(
                text,
                "<line{zero} x1=\"{LEFT}\" x2=\"{}\" y1=\"{place:.1}\" y2=\"{place:.1}\"/>\
                 <text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{label}</text>",
                WIDTH - RIGHT,
                LEFT - 6.0,
                place + 4.0
            );
        }
        let x_ticks = if self.x_ticks.is_empty() { x_axis.ticks() } else { self.x_ticks.clone() };
        for (x, label) in x_ticks {
            let place = x_place(x);
            let _ = write!(
                text,
                "<line x1=\"{place:.1}\" x2=\"{place:.1}\" y1=\"{TOP}\" y2=\"{}\"/>\
                 <text x=\"{place:.1}\" y=\"{}\" text-anchor=\"middle\">{label}</text>",
                HEIGHT - BOTTOM,
                HEIGHT - BOTTOM + 16.0
            );
        }
        let middle = (TOP + HEIGHT - BOTTOM) * 0.5;
        let _ = write!(
            text,
            "<text class=\"label\" x=\"{}\" y=\"{}\" text-anchor=\"middle\">{}</text>\
             <text class=\"label\" transform=\"translate(13 {middle}) rotate(-90)\" text-anchor=\"middle\">{}</text>",
            (LEFT + WIDTH - RIGHT) * 0.5,
            HEIGHT - 8.0,
            escape(&self.x_label),
            escape(&self.y_label)
        );

        // 2. The lines; a pointer over a point shows its values.
        for series in &self.series {
            let colour = line_colour(series.colour);
            let shown = |&(x, y): &(f64, f64)| x_axis.shows(x) && y_axis.shows(y);
            let points: Vec<_> = series.points.iter().copied().filter(shown).collect();
            let mut path = String::new();
            for &(x, y) in &points {
                let _ = write!(path, "{:.1},{:.1} ", x_place(x), y_place(y));
            }
            let dash =
                if series.stroke == Stroke::Dashed { " stroke-dasharray=\"5 3\"" } else { "" };
            let _ = write!(text, "<polyline points=\"{path}\" stroke=\"{colour}\"{dash}/>");
            for (x, y) in points {
                let _ = write!(
                    text,
                    "<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"2.6\" fill=\"{colour}\"><title>{}: {} at \
                     {}</title></circle>",
                    x_place(x),
                    y_place(y),
                    escape(&series.label),
                    number(y),
                    number(x)
                );
            }
        }

        // 3. The legend.
        text += "</svg><figcaption>";
        for series in &self.series {
            let dashed = if series.stroke == Stroke::Dashed { "dashed" } else { "solid" };
            let _ = write!(
                text,
                "<span><i style=\"border-top:3px {dashed} {}\"></i>{}</span> ",
                line_colour(series.colour),
                escape(&series.label)
            );
        }
        text += "</figcaption></figure>";
        text
    }

    fn points(&self) -> impl Iterator<Item = (f64, f64)> {
        self.series.iter().flat_map(|series| series.points.iter().copied())
    }
}

/// The range of an axis, with tidy ends.
struct Axis {
    scale: Scale,
    /// In units of the scale: logarithms to base 10 where it is logarithmic.
    low: f64,
    high: f64,
    step: f64,
}

impl Axis {
    fn of(scale: Scale, values: impl Iterator<Item = f64>) -> Self {
        let mut low = f64::INFINITY;
        let mut high = f64::NEG_INFINITY;
        for value in values {
            let value = if scale == Scale::Logarithmic { value.log10() } else { value };
            if value.is_finite() {
                (low, high) = (low.min(value), high.max(value));
            }
        }
        if low > high {
            (low, high) = (0.0, 1.0);
        }
        let step = match scale {
            Scale::Linear => tidy((high - low).max(1e-9) / TICKS),
            // Whole powers of ten, or thirds of them.
            Scale::Logarithmic if high - low > 2.5 => ((high - low) / TICKS).ceil(),
            Scale::Logarithmic => 1.0 / 3.0,
        };
        (low, high) = ((low / step + 1e-6).floor() * step, (high / step - 1e-6).ceil() * step);
        if low >= high {
            high = low + step;
        }
        Self { scale, low, high, step }
    }

    fn shows(&self, value: f64) -> bool {
        value.is_finite() && (self.scale == Scale::Linear || value > 0.0)
    }

    fn share(&self, value: f64) -> f64 {
        let value = if self.scale == Scale::Logarithmic { value.log10() } else { value };
        (value - self.low) / (self.high - self.low)
    }

    fn ticks(&self) -> Vec<(f64, String)> {
        let count = ((self.high - self.low) / self.step).round() as usize;
        (0..=count)
            .map(|tick| {
                let value = self.low + tick as f64 * self.step;
                match self.scale {
                    Scale::Linear => {
                        // -0 and rounding left from the addition.
                        let value = (value / self.step).round() * self.step + 0.0;
                        (value, number(value))
                    }
                    Scale::Logarithmic => {
                        let power = 10_f64.powf(value.floor());
                        // Thirds of a power of ten are called 1, 2, 5.
                        let third = ((value - value.floor()) * 3.0).round() as usize;
                        let value = power * [1.0, 2.0, 5.0, 10.0][third.min(3)];
                        (value, number(value))
                    }
                }
            })
            .collect()
    }
}

/// The nearest of 1, 2 and 5 times a power of ten that is not below.
fn tidy(step: f64) -> f64 {
    let power = 10_f64.powf(step.log10().floor());
    let factor = [1.0, 2.0, 5.0].into_iter().find(|factor| factor * power >= step * 0.999);
    factor.unwrap_or(10.0) * power
}

/// A number in few characters: 12k, 0.5, 3M.
pub fn number(value: f64) -> String {
    let size = value.abs();
    let (value, unit) = match size {
        1e9.. => (value / 1e9, "G"),
        1e6.. => (value / 1e6, "M"),
        1e4.. => (value / 1e3, "k"),
        _ => (value, ""),
    };
    let places = match value.abs() {
        0.0 | 100.0.. => 0,
        10.0.. => 1,
        1.0.. => 2,
        _ => 3,
    };
    let text = format!("{value:.places$}");
    let text =
        if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    format!("{text}{unit}")
}

/// Makes text safe in HTML.
pub fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        let cases =
            [(0.0, "0"), (0.125, "0.125"), (12.0, "12"), (1_500.0, "1500"), (70_888.0, "70.9k")];
        for (value, text) in cases.into_iter().chain([(2.5e6, "2.5M"), (-40.0, "-40")]) {
            assert_eq!(number(value), text);
        }
    }

    #[test]
    fn axes_hold_all_values() {
        let axis = Axis::of(Scale::Linear, [-3.0, 96.0].into_iter());
        assert_eq!((axis.low, axis.high, axis.step), (-20.0, 100.0, 20.0));
        let axis = Axis::of(Scale::Logarithmic, [3.0, 20_000.0].into_iter());
        assert!(axis.share(3.0) >= 0.0 && axis.share(20_000.0) <= 1.0);
        assert_eq!(axis.ticks()[1].1, "10");
        let nothing = Axis::of(Scale::Logarithmic, std::iter::empty());
        assert!(nothing.low < nothing.high);
    }

    #[test]
    fn a_plot_without_points_is_still_a_plot() {
        let plot = Plot {
            title: "a < b".to_owned(),
            x_label: String::new(),
            y_label: String::new(),
            x_scale: Scale::Linear,
            y_scale: Scale::Logarithmic,
            x_ticks: Vec::new(),
            series: Vec::new(),
        };
        let html = plot.to_html();
        assert!(html.contains("a &lt; b") && !html.contains("NaN"));
    }
}
