//! Pages about comparisons, and the tables and sections that they are made of.

mod compare;
mod paper;
mod paper_equal_bytes;
mod paper_figure3;
mod paper_tables;
mod paper_words;
mod peers;
pub mod peers_table;
mod separation;

pub use compare::{CompareEvidence, compare_page};
pub use paper::{PaperEvidence, paper_page};
pub use peers::{PeersEvidence, absent, peers_page};
