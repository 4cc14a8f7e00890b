//! Plain values as bytes and back, little-endian on every machine.

use glam::DVec3;

use crate::error::{Error, Result};

/// Reads what was saved behind its first bytes, `magic`. The error names the parameter and what it
/// must be.
pub(crate) fn read_saved<T>(
    bytes: &[u8],
    magic: &[u8],
    parameter: &'static str,
    saved: &str,
    read: impl FnOnce(&mut Reader<'_>) -> Option<T>,
) -> Result<T> {
    let mut from = bytes.strip_prefix(magic).map(Reader);
    let value = from.as_mut().and_then(read);
    let complete = from.is_some_and(|from| from.0.is_empty());
    value.filter(|_| complete).ok_or_else(|| {
        let must = format!("the complete bytes of {saved}");
        Error::parameter(parameter, must, format!("{} other bytes", bytes.len()))
    })
}

/// Appends values to a buffer.
pub(crate) struct Writer(pub(crate) Vec<u8>);

impl Writer {
    pub(crate) fn count(&mut self, value: u64) {
        self.0.extend(value.to_le_bytes());
    }

    pub(crate) fn real(&mut self, value: f64) {
        self.0.extend(value.to_le_bytes());
    }

    pub(crate) fn quanta(&mut self, value: i128) {
        self.0.extend(value.to_le_bytes());
    }

    pub(crate) fn optional(&mut self, value: Option<f64>) {
        self.reals(value.as_slice());
    }

    pub(crate) fn choice<T: PartialEq>(&mut self, all: &[T], value: &T) {
        let place = all.iter().position(|one| one == value);
        self.count(place.unwrap_or(all.len()) as u64);
    }

    pub(crate) fn reals(&mut self, values: &[f64]) {
        self.count(values.len() as u64);
        for &value in values {
            self.real(value);
        }
    }

    pub(crate) fn points(&mut self, points: &[DVec3]) {
        self.count(points.len() as u64);
        points.iter().flat_map(DVec3::to_array).for_each(|value| self.real(value));
    }
}

/// The bytes still to read. Each method returns `None` if they are too few or invalid.
pub(crate) struct Reader<'a>(pub(crate) &'a [u8]);

impl Reader<'_> {
    pub(crate) fn bytes<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (first, rest) = self.0.split_first_chunk::<N>()?;
        self.0 = rest;
        Some(*first)
    }

    pub(crate) fn count(&mut self) -> Option<u64> {
        self.bytes().map(u64::from_le_bytes)
    }

    pub(crate) fn size(&mut self) -> Option<usize> {
        self.count().and_then(|count| usize::try_from(count).ok())
    }

    /// A count of items of `bytes` bytes each; `None` if the rest is shorter than that.
    pub(crate) fn length(&mut self, bytes: usize) -> Option<usize> {
        self.size().filter(|&count| count <= self.0.len() / bytes)
    }

    pub(crate) fn real(&mut self) -> Option<f64> {
        self.bytes().map(f64::from_le_bytes)
    }

    pub(crate) fn quanta(&mut self) -> Option<i128> {
        self.bytes().map(i128::from_le_bytes)
    }

    pub(crate) fn choice<T: Copy>(&mut self, all: &[T]) -> Option<T> {
        let place = self.size()?;
        all.get(place).copied()
    }

    pub(crate) fn reals(&mut self) -> Option<Vec<f64>> {
        (0..self.length(8)?).map(|_| self.real()).collect()
    }

    pub(crate) fn points(&mut self) -> Option<Vec<DVec3>> {
        let count = self.length(size_of::<DVec3>())?;
        (0..count).map(|_| Some(DVec3::new(self.real()?, self.real()?, self.real()?))).collect()
    }
}
