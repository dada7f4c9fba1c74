//! Tests of hostile index bytes: truncated, damaged, or forged.
//!
//! `from_bytes` must not panic, and an index that it accepts must be safe to query. `arboleda_tests::checks::hostile` defines
//! "safe".

use arboleda::{AnyIndex, IndexKind, Level, OpenError, Options, Scene, Vec3};
use arboleda_tests::build::Built;
use arboleda_tests::checks::hostile::{
    self, is_harmless, offset_in, small_options, some_rays, two_lattices, with_words,
};
use arboleda_tests::random::Random;
use arboleda_tests::{parallel, scenes};

const DEBUG: bool = cfg!(debug_assertions);

/// Builds a small index of every kind.
fn indices() -> Vec<Built> {
    let triangles = two_lattices();
    let built = IndexKind::ALL.iter().map(|&kind| {
        Built::new(kind, &Scene::new(&triangles), &small_options()).expect("an ordinary scene")
    });
    built.collect()
}

#[test]
fn every_truncation_is_refused() {
    for built in indices() {
        let bytes = built.bytes();
        hostile::every_truncation_is_refused(&built, |cut| built.kind().from_bytes(cut).err());
        // Bytes after the index are not part of it.
        let longer = Built::copied(built.kind(), &[bytes, &[0xff; 100]].concat());
        let index = longer.index();
        assert_eq!(arboleda::RayIndex::as_bytes(&index), bytes);
    }
}

#[test]
fn every_flipped_bit_is_harmless() {
    for built in indices() {
        let rays = some_rays(&two_lattices());
        hostile::every_flipped_bit_is_harmless(&built, |damaged| is_harmless(damaged, &rays));
    }
}

/// Replaces one to four words by plausible values.
#[test]
fn replaced_words_are_harmless() {
    let rounds = if DEBUG { 2_000 } else { 40_000 };
    for built in indices() {
        let rays = some_rays(&two_lattices());
        let word_count = built.bytes().len() / 4;
        parallel::map(rounds / 1_000, |job| {
            let mut random = Random::new(job as u64);
            for _ in 0..1_000 {
                let mut damaged = Built::copied(built.kind(), built.bytes());
                for _ in 0..random.whole(1, 4) {
                    // The magic number and the version are spared, because a change of them is always refused.
                    let to = 4 * (3 + random.below(word_count - 3));
                    let from = 4 * random.below(word_count);
                    let mut word = [0; 4];
                    word.copy_from_slice(&built.bytes()[from..from + 4]);
                    let near =
                        i32::from_ne_bytes(word).wrapping_add(random.whole(-2, 2)).to_ne_bytes();
                    let small = random.below(40).to_ne_bytes();
                    let word = random.pick(&[
                        word,
                        near,
                        [small[0], small[1], small[2], small[3]],
                        u32::MAX.to_ne_bytes(),
                        (1_u32 << 31 | random.clone().below(40) as u32).to_ne_bytes(),
                    ]);
                    damaged.bytes_mut()[to..to + 4].copy_from_slice(&word);
                }
                is_harmless(&damaged, &rays);
            }
        });
    }
}

#[test]
fn random_words_below_a_valid_header_are_harmless() {
    let triangles = scenes::lattice(9, 2, 5);
    for &kind in IndexKind::ALL {
        let valid = Built::new(kind, &Scene::new(&triangles), &one_cluster()).expect("one cluster");
        let rays = some_rays(&triangles);
        let mut random = Random::new(9);
        let mut accepted = 0;
        for _ in 0..if DEBUG { 2_000 } else { 20_000 } {
            let length = random.below(24);
            let word = |random: &mut Random| {
                let small = random.below(12) as u32;
                random.pick(&[small, small, small | 1 << 31, u32::MAX, 0xff])
            };
            let words: Vec<u32> = (0..length).map(|_| word(&mut random)).collect();
            accepted += is_harmless(&with_words(&valid, &words), &rays);
        }
        println!("{}: {accepted} random indices accepted", kind.name());
    }
}

fn one_cluster() -> Options {
    Options { proximity: 1e6, size_classes: 1, ..Options::default() }
}

