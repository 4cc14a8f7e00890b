//! Cost of a batch epoch by number of points and nodes, and of a presentation in online training.

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use neurbs::DVec3;
use neurbs::progress::Silent;
use neurbs::som::{Init, Lattice, Schedule, SelfOrganizingMap, SomOptions, Training};

/// Unordered points of a wavy sheet.
fn sheet(count: u32) -> Vec<DVec3> {
    let point = |i: u32| {
        let (x, y) = (f64::from(i) * 0.754_877_666, f64::from(i) * 0.569_840_291);
        let (x, y) = (x.fract(), y.fract());
        DVec3::new(x, y, 0.2 * (4.0 * x).sin() * (3.0 * y).cos())
    };
    (0..count).map(point).collect()
}

/// A map trained for a few epochs, so that its nodes are near the points.
fn trained(points: &[DVec3], side: usize) -> SelfOrganizingMap {
    let options = SomOptions { epochs: Some(5), ..SomOptions::default() };
    let lattice = Lattice::quad(side, side).expect("sides are at least 2");
    SelfOrganizingMap::fit(points, lattice, &options, &mut Silent).expect("a sheet can be learned")
}

fn epoch(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("epoch");
    group.sample_size(10);
    for (count, side) in
        [(10_000, 50), (100_000, 50), (1_000_000, 50), (100_000, 10), (100_000, 316)]
    {
        let points = sheet(count);
        let som = trained(&points, side);
        group.throughput(Throughput::Elements(u64::from(count)));
        let name = BenchmarkId::new(format!("{} nodes", side * side), count);
        group.bench_function(name, |bencher| {
            bencher.iter_batched_ref(
                || som.clone(),
                |som| {
                    let sums = som.sums(&points, &mut Silent).expect("points are finite");
                    som.learn(&sums, &mut Silent).expect("sums are of this map");
                },
                criterion::BatchSize::LargeInput,
            );
        });
    }
    group.finish();
}

fn online(criterion: &mut Criterion) {
    let points = sheet(10_000);
    let mut group = criterion.benchmark_group("presentations");
    group.throughput(Throughput::Elements(10_000));
    for side in [10, 20, 50] {
        let som = trained(&points, side);
        let options = SomOptions {
            training: Training::Online,
            init: Init::Given(som.codebook()),
            radius: Some(Schedule::Linear { start: 5.0, end: 1.0 }),
            ..SomOptions::default()
        };
        let start = SelfOrganizingMap::new(&points, som.lattice, &options, &mut Silent);
        let start = start.expect("options are valid");
        group.bench_function(BenchmarkId::new("nodes", side * side), |bencher| {
            bencher.iter_batched_ref(
                || start.clone(),
                |som| som.present(&points, &mut Silent).expect("points are finite"),
                criterion::BatchSize::LargeInput,
            );
        });
    }
    group.finish();
}

criterion_group!(benches, epoch, online);
criterion_main!(benches);
