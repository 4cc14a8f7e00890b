//! On which side of a closed shell its normals are.

use glam::{DVec2, DVec3};

use crate::brep::{Face, Loop, Shell};
use crate::nurbs::{NurbsSurface, gauss};

/// Points of the Gauss rule on each span. Only the sign of the sum is used.
const POINTS: usize = 3;

/// Number of spans from which one point on each is enough for the sign.
const MANY_SPANS: usize = 16;

/// The rule for a number of spans.
fn rule(spans: usize) -> Vec<(f64, f64)> {
    gauss::rule(if spans < MANY_SPANS { POINTS } else { 1 })
}

/// Three times the volume that closed faces of a shell enclose, roughly; negative if their normals
/// point inward.
pub(super) fn signed_volume(shell: &Shell, faces: &[usize]) -> f64 {
    let vertices = shell.vertices();
    let middle = vertices.iter().sum::<DVec3>() / vertices.len() as f64;
    let volume = |face: &Face| {
        let signed = below(face, middle);
        if face.is_reversed() { -signed } else { signed }
    };
    faces.iter().map(|&face| volume(&shell.faces()[face])).sum()
}

/// Three times the volume between a face and a point, negative if the surface's normals point
/// to it. By Green's theorem it is an integral along the loops.
fn below(face: &Face, middle: DVec3) -> f64 {
    let surface = face.surface();
    let mut sum = 0.0;
    for curve in face.loops().iter().flat_map(Loop::curves) {
        let breaks = curve.knots().breaks();
        // About as many pieces as the curve may cross spans of the surface.
        let pieces = surface.knots_v().spans().div_ceil(breaks.len() - 1);
        let rule = rule(pieces * (breaks.len() - 1));
        for (span, piece) in breaks.windows(2).flat_map(|span| (0..pieces).map(move |k| (span, k)))
        {
            let step = (span[1] - span[0]) / pieces as f64;
            for (share, weight) in &rule {
                let at = span[0] + (piece as f64 + share) * step;
                let (uv, along) = (curve.point(at).truncate(), curve.velocity(at));
                if along.y != 0.0 {
                    sum += weight * step * along.y * up_to(surface, uv, middle);
                }
            }
        }
    }
    sum
}

/// The integral of S · (Su × Sv) along u, from the surface's side to a place.
fn up_to(surface: &NurbsSurface, end: DVec2, middle: DVec3) -> f64 {
    let breaks = surface.knots_u().breaks();
    let rule = rule(breaks.len() - 1);
    let mut sum = 0.0;
    for span in breaks.windows(2).take_while(|span| span[0] < end.x) {
        let (start, stop) = (span[0], span[1].min(end.x));
        for (share, weight) in &rule {
            let [point, by_u, by_v] = surface.tangents(start + share * (stop - start), end.y);
            sum += weight * (stop - start) * (point - middle).dot(by_u.cross(by_v));
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Result;
    use crate::nurbs::Direction;
    use crate::progress::Silent;

    #[test]
    fn turned_shells_have_negative_volumes() {
        let torus = NurbsSurface::torus(1e6 * DVec3::ONE, 3.0, 1.0).unwrap();
        let turned = torus.reversed(Direction::U, &mut Silent).unwrap();
        let reversed = Face::whole(torus.clone()).unwrap().reversed();
        let exact = 18.0 * std::f64::consts::PI.powi(2);
        let volume = |shell: Result<Shell>| signed_volume(&shell.unwrap(), &[0]) / exact;
        assert!((volume(Shell::whole(torus)) - 1.0).abs() < 1e-2);
        assert!((volume(Shell::whole(turned)) + 1.0).abs() < 1e-2);
        assert!((volume(Shell::new(vec![reversed], None)) + 1.0).abs() < 1e-2);
    }
}
