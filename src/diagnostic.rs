//! Diagnostics: findings about points or a surface, one enum with stable codes.
//!
//! A program should read the variant or its [`code`](Diagnostic::code), not parse the message.
//! In a message, arguments stand between backticks: the command line shows its options instead.

use std::fmt;

use crate::chart::Kind;
use crate::numeric::Short;

/// A finding about points or about the surface fitted to them. Lengths are in the points' unit,
/// shares are from 0 to 1.
#[derive(Clone, Debug, PartialEq)]
pub enum Diagnostic {
    /// The surface folds over where the points do not.
    Folded {
        /// Share of neighboring samples whose normals turn over.
        share: f64,
    },
    /// The surface reaches far beyond the points.
    Overshoot {
        /// Largest distance outside the cylinder around the box along the points' principal axes.
        distance: f64,
        /// Diagonal of the points' bounding box.
        diagonal: f64,
    },
    /// A part of a closed surface has no points near.
    Uncovered {
        /// Share of the area.
        share: f64,
    },
    /// Neighboring points are far apart on the surface.
    Torn {
        /// Share of the neighbor pairs.
        share: f64,
    },
    /// The points fill a volume.
    Thick {
        /// Root mean square distance of the points from the surface.
        rms: f64,
        /// Diagonal of the points' bounding box.
        diagonal: f64,
    },
    /// The points enclose a body, which one surface cannot cover.
    ClosedBody,
    /// The points lie in two layers that the surface does not separate.
    TwoLayers {
        /// Root mean square distance of the points from the surface.
        rms: f64,
        /// Noise of the points.
        noise: f64,
    },
    /// The cloud has several components, which were fitted together.
    Components {
        /// Number of points of each component, the largest first.
        sizes: Vec<usize>,
    },
    /// The axes look like different units.
    MixedUnits {
        /// Divisor of each coordinate for the fit.
        scale: [f64; 3],
    },
    /// Points were left out as outliers: many of them, or a group.
    LeftOut {
        /// Number of points left out.
        count: usize,
        /// Number of points of the cloud.
        points: usize,
        /// Whether they lie together.
        together: bool,
    },
    /// Points with a no-data value were left out.
    NoData {
        /// The value.
        value: f64,
        /// Number of points that have it.
        count: usize,
    },
    /// Points lie farther from the surface than the tolerance.
    ToleranceMissed {
        /// The tolerance.
        tolerance: f64,
        /// Number of points farther away.
        missed: usize,
        /// Number of fitted points.
        points: usize,
        /// The reason why no closer surface was found.
        cause: Cause,
    },
    /// The requested kind does not fit the points.
    KindDoubtful {
        /// The requested kind.
        requested: Kind,
        /// Root mean square distance of the points from the surface.
        rms: f64,
        /// Diagonal of the points' bounding box.
        diagonal: f64,
    },
    /// The surface was not trimmed where the points end.
    Untrimmed {
        /// The reason.
        reason: String,
    },
    /// The loops around the points are doubtful.
    TrimDoubtful {
        /// The reason.
        reason: String,
    },
    /// The points lie in several regions of the surface.
    Regions {
        /// Number of regions.
        count: usize,
    },
    /// Training ended before the map settled.
    NotSettled {
        /// Number of training steps.
        steps: u64,
        /// Largest move of a node in the last epoch; `None` if no epoch was finished.
        change: Option<f64>,
    },
}

/// The reason why a tolerance was missed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cause {
    /// The net has the largest number of control points allowed.
    MaxControlPoints,
    /// The size of the net was given.
    Grid,
    /// The points do not determine more control points.
    Points,
    /// Closer fits have defects.
    Defects,
    /// A closer fit follows the noise of the points.
    Noise,
}

impl Cause {
    /// The name, as Python and the command line spell it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::MaxControlPoints => "max_control_points",
            Self::Grid => "grid",
            Self::Points => "points",
            Self::Defects => "defects",
            Self::Noise => "noise",
        }
    }

    /// The cause and its remedy, for the message.
    fn remedy(self) -> &'static str {
        match self {
            Self::MaxControlPoints => {
                "The net has the largest size allowed: raise `max_control_points`"
            }
            Self::Grid => "The given `grid` is too small: give a larger one",
            Self::Points => "The points do not determine a larger net: raise the `tolerance`",
            Self::Defects => "Closer fits fold or overshoot: raise the `tolerance`",
            Self::Noise => "Closer fits follow the noise: raise the `tolerance`",
        }
    }
}

