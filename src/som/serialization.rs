//! Exact serialization of a map and its training state to bytes and back.

use super::lattice::Lattice;
use super::map::SelfOrganizingMap;
use super::online_state::OnlineState;
use super::options::{Kernel, Neighborhood, Plan, Presentation, Training};
use super::presentation_order::PresentationOrder;
use super::random::Random;
use super::schedule::Schedule;
use super::stop_criterion::StoppedBy;
use super::topology::{Cells, Topology};
use crate::bytes::{Reader, Writer, read_saved};
use crate::error::Result;

/// The first bytes: the kind of data and the version of the layout.
const MAGIC: &[u8; 12] = b"neurbs-som-1";

impl SelfOrganizingMap {
    /// The whole map, training state included, as bytes for [`Self::from_bytes`]. Little-endian on
    /// every machine.
    ///
    /// ```
    /// use neurbs::{DVec3, progress::Silent};
    /// use neurbs::som::{Lattice, SelfOrganizingMap, SomOptions};
    /// let points = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::new(1.0, 1.0, 0.5)];
    /// let lattice = Lattice::quad(4, 4)?;
    /// let som = SelfOrganizingMap::fit(&points, lattice, &SomOptions::default(), &mut Silent)?;
    /// assert_eq!(SelfOrganizingMap::from_bytes(&som.to_bytes())?, som);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut out = Writer(MAGIC.to_vec());
        out.lattice(&self.lattice);
        for count in [self.steps, self.ordered_at, self.reached as u64, self.random.draws()] {
            out.count(count);
        }
        out.choice(&StoppedBy::ALL, &self.stopped_by);
        out.optional(self.change);
        out.optional(self.error);
        out.points(&self.nodes);
        out.frame(&self.frame);
        out.plan(&self.plan);
        out.count(u64::from(self.online.is_some()));
        if let Some(online) = &self.online {
            out.online(online);
        }
        out.0
    }

    /// Reads a map that [`Self::to_bytes`] wrote.
    ///
    /// ```
    /// # use neurbs::{DVec3, progress::Silent};
    /// # use neurbs::som::{Lattice, SelfOrganizingMap, SomOptions};
    /// # let point = |i| DVec3::new(f64::from(i % 20), f64::from(i / 20), f64::from(i % 7));
    /// # let points: Vec<DVec3> = (0..400).map(point).collect();
    /// # let (lattice, options) = (Lattice::quad(5, 6)?, SomOptions::default());
    /// # let som = SelfOrganizingMap::fit(&points, lattice, &options, &mut Silent)?;
    /// assert_eq!(SelfOrganizingMap::from_bytes(&som.to_bytes())?, som);
    /// # Ok::<(), neurbs::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`](crate::Error::Parameter) if the bytes are not a complete map.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self> {
        read_saved(bytes, MAGIC, "state", "a saved map", Self::read)
    }

    fn read(from: &mut Reader<'_>) -> Option<Self> {
        let lattice = from.lattice()?;
        let [steps, ordered_at, reached, draws] =
            [from.count()?, from.count()?, from.count()?, from.count()?];
        let stopped_by = from.choice(&StoppedBy::ALL)?;
        let (change, error) = (from.reals()?.first().copied(), from.reals()?.first().copied());
        let nodes = from.points()?;
        let frame = from.frame()?;
        let plan = from.plan()?;
        let online = if from.count()? == 1 { Some(from.online()?) } else { None };
        let random = Random::after(plan.seed, draws);
        let reached = usize::try_from(reached).ok()?;
        (nodes.len() == lattice.len()).then_some(Self {
            lattice,
            steps,
            ordered_at,
            stopped_by,
            reached,
            change,
            error,
            nodes,
            frame,
            plan,
            random,
            online,
        })
    }
}

impl Writer {
    fn lattice(&mut self, lattice: &Lattice) {
        let (rows, cols) = lattice.shape();
        self.count(rows as u64);
        self.count(cols as u64);
        self.choice(&Topology::ALL, &lattice.topology());
        if let Some(cells) = lattice.cells() {
            self.choice(&Cells::ALL, &cells);
        } else {
            self.count(Cells::ALL.len() as u64);
            let edges = lattice.edges();
            self.count(edges.len() as u64);
            for (a, b) in edges {
                self.count(a as u64);
                self.count(b as u64);
            }
        }
    }

    fn schedule(&mut self, schedule: &Schedule) {
        let optional = |value: &Option<f64>| value.map_or(vec![], |value| vec![value]);
        let (kind, parts) = match schedule {
            Schedule::Gaussian { start, scale } => (0, vec![optional(start), optional(scale)]),
            Schedule::Linear { start, end } => (1, vec![vec![*start, *end]]),
            Schedule::Exponential { start, end } => (2, vec![vec![*start, *end]]),
            Schedule::Constant(value) => (3, vec![vec![*value]]),
            Schedule::Table(values) => (4, vec![values.clone()]),
        };
        self.count(kind);
        for part in parts {
            self.reals(&part);
        }
    }

    fn plan(&mut self, plan: &Plan) {
        self.choice(&Training::ALL, &plan.training);
        self.choice(&Neighborhood::ALL, &plan.neighborhood);
        self.choice(&Kernel::ALL, &plan.kernel);
        self.choice(&Presentation::ALL, &plan.presentation);
        self.schedule(&plan.gain);
        self.schedule(&plan.radius);
        for count in
            [plan.max_steps, plan.epoch_points, plan.epoch_steps, plan.ordered_at, plan.seed]
        {
            self.count(count);
        }
        self.real(plan.reach);
        self.real(plan.min_change);
    }

