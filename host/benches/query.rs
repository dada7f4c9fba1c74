//! `cargo bench -p arboleda-host --bench query`: the rays of photons through every index.
//!
//! The answers are compared with the guide's, bit for bit, before anything is timed. One iteration answers
//! all rays; the linear scan is left to `arboleda compare`.

use std::hint::black_box;

use arboleda::IndexKind;
use arboleda_host::benchmark::contenders::contender::Mode;
use arboleda_host::benchmark::harness::measurement::{build, checked, verified_workload};
use arboleda_host::benchmark::harness::plan::{Case, Effort, Share};
use arboleda_host::scene::builtin;
use criterion::{Criterion, Throughput, criterion_group, criterion_main};

/// A scene of clusters far apart, the paper's usual one, and many clusters.
const SCENES: [&str; 3] = ["fig3", "fig4c", "city"];
const PHOTONS: u64 = 2_000;
const EFFORT: Effort =
    Effort { photons: PHOTONS, repetitions: 1, seconds: 1.0, share: Share::Own, seed: 1 };

fn query(criterion: &mut Criterion) {
    for name in SCENES {
        let model = builtin::require(name).expect("the scene is built in");
        let workload =
            verified_workload(&model, &EFFORT).expect("the guide agrees with the linear scan");
        let rays = workload.rays(Mode::Single);
        let mut group = criterion.benchmark_group(format!("query/{name}"));
        group.throughput(Throughput::Elements(rays.len() as u64)).sample_size(20);
        for &kind in IndexKind::ALL.iter().filter(|&&kind| kind != IndexKind::Linear) {
            let owned = build(&model, &Case::usual(kind), workload.sample())
                .expect("the defaults are valid");
            let index = owned.index();
            checked(&index, &workload, PHOTONS).expect("every index agrees with the guide");
            let index = index.as_ray_index();
            group.bench_function(kind.name(), |bencher| {
                bencher.iter(|| {
                    for ray in rays {
                        black_box(index.closest_hit(black_box(ray)));
                    }
                });
            });
        }
    }
}

criterion_group!(benches, query);
criterion_main!(benches);