impl Diagnostic {
    /// Each code with its meaning in one line.
    ///
    /// ```
    /// use neurbs::Diagnostic;
    /// let folded = Diagnostic::Folded { share: 0.03 };
    /// assert!(Diagnostic::CODES.iter().any(|(code, _)| *code == folded.code()));
    /// assert!(folded.to_string().starts_with("The surface folds over"));
    /// ```
    pub const CODES: &[(&str, &str)] = &[
        ("folded", "The surface folds over where the points do not."),
        ("overshoot", "The surface reaches beyond the points by over a tenth of their diagonal."),
        ("uncovered", "Over a tenth of a closed surface's area has no points near."),
        ("torn", "Over 5 % of the neighbor pairs are far apart on the surface."),
        ("thick", "The points fill a volume."),
        ("closed-body", "The points enclose a body, which one surface cannot cover."),
        ("two-layers", "The points lie in two layers that the surface does not separate."),
        ("components", "The cloud has several components."),
        ("mixed-units", "The axes look like different units and were scaled for the fit."),
        ("left-out", "Over 1 % of the points, or a group of them, were left out as outliers."),
        ("no-data", "Points with a no-data value were left out."),
        ("tolerance-missed", "Points lie farther from the surface than the tolerance."),
        ("kind-doubtful", "The requested kind does not fit the points."),
        ("untrimmed", "The surface was not trimmed where the points end."),
        ("trim-doubtful", "The loops around the points are doubtful."),
        ("regions", "The points lie in several regions of the surface, with a face each."),
        ("not-settled", "Training ended before the map settled."),
    ];

    /// The stable code.
    #[must_use]
    pub fn code(&self) -> &'static str {
        match self {
            Self::Folded { .. } => "folded",
            Self::Overshoot { .. } => "overshoot",
            Self::Uncovered { .. } => "uncovered",
            Self::Torn { .. } => "torn",
            Self::Thick { .. } => "thick",
            Self::ClosedBody => "closed-body",
            Self::TwoLayers { .. } => "two-layers",
            Self::Components { .. } => "components",
            Self::MixedUnits { .. } => "mixed-units",
            Self::LeftOut { .. } => "left-out",
            Self::NoData { .. } => "no-data",
            Self::ToleranceMissed { .. } => "tolerance-missed",
            Self::KindDoubtful { .. } => "kind-doubtful",
            Self::Untrimmed { .. } => "untrimmed",
            Self::TrimDoubtful { .. } => "trim-doubtful",
            Self::Regions { .. } => "regions",
            Self::NotSettled { .. } => "not-settled",
        }
    }

    /// Whether this finding makes a surface invalid.
    ///
    /// ```
    /// use neurbs::Diagnostic;
    /// assert!(Diagnostic::ClosedBody.is_defect());
    /// assert!(!Diagnostic::NoData { value: -9999.0, count: 3 }.is_defect());
    /// ```
    #[must_use]
    pub fn is_defect(&self) -> bool {
        matches!(
            self,
            Self::Folded { .. }
                | Self::Overshoot { .. }
                | Self::Uncovered { .. }
                | Self::Torn { .. }
                | Self::Thick { .. }
                | Self::ClosedBody
                | Self::KindDoubtful { .. }
        )
    }
}

impl fmt::Display for Diagnostic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Folded { .. }
            | Self::Overshoot { .. }
            | Self::Uncovered { .. }
            | Self::Torn { .. }
            | Self::KindDoubtful { .. }
            | Self::ToleranceMissed { .. } => self.write_about_surface(f),
            _ => self.write_about_points(f),
        }
    }
}

impl Diagnostic {
    /// Writes the message of a finding about the surface.
    fn write_about_surface(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Folded { share } => write!(
                f,
                "The surface folds over: {} of the neighboring normals turn over. Raise \
                 `fairness`, use fewer control points, or use another `kind`.",
                Percent(share)
            ),
            Self::Overshoot { distance, diagonal } => write!(
                f,
                "The surface reaches beyond the points by {}, which is {} of their diagonal. \
                 Raise `fairness` or use fewer control points.",
                Short(distance),
                Percent(distance / diagonal)
            ),
            Self::Uncovered { share } => write!(
                f,
                "{} of the surface's area has no points near. Use `kind=\"sheet\"` if the points \
                 lie on an open surface.",
                Percent(share)
            ),
            Self::Torn { share } => write!(
                f,
                "{} of the neighboring points are far apart on the surface. Use another `kind`, or \
                 fit parts of the cloud.",
                Percent(share)
            ),
            Self::KindDoubtful { requested, rms, diagonal } => write!(
                f,
                "The points do not look like kind '{requested}': their rms distance from it is {}, \
                 which is {} of the diagonal. Use `kind=\"auto\"` or another one.",
                Short(rms),
                Percent(rms / diagonal)
            ),
            Self::ToleranceMissed { tolerance, missed, points, cause } => write!(
                f,
                "Tolerance {} not reached: {missed} of {points} points are farther away. {}.",
                Short(tolerance),
                cause.remedy()
            ),
            _ => Ok(()),
        }
    }

    /// Writes the message of a finding about the points.
    fn write_about_points(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Thick { rms, diagonal } => write!(
                f,
                "The points fill a volume: their rms distance from the surface is {}, which is {} \
                 of the diagonal. Give points of one surface only.",
                Short(*rms),
                Percent(rms / diagonal)
            ),
            Self::ClosedBody => f.write_str(
                "The points enclose a body, which one surface cannot cover. Cut the cloud into \
                 open parts and fit each.",
            ),
            Self::TwoLayers { rms, noise } => write!(
                f,
                "The points lie in two layers that the surface does not separate: the rms distance \
                 of the points from it is {}, but their noise is {}. Leave one layer out.",
                Short(*rms),
                Short(*noise)
            ),
            Self::Components { sizes } => write!(
                f,
                "The cloud has {} components of {}. One surface was fitted to all of them. Choose \
                 one with `component`, or fit each: `component=\"each\"`.",
                sizes.len(),
                Points(sizes)
            ),
            Self::MixedUnits { scale } => {
                f.write_str("Axes look like mixed units: ")?;
                let axes = ["x", "y", "z"].into_iter().zip(scale);
                let scaled = axes.filter(|(_, by)| **by != 1.0);
                let words: Vec<String> = scaled
                    .map(|(axis, by)| format!("{axis} was divided by {}", Short(*by)))
                    .collect();
                f.write_str(&words.join(", "))?;
                f.write_str(
                    " for the fit; results are in your units. Give `axis_scale` to choose it.",
                )
            }
            Self::LeftOut { count, points, together } => write!(
                f,
                "{count} of {points} points were left out as outliers{}. Use `clean=False` and \
                 `robust=False` to keep them.",
                if *together { ", and they lie together" } else { "" }
            ),
            Self::NoData { value, count } => write!(
                f,
                "{count} points with the no-data value {value} were left out. Use \
                 `clean=False` to keep them."
            ),
            Self::Untrimmed { reason } => {
                write!(f, "The surface was not trimmed: {reason}. The face is the whole surface.")
            }
            Self::TrimDoubtful { reason } => {
                write!(
                    f,
                    "The loops around the points are doubtful: {reason}. Look at them in a picture."
                )
            }
            Self::Regions { count } => write!(
                f,
                "The points lie in {count} regions of the surface, with a face each. Use \
                 `trim=False` to keep the surface whole."
            ),
            Self::NotSettled { steps, change } => {
                write!(f, "Training ended after {steps} steps")?;
                if let Some(change) = change {
                    write!(f, ", while the lattice still moved {} an epoch", Short(*change))?;
                }
                f.write_str(". Raise `max_steps` or `min_change`.")
            }
            _ => Ok(()),
        }
    }
}

