//! Statistics of distributed frames.

use super::compose::Composed;
use super::exchange::Exchanged;
use super::group::Group;
use crate::layers::Axis;
use crate::renderer::LatticeReport;
use crate::volume::Together;
use serde::Serialize;

/// Statistics of one process for a frame.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct RankReport {
    /// Rank of the process.
    pub rank: usize,
    /// Composited layers, over all lattices.
    pub layers: usize,
    /// Bytes of voxels read from the file, or generated for a built-in volume, since it was opened.
    pub read_bytes: u64,
    /// Voxel traffic for this frame.
    #[serde(flatten)]
    pub exchanged: Exchanged,
    /// Milliseconds for compositing the layers.
    pub render_ms: f64,
    /// Idle time as a share of the slowest rank's time, 0 to 1.
    pub idle: f64,
}

/// Statistics of a distributed frame.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct DistributedReport {
    /// The lattice of the layer axis most parallel to the view direction.
    pub lattice: LatticeReport,
    /// The layer axes of the frame, the one most parallel to the view direction first.
    pub axes: Vec<Axis>,
    /// Statistics by rank.
    pub ranks: Vec<RankReport>,
    /// Statistics of the composition of each lattice.
    pub composed: Vec<Composed>,
    /// Milliseconds for composing the lattices on this process, including waiting for others.
    pub compose_ms: f64,
}

/// Totals of this process for a frame.
#[derive(Clone, Copy, Default)]
pub(super) struct Totals {
    pub layers: usize,
    pub read_bytes: u64,
    pub exchanged: Exchanged,
    pub render_ms: f64,
}

impl Totals {
    /// Gathers the statistics of all ranks. Collective.
    pub fn gather(self, group: &Group) -> Vec<RankReport> {
        let Exchanged { sent_bytes, received_bytes } = self.exchanged;
        let bytes = [self.read_bytes, sent_bytes, received_bytes].map(|bytes| bytes as f64);
        let all = group.gather(&[self.layers as f64, bytes[0], bytes[1], bytes[2], self.render_ms]);
        let slowest = all.chunks_exact(5).map(|own| own[4]).fold(f64::MIN_POSITIVE, f64::max);
        let report = |(rank, own): (usize, &[f64])| RankReport {
            rank,
            layers: own[0] as usize,
            read_bytes: own[1] as u64,
            exchanged: Exchanged { sent_bytes: own[2] as u64, received_bytes: own[3] as u64 },
            render_ms: own[4],
            idle: 1.0 - own[4] / slowest,
        };
        all.chunks_exact(5).enumerate().map(report).collect()
    }
}
