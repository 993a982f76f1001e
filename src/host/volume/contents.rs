//! What a file states and holds beside the volume that is read from it.

use glam::DVec3;

/// What a file states about its volumes: their numbers, and which of them was read. Built-in volumes and volumes in memory hold one.
///
/// ```
/// use layersplat::volume::{Contents, OpenOptions, Volume};
///
/// let volume = Volume::open("builtin:cube@8", &OpenOptions::default())?;
/// assert_eq!(volume.contents(), &Contents::default());
/// assert_eq!((volume.contents().frames, volume.contents().channels), (1, 1));
/// # Ok::<(), layersplat::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Contents {
    /// Whether the file states distances between voxels. If not, they are 1, or as [`OpenOptions::spacing`](super::OpenOptions::spacing).
    pub states_spacing: bool,
    /// Unit of lengths in the world, by its symbol where it is known: `mm`, `µm`. `None` if the file states none.
    pub length_unit: Option<String>,
    /// Volumes of a sequence, usually times.
    pub frames: usize,
    /// The frame that was read, from 0.
    pub frame: usize,
    /// Distance between frames, if the file states one.
    pub frame_spacing: Option<FrameSpacing>,
    /// Times of the frames, if the file states them and they are not evenly spaced.
    pub frame_times: Vec<f64>,
    /// Components of each voxel.
    pub channels: usize,
    /// The channel that was read, from 0.
    pub channel: usize,
    /// Whether the magnitude of all channels was read instead of one of them.
    pub magnitude: bool,
    /// Whether the file declares the channels as the components of vectors.
    pub is_vector: bool,
    /// Whether the file declares the channels as colours: red, green, blue and possibly alpha, then others.
    pub are_colors: bool,
    /// Dimensions of all resolutions, finest first. Empty if the format has one resolution.
    pub levels: Vec<[usize; 3]>,
    /// The resolution that was read, from 0.
    pub level: usize,
    /// Where the voxels of each resolution lie.
    pub lattices: Vec<LevelLattice>,
    /// Voxels along x, y and z of the chunks of each resolution, if they are stored in chunks that can be read by themselves.
    pub chunks: Vec<[usize; 3]>,
    /// Range of values that the file says to show, of the channel that was read.
    pub window: Option<(f64, f64)>,
    /// Red, green and blue, 0 to 1, of each value, if voxels are indices of a palette. Empty otherwise.
    pub palette: Vec<[f64; 3]>,
}

/// Where the voxels of a resolution lie, in voxels of the finest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LevelLattice {
    /// The first voxel.
    pub first: DVec3,
    /// Distances between voxels.
    pub step: DVec3,
}

impl LevelLattice {
    /// That of the finest.
    pub(super) const OWN: Self = Self { first: DVec3::ZERO, step: DVec3::ONE };
}

/// Distance between consecutive frames.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct FrameSpacing {
    /// A positive number.
    pub distance: f64,
    /// Unit, as the file states it: `s` for seconds.
    pub unit: Option<String>,
}

impl Default for Contents {
    fn default() -> Self {
        Self {
            states_spacing: true,
            length_unit: None,
            frames: 1,
            frame: 0,
            frame_spacing: None,
            frame_times: Vec::new(),
            channels: 1,
            channel: 0,
            magnitude: false,
            is_vector: false,
            are_colors: false,
            levels: Vec::new(),
            level: 0,
            lattices: Vec::new(),
            chunks: Vec::new(),
            window: None,
            palette: Vec::new(),
        }
    }
}

impl FrameSpacing {
    /// `None` unless the distance is finite and positive.
    pub(super) fn new(distance: f64, unit: Option<&str>) -> Option<Self> {
        let unit = unit.map(str::trim).filter(|unit| !unit.is_empty()).map(Into::into);
        (distance.is_finite() && distance > 0.0).then_some(Self { distance, unit })
    }
}

/// Largest difference of intervals of time that count as equal, as a share of one.
const SAME_INTERVAL: f64 = 1e-6;

/// Fewest and most voxels of a level that stands for all.
const OVERVIEW: std::ops::RangeInclusive<usize> = 1 << 18..=1 << 28;

impl Contents {
    /// The level that stands for all, if there are several: the coarsest with enough voxels for statistics, else the finest.
    pub(super) fn overview_level(&self) -> Option<usize> {
        let voxels = |dims: &[usize; 3]| dims.iter().fold(1, |n: usize, &size| n.saturating_mul(size));
        let level = self.levels.iter().rposition(|dims| voxels(dims) >= *OVERVIEW.start()).unwrap_or(0);
        (self.levels.len() > 1 && voxels(&self.levels[level]) <= *OVERVIEW.end()).then_some(level)
    }

    /// Whether voxels of these dimensions are a part of the level.
    pub(super) fn are_part(&self, dims: [usize; 3]) -> bool {
        self.levels.get(self.level).is_some_and(|&whole| whole != dims)
    }

    /// Sets the times of the frames: their distance, if it is the same between all.
    pub(super) fn set_times(&mut self, times: Vec<f64>) {
        let mut intervals = times.windows(2).map(|pair| pair[1] - pair[0]);
        let first = intervals.next().unwrap_or_default();
        if intervals.all(|interval| (interval - first).abs() <= SAME_INTERVAL * first.abs()) {
            self.frame_spacing = FrameSpacing::new(first, None);
        } else {
            self.frame_times = times;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_are_positive() {
        for distance in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert_eq!(FrameSpacing::new(distance, Some("s")), None);
        }
        assert_eq!(FrameSpacing::new(0.5, Some(" ")), Some(FrameSpacing { distance: 0.5, unit: None }));
    }
}
