//! Statistics of frames of several processes.

use super::report::LatticeReport;
use crate::layers::Axis;
use serde::{Serialize, Serializer};
use std::ops::AddAssign;

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
    /// Frame statistics, if enabled by `Renderer::measure`.
    #[serde(flatten, skip_serializing_if = "Option::is_none")]
    pub measured: Option<RankMeasured>,
}

/// Frame statistics of one process.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct RankMeasured {
    /// Milliseconds per stage. On rank 0 this includes the warp.
    #[serde(serialize_with = "as_map")]
    pub stages: Vec<(String, f64)>,
    /// Number of composited samples of this rank's layers with an opacity above 0.
    pub active_samples: u64,
}

fn as_map<S: Serializer>(stages: &[(String, f64)], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_map(stages.iter().map(|(stage, ms)| (stage, ms)))
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

/// Statistics of the composition of a lattice.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Composed {
    /// Participating ranks: those with visible samples, and rank 0, which receives the result.
    pub ranks: usize,
    /// Samples of the lattice.
    pub lattice_samples: usize,
    /// Samples of the bounding box of all visible samples; only these are reduced.
    pub box_samples: usize,
    /// Bytes on the critical path: the box at each of the reduction's ⌈log₂ ranks⌉ levels.
    pub path_bytes: u64,
    /// Total bytes sent between ranks.
    pub bytes: u64,
}

/// Traffic of voxels and of light of a rank.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Exchanged {
    /// Bytes that this rank sent.
    pub sent_bytes: u64,
    /// Bytes that this rank received.
    pub received_bytes: u64,
}

impl AddAssign for Exchanged {
    fn add_assign(&mut self, more: Self) {
        self.sent_bytes += more.sent_bytes;
        self.received_bytes += more.received_bytes;
    }
}
