//! Times of uniform tessellations by the size of the net, and of adaptive ones by the tolerance.

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use neurbs::mesh::{TessellateOptions, UniformGrid};
use neurbs::nurbs::KnotVector;
use neurbs::progress::Silent;
use neurbs::{DVec3, NurbsSurface};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

/// A rational bicubic surface over a random net.
fn surface(side: usize) -> NurbsSurface {
    let mut rng = Pcg64::seed_from_u64(0);
    let net = (0..side * side).map(|i| {
        let (row, col) = ((i / side) as f64, (i % side) as f64);
        DVec3::new(row, col, rng.random_range(0.0..2.0))
    });
    let net = net.collect();
    let weights = (0..side * side).map(|_| rng.random_range(0.5..2.0)).collect();
    let knots = KnotVector::clamped_uniform(3, side).expect("the net is large enough");
    NurbsSurface::new(net, Some(weights), knots.clone(), knots).expect("the parts fit")
}

fn tessellation(criterion: &mut Criterion) {
    let grid = UniformGrid::new(500, 500).expect("the sides are fine");
    let mut group = criterion.benchmark_group("tessellation, 500 × 500 vertices with normals");
    group.throughput(Throughput::Elements(grid.vertices() as u64));
    for side in [20, 100] {
        let surface = surface(side);
        group.bench_function(
            BenchmarkId::from_parameter(format!("net {side} × {side}")),
            |bench| {
                bench.iter(|| grid.tessellate(black_box(&surface), &mut Silent));
            },
        );
    }
    group.finish();
}

fn adaptive(criterion: &mut Criterion) {
    let surface = surface(20);
    let mut group = criterion.benchmark_group("adaptive tessellation, net 20 × 20");
    for tolerance in [1e-2, 1e-3, 1e-4] {
        let options =
            TessellateOptions { tolerance: Some(tolerance), relative: true, ..Default::default() };
        let mesh = surface.tessellate(&options, &mut Silent).expect("the limits are fine");
        group.throughput(Throughput::Elements(mesh.triangles.len() as u64));
        group.bench_function(BenchmarkId::from_parameter(tolerance), |bench| {
            bench.iter(|| black_box(&surface).tessellate(&options, &mut Silent));
        });
    }
    group.finish();
}

criterion_group!(benches, tessellation, adaptive);
criterion_main!(benches);
