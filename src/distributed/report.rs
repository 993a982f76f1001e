//! What is told of a picture that several processes made.

use super::compose::Composed;
use super::exchange::Exchanged;
use super::group::Group;
use crate::layers::Axis;
use crate::renderer::LatticeReport;
use crate::volume::Together;
use serde::Serialize;

/// What a process did for a picture.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct RankReport {
    /// Its number.
    pub rank: usize,
    /// Layers that it composited, on all lattices.
    pub layers: usize,
    /// Bytes of voxels that it has read of the file since it was opened, or has made of a built-in volume.
    pub read_bytes: u64,
    /// Voxels that were brought for this picture.
    #[serde(flatten)]
    pub exchanged: Exchanged,
    /// Milliseconds for its layers.
    pub render_ms: f64,
    /// Share of the slowest rank's time that it waited.
    pub idle: f64,
}

/// What a picture took.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct DistributedReport {
    /// The lattice, of the most parallel axis.
    pub lattice: LatticeReport,
    /// The axes along which layers lay, the most parallel one first.
    pub axes: Vec<Axis>,
    /// What each process did.
    pub ranks: Vec<RankReport>,
    /// How the lattices were composed.
    pub composed: Vec<Composed>,
    /// Milliseconds for composing them, on this process, which may have waited for others.
    pub compose_ms: f64,
}

/// What one process adds up over a picture.
#[derive(Clone, Copy, Default)]
pub(super) struct Own {
    pub layers: usize,
    pub read_bytes: u64,
    pub exchanged: Exchanged,
    pub render_ms: f64,
}

impl Own {
    /// Of all ranks. Collective.
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
