//! Time of evaluation, heights, closest points, fitting, interpolation and areas, as a function of
//! the net size.
//!
//! The side of the rational bicubic net varies from 5 to 100.

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use neurbs::fit::{FitOptions, fit};
use neurbs::nurbs::{
    ClosestPointSearch, GridOptions, HeightSearch, KnotVector, NurbsSurface, Outside,
};
use neurbs::progress::Silent;
use neurbs::{DVec2, DVec3};

const NETS: [usize; 3] = [5, 20, 100];

fn surface(side: usize) -> NurbsSurface {
    let place = |k: usize| (k / side, k % side);
    let net = (0..side * side).map(place).map(|(i, j)| {
        let (x, y) = (i as f64 * 10.0 / side as f64, j as f64 * 10.0 / side as f64);
        DVec3::new(x, y, (1.3 * x).sin() * (1.1 * y).cos())
    });
    let weights = (0..side * side).map(|k| 1.0 + (k % 7) as f64 / 10.0).collect();
    let knots = KnotVector::clamped_uniform(3, side).unwrap();
    NurbsSurface::new(net.collect(), Some(weights), knots.clone(), knots).unwrap()
}

fn steps(count: usize) -> Vec<f64> {
    (0..count).map(|i| i as f64 / (count - 1) as f64).collect()
}

/// Returns parameters that fill the unit square evenly, in scattered order.
fn scattered(count: usize) -> Vec<DVec2> {
    let place = |i: usize| (i as f64 * 0.754_877_666).fract();
    (0..count).map(|i| DVec2::new(place(i), (i as f64 * 0.569_840_291).fract())).collect()
}

fn evaluation(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("evaluation");
    let (t, uv) = (steps(500), scattered(250_000));
    let (mut points, mut normals) = (vec![DVec3::ZERO; 250_000], vec![DVec3::ZERO; 250_000]);
    group.throughput(Throughput::Elements(250_000));
    for side in NETS {
        let surface = surface(side);
        group.bench_function(BenchmarkId::new("grid points", side), |bencher| {
            bencher.iter(|| {
                surface.evaluate_grid(&t, &t, &mut points, None, Outside::Refuse, &mut Silent)
            });
        });
        group.bench_function(BenchmarkId::new("grid points and normals", side), |bencher| {
            bencher.iter(|| {
                let normals = Some(&mut normals[..]);
                surface.evaluate_grid(&t, &t, &mut points, normals, Outside::Refuse, &mut Silent)
            });
        });
        group.bench_function(BenchmarkId::new("scattered points", side), |bencher| {
            bencher.iter(|| surface.evaluate(&uv, &mut points, Outside::Refuse, &mut Silent));
        });
    }
}

fn heights(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("heights");
    let places: (Vec<f64>, Vec<f64>) =
        scattered(1_000_000).iter().map(|at| (9.0 * at.x, 9.0 * at.y)).unzip();
    let mut z = vec![0.0; 1_000_000];
    group.throughput(Throughput::Elements(1_000_000)).sample_size(10);
    for side in NETS {
        let rational = surface(side);
        let net = rational.control_points().to_vec();
        let polynomial = NurbsSurface::clamped(net, (side, side), 3).unwrap();
        for (name, surface) in [("polynomial", polynomial), ("rational", rational)] {
            let search = HeightSearch::new(&surface).unwrap();
            group.bench_function(BenchmarkId::new(name, side), |bencher| {
                bencher.iter(|| search.heights(&places.0, &places.1, &mut z, &mut Silent));
            });
        }
    }
}

fn inverse_problems(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("inverse problems");
    group.sample_size(20);
    let uv = scattered(10_000);
    for side in NETS {
        let surface = surface(side);
        let place = |at: &DVec2| surface.point(at.x, at.y) + 0.1 * surface.normal(at.x, at.y);
        let points: Vec<DVec3> = uv.iter().map(place).collect();
        group.bench_function(BenchmarkId::new("prepare closest points", side), |bencher| {
            bencher.iter(|| ClosestPointSearch::new(&surface));
        });
        let search = ClosestPointSearch::new(&surface).unwrap();
        group.bench_function(BenchmarkId::new("10,000 closest points", side), |bencher| {
            bencher.iter(|| points.iter().map(|p| search.closest_point(*p).distance).sum::<f64>());
        });
        let options = FitOptions::new((side, side), (3, 3), (false, false)).unwrap();
        group.bench_function(BenchmarkId::new("fit to 10,000 points", side), |bencher| {
            bencher.iter(|| fit(&points, &uv, None, &options, &mut Silent));
        });
        group.bench_function(BenchmarkId::new("interpolate as many", side), |bencher| {
            let net = surface.control_points();
            bencher.iter(|| {
                NurbsSurface::interpolate(net, (side, side), &GridOptions::default(), &mut Silent)
            });
        });
    }
}

/// Measures areas of a wavy sheet and of a random net, which folds in every patch.
fn areas(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("area");
    group.sample_size(10);
    let side = NETS[2];
    let wavy = surface(side);
    let random = |k: usize| (k as f64 * 0.618_033_989 + (k as f64).sin() * 1e4).rem_euclid(1.0);
    let net =
        (0..side * side).map(|k| DVec3::new(random(3 * k), random(3 * k + 1), random(3 * k + 2)));
    let knots = || wavy.knots_u().clone();
    let folded =
        NurbsSurface::new(net.collect(), wavy.weights().map(Into::into), knots(), knots()).unwrap();
    for (name, surface) in [("wavy", &wavy), ("folded", &folded)] {
        for accuracy in [1e-6, 1e-9] {
            group.bench_function(BenchmarkId::new(name, accuracy), |bencher| {
                bencher.iter(|| surface.area(accuracy, &mut Silent));
            });
        }
    }
}

criterion_group!(benches, evaluation, heights, inverse_problems, areas);
criterion_main!(benches);
