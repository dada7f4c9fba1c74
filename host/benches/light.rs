//! `cargo bench -p arboleda-host --bench light`: photon maps and estimates of irradiance, on one thread.
//!
//! The nearest photons are compared with those of the crate `kiddo`, by distance, before anything is timed. Both trees
//! have the same photons, and answer the same points on surfaces. `kiddo` computes in `f32`, and its ties are its own.

use std::hint::black_box;
use std::num::NonZero;

use arboleda::{IndexKind, Options, OwnedIndex, Vec3};
use arboleda_host::density::{
    Discs, Domain, Fan, Kernel, Neighbourhood, PhotonMap, PhotonSource, Receiver, TangentPlane,
};
use arboleda_host::scene::builtin;
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use kiddo::{ImmutableKdTree, SquaredEuclidean};

const PHOTONS: u64 = 1_000_000;
const POINTS: usize = 20_000;
const NEAREST: [usize; 2] = [50, 200];

fn light(criterion: &mut Criterion) {
    // One thread for all, as `kiddo` has without its feature.
    rayon::ThreadPoolBuilder::new().num_threads(1).build_global().expect("the first pool");
    let model = builtin::require("fig4b").expect("the scene is built in");
    let built = OwnedIndex::build(IndexKind::WideBvh, &model.scene(), &Options::DEFAULT);
    let built = built.expect("the defaults are valid");
    let index = built.index();
    let source = PhotonSource::new(&model, index.as_ray_index(), PHOTONS, 1);
    let map = PhotonMap::shoot(&source, &|_| {}).expect("a million photons fit");
    let positions: Vec<[f32; 3]> = map.positions().map(|position| position.to_array()).collect();
    let tree = ImmutableKdTree::new_from_slice(&positions).expect("finite positions");
    // Points where photons fell, moved by a little.
    let step = positions.len() / POINTS;
    let points: Vec<Vec3> = positions
        .iter()
        .step_by(step)
        .take(POINTS)
        .map(|&position| Vec3::from_array(position) + Vec3::new(0.01, 0.02, 0.0))
        .collect();
    let receivers: Vec<Receiver> = points
        .iter()
        .map(|&point| Receiver::new(point, Vec3::Z).expect("a valid normal"))
        .collect();

    let mut group = criterion.benchmark_group("light/photons");
    group.throughput(Throughput::Elements(PHOTONS)).sample_size(10);
    group.bench_function("photon map, shot and built", |bencher| {
        bencher.iter(|| black_box(PhotonMap::shoot(&source, &|_| {}).expect("it fits")));
    });
    group.bench_function("kiddo, built only", |bencher| {
        bencher.iter(|| black_box(ImmutableKdTree::new_from_slice(&positions).expect("finite")));
    });
    group.finish();

    let around = |receiver| Neighbourhood { receiver, facing: None, radius: 1e9 };
    let mut found = Vec::new();
    for k in NEAREST {
        let count = NonZero::new(k).expect("above 0");
        for receiver in &receivers[..200] {
            map.nearest(&around(receiver), k, &mut found);
            let place = receiver.position().to_array();
            let theirs = tree.query(&place).nearest_n::<SquaredEuclidean<f32>>(count).execute();
            assert_eq!(found.len(), theirs.len());
            for (ours, theirs) in found.iter().zip(&theirs) {
                let (ours, theirs) = (ours.distance_squared(), f64::from(theirs.distance));
                assert!((ours - theirs).abs() <= 1e-4 * ours + 1e-9, "{ours} {theirs}");
            }
        }
        let mut group = criterion.benchmark_group(format!("light/nearest {k}"));
        group.throughput(Throughput::Elements(POINTS as u64)).sample_size(10);
        group.bench_function("arboleda", |bencher| {
            bencher.iter(|| {
                for receiver in &receivers {
                    map.nearest(&around(black_box(receiver)), k, &mut found);
                    black_box(&found);
                }
            });
        });
        group.bench_function("kiddo", |bencher| {
            bencher.iter(|| {
                for point in &points {
                    let place = black_box(point.to_array());
                    let query = tree.query(&place).nearest_n::<SquaredEuclidean<f32>>(count);
                    black_box(query.execute());
                }
            });
        });
        group.finish();
    }

    let mut group = criterion.benchmark_group("light/detp");
    group.throughput(Throughput::Elements(PHOTONS)).sample_size(10);
    let options =
        TangentPlane { radius: 0.29, beyond: 0.0, kernel: Kernel::Constant, domain: Domain::Disc };
    group.bench_function("20,000 discs", |bencher| {
        bencher.iter(|| {
            let fan = Fan::default();
            let kind = IndexKind::WideBvh;
            let mut discs = Discs::new(&receivers, &options, kind, source.index, &fan)
                .expect("the discs are small");
            black_box(discs.count(&source, &|_| {}));
            black_box(discs.estimate(0, 1.0))
        });
    });
    group.finish();
}

criterion_group!(benches, light);
criterion_main!(benches);