/// Forged words of an octree are refused. The core's `indices/cells/octant_tree.rs` describes the format.
#[test]
fn forged_octrees_are_refused() {
    const LEAF: u32 = 1 << 31;
    const AXES: u32 = 0x700;
    let triangles = scenes::lattice(9, 2, 5);
    let is_accepted = |words: &[u32]| {
        let valid = Built::new(IndexKind::Octree, &Scene::new(&triangles), &one_cluster());
        let forged = with_words(&valid.expect("one cluster"), words);
        IndexKind::Octree.from_bytes(forged.bytes()).is_ok()
    };
    let refused = |what: &str, words: &[u32]| {
        for kind in [IndexKind::Octree, IndexKind::OctreeHierarchy] {
            let valid =
                Built::new(kind, &Scene::new(&triangles), &one_cluster()).expect("one cluster");
            let forged = with_words(&valid, words);
            let error = kind.from_bytes(forged.bytes()).err();
            assert!(matches!(error, Some(OpenError::Malformed { .. })), "{what}: {error:?}");
        }
    };
    refused("nothing", &[]);
    refused("a root that is its own child", &[1, AXES | 0b1, 1]);
    refused("a child that is the root's link", &[1, AXES | 0b1, 0]);
    refused("two children that are one", &[1, AXES | 0b11, LEAF | 4, LEAF | 4, 1, 0]);
    refused("a link past the end", &[1, AXES | 0b1, LEAF | 99]);
    refused("a node without children", &[1, AXES]);
    refused("a node that divides no axis", &[1, 0b1, LEAF | 3, 1, 0]);
    refused("a node that divides a fourth axis", &[1, 0x801, LEAF | 3, 1, 0]);
    refused("a leaf without triangles", &[LEAF | 1, 0]);
    refused("a leaf that is longer than the index", &[LEAF | 1, 3, 0, 1]);
    refused("the longest leaf", &[LEAF | 1, u32::MAX, 0]);
    refused("a triangle that does not exist", &[LEAF | 1, 1, 9]);
    refused("words left over", &[LEAF | 1, 1, 0, 0]);
    assert!(is_accepted(&[1, AXES | 0b1, LEAF | 3, 1, 0]), "a node with one leaf");
}

/// Forged words of a grid are refused. The core's `indices/grid/mod.rs` describes the format.
#[test]
fn forged_grids_are_refused() {
    let triangles = scenes::lattice(9, 2, 5);
    let opened = |words: &[u32]| {
        let valid = Built::new(IndexKind::UniformGrid, &Scene::new(&triangles), &one_cluster());
        let forged = with_words(&valid.expect("one cluster"), words);
        IndexKind::UniformGrid.from_bytes(forged.bytes()).map(|_| ())
    };
    let refused = |what: &str, words: &[u32]| {
        let error = opened(words).err();
        assert!(matches!(error, Some(OpenError::Malformed { .. })), "{what}: {error:?}");
    };
    // Two cells, both full: cells, full cells, mask, rank, firsts and the end, ids.
    opened(&[2, 1, 1, 2, 0b11, 0, 0, 1, 3, 5, 5, 6]).expect("what the format says");
    refused("nothing", &[]);
    refused("no cells", &[0, 1, 1, 0, 0]);
    refused("more cells than an axis may have", &[65_537, 1, 1, 1, 0b1, 0, 0, 1, 5]);
    refused("more cells than a number holds", &[65_536, 65_536, 65_536, 1, 0b1, 0, 0, 1, 5]);
    refused("a cell beyond the last", &[2, 1, 1, 3, 0b111, 0, 0, 1, 2, 3, 5, 5, 6]);
    refused("another number of full cells", &[2, 1, 1, 1, 0b11, 0, 0, 1, 3, 5, 5, 6]);
    refused("another rank", &[2, 1, 1, 2, 0b11, 1, 0, 1, 3, 5, 5, 6]);
    refused("a full cell without references", &[2, 1, 1, 2, 0b11, 0, 0, 0, 3, 5, 5, 6]);
    refused("references in another order", &[2, 1, 1, 2, 0b11, 0, 0, 4, 3, 5, 5, 6]);
    refused("references past the end", &[2, 1, 1, 2, 0b11, 0, 0, 1, 4, 5, 5, 6]);
    refused("the last reference", &[2, 1, 1, 2, 0b11, 0, 0, 1, u32::MAX, 5, 5, 6]);
    refused("a triangle that does not exist", &[2, 1, 1, 2, 0b11, 0, 0, 1, 3, 5, 5, 9]);
    refused("words left over", &[2, 1, 1, 2, 0b11, 0, 0, 1, 3, 5, 5, 6, 0]);
}

