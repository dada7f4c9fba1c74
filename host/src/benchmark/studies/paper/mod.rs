//! The paper's measurements, made again: figure 3, and tables 1 to 3.
//!
//! ```text
//! printed                            the paper's tables, number by number
//! protocol -> verdict, table_file    the same rows measured, and how far they agree
//! equal_bytes -> equal_bytes_tables  other grids: of the octrees' bytes
//! lit                                the scenes in the light of photons
//! figure3, figure3_apart             a single octree against a hierarchy: by level, and as the clusters move apart
//! ```

pub mod equal_bytes;
pub mod equal_bytes_tables;
pub mod figure3;
pub mod figure3_apart;
pub mod lit;
pub mod printed;
pub mod protocol;
pub mod table_file;
pub mod verdict;
