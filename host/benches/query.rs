//! `cargo bench -p arboleda-host --bench query`: the rays of photons through every index.
//!
//! The answers are compared with the guide's, bit for bit, before anything is timed. One iteration answers
//! all rays; the linear scan is left to `arboleda compare`.

use std::hint::black_box;

use arboleda::IndexKind;
use arboleda_host::bench::plan::Case;
use arboleda_host::bench::rays::RaySet;
use arboleda_host::bench::run::{build, check_against_oracle, checked};
use arboleda_host::scene::builtin;
use criterion::{Criterion, Throughput, criterion_group, criterion_main};

/// A scene of clusters far apart, the paper's usual one, and many clusters.
const SCENES: [&str; 3] = ["fig3", "fig4c", "city"];
const PHOTONS: u64 = 2_000;

fn query(criterion: &mut Criterion) {
    for name in SCENES {
        let model = builtin::require(name).expect("the scene is built in");
        let rays = RaySet::shoot(&model, PHOTONS, 1).expect("built-in scenes have lights");
        check_against_oracle(&model, &rays).expect("the guide agrees with the linear scan");
        let mut group = criterion.benchmark_group(format!("query/{name}"));
        group.throughput(Throughput::Elements(rays.of_first(PHOTONS).len() as u64)).sample_size(20);
        for &kind in IndexKind::ALL.iter().filter(|&&kind| kind != IndexKind::Linear) {
            let owned =
                build(&model, &Case::usual(kind), rays.sample()).expect("the defaults are valid");
            let index = owned.index();
            checked(&index, &rays, PHOTONS).expect("every index agrees with the guide");
            let index = index.as_ray_index();
            group.bench_function(kind.name(), |bencher| {
                bencher.iter(|| {
                    for ray in rays.of_first(PHOTONS) {
                        black_box(index.closest_hit(black_box(ray)));
                    }
                });
            });
        }
    }
}

criterion_group!(benches, query);
criterion_main!(benches);
