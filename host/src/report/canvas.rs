//! Pixels, lines and PNG files.

use std::io;
use std::path::Path;

use image::codecs::png::PngEncoder;
use image::{ImageError, Rgb, RgbImage};
use noto_sans_mono_bitmap::{
    FontWeight, RasterHeight, RasterizedChar, get_raster, get_raster_width,
};

use crate::file_output::write_file;

/// Linear red, green and blue, 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Colour(pub f32, pub f32, pub f32);

impl Colour {
    /// The page.
    pub const PAPER: Self = Self(0.97, 0.97, 0.96);
    /// Text and lines.
    pub const INK: Self = Self(0.16, 0.18, 0.22);

    /// Scales the brightness.
    #[must_use]
    pub fn times(self, factor: f32) -> Self {
        Self(self.0 * factor, self.1 * factor, self.2 * factor)
    }

    /// `other` by the share `part`, this one by the rest.
    #[must_use]
    pub fn mixed(self, other: Self, part: f32) -> Self {
        let mix = |a: f32, b: f32| a + (b - a) * part;
        Self(mix(self.0, other.0), mix(self.1, other.1), mix(self.2, other.2))
    }

    fn to_pixel(self) -> Rgb<u8> {
        Rgb([self.0, self.1, self.2].map(|c| (c.clamp(0.0, 1.0) * 255.0 + 0.5) as u8))
    }
}

/// Size of the letters of all text.
const LETTERS: RasterHeight = RasterHeight::Size16;
const LETTER_WIDTH: u32 = get_raster_width(FontWeight::Regular, LETTERS) as u32;
/// Pixels down of a line of text.
pub const TEXT_HEIGHT: i64 = LETTERS as i64;

/// A picture being drawn.
pub struct Canvas {
    pixels: Vec<Colour>,
    width: u32,
    height: u32,
}

impl Canvas {
    /// An empty page.
    pub fn new(width: u32, height: u32) -> Self {
        Self { pixels: vec![Colour::PAPER; width as usize * height as usize], width, height }
    }

    /// Pixels across.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Pixels down.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// The rows of pixels, for filling in parallel.
    pub fn rows_mut(&mut self) -> std::slice::ChunksMut<'_, Colour> {
        self.pixels.chunks_mut(self.width as usize)
    }

    /// All pixels, row by row.
    pub fn pixels_mut(&mut self) -> &mut [Colour] {
        &mut self.pixels
    }

    /// Mixes a colour into one pixel; outside the page it does nothing.
    pub fn blend(&mut self, x: i64, y: i64, colour: Colour, part: f32) {
        let inside =
            (0..i64::from(self.width)).contains(&x) && (0..i64::from(self.height)).contains(&y);
        if inside {
            let pixel = &mut self.pixels[y as usize * self.width as usize + x as usize];
            *pixel = pixel.mixed(colour, part);
        }
    }

    /// Draws a smooth line; `visible` is asked at each step with the share of the way, 0 to 1.
    pub fn line(
        &mut self,
        from: (f32, f32),
        to: (f32, f32),
        colour: Colour,
        visible: impl Fn(f32, i64, i64) -> f32,
    ) {
        let (dx, dy) = (to.0 - from.0, to.1 - from.1);
        let steps = dx.abs().max(dy.abs()).ceil().clamp(1.0, 20_000.0) as u32;
        for step in 0..=steps {
            let share = step as f32 / steps as f32;
            let (x, y) = (from.0 + dx * share, from.1 + dy * share);
            // Spread over the two pixels across the line (Wu 1991).
            let steep = dy.abs() > dx.abs();
            let across = if steep { x } else { y };
            let low = across.floor();
            for (offset, part) in [(0.0, 1.0 - (across - low)), (1.0, across - low)] {
                let place = (low + offset) as i64;
                let (px, py) =
                    if steep { (place, y.round() as i64) } else { (x.round() as i64, place) };
                self.blend(px, py, colour, part * visible(share, px, py));
            }
        }
    }

    /// Fills a disc.
    pub fn disc(&mut self, centre: (f32, f32), radius: f32, colour: Colour) {
        let reach = radius.ceil() as i64 + 1;
        let (cx, cy) = (centre.0.round() as i64, centre.1.round() as i64);
        for y in cy - reach..=cy + reach {
            for x in cx - reach..=cx + reach {
                let (dx, dy) = (x as f32 - centre.0, y as f32 - centre.1);
                let cover = (radius + 0.5 - (dx * dx + dy * dy).sqrt()).clamp(0.0, 1.0);
                self.blend(x, y, colour, cover);
            }
        }
    }

    /// Writes a line of text whose upper left corner is given, over a faint ground. What is not ASCII is shown as `?`.
    pub fn text(&mut self, (left, top): (i64, i64), text: &str, colour: Colour, ground: Colour) {
        let (width, height) = (Self::text_width(text), TEXT_HEIGHT);
        for y in top - 1..=top + height {
            for x in left - 3..left + width + 3 {
                self.blend(x, y, ground, 0.7);
            }
        }
        for (at, letter) in (0_u32..).zip(text.chars()) {
            let raster = get_raster(letter, FontWeight::Regular, LETTERS)
                .or_else(|| get_raster('?', FontWeight::Regular, LETTERS));
            let rows = raster.iter().flat_map(RasterizedChar::rows);
            for (y, row) in (top..).zip(rows) {
                for (x, &cover) in (left + i64::from(at * LETTER_WIDTH)..).zip(row) {
                    self.blend(x, y, colour, f32::from(cover) / 255.0);
                }
            }
        }
    }

    /// Pixels across of a line of text.
    pub fn text_width(text: &str) -> i64 {
        i64::from(text.chars().count() as u32 * LETTER_WIDTH)
    }

    /// Copies another picture to a place on this one.
    pub fn paste(&mut self, other: &Self, left: u32, top: u32) {
        for y in 0..other.height.min(self.height.saturating_sub(top)) {
            for x in 0..other.width.min(self.width.saturating_sub(left)) {
                let from = (y * other.width + x) as usize;
                let to = (y + top) as usize * self.width as usize + (x + left) as usize;
                self.pixels[to] = other.pixels[from];
            }
        }
    }

    /// Writes the picture as PNG, whatever the file is called.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn save(&self, path: &Path) -> anyhow::Result<()> {
        let image = RgbImage::from_fn(self.width, self.height, |x, y| {
            self.pixels[y as usize * self.width as usize + x as usize].to_pixel()
        });
        write_file(path, |file| {
            let encoder = PngEncoder::new(file);
            image.write_with_encoder(encoder).map_err(|error| match error {
                ImageError::IoError(error) => error,
                other => io::Error::other(other),
            })
        })
    }
}