    fn online(&mut self, online: &OnlineState) {
        let PresentationOrder { kind, points, pool, place } = &online.order;
        self.choice(&Presentation::ALL, kind);
        self.count(*points as u64);
        self.count(*place as u64);
        self.count(pool.len() as u64);
        for index in pool {
            self.0.extend(index.to_le_bytes());
        }
        self.count(online.on_lattice.len() as u64);
        self.0.extend(online.on_lattice.iter().map(|&flag| u8::from(flag)));
        self.points(&online.epoch_start);
        self.real(online.distance);
    }
}

impl Reader<'_> {
    fn lattice(&mut self) -> Option<Lattice> {
        let (rows, cols) = (self.size()?, self.size()?);
        let topology = self.choice(&Topology::ALL)?;
        let kind = self.size()?;
        if let Some(&cells) = Cells::ALL.get(kind) {
            return Lattice::grid(rows, cols, cells, topology).ok();
        }
        let count = self.length(16)?;
        let edges: Option<Vec<_>> =
            (0..count).map(|_| Some((self.size()?, self.size()?))).collect();
        Lattice::graph(rows, &edges?).ok()
    }

    fn schedule(&mut self) -> Option<Schedule> {
        let kind = self.count()?;
        let first = self.reals()?;
        Some(match (kind, &first[..]) {
            (0, start) => {
                let scale = self.reals()?.first().copied();
                Schedule::Gaussian { start: start.first().copied(), scale }
            }
            (1, &[start, end]) => Schedule::Linear { start, end },
            (2, &[start, end]) => Schedule::Exponential { start, end },
            (3, &[value]) => Schedule::Constant(value),
            (4, [_, ..]) => Schedule::Table(first),
            _ => return None,
        })
    }

    fn plan(&mut self) -> Option<Plan> {
        Some(Plan {
            training: self.choice(&Training::ALL)?,
            neighborhood: self.choice(&Neighborhood::ALL)?,
            kernel: self.choice(&Kernel::ALL)?,
            presentation: self.choice(&Presentation::ALL)?,
            gain: self.schedule()?,
            radius: self.schedule()?,
            max_steps: self.count()?,
            epoch_points: self.count().filter(|&points| points > 0)?,
            epoch_steps: self.count().filter(|&steps| steps > 0)?,
            ordered_at: self.count()?,
            seed: self.count()?,
            reach: self.real()?,
            min_change: self.real()?,
        })
    }

    fn online(&mut self) -> Option<OnlineState> {
        let kind = self.choice(&Presentation::ALL)?;
        let (points, place) = (self.size()?, self.size()?);
        let count = self.length(4)?;
        let pool: Option<Vec<u32>> =
            (0..count).map(|_| self.bytes().map(u32::from_le_bytes)).collect();
        let pool = pool?;
        let count = self.length(1)?;
        let on_lattice: Option<Vec<bool>> =
            (0..count).map(|_| self.bytes().map(|[flag]| flag != 0)).collect();
        let order = PresentationOrder { kind, points, pool, place };
        let sound = order.is_valid();
        let (on_lattice, epoch_start) = (on_lattice?, self.points()?);
        let distance = self.real()?;
        (sound && on_lattice.len() == points).then_some(OnlineState {
            order,
            on_lattice,
            epoch_start,
            distance,
        })
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::progress::Silent;
    use crate::som::{Init, SomOptions};

    fn points() -> Vec<DVec3> {
        let point = |i: i32| DVec3::new(f64::from(i % 6), f64::from(i / 6), f64::from(i * i % 5));
        (0..30).map(point).collect()
    }

    #[test]
    fn every_kind_of_map_survives_serialization() {
        let lattices = [
            Lattice::quad(3, 4).unwrap(),
            Lattice::grid(3, 5, Cells::Triangular, Topology::Torus).unwrap(),
            Lattice::graph(4, &[(0, 1), (1, 2), (2, 3)]).unwrap(),
        ];
        let schedules = [
            Schedule::Gaussian { start: None, scale: Some(50.0) },
            Schedule::Linear { start: 0.5, end: 0.0 },
            Schedule::Exponential { start: 0.5, end: 0.1 },
            Schedule::Constant(0.2),
            Schedule::Table(vec![0.4, 0.3, 0.1]),
        ];
        for lattice in lattices {
            for presentation in Presentation::ALL {
                for gain in &schedules {
                    let options = SomOptions {
                        training: Training::Online,
                        init: Init::Centroid,
                        presentation,
                        gain: Some(gain.clone()),
                        max_steps: Some(100),
                        ..SomOptions::default()
                    };
                    let som =
                        SelfOrganizingMap::fit(&points(), lattice.clone(), &options, &mut Silent);
                    let som = som.unwrap();
                    assert_eq!(SelfOrganizingMap::from_bytes(&som.to_bytes()).unwrap(), som);
                }
            }
        }
    }

    #[test]
    fn truncated_or_foreign_bytes_are_refused() {
        let (lattice, options) = (Lattice::quad(3, 4).unwrap(), SomOptions::default());
        let som = SelfOrganizingMap::new(&points(), lattice, &options, &mut Silent);
        let bytes = som.unwrap().to_bytes();
        for length in 0..bytes.len() {
            assert!(SelfOrganizingMap::from_bytes(&bytes[..length]).is_err());
        }
        let message = SelfOrganizingMap::from_bytes(b"something else").unwrap_err().to_string();
        assert_eq!(message, "state must be the complete bytes of a saved map, got 14 other bytes");
    }
}
