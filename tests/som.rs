//! The self-organizing map: properties that hold for any points, and each option.

use std::ops::ControlFlow;

use neurbs::progress::{Epoch, Observer, Progress, Silent};
use neurbs::som::{
    BatchSums, Cells, Init, Kernel, Lattice, Neighborhood, Presentation, Schedule,
    SelfOrganizingMap, SomOptions, StoppedBy, Topology, Training,
};
use neurbs::{DVec2, DVec3, Error};
use proptest::prelude::*;

/// Pseudo-random numbers from 0 to 1.
fn noise(index: usize, salt: f64) -> f64 {
    ((index as f64 + 1.0) * (12.9898 + salt)).sin().mul_add(43_758.545_3, 0.0).rem_euclid(1.0)
}

/// A wavy sheet.
fn sheet(count: usize) -> Vec<DVec3> {
    let point = |i| {
        let (x, y) = (noise(i, 0.0), noise(i, 7.0));
        DVec3::new(x, y, 0.2 * (4.0 * x).sin() * (3.0 * y).cos())
    };
    (0..count).map(point).collect()
}

fn fit(points: &[DVec3], lattice: &Lattice, options: &SomOptions) -> SelfOrganizingMap {
    SelfOrganizingMap::fit(points, lattice.clone(), options, &mut Silent).unwrap()
}

fn online() -> SomOptions {
    SomOptions { training: Training::Online, max_steps: Some(3000), ..SomOptions::default() }
}

/// One epoch of the textbook batch map, comparing every node with every point.
fn plain_epoch(
    nodes: &[DVec3],
    points: &[DVec3],
    weight: impl Fn(usize, usize) -> f64,
) -> Vec<DVec3> {
    let winner = |p: &DVec3| {
        let distance = |i: &usize| nodes[*i].distance_squared(*p);
        (0..nodes.len()).min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap()
    };
    let winners: Vec<usize> = points.iter().map(winner).collect();
    let place = |node: usize| {
        let (mut sum, mut total) = (DVec3::ZERO, 0.0);
        for (&winner, &point) in winners.iter().zip(points) {
            sum += weight(node, winner) * point;
            total += weight(node, winner);
        }
        if total > 0.0 { sum / total } else { nodes[node] }
    };
    (0..nodes.len()).map(place).collect()
}

#[test]
fn an_epoch_agrees_with_a_plain_batch_map_on_every_topology() {
    let points = sheet(500);
    let radius = 1.7_f64;
    for topology in Topology::ALL {
        for cells in Cells::ALL {
            for neighborhood in Neighborhood::ALL {
                let lattice = Lattice::grid(6, 5, cells, topology).unwrap();
                let start = fit(
                    &points,
                    &lattice,
                    &SomOptions { epochs: Some(2), ..SomOptions::default() },
                );
                let options = SomOptions {
                    init: Init::Given(start.codebook()),
                    neighborhood,
                    kernel: Some(Kernel::Mean),
                    radius: Some(Schedule::Constant(radius)),
                    epochs: Some(1),
                    ..SomOptions::default()
                };
                let closed = topology.closed();
                let hops = |a: usize, b: usize| {
                    (0..30).find(|&hops| lattice.neighborhood(a, hops).contains(&b)).unwrap()
                };
                let around = |a: usize, b: usize, count: usize, closed: bool| {
                    let apart = a.abs_diff(b);
                    (if closed { apart.min(count - apart) } else { apart }) as f64
                };
                let weight = |a: usize, b: usize| match (neighborhood, cells) {
                    (Neighborhood::Bubble, _) => f64::from(u8::from(hops(a, b) as f64 <= radius)),
                    (Neighborhood::Gaussian, Cells::Triangular) => {
                        (-0.5 * (hops(a, b) as f64 / radius).powi(2)).exp()
                    }
                    (Neighborhood::Gaussian, Cells::Quad) => {
                        let (du, dv) =
                            (around(a / 5, b / 5, 6, closed.0), around(a % 5, b % 5, 5, closed.1));
                        (-0.5 * (du * du + dv * dv) / (radius * radius)).exp()
                    }
                };
                let expected = plain_epoch(&start.codebook(), &points, weight);
                let got = fit(&points, &lattice, &options).codebook();
                for (got, expected) in got.iter().zip(&expected) {
                    assert!(
                        got.distance(*expected) < 1e-12,
                        "{topology:?} {cells:?} {neighborhood:?}"
                    );
                }
            }
        }
    }
}

