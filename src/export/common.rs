//! What the writers of shells share.

use glam::DVec3;

use crate::brep::{LengthUnit, Shell};
use crate::error::{Error, Result};

/// Distance below which a reader may identify two points, as a fraction of the shell's size.
/// Edges and surface are exactly the same curves, but readers compare them at sampled points.
const UNCERTAINTY: f64 = 1e-6;

/// The same distance as a fraction of the largest coordinate. Far from the origin, rounding is
/// larger.
const ROUNDING: f64 = 1e-11;

/// The smallest uncertainty that CAD programs accept, in millimeters.
const MIN_UNCERTAINTY: f64 = 1e-7;

/// Refuses to write nothing.
pub(super) fn check_shells(shells: &[Shell]) -> Result<()> {
    if shells.is_empty() {
        return Err(Error::parameter("shells", "at least one", "none"));
    }
    Ok(())
}

/// The smallest uncertainty, in a unit.
pub(super) fn min_uncertainty(unit: LengthUnit) -> f64 {
    MIN_UNCERTAINTY / unit.in_millimeters()
}

/// The uncertainty that a file declares for a shell, in the unit of the file.
pub(super) fn uncertainty(shell: &Shell, unit: LengthUnit) -> f64 {
    let boxes = shell.faces().iter().map(|face| face.surface().net_box());
    let whole = boxes.reduce(|(a, b), (c, d)| (a.min(c), b.max(d)));
    let (min, max) = whole.unwrap_or((DVec3::ZERO, DVec3::ZERO));
    let magnitude = min.abs().max(max.abs()).max_element();
    let relative = (UNCERTAINTY * (max - min).length()).max(ROUNDING * magnitude);
    min_uncertainty(unit).max(shell.tolerance()).max(relative)
}

/// The name of a shell's product: that of its only face, or what it is.
pub(super) fn product_name(shell: &Shell) -> &str {
    match shell.faces() {
        [face] if face.name().is_some() => face.name().unwrap_or_default(),
        _ if shell.is_closed() => "solid",
        [_] => "surface",
        _ => "shell",
    }
}
