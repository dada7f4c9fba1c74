//! Line plots as SVG inside HTML.
//!
//! The drawing is only 480 units wide, so that its text stays readable on narrow screens. The legend is HTML, which can
//! wrap.

use std::fmt::Write;

use super::colour::line_colour;
pub use super::number::number;

/// Scale of an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// Scale linear in the values.
    Linear,
    /// Scale linear in the logarithms. Values not above 0 are omitted.
    Logarithmic,
}

/// Line of a plot.
pub struct Series {
    /// Label in the legend.
    pub label: String,
    /// Number of the colour: equal numbers give equal colours.
    pub colour: usize,
    /// Stroke of the line.
    pub stroke: Stroke,
    /// Points (x, y), joined in order.
    pub points: Vec<(f64, f64)>,
}

/// Stroke of a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stroke {
    /// Continuous stroke.
    Solid,
    /// Stroke with gaps.
    Dashed,
}

/// Line plot.
pub struct Plot {
    /// Title above the plot.
    pub title: String,
    /// Quantity along x, with its unit.
    pub x_label: String,
    /// Quantity along y, with its unit.
    pub y_label: String,
    /// Scale of x.
    pub x_scale: Scale,
    /// Scale of y.
    pub y_scale: Scale,
    /// Ticks along x with their labels; if empty, ticks are chosen automatically.
    pub x_ticks: Vec<(f64, String)>,
    /// Lines of the plot.
    pub series: Vec<Series>,
}

const WIDTH: f64 = 480.0;
const HEIGHT: f64 = 330.0;
const LEFT: f64 = 58.0;
const RIGHT: f64 = 14.0;
const TOP: f64 = 14.0;
const BOTTOM: f64 = 46.0;
/// Approximate number of ticks along an axis.
const TICKS: f64 = 6.0;

impl Plot {
    /// Draws the plot, with the legend below, as HTML.
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

        // 2. The lines, with points that show their values when the pointer is on them.
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

/// Range of an axis, with ends at ticks.
struct Axis {
    scale: Scale,
    /// Lower end, in values, or in logarithms to base 10 if the scale is logarithmic.
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
            // Ticks at whole powers of ten, or at thirds of a power of ten for short ranges.
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
                        // Removes -0 and the rounding error of the addition.
                        let value = (value / self.step).round() * self.step + 0.0;
                        (value, number(value))
                    }
                    Scale::Logarithmic => {
                        let power = 10_f64.powf(value.floor());
                        // Thirds of a power of ten are labelled 1, 2, 5.
                        let third = ((value - value.floor()) * 3.0).round() as usize;
                        let value = power * [1.0, 2.0, 5.0, 10.0][third.min(3)];
                        (value, number(value))
                    }
                }
            })
            .collect()
    }
}

/// Rounds a step up to 1, 2 or 5 times a power of ten.
fn tidy(step: f64) -> f64 {
    let power = 10_f64.powf(step.log10().floor());
    let factor = [1.0, 2.0, 5.0].into_iter().find(|factor| factor * power >= step * 0.999);
    factor.unwrap_or(10.0) * power
}

/// Escapes text for HTML.
pub fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

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
