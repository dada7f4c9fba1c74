//! Canvas: pixels, lines, text and PNG files.

use std::io;
use std::path::Path;

use image::codecs::png::PngEncoder;
use image::{ImageError, RgbImage};
use noto_sans_mono_bitmap::{
    FontWeight, RasterHeight, RasterizedChar, get_raster, get_raster_width,
};

use super::Colour;
use crate::files::output::write_file;

/// Height of letters.
const LETTERS: RasterHeight = RasterHeight::Size16;
const LETTER_WIDTH: u32 = get_raster_width(FontWeight::Regular, LETTERS) as u32;
/// Height of a line of text in pixels.
pub const TEXT_HEIGHT: i64 = LETTERS as i64;

/// Picture being drawn.
pub struct Canvas {
    pixels: Vec<Colour>,
    width: u32,
    height: u32,
}

impl Canvas {
    /// Creates an empty page.
    pub fn new(width: u32, height: u32) -> Self {
        Self { pixels: vec![Colour::PAPER; width as usize * height as usize], width, height }
    }

    /// Returns the width in pixels.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Returns the height in pixels.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Iterates over the rows of pixels, which can be filled in parallel.
    pub fn rows_mut(&mut self) -> std::slice::ChunksMut<'_, Colour> {
        self.pixels.chunks_mut(self.width as usize)
    }

    /// Returns all pixels, row by row.
    pub fn pixels_mut(&mut self) -> &mut [Colour] {
        &mut self.pixels
    }

    /// Mixes a colour into one pixel. Does nothing outside the page.
    pub fn blend(&mut self, x: i64, y: i64, colour: Colour, part: f32) {
        let inside =
            (0..i64::from(self.width)).contains(&x) && (0..i64::from(self.height)).contains(&y);
        if inside {
            let pixel = &mut self.pixels[y as usize * self.width as usize + x as usize];
            *pixel = pixel.mixed(colour, part);
        }
    }

    /// Draws an anti-aliased line (Wu 1991). `visible` returns the opacity at a share of the way, 0 to 1, and a pixel.
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
            // Divides each step between the two nearest pixels across the line.
            let steep = dy.abs() > dx.abs();
            let across = if steep { x } else { y };
            let low = across.floor();
            for (offset, part) in [(0.0, 1.0 - (across - low)), (1.0, across - low)] {
                let pixel = (low + offset) as i64;
                let (px, py) =
                    if steep { (pixel, y.round() as i64) } else { (x.round() as i64, pixel) };
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

    /// Writes a line of text over a faint background, from its upper left corner. Characters beyond ASCII become `?`.
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

    /// Computes the width of a line of text in pixels.
    pub fn text_width(text: &str) -> i64 {
        i64::from(text.chars().count() as u32 * LETTER_WIDTH)
    }

    /// Copies another picture into this one, its upper left corner at (`left`, `top`).
    pub fn paste(&mut self, other: &Self, left: u32, top: u32) {
        for y in 0..other.height.min(self.height.saturating_sub(top)) {
            for x in 0..other.width.min(self.width.saturating_sub(left)) {
                let from = (y * other.width + x) as usize;
                let to = (y + top) as usize * self.width as usize + (x + left) as usize;
                self.pixels[to] = other.pixels[from];
            }
        }
    }

    /// Writes the picture as PNG, whatever the ending of the file's name.
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
