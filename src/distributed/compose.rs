//! The pictures of all ranks become one.

use super::group::Group;
use super::over::Over;
use crate::renderer::LatticeView;
use serde::Serialize;

/// What it took to compose a lattice.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Composed {
    /// Ranks that took part: those that show something, and rank 0, to which it all comes.
    pub ranks: usize,
    /// Samples of the lattice.
    pub lattice_samples: usize,
    /// Samples of the box around all that shows, which are reduced.
    pub box_samples: usize,
    /// Bytes that go one after the other: the box at each of the reduction's ⌈log₂ ranks⌉ levels.
    pub path_bytes: u64,
    /// Bytes that go from rank to rank in all.
    pub bytes: u64,
}

/// Samples `from` up to, but not including, `to` along u and v.
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

    fn with(self, other: Self) -> Self {
        Self { from: [0, 1].map(|i| self.from[i].min(other.from[i])), to: [0, 1].map(|i| self.to[i].max(other.to[i])) }
    }

    fn count(self) -> usize {
        if self.is_empty() { 0 } else { (self.to[0] - self.from[0]) * (self.to[1] - self.from[1]) }
    }

    /// Where its rows begin, in a picture of this width.
    fn rows(self, width: usize) -> impl Iterator<Item = usize> {
        (self.from[1]..self.to[1]).map(move |row| row * width + self.from[0])
    }
}

/// The smallest box with all samples that are not nothing.
fn outline(samples: &[[f32; 4]], width: usize, nothing: impl Fn([f32; 4]) -> bool) -> SampleBox {
    let mut all = SampleBox::EMPTY;
    for (row, samples) in samples.chunks(width.max(1)).enumerate() {
        let Some(first) = samples.iter().position(|&s| !nothing(s)) else { continue };
        let last = samples.iter().rposition(|&s| !nothing(s)).unwrap_or(first);
        all = all.with(SampleBox { from: [first, row], to: [last + 1, row + 1] });
    }
    all
}

/// Composes lattices; keeps the groups of those that took part.
#[derive(Default)]
pub(super) struct Composer {
    groups: Vec<(Vec<bool>, Group)>,
}

/// Groups that are kept: from frame to frame of a film mostly the same ranks take part.
const KEPT: usize = 8;

impl Composer {
    /// Puts into rank 0's samples what those of all ranks are together, one behind the other in the order of the view. Collective.
    pub fn compose(&mut self, group: &Group, view: &LatticeView, has_layers: bool, samples: &mut [[f32; 4]]) -> Composed {
        let [width, height] = view.size();
        let mut composed = Composed { ranks: 1, lattice_samples: samples.len(), ..Composed::default() };
        if group.size() == 1 {
            return composed;
        }
        let own = match view.blend().gathers_values() {
            // Values have no nothing that is the same everywhere.
            true if has_layers => SampleBox { from: [0; 2], to: [width, height] },
            true => SampleBox::EMPTY,
            false => outline(samples, width, |sample| sample == [0.0, 0.0, 0.0, 1.0]),
        };
        let numbers = [own.from, own.to].concat().iter().map(|&n| n as u64).collect::<Vec<_>>();
        let all: Vec<SampleBox> = (group.gather_counts(&numbers).chunks_exact(4))
            .map(|n| SampleBox { from: [n[0] as usize, n[1] as usize], to: [n[2] as usize, n[3] as usize] })
            .collect();
        let parts: Vec<bool> = all.iter().enumerate().map(|(rank, part)| rank == 0 || !part.is_empty()).collect();
        let union = all.into_iter().fold(SampleBox::EMPTY, SampleBox::with);
        composed.ranks = parts.iter().filter(|&&part| part).count();
        composed.box_samples = union.count();
        if composed.ranks == 1 {
            return composed;
        }
        let bytes = (union.count() * size_of::<[f32; 4]>()) as u64;
        composed.path_bytes = bytes * u64::from(composed.ranks.next_power_of_two().ilog2());
        composed.bytes = bytes * (composed.ranks as u64 - 1);
        let takes_part = parts[group.rank()];
        let among = self.among(group, parts);
        if takes_part {
            let columns = union.to[0] - union.from[0];
            let mut inside: Vec<[f32; 4]> = union.rows(width).flat_map(|at| samples[at..at + columns].to_vec()).collect();
            among.reduce(&Over::new(view.blend(), view.ascending()), &mut inside);
            if group.leads() {
                for (at, row) in union.rows(width).zip(inside.chunks(columns)) {
                    samples[at..at + columns].copy_from_slice(row);
                }
            }
        }
        composed
    }

    /// The group of those that take part, or of all others.
    fn among(&mut self, group: &Group, parts: Vec<bool>) -> Group {
        if let Some((_, kept)) = self.groups.iter().find(|(kept, _)| *kept == parts) {
            return kept.clone();
        }
        let among = if parts.iter().all(|&part| part) { group.clone() } else { group.split(usize::from(!parts[group.rank()])) };
        if self.groups.len() == KEPT {
            self.groups.remove(0);
        }
        self.groups.push((parts, among.clone()));
        among
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn outlines_hold_all_that_is_something() {
        let mut samples = vec![[0.0, 0.0, 0.0, 1.0]; 5 * 4];
        let nothing = |sample: [f32; 4]| sample == [0.0, 0.0, 0.0, 1.0];
        assert!(outline(&samples, 5, nothing).is_empty());
        samples[5 + 3] = [0.0, 0.0, 0.0, 0.5];
        samples[10 + 1] = [0.1, 0.0, 0.0, 1.0];
        let found = outline(&samples, 5, nothing);
        assert_eq!(found, SampleBox { from: [1, 1], to: [4, 3] });
        assert_eq!((found.count(), found.rows(5).collect::<Vec<_>>()), (6, vec![6, 11]));
    }
}
