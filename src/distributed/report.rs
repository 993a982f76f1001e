//! Collects the statistics of distributed frames.

use super::group::Group;
use crate::renderer::{Exchanged, Measured, RankMeasured, RankReport};
use crate::volume::Collective;

/// Totals of this process for a frame.
#[derive(Default)]
pub(super) struct Totals {
    pub layers: usize,
    pub read_bytes: u64,
    pub exchanged: Exchanged,
    pub render_ms: f64,
    /// Frame statistics, if measured.
    pub measured: Option<Measured>,
}

impl Totals {
    /// Gathers the statistics of all ranks. Collective.
    pub fn gather(&self, group: &Group) -> Vec<RankReport> {
        let Exchanged { sent_bytes, received_bytes } = self.exchanged;
        let bytes = [self.read_bytes, sent_bytes, received_bytes].map(|bytes| bytes as f64);
        let all = group.gather(&[self.layers as f64, bytes[0], bytes[1], bytes[2], self.render_ms]);
        let measured = self.gather_measured(group);
        let slowest = all.chunks_exact(5).map(|own| own[4]).fold(f64::MIN_POSITIVE, f64::max);
        let report = |(rank, own): (usize, &[f64])| RankReport {
            rank,
            layers: own[0] as usize,
            read_bytes: own[1] as u64,
            exchanged: Exchanged { sent_bytes: own[2] as u64, received_bytes: own[3] as u64 },
            render_ms: own[4],
            idle: 1.0 - own[4] / slowest,
            measured: measured[rank].clone(),
        };
        all.chunks_exact(5).enumerate().map(report).collect()
    }

    /// Gathers the frame statistics of all ranks, which all measure or none.
    fn gather_measured(&self, group: &Group) -> Vec<Option<RankMeasured>> {
        let Some(Measured { stages, active_samples }) = &self.measured else { return vec![None; group.size()] };
        let encoded = serde_json::to_vec(&(stages, active_samples)).expect("names and numbers are valid JSON");
        let decode = |bytes: Vec<u8>| {
            let (stages, active_samples) = serde_json::from_slice(&bytes).expect("encoded by this function");
            Some(RankMeasured { stages, active_samples })
        };
        group.gather_parts(&encoded).into_iter().map(decode).collect()
    }
}
