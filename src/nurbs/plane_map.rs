//! The map from a patch to the plane of x and y, where it is shown to be one-to-one, and its inverse
//! by Newton's method.

use glam::{DMat2, DVec2, DVec3, DVec4};

use super::bezier_patch::BezierPatch;
use super::control_net::bounds;
use super::plane_tree::Rectangle;

/// A map is one-to-one if its derivative differs from a constant matrix by less than this share.
/// Newton's method then ends from any start: each step leaves at most 2/3 of the error.
const MAX_DISTORTION: f64 = 0.25;

/// Newton steps at most; with [`MAX_DISTORTION`] fewer are needed.
const MAX_STEPS: usize = 60;

/// Newton's method ends with a step below this share of a part. The error left is its square.
const LAST_STEP: f64 = 1e-8;

/// A map from the unit square of a patch to the plane that is one-to-one.
#[derive(Debug)]
pub(super) struct PlaneMap {
    /// The inverse of the mean derivative of w times the distances in x and y.
    inverse: DMat2,
    /// w x, w y and w in the middle of the patch.
    middle: DVec3,
    /// A solution of the linear map farther from the middle shows that there is none on the patch.
    reach: f64,
}

impl PlaneMap {
    /// Returns the map of a patch, if its control points show that it is one-to-one.
    ///
    /// They bound how much the derivative of w times the distances differs from its mean, for all
    /// places in the patch's rectangle.
    pub(super) fn of(patch: &BezierPatch, accuracy: f64) -> Option<Self> {
        let (p, q) = patch.degrees();
        let [low, high] = rectangle(patch, accuracy);
        let (center, half) = (low.midpoint(high), (high - low) / 2.0);
        let at = |i: usize, j: usize| {
            let h = patch.homogeneous(i, j);
            (DVec2::new(h.x, h.y) - h.w * center, h.w)
        };
        let mean = |from: &dyn Fn(usize) -> DVec2, count: usize| {
            (0..=count).map(from).sum::<DVec2>() / (count + 1) as f64
        };
        let along_u = mean(&|j| at(p, j).0 - at(0, j).0, q);
        let along_v = mean(&|i| at(i, q).0 - at(i, 0).0, p);
        let matrix = DMat2::from_cols(along_u, along_v);
        let parallel = f64::EPSILON * along_u.length() * along_v.length();
        let is_regular = matrix.determinant().abs() > parallel;
        if !is_regular {
            return None;
        }
        let inverse = matrix.inverse();
        let size = DMat2::from_cols(inverse.x_axis.abs(), inverse.y_axis.abs());
        // A place that differs from the center changes the derivative by that of w.
        let away = size * half;
        let difference = |(from, to): ((DVec2, f64), (DVec2, f64)), degree: usize, unit: DVec2| {
            let slope = degree as f64 * (to.0 - from.0);
            (inverse * slope - unit).abs() + degree as f64 * (to.1 - from.1).abs() * away
        };
        let mut distortion = [DVec2::ZERO; 2];
        for i in 0..=p {
            for j in 0..=q {
                if i < p {
                    let difference = difference((at(i, j), at(i + 1, j)), p, DVec2::X);
                    distortion[0] = distortion[0].max(difference);
                }
                if j < q {
                    let difference = difference((at(i, j), at(i, j + 1)), q, DVec2::Y);
                    distortion[1] = distortion[1].max(difference);
                }
            }
        }
        let is_one_to_one = (distortion[0] + distortion[1]).max_element() <= MAX_DISTORTION;
        if !is_one_to_one {
            return None;
        }
        let [middle, _, _] = patch.tangents(0.5, 0.5);
        let middle = DVec3::new(middle.x, middle.y, middle.w);
        let border = (size * DVec2::splat(2.0 * accuracy * middle.z)).max_element();
        Some(Self { inverse, middle, reach: 0.5 * (1.0 + MAX_DISTORTION) + border })
    }

    /// Returns the height of the patch at a place, by Newton's method inside the unit square.
    pub(super) fn height(&self, patch: &BezierPatch, place: DVec2, accuracy: f64) -> Option<f64> {
        let from_middle = -(self.inverse * (self.middle.truncate() - self.middle.z * place));
        let is_near = from_middle.abs().max_element() <= self.reach;
        if !is_near {
            return None;
        }
        let mut at = (DVec2::splat(0.5) + from_middle).clamp(DVec2::ZERO, DVec2::ONE);
        for _ in 0..MAX_STEPS {
            let tangents = patch.tangents(at.x, at.y);
            let [away, along_u, along_v] =
                tangents.map(|h: DVec4| DVec2::new(h.x, h.y) - h.w * place);
            let matrix = DMat2::from_cols(along_u, along_v);
            let target = at - matrix.inverse() * away;
            let next = target.clamp(DVec2::ZERO, DVec2::ONE);
            let step = next - at;
            if step.abs().max_element() <= LAST_STEP {
                let [point, by_u, by_v] = tangents;
                let h = point + step.x * by_u + step.y * by_v;
                let outside = (matrix * (target - next)).length();
                return (outside <= accuracy * h.w).then(|| h.z / h.w);
            }
            at = next;
        }
        None
    }
}

/// The rectangle of a patch in the plane, extended by the accuracy.
pub(super) fn rectangle(patch: &BezierPatch, accuracy: f64) -> Rectangle {
    let (low, high) = bounds(patch.points());
    [low.truncate() - accuracy, high.truncate() + accuracy]
}
