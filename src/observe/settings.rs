//! Thresholds of what is observed.

/// How a cloud is observed. Sources: the study of 149 synthetic and 44 real clouds that the
/// scoreboard repeats, unless a field says otherwise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ObserveSettings {
    /// Points that are looked at, at most.
    pub sample: usize,
    /// Neighbours of a point in the graph.
    pub neighbors: usize,
    /// Neighbours in the smallest local plane; the next sizes grow by half.
    pub least_plane: usize,
    /// Neighbours in the largest local plane.
    pub largest_plane: usize,
    /// Share of a smaller plane's thickness over width that a larger plane must get below.
    pub flatter: f64,
    /// Thickness over width of the planes, in that of points that fill a volume, from which on they say
    /// nothing of normals and noise. Source: waves with noise of 0.08 to 0.15 of their extent.
    pub thick: f64,
    /// Points under which that may be curvature, too, and planes are taken at their word.
    pub few: usize,
    /// Sine of the angle between a link and a local plane from which on the link is dropped.
    pub link_sine: f64,
    /// Neighbours of a point in the tight graph.
    pub tight_neighbors: usize,
    /// Length of a link of the tight graph, in mean distances of its ends to their neighbours.
    pub tight_length: f64,
    /// Neighbours among which a border point sees a gap.
    pub border_neighbors: usize,
    /// Angle of that gap, in radians.
    pub border_gap: f64,
}

impl Default for ObserveSettings {
    fn default() -> Self {
        Self {
            sample: 2000,
            neighbors: 8,
            least_plane: 6,
            largest_plane: 160,
            flatter: 0.93,
            thick: 0.75,
            few: 100,
            link_sine: 0.6,
            tight_neighbors: 4,
            tight_length: 1.8,
            border_neighbors: 16,
            border_gap: 2.8,
        }
    }
}
