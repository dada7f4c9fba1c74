//! `cargo bench -p arboleda-host --bench build`: every index, built in memory that is there already.
//!
//! Before anything is timed, the answers to some photons' rays are compared with the guide's.

use arboleda::{Block, IndexKind};
use arboleda_host::benchmark::harness::measurement::{build, checked, verified_workload};
use arboleda_host::benchmark::harness::plan::{Case, Effort, Share};
use arboleda_host::scene::builtin;
use criterion::{Criterion, Throughput, criterion_group, criterion_main};

const SCENES: [&str; 3] = ["fig2", "fig3", "fig4c"];
const PHOTONS: u64 = 500;
const EFFORT: Effort =
    Effort { photons: PHOTONS, repetitions: 1, seconds: 1.0, share: Share::Own, seed: 1 };

fn builds(criterion: &mut Criterion) {
    for name in SCENES {
        let model = builtin::require(name).expect("the scene is built in");
        let workload =
            verified_workload(&model, &EFFORT).expect("the guide agrees with the linear scan");
        let mut group = criterion.benchmark_group(format!("build/{name}"));
        group.throughput(Throughput::Elements(model.triangles.len() as u64)).sample_size(10);
        for &kind in IndexKind::ALL.iter().filter(|&&kind| kind != IndexKind::Linear) {
            let case = Case::usual(kind);
            let owned = build(&model, &case, &[]).expect("the defaults are valid");
            checked(&owned.index(), &workload, PHOTONS).expect("every index agrees");
            let mut arena = vec![Block::ZERO; Block::count(owned.bytes())];
            let mut scratch = vec![Block::ZERO; Block::count(owned.scratch_bytes())];
            group.bench_function(kind.name(), |bencher| {
                bencher.iter(|| {
                    let (arena, scratch) = (Block::bytes(&mut arena), Block::bytes(&mut scratch));
                    kind.build(&model.scene(), &case.options, arena, scratch).is_ok()
                });
            });
        }
    }
}

criterion_group!(benches, builds);
criterion_main!(benches);
