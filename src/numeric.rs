//! Numerical helpers for every module: quantiles, rms, integers, hashes, short numbers in
//! messages.

use std::fmt;

/// The upper median; 0 without values.
pub(crate) fn median(values: impl IntoIterator<Item = f64>) -> f64 {
    quantile(values, 0.5)
}

/// The quantile at this share, one of the values; 0 without values.
pub(crate) fn quantile(values: impl IntoIterator<Item = f64>, share: f64) -> f64 {
    let mut values: Vec<f64> = values.into_iter().collect();
    if values.is_empty() {
        return 0.0;
    }
    let place = whole(share * values.len() as f64).min(values.len() - 1);
    *values.select_nth_unstable_by(place, f64::total_cmp).1
}

/// The root mean square; 0 without values.
pub(crate) fn rms(values: impl IntoIterator<Item = f64>) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for value in values {
        sum += value * value;
        count += 1.0;
    }
    if count > 0.0 { (sum / count).sqrt() } else { 0.0 }
}

/// The least and the largest of some values; infinite without values.
pub(crate) fn min_max(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)))
}

/// The integer part of a number; 0 for negative numbers.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "saturates")]
pub(crate) fn whole(number: f64) -> usize {
    number as usize
}

/// A bijective hash of 64 bits (`SplitMix64`: G. Steele, D. Lea, C. Flood, 2014).
pub(crate) fn mix(value: u64) -> u64 {
    let z = value.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// An index as `u32`, the type in which neighbors and edges are stored.
pub(crate) fn index(place: usize) -> u32 {
    u32::try_from(place).unwrap_or(u32::MAX)
}

/// A number with four significant digits.
pub(crate) struct Short(pub(crate) f64);

impl fmt::Display for Short {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let size = self.0.abs();
        if size != 0.0 && !(1e-4..1e6).contains(&size) {
            let text = format!("{:.3e}", self.0);
            let Some((digits, exponent)) = text.split_once('e') else { return f.write_str(&text) };
            return write!(f, "{}e{exponent}", digits.trim_end_matches('0').trim_end_matches('.'));
        }
        let mut decimals = 3;
        let mut unit = 10.0;
        while decimals > 0 && size >= unit {
            (decimals, unit) = (decimals - 1, 10.0 * unit);
        }
        unit = 1.0;
        while size != 0.0 && size < unit {
            (decimals, unit) = (decimals + 1, unit / 10.0);
        }
        let text = format!("{:.decimals$}", self.0);
        let text =
            if decimals > 0 { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
        f.write_str(text)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn median_quantile_and_rms_of_short_lists() {
        assert_eq!(median([3.0, 1.0, 2.0]), 2.0);
        assert_eq!(quantile([3.0, 1.0, 2.0], 1.0), 3.0);
        assert_eq!(median([]), 0.0);
        assert_eq!(rms([3.0, 4.0, 0.0, 0.0]), 2.5);
    }

    #[test]
    fn numbers_have_four_digits() {
        let cases = [
            (0.0, "0"),
            (1.0, "1"),
            (123_456.7, "123457"),
            (12.345_67, "12.35"),
            (0.012_345_6, "0.01235"),
            (1.234_56e-7, "1.235e-7"),
            (-1e300, "-1e300"),
            (f64::NAN, "NaN"),
        ];
        for (number, text) in cases {
            assert_eq!(Short(number).to_string(), text);
        }
    }
}
