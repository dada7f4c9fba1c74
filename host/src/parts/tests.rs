//! Tests of parts of shots: cut anywhere, they are the shot.

use arboleda::{IndexKind, Vec3};

use super::*;
use crate::photon::fixtures::{BuiltIndex, closed_box, lamp, model};
use crate::photon::{ShootOptions, Shot, shoot, shoot_range};
use crate::scene::Model;

fn room(photons: u64) -> (Model, ShootOptions) {
    let mut triangles = closed_box(Vec3::ZERO, Vec3::new(4.0, 3.0, 2.0));
    triangles.pop();
    let model = model(triangles, 0.7, lamp(Vec3::new(2.0, 1.5, 1.9), 0.5, 40.0));
    (model, ShootOptions { photons, max_bounces: 6, ..ShootOptions::default() })
}

/// Shoots the photons between neighbouring cuts through one index after the other, with one to three threads.
fn parts(model: &Model, options: &ShootOptions, cuts: &[u64]) -> Vec<JobPart> {
    let ends = cuts.iter().skip(1).copied();
    let ranges = cuts.iter().zip(ends).map(|(&start, end)| start..end);
    let shot = ranges.enumerate().map(|(at, range)| {
        let mut built = BuiltIndex::new(model, IndexKind::ALL[at % IndexKind::ALL.len()]);
        let options = ShootOptions { threads: Some(1 + at % 3), ..options.clone() };
        let index = built.index();
        let sums = shoot_range(model, index.as_ray_index(), &options, range.clone(), &|_| {});
        JobPart { photons: range, sums: PartSums::Shot(sums) }
    });
    shot.collect()
}

fn join(parts: Vec<JobPart>) -> Option<JobPart> {
    parts.into_iter().reduce(|mut all, part| {
        assert!(all.join(part));
        all
    })
}

fn whole(model: &Model, options: &ShootOptions) -> Shot {
    shoot(model, &BuiltIndex::new(model, IndexKind::Octree).index(), options, &|_| {})
}

#[test]
fn parts_cut_anywhere_are_the_shot() {
    for (photons, cuts) in [
        (70_000, &[0, 1, 2, 1_023, 1_025, 5_000, 40_960, 40_961, 69_999, 70_000][..]),
        (70_000, &[0, 32_768, 65_536, 70_000]),
        (70_000, &[0, 70_000]),
        (2_048, &[0, 1_024, 1_500, 2_048]),
        (500, &[0, 100, 300, 500]),
        (1, &[0, 1]),
    ] {
        let (model, options) = room(photons);
        let (job, shot) = (Job::of_shot(&model, &options), whole(&model, &options));
        // The left half, the right half, and both.
        let mut left = parts(&model, &options, cuts);
        let right = left.split_off(left.len() / 2);
        let halves: Vec<JobPart> = [left, right].into_iter().filter_map(join).collect();
        let joined = join(halves).unwrap();
        assert_eq!(joined.digest(&job), Some(shot.digest), "{cuts:?}");
        assert_eq!(joined.sums.balance(), shot.balance);
        let PartSums::Shot(sums) = &joined.sums else { panic!("a shot") };
        assert_eq!(sums.bounce_count, shot.bounce_count);
        let both: Vec<u64> = sums.hits.iter().map(|[a, b]| a + b).collect();
        assert_eq!(both, shot.hit_counts);
        let front: Vec<u64> = sums.hits.iter().map(|sides| sides[0]).collect();
        assert_eq!(front, shot.front_hit_counts);
    }
}

#[test]
fn parts_that_do_not_follow_are_not_joined() {
    let (model, options) = room(3_000);
    let [first, second, third] = &parts(&model, &options, &[0, 1_000, 2_000, 3_000])[..] else {
        panic!("three parts")
    };
    let mut joined = first.clone();
    assert!(!joined.join(third.clone()) && !joined.join(first.clone()));
    assert_eq!(joined, *first);
    assert!(joined.join(second.clone()) && joined.join(third.clone()));
}

#[test]
fn a_shot_without_photons_knows_the_flux_of_the_lights() {
    let (model, options) = room(0);
    let shot = whole(&model, &options);
    assert_eq!((shot.balance.emitted, shot.balance.total_flux), (0, 40.0));
}

#[test]
fn a_scene_without_light_has_parts_too() {
    let (mut model, options) = room(3_000);
    model.lights.clear();
    let (job, shot) = (Job::of_shot(&model, &options), whole(&model, &options));
    let joined = join(parts(&model, &options, &[0, 10, 3_000])).unwrap();
    assert_eq!(joined.digest(&job), Some(shot.digest));
}

/// Takes the counts of parts out, adds them, and puts the sums into what is left, as several processes do.
#[test]
fn counts_that_are_added_apart_are_those_of_one_run() {
    let (model, options) = room(5_000);
    let all = join(parts(&model, &options, &[0, 1_000, 3_000, 5_000])).unwrap();
    let mut added = vec![0; 2 * model.triangles.len()];
    let rests = parts(&model, &options, &[0, 1_000, 3_000, 5_000]).into_iter().map(|mut part| {
        for (of, counts) in part.sums.take_counts() {
            assert_eq!(of, (0, 0));
            added.iter_mut().zip(counts).for_each(|(sum, count)| *sum += count);
        }
        part
    });
    let mut joined = join(rests.collect()).unwrap();
    assert_ne!(joined, all);
    joined.sums.put_counts((0, 0), &added);
    joined.sums.put_counts((0, 1), &[]);
    assert_eq!(joined, all);
}
