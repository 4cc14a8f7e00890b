//! The data section of a STEP file: numbered entities, reals, strings and lists.

use std::fmt::Write as _;
use std::io::Write;

use crate::error::Result;

/// The data section, which numbers its entities.
pub(super) struct Entities<'a, W: Write> {
    out: &'a mut W,
    count: usize,
}

impl<'a, W: Write> Entities<'a, W> {
    pub(super) fn new(out: &'a mut W) -> Self {
        Self { out, count: 0 }
    }

    /// Writes an entity and returns the reference to it.
    pub(super) fn add(&mut self, entity: &str) -> Result<String> {
        self.count += 1;
        writeln!(self.out, "#{}={entity};", self.count)?;
        Ok(format!("#{}", self.count))
    }
}

/// Formats a real with the fewest digits that read back as the same bits, always with a decimal
/// point.
pub(super) fn real(value: f64) -> String {
    let text = format!("{value:?}");
    match text.split_once('e') {
        Some((digits, exponent)) if digits.contains('.') => format!("{digits}E{exponent}"),
        Some((digits, exponent)) => format!("{digits}.E{exponent}"),
        None => text,
    }
}

/// Formats a list.
pub(super) fn list(items: impl IntoIterator<Item = String>) -> String {
    let items: Vec<String> = items.into_iter().collect();
    format!("({})", items.join(","))
}

/// Formats a string. Characters outside ASCII, and control characters, are written in hexadecimal
/// (ISO 10303-21, 6.4.3).
pub(super) fn string(text: &str) -> String {
    let mut quoted = String::from("'");
    for c in text.chars() {
        match c {
            '\'' => quoted.push_str("''"),
            '\\' => quoted.push_str("\\\\"),
            ' '..='~' => quoted.push(c),
            _ => {
                quoted.push_str("\\X4\\");
                // Writing to a string does not fail.
                let _ = write!(quoted, "{:08X}", u32::from(c));
                quoted.push_str("\\X0\\");
            }
        }
    }
    quoted.push('\'');
    quoted
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reals_have_a_decimal_point_and_all_digits() {
        let cases = [(1.0, "1.0"), (-0.1, "-0.1"), (1e300, "1.E300"), (-2.5e-7, "-2.5E-7")];
        for (value, text) in cases {
            assert_eq!(real(value), text);
        }
        assert_eq!(real(5e-324), "5.E-324");
        assert_eq!(real(0.1 + 0.2), "0.30000000000000004");
    }

    #[test]
    fn strings_are_plain_ascii() {
        assert_eq!(string("it's a \\"), "'it''s a \\\\'");
        assert_eq!(string("Öl\n"), "'\\X4\\000000D6\\X0\\l\\X4\\0000000A\\X0\\'");
    }
}
