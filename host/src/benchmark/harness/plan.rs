//! Plan of a measurement: the indices, their options, and the number of photons.

use arboleda::{Counters, IndexKind, Level, Options, Resolution};

/// Index with its options.
#[derive(Clone, Debug)]
pub struct Case {
    /// The index.
    pub kind: IndexKind,
    /// The options of its build.
    pub options: Options,
    /// Name of what is special about the options, for tables; empty for the defaults.
    pub setting: String,
}

impl Case {
    /// Takes an index with the default options.
    pub fn usual(kind: IndexKind) -> Self {
        Self { kind, options: Options::default(), setting: String::new() }
    }

    /// Takes an index with trees of cells up to a level.
    pub fn at_level(kind: IndexKind, level: u32) -> Self {
        let options = Options { level: Level::AtMost(level), ..Options::default() };
        Self { kind, options, setting: format!("level {level}") }
    }

    /// Takes an index with grids of `density` cells for each triangle.
    pub fn at_density(kind: IndexKind, density: f32) -> Self {
        let resolution = Resolution::CellsPerTriangle(density);
        let options = Options { resolution, ..Options::default() };
        Self { kind, options, setting: format!("{density} cells per triangle") }
    }

    /// Takes an index with a grid of these cells along x, y and z in each group.
    pub fn at_cells(kind: IndexKind, cells: [u32; 3]) -> Self {
        let options = Options { resolution: Resolution::Cells(cells), ..Options::default() };
        let [x, y, z] = cells;
        Self { kind, options, setting: format!("{x} x {y} x {z} cells") }
    }

    /// Divides cells of more than `capacity` triangles, in place of the default.
    #[must_use]
    pub fn with_leaves_of(mut self, capacity: u32) -> Self {
        self.options.leaf_capacity = capacity;
        self.setting = format!("{}, leaves of {capacity}", self.setting);
        self
    }

    /// Halves the sides of an octree's cell that are at least `share` of its longest side, in place of the default.
    #[must_use]
    pub fn with_least_side(mut self, share: f32) -> Self {
        self.options.least_side = share;
        self.setting = format!("{}, least side {share}", self.setting);
        self
    }
}

/// Work that a measurement may be.
#[derive(Clone, Copy, Debug)]
pub struct Effort {
    /// Photons to each repetition, where the index is fast enough.
    pub photons: u64,
    /// Number of times that the rays are replayed.
    pub repetitions: usize,
    /// About how long a repetition may take; slower indices get fewer photons.
    pub seconds: f64,
    /// The cases that get fewer photons where one is slow.
    pub share: Share,
    /// Seed that the photons are drawn with.
    pub seed: u64,
}

/// Photons that the cases of one measurement have in common.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Share {
    /// All answer the rays that the slowest can: for tables in which they stand side by side.
    Common,
    /// Each answers as many as it can: one slow case does not spoil the others.
    Own,
}

/// Photons whose counters tell how slow an index is.
pub const PROBE_PHOTONS: u64 = 64;
/// The fewest photons to a repetition.
const LEAST_PHOTONS: u64 = 16;

/// Returns how many photons take about the time allowed, judged by counters, so that the choice is the same on
/// every machine.
///
/// The weights come from the linear scan (15 ns a test on the processor this was written on) and from
/// the hierarchies (about 70 ns a node and 200 ns a ray); a factor of two either way does no harm.
pub fn photons_within(effort: &Effort, probe: Counters, probe_rays: usize, probed: u64) -> u64 {
    let seconds = probe.nodes_visited as f64 * 70e-9
        + probe.triangle_tests as f64 * 15e-9
        + probe_rays as f64 * 200e-9;
    let affordable = effort.seconds / (seconds / probed.max(1) as f64);
    effort.photons.min((affordable as u64).max(LEAST_PHOTONS))
}

/// Lists simple indices with their clustered counterparts. The registry lists each pair side by side.
pub fn pairs() -> impl Iterator<Item = (IndexKind, IndexKind)> {
    IndexKind::ALL.windows(2).filter_map(|pair| match *pair {
        [single, clustered] if !single.is_clustered() && clustered.is_clustered() => {
            Some((single, clustered))
        }
        _ => None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_clustered_index_has_a_partner() {
        let clustered = IndexKind::ALL.iter().filter(|kind| kind.is_clustered()).count();
        assert_eq!(pairs().count(), clustered);
        assert!(pairs().any(|pair| pair == (IndexKind::Octree, IndexKind::OctreeHierarchy)));
        assert!(pairs().any(|pair| pair == (IndexKind::UniformGrid, IndexKind::GridHierarchy)));
    }

    #[test]
    fn slow_indices_get_fewer_photons() {
        let effort =
            Effort { photons: 1_000, repetitions: 1, seconds: 0.1, share: Share::Own, seed: 1 };
        let probe = |tests| Counters { nodes_visited: 0, triangle_tests: tests };
        assert_eq!(photons_within(&effort, probe(10), 1, 1), 1_000);
        assert_eq!(photons_within(&effort, probe(10_000_000), 1, 1), LEAST_PHOTONS);
        let some = photons_within(&effort, probe(64 * 50_000), 64, PROBE_PHOTONS);
        assert!((100..200).contains(&some), "{some}");
    }
}
