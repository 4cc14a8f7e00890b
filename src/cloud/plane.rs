//! The plane nearest to points, by their principal directions.

use glam::{DMat3, DVec3};

use super::settings::PlaneSettings;

const SETTINGS: PlaneSettings = PlaneSettings::STANDARD;

/// The principal directions of points, the plane nearest to them, and their deviations.
///
/// ```
/// use neurbs::{DVec3, cloud::Plane};
/// let points = [DVec3::ZERO, DVec3::X * 4.0, DVec3::Y, DVec3::new(4.0, 1.0, 0.0)];
/// let plane = Plane::of(points);
/// assert_eq!(plane.normal().z.abs(), 1.0);
/// assert_eq!(plane.deviations, [2.0, 0.5, 0.0]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// The points' mean.
    pub center: DVec3,
    /// Unit vectors along which the points scatter most, second and least; right-handed.
    pub axes: [DVec3; 3],
    /// Root mean square coordinates along the axes, in the points' unit.
    pub deviations: [f64; 3],
}

impl Plane {
    /// The plane nearest to points; z = 0 without points.
    #[must_use]
    pub fn of(points: impl IntoIterator<Item = DVec3, IntoIter: Clone>) -> Self {
        let points = points.into_iter();
        let Some(origin) = points.clone().next() else {
            return Self { center: DVec3::ZERO, axes: DVec3::AXES, deviations: [0.0; 3] };
        };
        let (mut count, mut sum) = (0.0, DVec3::ZERO);
        for point in points.clone() {
            count += 1.0;
            sum += point - origin;
        }
        let center = origin + sum / count;
        let mut scatter = DMat3::ZERO;
        for point in points {
            let local = point - center;
            scatter += DMat3::from_cols(local * local.x, local * local.y, local * local.z);
        }
        let (values, axes) = symmetric(scatter * (1.0 / count));
        Self { center, axes, deviations: values.map(|value| value.max(0.0).sqrt()) }
    }

    /// The direction in which the points scatter least.
    #[must_use]
    pub fn normal(&self) -> DVec3 {
        self.axes[2]
    }

    /// Whether the points lie on a line, as neighbors on scan lines do.
    pub(crate) fn is_line(&self) -> bool {
        self.deviations[1] < SETTINGS.max_line_ratio * self.deviations[0]
    }

    /// Whether the points lie on a plane, and on no line.
    pub(crate) fn is_flat(&self) -> bool {
        !self.is_line() && self.deviations[2] < SETTINGS.max_flat_ratio * self.deviations[1]
    }

    /// Whether the points fill a volume, as those around an outlier do.
    pub(crate) fn is_thick(&self) -> bool {
        self.deviations[2] > SETTINGS.min_thick_ratio * self.deviations[0]
    }

    /// Distance of a point from the plane, with the sign of its side.
    #[must_use]
    pub fn height(&self, point: DVec3) -> f64 {
        self.normal().dot(point - self.center)
    }

    /// A point by its coordinates along the axes.
    #[must_use]
    pub fn local(&self, point: DVec3) -> DVec3 {
        let local = point - self.center;
        DVec3::from_array(self.axes.map(|axis| axis.dot(local)))
    }
}

/// Eigenvalues of a symmetric matrix, largest first, and their eigenvectors, by Jacobi's rotations
/// (Golub and Van Loan, Matrix Computations, section 8.5).
fn symmetric(matrix: DMat3) -> ([f64; 3], [DVec3; 3]) {
    let (mut matrix, mut axes) = (matrix.to_cols_array_2d(), DMat3::IDENTITY.to_cols_array_2d());
    let negligible = f64::EPSILON * (matrix[0][0] + matrix[1][1] + matrix[2][2]).abs();
    for _ in 0..SETTINGS.max_sweeps {
        // Each pair of indices, and the third index.
        for (p, q, other) in [(0, 1, 2), (0, 2, 1), (1, 2, 0)] {
            let mixed = matrix[q][p];
            if mixed.abs() <= negligible {
                continue;
            }
            let theta = (matrix[q][q] - matrix[p][p]) / (2.0 * mixed);
            let tangent = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
            let cosine = 1.0 / (tangent * tangent + 1.0).sqrt();
            let sine = tangent * cosine;
            matrix[p][p] -= tangent * mixed;
            matrix[q][q] += tangent * mixed;
            (matrix[q][p], matrix[p][q]) = (0.0, 0.0);
            let (a, b) = (matrix[other][p], matrix[other][q]);
            let (a, b) = (cosine * a - sine * b, sine * a + cosine * b);
            (matrix[other][p], matrix[p][other]) = (a, a);
            (matrix[other][q], matrix[q][other]) = (b, b);
            let (a, b) = (DVec3::from_array(axes[p]), DVec3::from_array(axes[q]));
            axes[p] = (cosine * a - sine * b).to_array();
            axes[q] = (sine * a + cosine * b).to_array();
        }
    }
    let (matrix, axes) = (DMat3::from_cols_array_2d(&matrix), DMat3::from_cols_array_2d(&axes));
    let mut order = [0, 1, 2];
    order.sort_by(|&a, &b| matrix.col(b)[b].total_cmp(&matrix.col(a)[a]));
    let [first, second, third] = order.map(|i| axes.col(i).normalize_or(DVec3::AXES[i]));
    let third = if first.cross(second).dot(third) < 0.0 { -third } else { third };
    (order.map(|i| matrix.col(i)[i]), [first, second, third])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_axes_of_a_rotated_ellipsoid_are_found() {
        let turn = DMat3::from_euler(glam::EulerRot::XYZ, 0.3, -1.1, 2.0);
        let axis = |i: usize, length: f64| [turn.col(i) * length, turn.col(i) * -length];
        let center = DVec3::new(1e6, -4.0, 7.0);
        let points = [axis(0, 3.0), axis(1, 2.0), axis(2, 0.5)].concat();
        let plane = Plane::of(points.iter().map(|&p| center + p));
        assert!(plane.center.distance(center) < 1e-9);
        for i in 0..3 {
            assert!((plane.axes[i].dot(turn.col(i)).abs() - 1.0).abs() < 1e-9);
            assert!((plane.deviations[i] - [3.0, 2.0, 0.5][i] / 3.0_f64.sqrt()).abs() < 1e-9);
        }
        assert!(plane.axes[0].cross(plane.axes[1]).dot(plane.axes[2]) > 0.999);
        assert!((plane.height(center + 0.5 * plane.normal()) - 0.5).abs() < 1e-9);
    }
}
