//! Times of uniform tessellations by the size of the net, of adaptive ones by the tolerance, and of a
//! shell of many faces.

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use neurbs::mesh::{TessellateOptions, UniformGrid};
use neurbs::nurbs::KnotVector;
use neurbs::progress::Silent;
use neurbs::{DVec3, Face, NurbsSurface, Shell};
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

/// A sphere cut into rows and columns of faces.
fn cut_sphere(rows: u32, cols: u32) -> Shell {
    let sphere = NurbsSurface::sphere(DVec3::ZERO, 1.0).expect("the radius is fine");
    let at = |k: u32, n: u32| f64::from(k) / f64::from(n);
    let mut faces = vec![];
    for (i, j) in (0..rows).flat_map(|i| (0..cols).map(move |j| (i, j))) {
        let (u, v) = ((at(i, rows), at(i + 1, rows)), (at(j, cols), at(j + 1, cols)));
        let part = sphere.sub_surface(u, v, &mut Silent).expect("the domain is (0, 1)");
        faces.push(Face::whole(part).expect("the knots are clamped"));
    }
    Shell::new(faces, None).expect("the faces fit")
}

fn shell(criterion: &mut Criterion) {
    let shell = cut_sphere(10, 10);
    let options = TessellateOptions { tolerance: Some(1e-3), relative: true, ..Default::default() };
    let found = shell.tessellate(&options, &mut Silent).expect("the limits are fine");
    let mut group = criterion.benchmark_group("tessellation of a shell");
    group.throughput(Throughput::Elements(found.mesh.triangles.len() as u64));
    group.bench_function("100 faces", |bench| {
        bench.iter(|| black_box(&shell).tessellate(&options, &mut Silent));
    });
    group.finish();
}

criterion_group!(benches, tessellation, adaptive, shell);
criterion_main!(benches);