/// The linear kernel keeps a plane with its border; the mean shrinks the border.
#[test]
fn the_linear_kernel_reproduces_a_plane_up_to_its_border() {
    let lattice = Lattice::quad(9, 7).unwrap();
    let node = |i: usize| DVec3::new((i / 7) as f64, 2.0 * (i % 7) as f64, 0.5 * (i / 7) as f64);
    let nodes: Vec<DVec3> = (0..63).map(node).collect();
    let largest_move = |kernel| {
        let options = SomOptions {
            init: Init::Given(nodes.clone()),
            kernel: Some(kernel),
            radius: Some(Schedule::Constant(1.0)),
            epochs: Some(1),
            reach: Some(1e-12),
            ..SomOptions::default()
        };
        // Two points beside each node, with their mean at the node, so that none is on the lattice.
        let points: Vec<DVec3> = nodes.iter().flat_map(|&n| [n + 0.01, n - 0.01]).collect();
        fit(&points, &lattice, &options).change.unwrap()
    };
    assert!(largest_move(Kernel::Linear) < 0.01, "{}", largest_move(Kernel::Linear));
    assert!(largest_move(Kernel::Mean) > 0.5);
}

#[test]
fn training_on_its_own_nodes_leaves_a_lattice_unchanged() {
    let nodes = sheet(48);
    for (lattice, training) in [
        (Lattice::quad(6, 8).unwrap(), Training::Batch),
        (Lattice::grid(6, 8, Cells::Triangular, Topology::Torus).unwrap(), Training::Batch),
        (Lattice::quad(6, 8).unwrap(), Training::Online),
    ] {
        let options = SomOptions {
            training,
            init: Init::Given(nodes.clone()),
            radius: Some(Schedule::Constant(0.0)),
            max_steps: Some(200),
            reach: Some(1e-14),
            min_change: Some(1e-300),
            presentation: Presentation::Shuffled,
            ..SomOptions::default()
        };
        let som = fit(&nodes, &lattice, &options);
        for (got, expected) in som.codebook().iter().zip(&nodes) {
            assert!(got.distance(*expected) < 1e-15);
        }
        assert_eq!((som.reached, som.stopped_by), (48, StoppedBy::Reached));
        if training == Training::Batch {
            // One more epoch computes the nodes again.
            let mut again = som.clone();
            let sums = again.sums(&nodes, &mut Silent).unwrap();
            again.learn(&sums, &mut Silent).unwrap();
            assert_eq!(again.steps, som.steps + 1);
            for (got, expected) in again.codebook().iter().zip(&nodes) {
                assert!(got.distance(*expected) < 1e-15);
            }
        }
        assert_eq!(som.predict(&nodes, &mut Silent).unwrap(), (0..48).collect::<Vec<_>>());
    }
}

