//! Tests of discs that walls cut: whole discs, and their visible parts.

use arboleda::IndexKind;

use super::tests::{by_map, disc, estimates, visible};
use super::*;
use crate::density::fixtures::{
    Lit, assert_near, furnace_behind_a_wall, on_floor, uniform_furnace,
};
use crate::density::{
    Estimate, Estimator, Facing, Gather, Light, LightField, MapEstimator, Receiver,
};

/// Estimates by a photon map from the visible part of discs.
fn by_visible_map(
    lit: &Lit,
    radius: f32,
    kernel: Kernel,
    receivers: &[Receiver],
    photons: u64,
) -> Vec<Estimate> {
    let facing = Facing::within_degrees(10.0);
    let map = MapEstimator { gather: Gather::Within { radius }, facing, kernel };
    let estimator = Estimator::PhotonMap(map, Domain::Visible);
    lit.shoot(photons, |source| {
        let kind = IndexKind::WideBvh;
        let field = LightField::new(source.clone(), estimator, kind, Light::Shot, &|_| {}).unwrap();
        field.estimates(receivers, &|_| {}, &|_| {}).unwrap().0
    })
}

#[test]
fn walls_cut_discs_and_the_visible_part_keeps_its_value() {
    let lit = uniform_furnace(0.5);
    let r = 0.25;
    let receivers = [(0.0, 1.0), (0.5 * r, 1.0), (0.0, 0.0)].map(|(x, y)| on_floor(x, y));
    let expected = [(1.0, 0.045), (1.608_998, 0.035), (0.5, 0.063)];
    let planes = estimates(&lit, &disc(r), &receivers, 1_000_000);
    let maps = by_map(&lit, r, &receivers, 1_000_000);
    for ((plane, map), (value, tolerance)) in planes.iter().zip(&maps).zip(expected) {
        assert_near(plane.mean().into(), value, tolerance, "tangent plane");
        assert_eq!(plane.count, map.count);
    }

    let receivers = [on_floor(0.1 * r, 1.0), on_floor(0.5 * r, 1.0), on_floor(0.1 * r, 0.1 * r)];
    for (estimate, tolerance) in
        estimates(&lit, &visible(r), &receivers, 1_000_000).iter().zip([0.045, 0.036, 0.062])
    {
        assert_near(estimate.mean().into(), 2.0, tolerance, "visible polygon");
    }
    // The same for the photons of a map.
    for (estimate, tolerance) in
        by_visible_map(&lit, r, Kernel::Epanechnikov, &receivers, 1_000_000)
            .iter()
            .zip([0.045, 0.036, 0.062])
    {
        let tolerance = tolerance * (4.0_f64 / 3.0).sqrt();
        assert_near(estimate.mean().into(), 2.0, tolerance, "visible polygon of a map");
    }
}

#[test]
fn a_thin_wall_leaks_into_discs_and_not_into_what_they_see() {
    let lit = furnace_behind_a_wall();
    let receivers = [0.1, 0.02, 0.05, 0.15, 0.25].map(|d| on_floor(2.0 + d, 1.0));
    let leaks = estimates(&lit, &disc(0.2), &receivers, 4_000_000);
    assert_near(leaks[0].mean().into(), 0.195_501, 0.063, "leak");
    assert_eq!(leaks[4].count, 0);
    for estimate in estimates(&lit, &visible(0.2), &receivers, 1_000_000) {
        assert_eq!((estimate.count, estimate.mean()), (0, 0.0));
    }
    let leaks = by_map(&lit, 0.2, &receivers, 100_000);
    assert!(leaks[0].count > 0, "a photon map leaks, too");
    for estimate in by_visible_map(&lit, 0.2, Kernel::Constant, &receivers, 100_000) {
        assert_eq!((estimate.count, estimate.mean()), (0, 0.0));
    }
}
