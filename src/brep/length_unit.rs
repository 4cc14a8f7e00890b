//! The unit of length of a shell and of CAD files.

/// The unit of length of the coordinates of a shell or a CAD file.
///
/// The unit is a label: coordinates are written unchanged, and readers convert them.
/// [`Shell::to_unit`](crate::Shell::to_unit) converts the coordinates.
///
/// ```
/// use neurbs::LengthUnit;
/// assert_eq!(LengthUnit::default(), LengthUnit::Millimeter);
/// assert_eq!(LengthUnit::Inch.in_millimeters(), 25.4);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LengthUnit {
    /// 1 mm, the default unit of CAD programs.
    #[default]
    Millimeter,
    /// 10 mm.
    Centimeter,
    /// 1000 mm.
    Meter,
    /// 25.4 mm.
    Inch,
    /// 304.8 mm, the international foot, not the US survey foot.
    Foot,
}

impl LengthUnit {
    /// All units.
    pub const ALL: [Self; 5] =
        [Self::Millimeter, Self::Centimeter, Self::Meter, Self::Inch, Self::Foot];

    /// The unit in millimeters.
    #[must_use]
    pub fn in_millimeters(self) -> f64 {
        match self {
            Self::Millimeter => 1.0,
            Self::Centimeter => 10.0,
            Self::Meter => 1000.0,
            Self::Inch => 25.4,
            Self::Foot => 304.8,
        }
    }

    /// The symbol of the unit, `"mm"` for example.
    #[must_use]
    pub fn symbol(self) -> &'static str {
        match self {
            Self::Millimeter => "mm",
            Self::Centimeter => "cm",
            Self::Meter => "m",
            Self::Inch => "in",
            Self::Foot => "ft",
        }
    }
}
