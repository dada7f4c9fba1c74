//! Every library at every setting answers as ours does, as far as it can.

use arboleda::{Hit, IndexKind, Options, Ray, Vec3};

use super::agreement::Disagreements;
use super::contender::{Answers, Mode};
use super::*;
use crate::TimedIndex;
use crate::benchmark::harness::workload::Workload;
use crate::benchmark::studies::peers::{PeerOptions, run};
use crate::report::pages::peers_table::write_csv;
use crate::scene::builtin;

/// A share of answers that rounding may spoil. The cubes and the floor of the built-in scenes have
/// many rays along edges; ties are counted apart.
const WRONG_SHARE: f64 = 0.01;

#[test]
fn all_agree_with_ours() {
    let model = builtin::require("fig2").unwrap();
    let judge = TimedIndex::build(IndexKind::Bvh, &model.scene(), &Options::default()).unwrap();
    let judge = judge.index();
    let workload = Workload::of_rays(&model, judge.as_ray_index(), 5_000, 7)
        .with_shadow_rays(judge.as_ray_index());
    let count = workload.hits.len();
    assert_eq!(count, 5_000);
    let mut answers = Answers::room(count);
    for peer in PEERS {
        for setting in peer.settings {
            let built = match setting.build(&model.triangles) {
                Err(
                    PeerError::EmbreeMissing { .. }
                    | PeerError::NeedsInstructions { .. }
                    | PeerError::NotCompiled { .. },
                ) => continue,
                built => built.unwrap(),
            };
            for mode in Mode::ALL {
                if !built.contender.answer(mode, workload.rays(mode), &mut answers) {
                    continue;
                }
                let wrong = Disagreements::of(&workload, mode, &answers);
                let share = wrong.wrong() as f64 / count as f64;
                let name = (peer.name, setting.name, mode);
                assert!(share <= WRONG_SHARE, "{name:?}: {wrong:?}");
            }
            assert_ne!(built.contender.bytes(), Some(0));
        }
    }
}

/// Rays whose direction has zeros, from where the bounds of boxes are level with them.
#[test]
fn rays_along_axes_hit() {
    let model = builtin::require("sphere").unwrap();
    let axes = [Vec3::X, Vec3::Y, Vec3::Z];
    let both = axes.iter().flat_map(|&axis| [axis, -axis]);
    let rays: Vec<Ray> = both.flat_map(|to| Ray::new(Vec3::ZERO, to)).collect();
    assert_eq!(rays.len(), 6);
    for peer in PEERS {
        for setting in peer.settings {
            let Ok(built) = setting.build(&model.triangles) else { continue };
            let mut hits = vec![Hit::NONE; rays.len()];
            built.contender.closest_hits(&rays, &mut hits);
            for hit in hits.iter().filter(|hit| !hit.is_none()) {
                assert!((hit.t - 1.0).abs() < 1e-3, "{}: {}", peer.name, hit.t);
            }
        }
    }
}

#[test]
fn ours_do_not_disagree_or_leak() {
    let model = builtin::require("sphere").unwrap();
    let options = PeerOptions {
        ray_count: 2_000,
        rounds: 1,
        leak_ray_count: 2_000,
        peers: &[],
        ..PeerOptions::default()
    };
    let comparison = run(&model, &options, &|| {}).unwrap();
    assert_eq!(comparison.rows.len(), 3 * options.kinds.len());
    for row in &comparison.rows {
        assert_eq!((row.disagreements.total(), row.leaks), (0, Some(0)), "{}", row.contender);
    }

    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("compare.csv");
    write_csv(&path, &comparison.rows).unwrap();
    let csv = std::fs::read_to_string(path).unwrap();
    assert_eq!(
        csv.lines().next(),
        Some(
            "scene,contender,mode,triangles,build_ms,bytes,mrays_median,mrays_min,mrays_max,\
             disagreements,leaks"
        )
    );
    assert_eq!(csv.lines().count(), comparison.rows.len() + 1);
}
