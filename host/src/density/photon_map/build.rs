//! Build of the kd-tree: photons are put into the order of the tree.

use super::Photon;

/// Most photons of a run that is not divided further: few enough that most of them are near a point that reaches the
/// run, and enough that a search skips the last levels of the tree, which cost more than they save.
pub const LEAF: usize = 12;
/// Photons of a run below which both halves are ordered by the same thread.
const ALONE: usize = 1 << 13;

/// Puts photons into the order of the tree, in the caller's pool. Ranks are distinct. Cost: `n log n`.
pub fn order(photons: &mut [Photon]) {
    if photons.len() <= LEAF {
        photons.sort_unstable_by_key(Photon::rank);
        return;
    }
    // 1. The plane is across the widest side of the photons' box; of equal ones, the first.
    let (mut lo, mut hi) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    for photon in photons.iter() {
        for (axis, &x) in photon.position.iter().enumerate() {
            lo[axis] = lo[axis].min(x);
            hi[axis] = hi[axis].max(x);
        }
    }
    let extent = [0, 1, 2].map(|axis| f64::from(hi[axis]) - f64::from(lo[axis]));
    let axis =
        (1..3).fold(0, |widest, axis| if extent[axis] > extent[widest] { axis } else { widest });

    // 2. The median by (coordinate, rank) is the root. The order is total, so the halves are determined.
    let middle = photons.len() / 2;
    photons.select_nth_unstable_by(middle, |a, b| {
        a.position[axis].total_cmp(&b.position[axis]).then(a.rank().cmp(&b.rank()))
    });
    let (lower, rest) = photons.split_at_mut(middle);
    let Some((root, upper)) = rest.split_first_mut() else { return };

    // 3. Both halves.
    if lower.len() + upper.len() < ALONE {
        order(lower);
        order(upper);
    } else {
        rayon::join(|| order(lower), || order(upper));
    }
    root.set_axis(axis);
}
