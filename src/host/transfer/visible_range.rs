//! The range of values over which transfer functions are stretched.

use crate::volume::Volume;

/// Range of values over which built-in functions are stretched: that which the file says to show, or the range of the data, of all levels of a
/// data set the same. If all voxels are equal, it includes the
/// background. If that is equal too, it spans 0 and a value above it, so that the volume is visible.
pub(super) fn visible_range(volume: &Volume) -> (f64, f64) {
    let (lo, hi) = volume.contents().window.unwrap_or(volume.description().common_range());
    if lo < hi {
        return (lo, hi);
    }
    match volume.field_range() {
        (lo, hi) if lo < hi => (lo, hi),
        (lo, _) if lo > 0.0 => (0.0, lo),
        // If adding 1 is lost to rounding, end the range at 0 instead.
        (lo, _) => (lo, if lo + 1.0 > lo { lo + 1.0 } else { 0.0 }),
    }
}