/// Damaged words of a wide BVH with upper nodes are refused. The core's `indices/wide/full/mod.rs` describes the
/// format.
#[test]
fn forged_upper_nodes_are_refused() {
    const UPPER_ROWS: usize = 3;
    let triangles = scenes::soup(2_000, 3);
    let kind = IndexKind::WideBvh;
    let valid = Built::new(kind, &Scene::new(&triangles), &Options::default()).expect("a soup");
    let words = valid.index().sections().words().to_vec();
    let (rows, upper_rows) = (words.len() as u32 / 8, words[UPPER_ROWS]);
    let upper: Vec<u32> = (2..2 + upper_rows).step_by(8).collect();
    assert!(upper.len() > 9, "{} upper nodes", upper.len());
    let links: Vec<usize> = upper
        .iter()
        .flat_map(|&row| (0..8).map(move |lane| 8 * (row as usize + 6) + lane))
        .filter(|&place| words[place] != 0)
        .collect();
    let forged = |changes: &[(usize, u32)]| {
        let mut words = words.clone();
        for &(place, word) in changes {
            words[place] = word;
        }
        with_words(&valid, &words)
    };
    let refused = |what: &str, changes: &[(usize, u32)]| {
        let error = kind.from_bytes(forged(changes).bytes()).err();
        assert!(matches!(error, Some(OpenError::Malformed { .. })), "{what}: {error:?}");
    };
    for wrong in [0, 8, upper_rows - 8, upper_rows + 8, upper_rows + 1, rows - 2, rows, u32::MAX] {
        refused("another number of upper nodes", &[(UPPER_ROWS, wrong)]);
    }
    for wrong in [0, 1, 3, upper[1], 2 + upper_rows, rows, u32::MAX] {
        refused("another root", &[(0, wrong)]);
    }
    // Upper nodes, lower nodes and leaves are each in order; the leaves of a node may share rows.
    let order = |link: u32| (link < 2 + upper_rows, link >> 31);
    let in_order = |pair: &&[usize]| {
        let (a, b) = (words[pair[0]], words[pair[1]]);
        order(a) == order(b) && a != b
    };
    for pair in links.windows(2).filter(in_order) {
        let swapped = [(pair[0], words[pair[1]]), (pair[1], words[pair[0]])];
        refused("children in another order", &swapped);
        refused("two children that are one", &swapped[..1]);
    }
    // The first lane of a leaf that shares its rows, and the lanes of no leaf.
    let mut lanes = 0;
    for &place in links.iter().filter(|&&place| words[place] >> 31 == 1) {
        let (row, edge) = (words[place] & !(15 << 28), place + 8);
        for other in 1..8 {
            refused("another lane", &[(edge, words[edge] ^ other)]);
        }
        let ids = 8 * (row as usize + 9);
        for unused in (ids..ids + 8).filter(|&id| words[id] == u32::MAX) {
            refused("a triangle of no leaf", &[(unused, 0)]);
            lanes += 1;
        }
    }
    assert!(lanes > 0, "no unused lane");
    // Any other change of a word is refused or harmless.
    let rays = some_rays(&triangles);
    let values: Vec<u32> =
        upper.iter().copied().chain([0, 1, rows - 8, 1 << 31, u32::MAX]).collect();
    parallel::map(links.len(), |at| {
        for &value in &values {
            is_harmless(&forged(&[(links[at], value)]), &rays);
        }
    });
}

/// Makes the words of an octree that is a chain of `depth` nested cells.
fn chain(depth: u32) -> Vec<u32> {
    let mut words = vec![1];
    for level in 0..depth {
        let child = 3 + 2 * level;
        let leaf = if level + 1 == depth { 1 << 31 } else { 0 };
        words.extend([0x701, child | leaf]);
    }
    if depth == 0 {
        words[0] |= 1 << 31;
    }
    words.extend([1, 0]);
    words
}

#[test]
fn an_octree_deeper_than_the_stack_of_the_traversal_is_refused() {
    let triangles = scenes::lattice(9, 2, 5);
    for kind in [IndexKind::Octree, IndexKind::OctreeHierarchy] {
        let valid = Built::new(kind, &Scene::new(&triangles), &one_cluster()).expect("one cluster");
        let rays = some_rays(&triangles);
        for depth in 0..200 {
            let forged = with_words(&valid, &chain(depth));
            let accepted = is_harmless(&forged, &rays) > 0;
            // The deepest level that can be built, 20, must be accepted; much deeper trees must not.
            assert!(accepted || depth > 20, "a chain of {depth} is refused");
            assert!(!accepted || depth < 30, "a chain of {depth} is accepted");
        }
    }
}

