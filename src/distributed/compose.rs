//! Composites the lattice samples of all ranks.

use super::group::Group;
use super::over::Over;
use crate::renderer::{Composed, LatticeView};

/// A box of samples along u and v, from `from` up to but excluding `to`.
#[derive(Clone, Copy, Debug, PartialEq)]
struct SampleBox {
    from: [usize; 2],
    to: [usize; 2],
}

impl SampleBox {
    const EMPTY: Self = Self { from: [usize::MAX; 2], to: [0; 2] };

    fn is_empty(self) -> bool {
        self.from[0] >= self.to[0]
    }

    fn union(self, other: Self) -> Self {
        Self { from: [0, 1].map(|i| self.from[i].min(other.from[i])), to: [0, 1].map(|i| self.to[i].max(other.to[i])) }
    }

    fn count(self) -> usize {
        if self.is_empty() { 0 } else { (self.to[0] - self.from[0]) * (self.to[1] - self.from[1]) }
    }

    /// Index of the first sample of each row, in a lattice of this width.
    fn rows(self, width: usize) -> impl Iterator<Item = usize> {
        (self.from[1]..self.to[1]).map(move |row| row * width + self.from[0])
    }
}

/// The bounding box of all samples that are not empty.
fn bounding_box(samples: &[[f32; 4]], width: usize, is_empty: impl Fn([f32; 4]) -> bool) -> SampleBox {
    let mut all = SampleBox::EMPTY;
    for (row, samples) in samples.chunks(width.max(1)).enumerate() {
        let Some(first) = samples.iter().position(|&s| !is_empty(s)) else { continue };
        let last = samples.iter().rposition(|&s| !is_empty(s)).unwrap_or(first);
        all = all.union(SampleBox { from: [first, row], to: [last + 1, row + 1] });
    }
    all
}

/// Composites lattices, and caches the groups of participating ranks.
#[derive(Default)]
pub(super) struct Composer {
    groups: Vec<(Vec<bool>, Group)>,
}

/// Number of cached groups. In a film, mostly the same ranks participate in consecutive frames.
const CACHED_GROUPS: usize = 8;

impl Composer {
    /// Composites the samples of all ranks in view order. Rank 0 receives the result in `samples`. Collective.
    pub fn compose(&mut self, group: &Group, view: &LatticeView, has_layers: bool, samples: &mut [[f32; 4]]) -> Composed {
        let [width, height] = view.size();
        let mut composed = Composed { ranks: 1, lattice_samples: samples.len(), ..Composed::default() };
        if group.size() == 1 {
            return composed;
        }
        let own = match view.blend().gathers_values() {
            // Gathered values have no common empty value.
            true if has_layers => SampleBox { from: [0; 2], to: [width, height] },
            true => SampleBox::EMPTY,
            false => bounding_box(samples, width, |sample| sample == [0.0, 0.0, 0.0, 1.0]),
        };
        let numbers = [own.from, own.to].concat().iter().map(|&n| n as u64).collect::<Vec<_>>();
        let all: Vec<SampleBox> = (group.gather_counts(&numbers).chunks_exact(4))
            .map(|n| SampleBox { from: [n[0] as usize, n[1] as usize], to: [n[2] as usize, n[3] as usize] })
            .collect();
        let participates: Vec<bool> = all.iter().enumerate().map(|(rank, part)| rank == 0 || !part.is_empty()).collect();
        let union = all.into_iter().fold(SampleBox::EMPTY, SampleBox::union);
        composed.ranks = participates.iter().filter(|&&part| part).count();
        composed.box_samples = union.count();
        if composed.ranks == 1 {
            return composed;
        }
        let bytes = (union.count() * size_of::<[f32; 4]>()) as u64;
        composed.path_bytes = bytes * u64::from(composed.ranks.next_power_of_two().ilog2());
        composed.bytes = bytes * (composed.ranks as u64 - 1);
        let is_participant = participates[group.rank()];
        let subgroup = self.subgroup(group, participates);
        if is_participant {
            let columns = union.to[0] - union.from[0];
            let mut inside: Vec<[f32; 4]> = union.rows(width).flat_map(|at| samples[at..at + columns].to_vec()).collect();
            subgroup.reduce(&Over::new(view.blend(), view.ascending()), &mut inside);
            if group.leads() {
                for (at, row) in union.rows(width).zip(inside.chunks(columns)) {
                    samples[at..at + columns].copy_from_slice(row);
                }
            }
        }
        composed
    }

    /// The group of this rank: that of the participating ranks, or that of all others.
    fn subgroup(&mut self, group: &Group, participates: Vec<bool>) -> Group {
        if let Some((_, cached)) = self.groups.iter().find(|(key, _)| *key == participates) {
            return cached.clone();
        }
        let all = participates.iter().all(|&part| part);
        let subgroup = if all { group.clone() } else { group.split(usize::from(!participates[group.rank()])) };
        if self.groups.len() == CACHED_GROUPS {
            self.groups.remove(0);
        }
        self.groups.push((participates, subgroup.clone()));
        subgroup
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounding_boxes_contain_all_visible_samples() {
        let mut samples = vec![[0.0, 0.0, 0.0, 1.0]; 5 * 4];
        let is_empty = |sample: [f32; 4]| sample == [0.0, 0.0, 0.0, 1.0];
        assert!(bounding_box(&samples, 5, is_empty).is_empty());
        samples[5 + 3] = [0.0, 0.0, 0.0, 0.5];
        samples[10 + 1] = [0.1, 0.0, 0.0, 1.0];
        let found = bounding_box(&samples, 5, is_empty);
        assert_eq!(found, SampleBox { from: [1, 1], to: [4, 3] });
        assert_eq!((found.count(), found.rows(5).collect::<Vec<_>>()), (6, vec![6, 11]));
    }
}
