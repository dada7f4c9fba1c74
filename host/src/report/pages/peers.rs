//! `peers.md`: what was aimed at, whether it was reached, and all figures.

use std::fmt::Write;

use super::peers_table::{self as tables, bytes_per_triangle, fastest};
use crate::benchmark::contenders::contender::Mode;
use crate::benchmark::harness::provenance::Provenance;
use crate::benchmark::studies::peers::{PeerComparison, PeerRow};
use crate::report::grid::{Cell, Grid, Mark};

/// All that the page shows.
pub struct PeersEvidence<'e> {
    /// Command that gives the same figures.
    pub command: &'e str,
    /// Machine and build.
    pub provenance: &'e Provenance,
    /// Rays, rounds and seed, in words.
    pub effort: &'e str,
    /// The index of ours that is held against the others in the first table.
    pub ours: &'e str,
    /// The scenes.
    pub comparisons: &'e [PeerComparison],
    /// The scenes by size; may be empty.
    pub growth: &'e [PeerComparison],
}

/// Writes the page as Markdown.
pub fn peers_page(evidence: &PeersEvidence<'_>) -> String {
    let PeersEvidence { command, provenance, effort, ours, comparisons, growth } = evidence;
    let mut sections = vec![format!(
        "# Arboleda against other libraries\n\n`{command}`\n\n{}\n\n{effort}. One thread, rays in processor \
         time; contenders take turns; answers are compared before anything is timed.\n",
        provenance.line()
    )];
    if !comparisons.is_empty() {
        sections.push(format!(
            "## `{ours}` against the others\n\nHow many times as fast; below 1.00 it loses. Both of a pair \
             answer in the mode named.\n\n{}",
            goals(comparisons, ours).markdown()
        ));
        sections.push(format!("## Scenes\n\n{}.\n", tables::SCENE_LEGEND));
    }
    for comparison in *comparisons {
        let PeerComparison { scene, triangle_count, .. } = comparison;
        let table = tables::scene_grid(comparison).markdown();
        sections.push(format!("### {scene}, {triangle_count} triangles\n\n{table}"));
    }
    if !growth.is_empty() {
        let table = tables::growth_grid(growth).markdown();
        sections.push(format!("## Growth\n\n{}.\n\n{table}", tables::GROWTH_LEGEND));
    }
    let all: Vec<&PeerComparison> = comparisons.iter().chain(*growth).collect();
    let absent = absent(&all);
    if !absent.is_empty() {
        let mut section = "## Absent\n\n".to_owned();
        for line in absent {
            let _ = writeln!(section, "- {line}");
        }
        sections.push(section);
    }
    sections.join("\n")
}

/// Lists who could not take part and why, a line for each reason.
pub fn absent(comparisons: &[&PeerComparison]) -> Vec<String> {
    let mut reasons: Vec<(String, Vec<&str>, Vec<&str>)> = Vec::new();
    for comparison in comparisons {
        for (name, error) in &comparison.absent {
            let reason = error.to_string();
            let at = reasons.iter().position(|(known, ..)| *known == reason);
            let at = at.unwrap_or_else(|| {
                reasons.push((reason, Vec::new(), Vec::new()));
                reasons.len() - 1
            });
            let (_, names, scenes) = &mut reasons[at];
            if !names.contains(name) {
                names.push(name);
            }
            if !scenes.contains(&comparison.scene.as_str()) {
                scenes.push(&comparison.scene);
            }
        }
    }
    let line = |(reason, names, scenes): (String, Vec<&str>, Vec<&str>)| {
        let somewhere = scenes.len() < comparisons.len();
        let place = if somewhere { format!(" on {}", scenes.join(", ")) } else { String::new() };
        format!("without {}{place}: {reason}", names.join(", "))
    };
    reasons.into_iter().map(line).collect()
}