/// Changes two links of the cluster tree, in release builds in a fifth of all ways.
#[test]
fn rewired_cluster_trees_are_harmless() {
    let place = |i: u8| Vec3::X * (100.0 * f32::from(i * i));
    let boxes = (0..6).flat_map(|i| scenes::cuboid(place(i), place(i) + Vec3::ONE));
    let triangles: Vec<_> = boxes.collect();
    for &kind in IndexKind::ALL.iter().filter(|kind| kind.is_clustered()) {
        let built = Built::new(kind, &Scene::new(&triangles), &Options::default());
        let built = built.expect("an ordinary scene");
        let index = built.index();
        let nodes = index.sections().nodes();
        assert_eq!(nodes.len(), 11, "six clusters");
        let start = offset_in(built.bytes(), nodes);
        let rays = some_rays(&triangles);
        // A node has three links: two children and the parent.
        let offsets: Vec<usize> = (0..33).map(|i| start + i / 3 * 36 + 24 + i % 3 * 4).collect();
        let values: Vec<u32> = (0..12).chain([u32::MAX, 1 << 31]).collect();
        let changes: Vec<(usize, u32)> = offsets
            .iter()
            .flat_map(|&offset| values.iter().map(move |&value| (offset, value)))
            .collect();
        parallel::map(changes.len(), |first| {
            let stride = if DEBUG { 37 } else { 5 };
            for second in (first..changes.len()).step_by(stride) {
                let mut damaged = Built::copied(kind, built.bytes());
                for (offset, value) in [changes[first], changes[second]] {
                    damaged.bytes_mut()[offset..offset + 4].copy_from_slice(&value.to_ne_bytes());
                }
                is_harmless(&damaged, &rays);
            }
        });
    }
}

#[test]
fn misaligned_memory_is_an_error() {
    let triangles = scenes::soup(30, 1);
    let scene = Scene::new(&triangles);
    let options = Options { level: Level::AtMost(2), ..Options::default() };
    for &kind in IndexKind::ALL {
        let built = Built::new(kind, &scene, &options).expect("an ordinary scene");
        let length = built.bytes().len();
        let scratch_length = kind.scratch_capacity(30, &options);
        let mut longer = Built::copied(kind, &vec![0; length + 64]);
        let mut scratch = Built::copied(kind, &vec![0; scratch_length + 64]);
        for shift in 1..64 {
            longer.bytes_mut()[shift..shift + length].copy_from_slice(built.bytes());
            let error = kind.from_bytes(&longer.bytes()[shift..]).err();
            assert_eq!(error, Some(OpenError::Misaligned), "{} at {shift}", kind.name());
            for (arena_at, scratch_at) in [(shift, 0), (0, shift)] {
                let arena = &mut longer.bytes_mut()[arena_at..];
                let scratch = &mut scratch.bytes_mut()[scratch_at..];
                let error = kind.build(&scene, &options, arena, scratch).err();
                assert_eq!(error, Some(arboleda::BuildError::Misaligned), "{}", kind.name());
            }
        }
    }
}

#[test]
fn fewer_bytes_than_a_header_are_cut_short_wherever_they_lie() {
    let bytes = [0; 63];
    for length in [0, 1, 62] {
        let error = AnyIndex::from_bytes(&bytes[1..=length]).err();
        assert_eq!(error, Some(OpenError::Truncated), "{length} bytes");
    }
}

#[test]
fn bytes_of_another_kind_order_or_version_are_refused_as_such() {
    for built in indices() {
        for &kind in IndexKind::ALL.iter().filter(|&&kind| kind != built.kind()) {
            let error = kind.from_bytes(built.bytes()).err();
            assert!(matches!(error, Some(OpenError::OtherKind { .. })), "{error:?}");
        }
        let damaged = |change: fn(&mut [u8])| {
            let mut copy = Built::copied(built.kind(), built.bytes());
            change(copy.bytes_mut());
            built.kind().from_bytes(copy.bytes()).err()
        };
        assert_eq!(damaged(|bytes| bytes[0] ^= 1), Some(OpenError::NotAnIndex));
        let swapped = damaged(|bytes| {
            bytes[..4].reverse();
            bytes[4..8].reverse();
        });
        assert_eq!(swapped, Some(OpenError::OtherByteOrder));
        let version = damaged(|bytes| bytes[8..12].copy_from_slice(&77_u32.to_ne_bytes()));
        assert_eq!(version, Some(OpenError::OtherVersion { found: 77 }));
        // Counts with which the sections would end beyond any memory.
        for field in 4..7 {
            let mut copy = Built::copied(built.kind(), built.bytes());
            copy.bytes_mut()[4 * field..4 * field + 4].fill(0xff);
            assert!(built.kind().from_bytes(copy.bytes()).is_err());
        }
    }
}