#[test]
fn results_have_the_same_bits_on_any_number_of_threads() {
    let points = sheet(70_000);
    let lattice = Lattice::quad(12, 15).unwrap();
    let triangular = Lattice::grid(12, 15, Cells::Triangular, Topology::Torus).unwrap();
    let batch = SomOptions { epochs: Some(3), ..SomOptions::default() };
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let som = fit(&points, &lattice, &batch);
            let uv = som.parametrize(&points, 0.75, &mut Silent).unwrap();
            let errors = (
                som.quantization_error(&points, &mut Silent).unwrap().to_bits(),
                som.topographic_error(&points, &mut Silent).unwrap().to_bits(),
            );
            let others = [fit(&points, &triangular, &batch), fit(&points, &lattice, &online())];
            (som, uv, errors, others)
        })
    };
    let expected = run(1);
    assert_eq!(run(2), expected);
    assert_eq!(run(7), expected);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn permuted_points_and_any_split_give_the_same_bits(
        cuts in proptest::collection::vec(0_usize..400, 0..6),
        seed in 0_u64..1000,
    ) {
        let points = sheet(400);
        let mut order: Vec<usize> = (0..400).collect();
        order.sort_by(|&a, &b| noise(a, seed as f64).total_cmp(&noise(b, seed as f64)));
        let permuted: Vec<DVec3> = order.iter().map(|&i| points[i]).collect();
        let start = fit(&points, &Lattice::quad(6, 7).unwrap(), &SomOptions { epochs: Some(1), ..SomOptions::default() });
        let options = SomOptions { init: Init::Given(start.codebook()), epochs: Some(4), ..SomOptions::default() };
        let whole = fit(&points, &start.lattice, &options);
        prop_assert_eq!(fit(&permuted, &start.lattice, &options).codebook(), whole.codebook());

        let mut som = SelfOrganizingMap::new(&points, start.lattice.clone(), &options, &mut Silent).unwrap();
        let mut cuts = cuts;
        cuts.extend([0, 400]);
        cuts.sort_unstable();
        for _ in 0..4 {
            let parts = cuts.windows(2).filter(|cut| cut[0] < cut[1]);
            let mut sums: Vec<BatchSums> = parts
                .map(|cut| som.sums(&permuted[cut[0]..cut[1]], &mut Silent).unwrap())
                .collect();
            let mut total = sums.pop().unwrap();
            for part in &sums {
                total.merge(part).unwrap();
            }
            som.learn(&total, &mut Silent).unwrap();
        }
        prop_assert_eq!(som.codebook(), whole.codebook());
    }

    #[test]
    fn results_follow_rigid_motions_and_scaling_of_the_points(
        angle in 0.0_f64..6.0,
        scale in 0.01_f64..100.0,
        x in -1e3_f64..1e3,
    ) {
        let points = sheet(300);
        let turn = glam::DQuat::from_axis_angle(DVec3::new(1.0, 2.0, -2.0).normalize(), angle);
        let motion = |p: DVec3| scale * (turn * p) + DVec3::new(x, -2.0 * x, 0.5 * x);
        let lattice = Lattice::quad(5, 6).unwrap();
        let start = fit(&points, &lattice, &SomOptions { epochs: Some(2), ..SomOptions::default() });
        for options in [SomOptions { epochs: Some(5), ..SomOptions::default() }, online()] {
            let given = |nodes| SomOptions { init: Init::Given(nodes), min_change: Some(1e-300 * scale), ..options.clone() };
            let moved_start: Vec<DVec3> = start.codebook().into_iter().map(motion).collect();
            let moved_points: Vec<DVec3> = points.iter().map(|&p| motion(p)).collect();
            let expected = fit(&points, &lattice, &given(start.codebook()));
            let got = fit(&moved_points, &lattice, &given(moved_start));
            for (got, expected) in got.codebook().iter().zip(expected.codebook()) {
                prop_assert!(got.distance(motion(expected)) < 1e-9 * scale.max(x.abs() * 1e-3));
            }
        }
    }
}

/// An observer that stops after this number of calls.
struct StopAfter(usize);

