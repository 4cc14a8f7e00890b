//! The quadratic height over a plane that is nearest to points.

use glam::DVec3;

use super::plane::Plane;

/// Coefficients of a quadratic in two variables.
const COEFFICIENTS: usize = 6;

/// A column's norm below this share of what it was is rounding: the points do not tell that term.
const DEPENDENT: f64 = 1e-6;

/// How far points are from the quadratic height over their plane that least squares give.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Quadric {
    /// Distance of one more point, along the plane's normal.
    pub(super) off: f64,
    /// Root of the squared distances' mean over the degrees of freedom.
    pub(super) deviation: f64,
}

impl Quadric {
    /// That of some points, and of one more which it does not know; `None` if they are too few.
    pub(super) fn of(points: &[DVec3], other: DVec3) -> Option<Self> {
        let free = points.len().checked_sub(COEFFICIENTS).filter(|&free| free > 0)?;
        let plane = Plane::of(points.iter().copied());
        let unit = plane.deviations[0].recip();
        // One row for each point; the first, of the other point, is in no product.
        let rows = [&other].into_iter().chain(points);
        let rows: Vec<DVec3> = rows.map(|&point| plane.local(point) * unit).collect();
        let terms = |p: &DVec3| [1.0, p.x, p.y, p.x * p.x, p.x * p.y, p.y * p.y];
        let columns = rows.iter().map(terms);
        let mut rest: Vec<f64> = rows.iter().map(|row| row.z).collect();
        let mut basis: Vec<Vec<f64>> = Vec::new();
        for term in 0..COEFFICIENTS {
            let mut column: Vec<f64> = columns.clone().map(|terms| terms[term]).collect();
            let whole = product(&column, &column).sqrt();
            for direction in &basis {
                remove(&mut column, direction);
            }
            let norm = product(&column, &column).sqrt();
            if norm > DEPENDENT * whole {
                for value in &mut column {
                    *value /= norm;
                }
                remove(&mut rest, &column);
                basis.push(column);
            }
        }
        let deviation = (product(&rest, &rest) / free as f64).sqrt();
        Some(Self { off: rest[0].abs() / unit, deviation: deviation / unit })
    }
}

/// Of two columns, without their first rows.
fn product(a: &[f64], b: &[f64]) -> f64 {
    a[1..].iter().zip(&b[1..]).map(|(a, b)| a * b).sum()
}

/// Takes from a column its part along a direction (modified Gram-Schmidt).
fn remove(column: &mut [f64], direction: &[f64]) {
    let part = product(column, direction);
    column.iter_mut().zip(direction).for_each(|(value, along)| *value -= part * along);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_lies_on_a_paraboloid_is_not_off() {
        let bowl = |x: f64, y: f64| DVec3::new(x, y, 5.0 + 0.3 * x * x - 0.2 * x * y + 0.1 * y * y);
        let points: Vec<DVec3> =
            (0..16).map(|i| bowl(f64::from(i % 4) - 1.5, f64::from(i / 4) - 1.5)).collect();
        // About the plane of the points, which is nearly level, it is a paraboloid but for little.
        let quadric = Quadric::of(&points, bowl(3.0, 2.0)).unwrap();
        assert!(quadric.off < 0.1 && quadric.deviation < 0.01, "{quadric:?}");
        let above = Quadric::of(&points, bowl(3.0, 2.0) + DVec3::Z).unwrap();
        assert!((above.off - 1.0).abs() < 0.1, "{above:?}");
        assert_eq!(Quadric::of(&points[..6], DVec3::ZERO), None);
    }

    #[test]
    fn points_on_a_line_show_its_bend() {
        let arc = |t: f64| DVec3::new(t, 0.0, 0.01 * t * t);
        let points: Vec<DVec3> = (0..16).map(|i| arc(f64::from(i) - 8.0)).collect();
        assert!(Quadric::of(&points, arc(9.0)).unwrap().off < 0.02);
    }
}
