//! Partition of the layers among ranks.

use std::ops::Range;

/// Contiguous ranges with nearly equal numbers of layers.
pub(super) fn even(layers: usize, parts: usize) -> Vec<Range<usize>> {
    (0..parts).map(|n| n * layers / parts..(n + 1) * layers / parts).collect()
}

/// Contiguous ranges with nearly equal work: each border lies where the sum of the previous work is nearest to its share. No
/// range exceeds its share by more than the work of one layer.
pub(super) fn balanced(work: &[u64], parts: usize) -> Vec<Range<usize>> {
    let total: u64 = work.iter().sum();
    if total == 0 {
        return even(work.len(), parts);
    }
    let (mut borders, mut before, mut layer) = (vec![0], 0u64, 0);
    for part in 1..parts {
        let share = (u128::from(total) * part as u128 / parts as u128) as u64;
        while layer < work.len() && before + work[layer] / 2 < share {
            before += work[layer];
            layer += 1;
        }
        borders.push(layer);
    }
    borders.push(work.len());
    borders.windows(2).map(|pair| pair[0]..pair[1]).collect()
}

/// The largest work of any range.
pub(super) fn max_work(work: &[u64], ranges: &[Range<usize>]) -> u64 {
    ranges.iter().map(|range| work[range.clone()].iter().sum()).max().unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_cover_each_layer_once_with_a_fair_share_of_the_work() {
        let humps: Vec<u64> = (0..100u64).map(|i| i % 37 * (i % 11) + 1).collect();
        for work in [vec![5; 64], humps, vec![0; 9], vec![0, 0, 90, 0, 0], vec![1]] {
            for parts in [1, 2, 3, 5, 8, 120] {
                let ranges = balanced(&work, parts);
                let layers: Vec<usize> = ranges.iter().cloned().flatten().collect();
                assert_eq!((ranges.len(), layers), (parts, (0..work.len()).collect()), "{work:?}");
                let (total, most) = (work.iter().sum::<u64>(), work.iter().copied().max().unwrap());
                assert!(max_work(&work, &ranges) <= total / parts as u64 + most + 1, "{ranges:?} of {work:?}");
            }
        }
    }

    /// All visible layers lie in the last tenth.
    #[test]
    fn ranges_balance_work_rather_than_layers() {
        let work: Vec<u64> = (0..100).map(|i| if i < 90 { 1 } else { 1000 }).collect();
        let (even, balanced) = (max_work(&work, &even(100, 5)), max_work(&work, &balanced(&work, 5)));
        assert!(even > 9000 && balanced < 2200, "{even} and {balanced}");
    }
}