/// A share, written in percent.
struct Percent(f64);

impl fmt::Display for Percent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} %", Short((1e3 * self.0).round() / 10.0))
    }
}

/// Numbers of points, of which only the first are written.
struct Points<'a>(&'a [usize]);

impl fmt::Display for Points<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let shown: Vec<String> = self.0.iter().take(5).map(ToString::to_string).collect();
        let more = if self.0.len() > shown.len() { ", …" } else { "" };
        write!(f, "{}{more} points", shown.join(", "))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn one_of_each() -> Vec<Diagnostic> {
        let (share, rms, diagonal) = (0.034, 0.25, 2.0);
        let (sizes, cause) = (vec![90, 10], Cause::Defects);
        vec![
            Diagnostic::Folded { share },
            Diagnostic::Overshoot { distance: 0.5, diagonal },
            Diagnostic::Uncovered { share },
            Diagnostic::Torn { share },
            Diagnostic::Thick { rms, diagonal },
            Diagnostic::ClosedBody,
            Diagnostic::TwoLayers { rms: 0.3, noise: 0.1 },
            Diagnostic::Components { sizes },
            Diagnostic::MixedUnits { scale: [1.0, 1.0, 8192.0] },
            Diagnostic::LeftOut { count: 12, points: 100, together: true },
            Diagnostic::NoData { value: -9999.0, count: 3 },
            Diagnostic::ToleranceMissed { tolerance: 0.1, missed: 12, points: 100, cause },
            Diagnostic::KindDoubtful { requested: Kind::Tube, rms, diagonal },
            Diagnostic::Untrimmed { reason: "few points".into() },
            Diagnostic::TrimDoubtful { reason: "few points".into() },
            Diagnostic::Regions { count: 2 },
            Diagnostic::NotSettled { steps: 100, change: Some(0.5) },
        ]
    }

    #[test]
    fn the_table_has_the_code_of_each_variant() {
        let codes: Vec<&str> = one_of_each().iter().map(Diagnostic::code).collect();
        let table: Vec<&str> = Diagnostic::CODES.iter().map(|(code, _)| *code).collect();
        assert_eq!(codes, table);
    }

    #[test]
    fn messages_are_sentences_with_their_numbers() {
        for found in one_of_each() {
            let message = found.to_string();
            assert!(message.ends_with('.') && message.contains(". "), "{message}");
        }
        let messages: Vec<String> = one_of_each().iter().map(ToString::to_string).collect();
        assert!(messages[0].contains("3.4 % of"), "{}", messages[0]);
        assert!(messages[1].contains("by 0.5, which is 25 %"), "{}", messages[1]);
        assert!(
            messages[6]
                .contains("rms distance of the points from it is 0.3, but their noise is 0.1")
        );
        assert!(messages[7].contains("2 components of 90, 10 points. One surface"));
        assert!(messages[8].contains("z was divided by 8192 for"), "{}", messages[8]);
        assert!(messages[11].starts_with("Tolerance 0.1 not reached: 12 of 100 points"));
    }
}
