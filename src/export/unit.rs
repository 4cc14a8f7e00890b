//! The unit of length in CAD files.

/// The unit of length of the coordinates in a STEP or IGES file.
///
/// The unit is a label: coordinates are written unchanged, and readers convert them.
///
/// ```
/// use neurbs::export::LengthUnit;
/// assert_eq!(LengthUnit::default(), LengthUnit::Millimetre);
/// assert_eq!(LengthUnit::Inch.in_millimetres(), 25.4);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LengthUnit {
    /// 1 mm, the default unit of CAD programs.
    #[default]
    Millimetre,
    /// 10 mm.
    Centimetre,
    /// 1000 mm.
    Metre,
    /// 25.4 mm.
    Inch,
    /// 304.8 mm, the international foot, not the US survey foot.
    Foot,
}

impl LengthUnit {
    /// All units.
    pub const ALL: [Self; 5] =
        [Self::Millimetre, Self::Centimetre, Self::Metre, Self::Inch, Self::Foot];

    /// The unit in millimeters.
    #[must_use]
    pub fn in_millimetres(self) -> f64 {
        match self {
            Self::Millimetre => 1.0,
            Self::Centimetre => 10.0,
            Self::Metre => 1000.0,
            Self::Inch => 25.4,
            Self::Foot => 304.8,
        }
    }

    /// The symbol of the unit, `"mm"` for example.
    #[must_use]
    pub fn symbol(self) -> &'static str {
        match self {
            Self::Millimetre => "mm",
            Self::Centimetre => "cm",
            Self::Metre => "m",
            Self::Inch => "in",
            Self::Foot => "ft",
        }
    }
}
