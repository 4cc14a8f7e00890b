//! Isomap chart: the flat map that preserves distances along the surface (J. Tenenbaum, V. de
//! Silva, J. Langford, *A global geometric framework for nonlinear dimensionality reduction*,
//! 2000).

use super::bounding_rectangle::BoundingRectangle;
use super::hypothesis::Hypothesis;
use super::input::{ChartInput, Graph};
use super::kind::Kind;
use super::traits::Chart;

/// Sheets by landmark Isomap, once along the surface and once along the shortest links.
pub(super) struct Isomap;

impl Chart for Isomap {
    fn name(&self) -> &'static str {
        "isomap"
    }

    fn kinds(&self) -> &'static [Kind] {
        &[Kind::Sheet]
    }

    fn propose(&self, input: &ChartInput<'_>) -> Vec<Hypothesis> {
        let sheet = |(name, graph)| {
            let map = input.landmark_map(graph)?;
            let rectangle = BoundingRectangle::around(&map.places);
            let uv = map.places.iter().map(|place| rectangle.uv(*place)).collect();
            Some(Hypothesis::new(name, Kind::Sheet, uv, rectangle.size.to_array()))
        };
        let graphs = [("isomap", Graph::Surface), ("isomap tight", Graph::Tight)];
        graphs.into_iter().filter_map(sheet).collect()
    }
}
