//! Steps between keys.

/// The step of a sequence that each of `count` pictures shows, evenly spaced in time from `start` to `end` seconds. `keys` have a time in
/// seconds and a step, in the order of time; between them the step is linear in time, rounded to the nearest one, and before the first and after
/// the last it is theirs.
///
/// ```
/// use layersplat::volume::steps_along;
///
/// assert_eq!(steps_along(&[(1.0, 0.0), (3.0, 4.0)], 0.0, 4.0, 5), [0, 0, 2, 4, 4]);
/// ```
///
/// # Panics
/// Without keys.
pub fn steps_along(keys: &[(f64, f64)], start: f64, end: f64, count: u32) -> Vec<usize> {
    let each = (end - start) / f64::from(count.max(2) - 1);
    (0..count).map(|n| step_at(keys, start + each * f64::from(n)).round() as usize).collect()
}

fn step_at(keys: &[(f64, f64)], time: f64) -> f64 {
    let after = keys.partition_point(|(t, _)| *t <= time);
    let (Some((to, end)), Some((from, start))) = (keys.get(after), keys[..after].last()) else {
        return keys[after.saturating_sub(1)].1;
    };
    start + (end - start) * (time - from) / (to - from)
}
