//! File that `shoot --out` and `merge --out` write: the photons and the flux that each side of each triangle received.

use std::path::Path;

use crate::files::output::write_triangle_rows;

/// Row of the file: photons and watts that one triangle received, by side.
#[derive(npyz::Serialize, npyz::AutoSerialize, Clone, Copy)]
struct Received {
    front_photons: u64,
    back_photons: u64,
    front_flux: f64,
    back_flux: f64,
}

/// Columns of the CSV file: the triangle, then the fields of the array.
const COLUMNS: [&str; 5] = ["triangle", "front_photons", "back_photons", "front_flux", "back_flux"];

/// Writes one row for each triangle, in the order of ids: as CSV if the name ends in .csv, else as a structured array.
/// `hits` has the photons on the front and on the back of each; each carries `photon_flux` watts.
///
/// # Errors
/// If the file cannot be written.
pub fn write_flux(
    path: &Path,
    hits: impl ExactSizeIterator<Item = [u64; 2]>,
    photon_flux: f64,
) -> anyhow::Result<()> {
    let received = |[front, back]: [u64; 2]| Received {
        front_photons: front,
        back_photons: back,
        front_flux: front as f64 * photon_flux,
        back_flux: back as f64 * photon_flux,
    };
    write_triangle_rows(path, &COLUMNS, hits.map(received), |row| {
        let Received { front_photons, back_photons, front_flux, back_flux } = *row;
        (front_photons, back_photons, front_flux, back_flux)
    })?;
    log::info!("photons and flux of each triangle: {}", path.display());
    Ok(())
}
