//! Batch of rays: each ray with what it is for, answered together.

use arboleda::{BATCH_SCRATCH, Hit, Ray, RayIndex};

/// Makes the scratch of batches. A job makes it once, and uses it for one batch after the other.
pub(super) fn scratch() -> Vec<u8> {
    vec![0; BATCH_SCRATCH]
}

/// Finds the closest hits of the rays, in their order; [`Hit::NONE`] where there is none.
pub(super) fn closest_hits<P>(
    index: &dyn RayIndex,
    rays: &[(P, Ray)],
    scratch: &mut [u8],
) -> Vec<Hit> {
    let rays: Vec<Ray> = rays.iter().map(|(_, ray)| *ray).collect();
    let mut hits = vec![Hit::NONE; rays.len()];
    index.closest_hits_in(&rays, &mut hits, scratch);
    hits
}
