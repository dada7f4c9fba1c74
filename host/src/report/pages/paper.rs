//! Page about the paper's figures and tables.

use super::paper_equal_bytes::equal_bytes_section;
use super::paper_figure3::figure3_section;
use super::paper_tables::tables_section;
use super::separation::separation_section;
use crate::benchmark::harness::measurement::Measurement;
use crate::benchmark::harness::provenance::Provenance;
use crate::benchmark::studies::paper::equal_bytes_tables::SceneTable;
use crate::benchmark::studies::paper::figure3::Figure3;
use crate::benchmark::studies::paper::figure3_apart::ApartRow;
use crate::benchmark::studies::paper::lit::ScenePicture;
use crate::benchmark::studies::paper::protocol::ProtocolTable;
use crate::benchmark::studies::separation::SeparationRow;
use crate::report::html::Page;

/// Measurements that the page shows.
pub struct PaperEvidence<'e> {
    /// Tables 1 to 3 as printed.
    pub tables: &'e [ProtocolTable],
    /// Tables 1 to 3 with grids of equal bytes; without any, their section is left out.
    pub equal_bytes: &'e [SceneTable],
    /// Measurements of figure 3.
    pub figure3: &'e Figure3,
    /// Octrees of figure 3 with its clusters at other distances.
    pub apart: &'e [ApartRow],
    /// All indices of figure 3 with its clusters at other distances; without any, their section is left out.
    pub separation: &'e [SeparationRow],
    /// Pictures of the scenes.
    pub lit: &'e [ScenePicture],
    /// Machine, compiler and commit of the measurements.
    pub provenance: &'e Provenance,
    /// Command that repeats the measurements.
    pub command: &'e str,
}

/// Makes the page.
///
/// # Errors
/// If a picture cannot be read.
pub fn paper_page(evidence: &PaperEvidence<'_>) -> anyhow::Result<Page> {
    let mut page = Page::new("The paper's figures and tables, measured again");
    page.paragraph(
        "N. Aguilera, J. Revelles, M. Lastra, R. Montes, R. J. García: Representaciones Espaciales Para Escenas \
         Constituidas Mediante Agrupaciones de Objetos. For a reader who has the paper at hand: first its scenes, lit; \
         then its tables 1 to 3, row by row, each number beside ours; then the same tables by bytes; then its figure \
         3.",
    );
    page.paragraph(
        "Every index gives the same hits, bit for bit; that was checked on these rays before they were timed. Times \
         are processor times of one thread: medians of repetitions in turns. A gain is the paper's: the time saved, as \
         a share of the slower index's time. It is above 0 where the octrees or the hierarchy are faster.",
    );
    page.note(&format!("{}. {}", evidence.command, evidence.provenance.line()));
    page.heading("The scenes, lit by photons");
    page.paragraph(
        "The density of photons gives the light on the surfaces, by the method of three of the paper's authors. The \
         99th percentile of the radiance is white. The paper gives no coordinates, so positions are ours.",
    );
    page.pictures(evidence.lit.iter().map(|lit| (lit.path.as_path(), lit.caption.clone())))?;
    tables_section(&mut page, evidence.tables);
    if !evidence.equal_bytes.is_empty() {
        equal_bytes_section(&mut page, evidence.equal_bytes);
    }
    figure3_section(&mut page, evidence.figure3, evidence.apart);
    if !evidence.separation.is_empty() {
        separation_section(&mut page, evidence.separation);
    }
    Ok(page)
}

/// Writes the seconds of a measurement for a million photons.
pub fn seconds_per_million(measurement: &Measurement) -> String {
    format!("{:.2}", measurement.microseconds_per_photon())
}

/// Marks every level from 1 on.
pub fn level_ticks(most: u32) -> Vec<(f64, String)> {
    (1..=most).map(|level| (f64::from(level), level.to_string())).collect()
}
