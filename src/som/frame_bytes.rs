//! A map's frame as bytes and back.

use super::frame::Frame;
use crate::bytes::{Reader, Writer};

impl Writer {
    pub(super) fn frame(&mut self, frame: &Frame) {
        let (center, size) = frame.parts();
        self.points(&[center]);
        self.real(size);
    }
}

impl Reader<'_> {
    pub(super) fn frame(&mut self) -> Option<Frame> {
        let [center] = self.points()?[..] else { return None };
        Some(Frame::from_parts(center, self.real()?))
    }
}
