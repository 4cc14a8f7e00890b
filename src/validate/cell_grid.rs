//! A surface divided into a grid of cells.

use glam::{DVec2, DVec3};

use crate::error::Result;
use crate::nurbs::{NurbsSurface, Outside};
use crate::progress::Observer;

/// Cells of equal parameter steps: their centers, normals and areas, row by row.
#[derive(Clone, Debug)]
pub struct CellGrid {
    /// Cells along a side.
    pub side: usize,
    /// Parameters of each cell's center.
    pub uv: Vec<DVec2>,
    /// The mean of each cell's corners.
    pub places: Vec<DVec3>,
    /// Unit normals; zero where a cell has no area.
    pub normals: Vec<DVec3>,
    /// Areas.
    pub areas: Vec<f64>,
    /// The corners, `side + 1` in each row.
    corners: Vec<DVec3>,
}

impl CellGrid {
    /// Divides a surface into `side` by `side` cells.
    ///
    /// # Errors
    ///
    /// [`Error::Interrupted`](crate::Error::Interrupted) if the observer stops it.
    pub fn of(surface: &NurbsSurface, side: usize, observer: &mut dyn Observer) -> Result<Self> {
        let along = |(low, high): (f64, f64)| {
            move |place: f64| (low + (high - low) * place / side as f64).clamp(low, high)
        };
        let (u, v) = (along(surface.knots_u().domain()), along(surface.knots_v().domain()));
        let line = |at: &dyn Fn(f64) -> f64| (0..=side).map(|i| at(i as f64)).collect::<Vec<f64>>();
        let mut corners = vec![DVec3::ZERO; (side + 1) * (side + 1)];
        let (u_line, v_line) = (line(&u), line(&v));
        surface.evaluate_grid(&u_line, &v_line, &mut corners, None, Outside::Refuse, observer)?;
        let cell = |at: usize| {
            let (i, j) = (at / side, at % side);
            let first = i * (side + 1) + j;
            let [a, b, c, d] = [0, 1, side + 1, side + 2].map(|step| corners[first + step]);
            let cross = (d - a).cross(b - c);
            let uv = DVec2::new(u(i as f64 + 0.5), v(j as f64 + 0.5));
            (uv, 0.25 * (a + b + c + d), cross.normalize_or_zero(), 0.5 * cross.length())
        };
        let count = side * side;
        let (mut uv, mut places, mut normals, mut areas) =
            (Vec::with_capacity(count), Vec::with_capacity(count), Vec::new(), Vec::new());
        for (at, place, normal, area) in (0..count).map(cell) {
            uv.push(at);
            places.push(place);
            normals.push(normal);
            areas.push(area);
        }
        Ok(Self { side, uv, places, normals, areas, corners })
    }

    /// The area of all cells.
    #[must_use]
    pub fn area(&self) -> f64 {
        self.areas.iter().sum()
    }

    /// The pairs of neighboring cells.
    pub fn neighbors(&self) -> impl Iterator<Item = [usize; 2]> + '_ {
        let side = self.side;
        (0..side * side).flat_map(move |at| {
            let right = (at % side + 1 < side).then_some([at, at + 1]);
            let below = (at / side + 1 < side).then_some([at, at + side]);
            right.into_iter().chain(below)
        })
    }

    /// Lengths of the grid lines along a direction, 0 for u and 1 for v.
    #[must_use]
    pub fn line_lengths(&self, direction: usize) -> Vec<f64> {
        let width = self.side + 1;
        let at = |line: usize, step: usize| {
            self.corners[if direction == 0 { step * width + line } else { line * width + step }]
        };
        let length = |line| (0..self.side).map(|i| at(line, i).distance(at(line, i + 1))).sum();
        (0..width).map(length).collect()
    }
}