/// Name of a comparison, and how it is read from a scene and the name of ours.
type Goal = (&'static str, fn(&PeerComparison, &str) -> Cell);

/// Comparisons with the others: the goals of the project, one line each.
const GOALS: [Goal; 11] = [
    ("closest hit, batch / fastest Embree", |c, ours| embree(c, ours, Mode::Batch)),
    ("closest hit, single / fastest Embree, single", |c, ours| embree(c, ours, Mode::Single)),
    ("occluded / fastest Embree", |c, ours| embree(c, ours, Mode::Occluded)),
    ("closest hit, single / tinybvh", |c, ours| library(c, ours, "tinybvh")),
    ("closest hit, single / obvhs", |c, ours| library(c, ours, "obvhs")),
    ("closest hit, single / parry3d", |c, ours| library(c, ours, "parry3d")),
    ("closest hit, single / bvh", |c, ours| library(c, ours, "bvh")),
    ("triangles a second of the build / Embree medium", build),
    ("bytes a triangle, and those of Embree medium", bytes),
    ("wrong answers, and those of the fastest Embree", wrong),
    ("leaks, and those of the fastest Embree and of Embree robust", leaks),
];

/// Makes the table of ours against the others, a column for each scene.
fn goals(comparisons: &[PeerComparison], ours: &str) -> Grid {
    let scenes = comparisons.iter().map(|comparison| comparison.scene.clone());
    let line = |(name, of): Goal| {
        let cells = comparisons.iter().map(|comparison| of(comparison, ours));
        std::iter::once(Cell::new(name)).chain(cells).collect()
    };
    Grid {
        headings: std::iter::once(String::new()).chain(scenes).collect(),
        text_columns: 1,
        lines: GOALS.into_iter().map(line).collect(),
    }
}

/// Fills a cell with a ratio, which loses below 1.
fn ratio(ours: Option<f64>, theirs: Option<f64>) -> Cell {
    let ratio = ours.zip(theirs).map(|(ours, theirs)| ours / theirs);
    let loses = ratio.is_some_and(|ratio| ratio < 1.0);
    Cell::number(ratio, 2).marked(if loses { Mark::Loses } else { Mark::Plain })
}

fn speed(comparison: &PeerComparison, contender: &str, mode: Mode) -> Option<f64> {
    fastest(&comparison.rows, |row| row.contender == contender && row.mode == mode)
}

fn embree(comparison: &PeerComparison, ours: &str, mode: Mode) -> Cell {
    ratio(speed(comparison, ours, mode), tables::embree(&comparison.rows, mode))
}

fn library(comparison: &PeerComparison, ours: &str, theirs: &str) -> Cell {
    let single = |name| speed(comparison, name, Mode::Single);
    ratio(single(ours), single(theirs))
}

fn any_row<'c>(comparison: &'c PeerComparison, contender: &str) -> Option<&'c PeerRow> {
    comparison.rows.iter().find(|row| row.contender == contender)
}

fn build(comparison: &PeerComparison, ours: &str) -> Cell {
    let per_second = |name| any_row(comparison, name).map(|row| 1.0 / row.build_seconds);
    ratio(per_second(ours), per_second(EMBREE))
}

fn bytes(comparison: &PeerComparison, ours: &str) -> Cell {
    let bytes = |name| any_row(comparison, name).and_then(bytes_per_triangle);
    let (ours, theirs) = (bytes(ours), bytes(EMBREE));
    let loses = ours.zip(theirs).is_some_and(|(ours, theirs)| ours > theirs);
    let [ours, theirs] = [ours, theirs].map(|bytes| Cell::number(bytes, 0).text);
    Cell::new(format!("{ours}; {theirs}")).marked(if loses { Mark::Loses } else { Mark::Plain })
}

/// The Embree whose build and memory are compared with.
const EMBREE: &str = "embree4-medium";

/// Finds the contender of the fastest single rays among Embrees.
fn fastest_embree(comparison: &PeerComparison) -> &str {
    let best = tables::embree(&comparison.rows, Mode::Single);
    let is_it = |row: &&PeerRow| Some(row.speed.median) == best && row.mode == Mode::Single;
    comparison.rows.iter().find(is_it).map_or(EMBREE, |row| row.contender)
}

fn wrong(comparison: &PeerComparison, ours: &str) -> Cell {
    let wrong = |name: &str| {
        any_row(comparison, name)?;
        let rows = comparison.rows.iter().filter(|row| row.contender == name);
        Some(rows.map(|row| row.disagreements.wrong()).sum::<usize>())
    };
    counts(&[wrong(ours), wrong(fastest_embree(comparison))])
}

fn leaks(comparison: &PeerComparison, ours: &str) -> Cell {
    let leaks = |name: &str| {
        let rows = comparison.rows.iter().filter(|row| row.contender == name);
        rows.filter_map(|row| row.leaks).max()
    };
    counts(&[leaks(ours), leaks(fastest_embree(comparison)), leaks("embree4-robust")])
}

/// Fills a cell with counts, ours first; any of ours is one too many.
fn counts(counts: &[Option<usize>]) -> Cell {
    if counts.iter().all(Option::is_none) {
        return Cell::unknown();
    }
    let loses = counts[0].is_some_and(|count| count > 0);
    let shown = |count: &Option<usize>| count.map_or_else(|| "-".into(), |n| n.to_string());
    let text = counts.iter().map(shown).collect::<Vec<_>>().join("; ");
    Cell::new(text).marked(if loses { Mark::Loses } else { Mark::Plain })
}
