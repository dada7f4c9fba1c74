//! Checks of hostile index bytes, which no build wrote.
//!
//! `from_bytes` may refuse such bytes. If it accepts them, every query must end, read only inside the bytes, and do no
//! more work than there are bits.

use arboleda::{AnyIndex, Counters, Hit, IndexKind, Mesh, OpenError, Options, Ray, Triangle, Vec3};

use super::answers_in_flight;
use crate::build::Built;
use crate::{parallel, rays, scenes};

/// Opens bytes as every kind of index, and queries each index that is accepted. Returns the number of kinds that accept
/// the bytes.
///
/// # Panics
/// If a query panics, or does more work than there are bits.
pub fn is_harmless(bytes: &Built, rays: &[Ray]) -> usize {
    is_harmless_beside(bytes, None, rays)
}

/// Checks bytes as [`is_harmless`] does, optionally beside a mesh.
///
/// # Panics
/// If a query panics, or does more work than there are bits.
pub fn is_harmless_beside(bytes: &Built, mesh: Option<Mesh<'_>>, rays: &[Ray]) -> usize {
    let bytes = bytes.bytes();
    // A cell of a grid takes a bit. Each other node, and each reference, takes at least a word; nodes of the cluster
    // tree take nine.
    let most = bytes.len() as u64 * 8;
    let mut accepted = 0;
    for &kind in IndexKind::ALL {
        let index = match mesh {
            None => kind.from_bytes(bytes),
            Some(mesh) => kind.from_bytes_beside(bytes, mesh),
        };
        let Ok(index) = index else {
            continue;
        };
        accepted += 1;
        assert!(index.check().is_ok(), "{} accepts what it finds malformed", kind.name());
        answers_in_flight(&index, rays);
        for ray in rays {
            let mut counters = Counters::default();
            index.closest_hit_counted(ray, &mut counters);
            assert_bounded(kind, &counters, most);
            let mut counters = Counters::default();
            index.occluded_counted(ray, &mut counters);
            assert_bounded(kind, &counters, most);
            let mut buffer = [Hit::NONE; 3];
            let all = index.all_hits(ray, &mut buffer);
            assert!(all.hits.is_sorted_by_key(|hit| (hit.t, hit.triangle)));
        }
    }
    accepted
}

/// Checks that every truncation of the bytes is refused as truncated. `read` opens bytes and returns the error.
///
/// # Panics
/// If a truncation is accepted or refused with another error.
pub fn every_truncation_is_refused(built: &Built, read: impl Fn(&[u8]) -> Option<OpenError>) {
    let bytes = built.bytes();
    for length in 0..bytes.len() {
        let cut = Built::copied(built.kind(), &bytes[..length]);
        let error = read(cut.bytes());
        assert_eq!(error, Some(OpenError::Truncated), "{length} of {} bytes", bytes.len());
    }
}

/// Checks that bytes with any one bit flipped are harmless. `accepted` checks damaged bytes, and returns the number of
/// times that they were accepted.
///
/// # Panics
/// If damaged bytes do harm. Also if all or none of them were accepted: a coordinate may have any value, a header may
/// not.
pub fn every_flipped_bit_is_harmless(built: &Built, accepted: impl Fn(&Built) -> usize + Sync) {
    let bits = built.bytes().len() * 8;
    let accepted = parallel::map(bits.div_ceil(64), |job| {
        let mut damaged = Built::copied(built.kind(), built.bytes());
        let mut sum = 0;
        for bit in (job * 64..bits).take(64) {
            damaged.bytes_mut()[bit / 8] ^= 1 << (bit % 8);
            sum += accepted(&damaged);
            damaged.bytes_mut()[bit / 8] ^= 1 << (bit % 8);
        }
        sum
    });
    let accepted: usize = accepted.iter().sum();
    assert!(accepted > 0 && accepted < bits, "{} {accepted} of {bits}", built.kind().name());
}

/// Makes the scene of small indices, with two groups that are clusters of a hierarchy.
pub fn two_lattices() -> Vec<Triangle> {
    let near = scenes::lattice(14, 2, 3);
    let far = scenes::moved(&scenes::lattice(10, 2, 4), 1.0, Vec3::splat(300.0));
    [near, far].concat()
}

/// Makes a few rays. Every damaged index answers each, so more would take long.
pub fn some_rays(triangles: &[Triangle]) -> Vec<Ray> {
    rays::around(triangles, 6, 1)
}

fn assert_bounded(kind: IndexKind, counters: &Counters, most: u64) {
    let name = kind.name();
    assert!(counters.nodes_visited <= most, "{name}: {counters:?} in {most} bits");
    assert!(counters.triangle_tests <= most, "{name}: {counters:?} in {most} bits");
}

/// Forges an index: replaces the local index of a valid index of one cluster by `words`.
///
/// # Panics
/// If `valid` does not have one cluster.
pub fn with_words(valid: &Built, words: &[u32]) -> Built {
    forged(valid, &valid.index(), words)
}

/// Forges an index as [`with_words`] does, beside a mesh.
///
/// # Panics
/// If `valid` does not have one cluster.
pub fn with_words_beside(valid: &Built, mesh: Mesh<'_>, words: &[u32]) -> Built {
    forged(valid, &valid.index_beside(mesh), words)
}

fn forged(valid: &Built, index: &AnyIndex<'_>, words: &[u32]) -> Built {
    let sections = index.sections();
    assert_eq!(sections.cluster_count(), 1, "the forger knows one cluster only");
    let word_count = sections.local_words(&sections.nodes()[0]).len();
    let words_start = valid.bytes().len() - 4 * word_count;
    let node_start = offset_in(valid.bytes(), sections.nodes());
    let mut bytes = valid.bytes()[..words_start].to_vec();
    // The seventh field of the header is the number of words; so is the second link of a leaf of the cluster tree.
    let length = (words.len() as u32).to_ne_bytes();
    bytes[24..28].copy_from_slice(&length);
    bytes[node_start + 28..node_start + 32].copy_from_slice(&length);
    bytes.extend_from_slice(bytemuck::cast_slice(words));
    Built::copied(valid.kind(), &bytes)
}

/// Computes the offset of a section in index bytes.
pub fn offset_in<T>(bytes: &[u8], part: &[T]) -> usize {
    part.as_ptr().addr() - bytes.as_ptr().addr()
}

/// Returns options with which indices are small and still have all sections.
pub fn small_options() -> Options {
    Options { leaf_capacity: 2, ..Options::default() }
}
