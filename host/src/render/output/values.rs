//! Files of a picture's values: `OpenEXR` with all channels, PFM with three.

use std::io::{self, Cursor};
use std::path::Path;

use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, SmallVec,
    WritableImage,
};

use super::picture::Look;
use crate::files::output::write_file;
use crate::render::film::{Film, Pixel};

/// Writes the values of a film, in watts: as `OpenEXR` if the name ends in .exr, else as PFM.
///
/// Channels of the EXR file: `R G B` are radiance; `irradiance.R`, `.G` and `.B`; `count` (u32), `radius`, `depth.Z`,
/// `triangle` (u32) and `stderr`. Without a hit, the depth is infinite and the triangle 4294967295. The PFM file has
/// red, green and blue of the look's quantity, its rows from the bottom up, little-endian.
///
/// # Errors
/// If the file cannot be written.
pub fn write_values(path: &Path, film: &Film, look: &Look) -> anyhow::Result<()> {
    let is_exr = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("exr"));
    let bytes = if is_exr { exr_bytes(film)? } else { pfm_bytes(film, look) };
    write_file(path, |file| file.write_all(&bytes))
}

/// Encodes a film as `OpenEXR`, compressed without loss.
fn exr_bytes(film: &Film) -> io::Result<Vec<u8>> {
    let floats = |name: &str, value: &dyn Fn(&Pixel) -> f32| {
        AnyChannel::new(name, FlatSamples::F32(film.pixels().iter().map(value).collect()))
    };
    let whole = |name: &str, value: &dyn Fn(&Pixel) -> u32| {
        AnyChannel::new(name, FlatSamples::U32(film.pixels().iter().map(value).collect()))
    };
    let channels: SmallVec<[AnyChannel<FlatSamples>; 4]> = [
        floats("R", &|pixel| pixel.radiance()[0]),
        floats("G", &|pixel| pixel.radiance()[1]),
        floats("B", &|pixel| pixel.radiance()[2]),
        floats("irradiance.R", &|pixel| pixel.irradiance[0]),
        floats("irradiance.G", &|pixel| pixel.irradiance[1]),
        floats("irradiance.B", &|pixel| pixel.irradiance[2]),
        whole("count", &|pixel| pixel.count),
        floats("radius", &|pixel| pixel.radius),
        floats("depth.Z", &|pixel| pixel.depth),
        whole("triangle", &|pixel| pixel.triangle),
        floats("stderr", &|pixel| pixel.standard_error),
    ]
    .into_iter()
    .collect();
    let (width, height) = film.size();
    let layer = Layer::new(
        (width as usize, height as usize),
        LayerAttributes::default(),
        Encoding::SMALL_FAST_LOSSLESS,
        AnyChannels::sort(channels),
    );
    let mut bytes = Cursor::new(Vec::new());
    let written = Image::from_layer(layer).write().non_parallel().to_buffered(&mut bytes);
    written.map_err(io::Error::other)?;
    Ok(bytes.into_inner())
}

/// Encodes the three values of each pixel as PFM.
///
/// # Source
/// P. Debevec's format, as `pfmtopfm` of HDR Shop writes it: the sign of the scale is that of little-endian.
pub(in crate::render) fn pfm_bytes(film: &Film, look: &Look) -> Vec<u8> {
    let (width, height) = film.size();
    let mut bytes = format!("PF\n{width} {height}\n-1.0\n").into_bytes();
    for row in film.pixels().chunks_exact((width as usize).max(1)).rev() {
        for value in row.iter().flat_map(|pixel| look.colours(pixel)) {
            bytes.extend(value.to_le_bytes());
        }
    }
    bytes
}
