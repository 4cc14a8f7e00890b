//! Time of an online training by size of the lattice.

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use neurbs::DVec3;
use neurbs::progress::Silent;
use neurbs::som::{Lattice, SelfOrganizingMap, SomOptions};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

/// Presentations in each run.
const STEPS: u64 = 100_000;

/// Points scattered over a wave.
fn wave(count: usize) -> Vec<DVec3> {
    let mut rng = Pcg64::seed_from_u64(0);
    let mut point = || {
        let (x, y) = (rng.random_range(-1.0..1.0), rng.random_range(-1.0..1.0));
        DVec3::new(x, y, f64::sin(3.0 * x) * f64::cos(2.0 * y))
    };
    (0..count).map(|_| point()).collect()
}

fn training(criterion: &mut Criterion) {
    let points = wave(10_000);
    let options =
        SomOptions { max_steps: Some(STEPS), min_change: Some(1e-9), ..SomOptions::paper() };
    let mut group = criterion.benchmark_group("training, 100,000 presentations of 10,000 points");
    group.sample_size(10);
    for side in [10, 20, 40] {
        let lattice = Lattice::quad(side, side).expect("the sides are fine");
        group.bench_function(BenchmarkId::from_parameter(format!("{side} × {side}")), |bench| {
            bench.iter(|| {
                SelfOrganizingMap::fit(black_box(&points), lattice.clone(), &options, &mut Silent)
            });
        });
    }
    group.finish();
}

criterion_group!(benches, training);
criterion_main!(benches);
