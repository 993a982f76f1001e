//! What standard error says of a volume and of its transfer function.

use super::numbers::shortened;
use super::options::VolumeOptions;
use crate::transfer::TransferFunction;
use crate::volume::Volume;

/// Larger ratios of spacings are suspicious: a spacing may be missing or have another unit.
const MAX_SPACING_RATIO: f64 = 20.0;

/// Says on standard error what is assumed of a volume, and what looks wrong.
pub(super) fn remark_on_volume(options: &VolumeOptions, volume: &Volume) {
    if options.assumes_spacing() {
        eprintln!("spacing: 1,1,1 assumed, since raw files state none (--spacing X,Y,Z)");
    }
    let notices = [explain_spacing(volume.grid().spacing()), explain_values(volume)];
    notices.into_iter().flatten().for_each(|notice| eprintln!("layersplat: {notice}"));
}

/// Says on standard error how the other components of a file are drawn, where one of them was chosen by default.
pub(super) fn remark_on_components(volume: &Volume) {
    let contents = volume.contents();
    if contents.channels > 1 && !contents.magnitude {
        let colors = if contents.are_colors || (3..=4).contains(&contents.channels) {
            ", as red, green and blue by --colors direct"
        } else {
            ""
        };
        eprintln!("channels: {} of {} is drawn; all by --channels all{colors}", contents.channel, contents.channels);
    }
}

/// Says on standard error which transfer function was made for the volume. The built-in phantom has its own, which needs no remark.
pub(super) fn remark_on_transfer(transfer: &TransferFunction) {
    match transfer.name() {
        TransferFunction::AUTOMATIC => {
            eprintln!("transfer function: {} (choose another with --transfer)", describe(transfer));
        }
        name @ (TransferFunction::GREY_RAMP | TransferFunction::INVERTED_GREY_RAMP) => {
            let (lo, hi) = transfer.range();
            let [lo, hi] = [lo, hi].map(|value| rounded(value, hi - lo));
            eprintln!("transfer function: {name} from {lo} to {hi} (choose another with --transfer or --window)");
        }
        _ => {}
    }
}

/// Describes a transfer function in one line: its name, and the ramps of its opacity.
pub(super) fn describe(transfer: &TransferFunction) -> String {
    let mut points: Vec<String> = Vec::new();
    for pair in transfer.opacities().windows(2) {
        if pair[0].1 != pair[1].1 {
            let [from, to] = [pair[0], pair[1]].map(|(value, opacity)| {
                let opacity = (opacity * 1e3).round() / 1e3;
                format!("{opacity} at {}", shortened(value))
            });
            points.push(format!("{from} to {to}"));
        }
    }
    let changes = if points.is_empty() { "constant".into() } else { points.join(", ") };
    format!("{}, opacity {changes}", transfer.name())
}

/// Writes a value to about a ten-thousandth of the range that it bounds.
fn rounded(value: f64, range: f64) -> String {
    let decimals = 4.0 - range.log10().floor();
    if (0.0..10.0).contains(&decimals) { format!("{value:.0$}", decimals as usize) } else { format!("{value:.4e}") }
}

/// Explains volumes without a single valid voxel. Takes a pass over volumes of one value.
fn explain_values(volume: &Volume) -> Option<String> {
    let (lo, hi) = volume.range();
    (lo == hi && volume.statistics().histogram.iter().all(|&voxels| voxels == 0)).then(|| {
        format!(
            "no voxel is a finite number of at most 1e30 in magnitude, so all count as the background value {}; check file, frame \
             and channel, or scale the values down",
            volume.background()
        )
    })
}

/// Warns of spacings that differ by a large factor between axes.
fn explain_spacing(spacing: glam::DVec3) -> Option<String> {
    let ratio = spacing.max_element() / spacing.min_element();
    (ratio > MAX_SPACING_RATIO).then(|| {
        let [x, y, z] = spacing.to_array();
        format!(
            "the spacing {x},{y},{z} is {ratio:.0} times larger along one axis than along another; if wrong, use --spacing X,Y,Z"
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    #[test]
    fn uneven_spacings_are_reported() {
        assert_eq!(explain_spacing(DVec3::new(1.0, 1.0, 20.0)), None);
        let text = explain_spacing(DVec3::new(0.5, 0.5, 40.0)).unwrap();
        assert!(text.contains("80 times") && text.contains("--spacing"), "{text}");
    }
}
