//! Device check.

use crate::common::device;
use layersplat::check::{Family, TOLERANCE};

/// Margin for other devices: half of the tolerance.
const MARGIN: f64 = 0.5;

#[test]
fn the_device_under_test_passes_with_a_margin() {
    let report = device().check().unwrap();
    assert_eq!(report.verdicts.iter().map(|v| v.family).collect::<Vec<_>>(), Family::ALL);
    report.require().unwrap();
    for verdict in report.verdicts {
        let largest = verdict.largest_difference.unwrap();
        assert!(largest > 0.0 && largest < MARGIN * TOLERANCE, "{}: off by {largest}", verdict.family);
    }
}