impl Observer for StopAfter {
    fn observe(&mut self, _: &Progress) -> ControlFlow<()> {
        self.0 = self.0.saturating_sub(1);
        if self.0 == 0 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    fn observe_epoch(&mut self, _: &Epoch<'_>) -> ControlFlow<()> {
        self.0 = self.0.saturating_sub(1);
        if self.0 == 0 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}

#[test]
fn an_interrupted_training_continues_to_the_same_bits() {
    let points = sheet(150);
    let lattice = Lattice::quad(6, 7).unwrap();
    let mut trainings = vec![SomOptions { epochs: Some(6), ..SomOptions::default() }];
    for presentation in Presentation::ALL {
        trainings.push(SomOptions { presentation, init: Init::Centroid, ..online() });
    }
    for options in trainings {
        let expected = fit(&points, &lattice, &options);
        for calls in 1..8 {
            let mut som =
                SelfOrganizingMap::new(&points, lattice.clone(), &options, &mut Silent).unwrap();
            let stopped = som.train(&points, &mut StopAfter(calls));
            if matches!(stopped, Err(Error::Interrupted)) && som.stopped_by == StoppedBy::Unfinished
            {
                assert!(som.codebook().iter().all(|node| node.is_finite()));
                som = SelfOrganizingMap::from_bytes(&som.to_bytes()).unwrap();
                som.train(&points, &mut Silent).unwrap();
            }
            assert_eq!(som, expected, "{calls} calls");
        }
    }
}

#[test]
fn the_observer_receives_each_epoch() {
    #[derive(Default)]
    struct Watch(Vec<(u64, f64, f64, usize)>);
    impl Observer for Watch {
        fn observe(&mut self, _: &Progress) -> ControlFlow<()> {
            ControlFlow::Continue(())
        }
        fn observe_epoch(&mut self, epoch: &Epoch<'_>) -> ControlFlow<()> {
            self.0.push((epoch.step, epoch.error, epoch.radius, epoch.lattice.len()));
            ControlFlow::Continue(())
        }
    }
    let points = sheet(500);
    let options = SomOptions {
        radius: Some(Schedule::Linear { start: 3.0, end: 1.0 }),
        epochs: Some(5),
        ..SomOptions::default()
    };
    let mut watch = Watch::default();
    let lattice = Lattice::quad(6, 7).unwrap();
    SelfOrganizingMap::fit(&points, lattice, &options, &mut watch).unwrap();
    let seen = &watch.0;
    assert_eq!(seen.iter().map(|e| e.0).collect::<Vec<_>>(), [1, 2, 3, 4, 5]);
    assert_eq!(seen.iter().map(|e| e.2).collect::<Vec<_>>(), [3.0, 2.5, 2.0, 1.5, 1.0]);
    assert!(seen.iter().all(|e| e.3 == 42 && e.1 > 0.0));
    assert!(seen[4].1 < seen[1].1);
}

#[test]
fn a_rolled_sheet_unrolls_only_from_the_geodesic_start() {
    // Nine tenths of a cylinder.
    let point = |i: usize| {
        let angle = 0.9 * std::f64::consts::TAU * noise(i, 0.0);
        DVec3::new(angle.cos(), angle.sin(), 1.5 * noise(i, 7.0))
    };
    let points: Vec<DVec3> = (0..3000).map(point).collect();
    let lattice = Lattice::quad(24, 8).unwrap();
    let train = |init| fit(&points, &lattice, &SomOptions { init, ..SomOptions::default() });
    let (unrolled, flat) = (train(Init::Geodesic), train(Init::Pca));
    assert_eq!(unrolled.fold_overs(&mut Silent).unwrap(), Some(0));
    assert!(unrolled.topographic_error(&points, &mut Silent).unwrap() < 0.02);
    assert!(flat.topographic_error(&points, &mut Silent).unwrap() > 0.02);
}

#[test]
fn closed_lattices_fit_closed_shapes() {
    let tube = |i: usize| {
        let angle = std::f64::consts::TAU * noise(i, 0.0);
        DVec3::new(angle.cos(), 3.0 * noise(i, 7.0), angle.sin())
    };
    let torus = |i: usize| {
        let (a, b) = (noise(i, 0.0) * std::f64::consts::TAU, noise(i, 7.0) * std::f64::consts::TAU);
        let ring = 3.0 + b.cos();
        DVec3::new(ring * a.cos(), ring * a.sin(), b.sin())
    };
    let cases: [(Topology, Vec<DVec3>); 2] = [
        (Topology::Tube, (0..4000).map(tube).collect()),
        (Topology::Torus, (0..4000).map(torus).collect()),
    ];
    for (topology, points) in cases {
        for cells in Cells::ALL {
            let lattice = Lattice::grid(20, 12, cells, topology).unwrap();
            let som = fit(&points, &lattice, &SomOptions::default());
            assert_eq!(som.fold_overs(&mut Silent).unwrap(), Some(0), "{topology:?} {cells:?}");
            assert!(som.topographic_error(&points, &mut Silent).unwrap() < 0.05);
            let uv = som.parametrize(&points, 0.75, &mut Silent).unwrap();
            assert!(uv.iter().all(|uv| (0.0..1.0).contains(&uv.x)));
        }
    }
}

#[test]
fn a_graph_fits_a_circle() {
    // A ring of twenty nodes on a circle, started from the principal plane.
    let edges: Vec<(usize, usize)> = (0..20).map(|i| (i, (i + 1) % 20)).collect();
    let ring = Lattice::graph(20, &edges).unwrap();
    let point = |i: usize| {
        let angle = std::f64::consts::TAU * noise(i, 0.0);
        DVec3::new(2.0 * angle.cos(), angle.sin(), 0.0)
    };
    let points: Vec<DVec3> = (0..2000).map(point).collect();
    for options in [SomOptions::default(), SomOptions { max_steps: Some(20_000), ..online() }] {
        let som = fit(&points, &ring, &options);
        assert!(som.quantization_error(&points, &mut Silent).unwrap() < 0.15);
        assert!(som.topographic_error(&points, &mut Silent).unwrap() < 0.05);
        let uv = som.parametrize(&points, 0.75, &mut Silent).unwrap_err();
        assert!(uv.to_string().starts_with("lattice must be a grid"));
        assert_eq!(som.fold_overs(&mut Silent).unwrap(), None);
    }
}

#[test]
fn skip_reached_needs_no_more_steps_than_random() {
    let points = sheet(60);
    let lattice = Lattice::for_points(60);
    let train = |presentation| {
        let (max_steps, reach) = (Some(200_000), Some(1e-4));
        let options = SomOptions { presentation, max_steps, reach, ..SomOptions::paper() };
        fit(&points, &lattice, &options)
    };
    let (special, original) = (train(Presentation::SkipReached), train(Presentation::Random));
    assert_eq!(special.stopped_by, StoppedBy::Reached);
    assert!(special.steps <= original.steps, "{} {}", special.steps, original.steps);
}

#[test]
fn a_distribution_is_fitted_from_a_sampler() {
    let lattice = Lattice::quad(8, 8).unwrap();
    for options in [SomOptions::default(), SomOptions { max_steps: None, ..online() }] {
        let mut drawn = 0;
        let mut sampler = |count: usize| {
            drawn += count;
            Ok(sheet(drawn)[drawn - count..].to_vec())
        };
        let mut silent = Silent;
        let som = SelfOrganizingMap::fit_distribution(
            &mut sampler,
            lattice.clone(),
            &options,
            &mut silent,
        );
        assert!(som.unwrap().quantization_error(&sheet(2000), &mut Silent).unwrap() < 0.06);
    }
    let mut short = |count: usize| Ok(sheet(count - 1));
    let options = SomOptions::default();
    let error = SelfOrganizingMap::fit_distribution(&mut short, lattice, &options, &mut Silent);
    assert!(error.unwrap_err().to_string().starts_with("sampler must be a source of as many"));
}

#[test]
fn parameters_of_nodes_are_their_places_on_the_extended_lattice() {
    let points = sheet(2000);
    let som = fit(&points, &Lattice::quad(10, 12).unwrap(), &SomOptions::default());
    let nodes = som.codebook();
    for beyond in [0.0, 0.75] {
        let uv = som.parametrize(&nodes, beyond, &mut Silent).unwrap();
        for (i, uv) in uv.iter().enumerate() {
            let share = |node: usize, cells: f64| (node as f64 + beyond) / (cells + 2.0 * beyond);
            let expected = DVec2::new(share(i / 12, 9.0), share(i % 12, 11.0));
            assert!(uv.distance(expected) < 1e-6, "{i}: {uv} {expected}");
        }
    }
    let far = [DVec3::new(-9.0, 0.5, 0.0), DVec3::new(0.5, 9.0, 0.0)];
    for uv in som.parametrize(&far, 0.5, &mut Silent).unwrap() {
        assert!((0.0..=1.0).contains(&uv.x) && (0.0..=1.0).contains(&uv.y), "{uv}");
    }
}

#[test]
fn bad_options_are_refused_by_name() {
    let points = sheet(50);
    let refuse = |options: SomOptions| {
        let lattice = Lattice::quad(4, 4).unwrap();
        SelfOrganizingMap::new(&points, lattice, &options, &mut Silent).unwrap_err().to_string()
    };
    let options = SomOptions::default();
    let cases = [
        (SomOptions { epochs: Some(0), ..options.clone() }, "epochs must be at least 1"),
        (SomOptions { reach: Some(0.0), ..options.clone() }, "reach must be positive"),
        (
            SomOptions { min_change: Some(f64::NAN), ..options.clone() },
            "min_change must be positive",
        ),
        (
            SomOptions { gain: Some(Schedule::Constant(1.5)), ..options.clone() },
            "gain must be from 0",
        ),
        (
            SomOptions { radius: Some(Schedule::Constant(-1.0)), ..options.clone() },
            "radius must be",
        ),
        (SomOptions { init: Init::Given(vec![DVec3::ZERO]), ..options.clone() }, "init must be 16"),
        (
            SomOptions { init: Init::Given(vec![DVec3::NAN; 16]), ..options.clone() },
            "init must be finite",
        ),
        (
            SomOptions {
                kernel: Some(Kernel::Linear),
                neighborhood: Neighborhood::Bubble,
                ..options.clone()
            },
            "kernel must be 'mean'",
        ),
    ];
    for (options, expected) in cases {
        let message = refuse(options);
        assert!(message.starts_with(expected), "{message}");
    }
    let mut som = fit(&points, &Lattice::quad(4, 4).unwrap(), &options);
    let others = som.train(&points[1..], &mut Silent).unwrap_err().to_string();
    assert!(others.starts_with("points must be the 50 points that the map was made for"));
    let old = som.sums(&points, &mut Silent).unwrap();
    som.learn(&old, &mut Silent).unwrap();
    let again = som.learn(&old, &mut Silent).unwrap_err().to_string();
    assert!(again.starts_with("sums must be of the same map and state"), "{again}");
    let far = som.sums(&[DVec3::splat(1e9)], &mut Silent).unwrap_err().to_string();
    assert!(far.starts_with("points must be at most"), "{far}");
}
