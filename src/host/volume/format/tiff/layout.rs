//! Assignment of pages to slices, channels and frames.

use crate::volume::{FrameSpacing, lengths};
use glam::DVec3;
use serde_json::Value;

/// Which description states a layout.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Kind {
    /// None: pages are slices.
    Plain,
    ImageJ,
    Ome,
    /// The shape of an array, which tifffile writes.
    Shaped,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Axis {
    Slice,
    Frame,
    Channel,
}

impl Axis {
    fn named(letter: char) -> Option<Self> {
        match letter.to_ascii_uppercase() {
            'Z' => Some(Self::Slice),
            'T' => Some(Self::Frame),
            'C' => Some(Self::Channel),
            _ => None,
        }
    }

    /// Parses an order such as `CZT`.
    pub fn order(letters: &str) -> Option<[Self; 3]> {
        let order: Vec<Self> = letters.chars().map(Self::named).collect::<Option<_>>()?;
        let order = <[Self; 3]>::try_from(order).ok()?;
        [Self::Slice, Self::Frame, Self::Channel].iter().all(|axis| order.contains(axis)).then_some(order)
    }
}

/// Order of pages.
#[derive(Clone, Debug)]
pub(super) struct Layout {
    pub kind: Kind,
    pub slices: usize,
    pub frames: usize,
    pub channels: usize,
    /// Axes and their sizes, the fastest first. Several axes may be frames.
    pub axes: Vec<(Axis, usize)>,
    pub spacing: DVec3,
    pub states_spacing: bool,
    /// Unit of the spacing.
    pub length_unit: Option<String>,
    pub frame_spacing: Option<FrameSpacing>,
}

impl Layout {
    /// Axes in an order, the fastest first.
    pub fn ordered(order: [Axis; 3], slices: usize, frames: usize, channels: usize) -> Self {
        let size = |axis| match axis {
            Axis::Slice => slices,
            Axis::Frame => frames,
            Axis::Channel => channels,
        };
        Self {
            kind: Kind::Plain,
            slices,
            frames,
            channels,
            axes: order.map(|axis| (axis, size(axis))).into(),
            spacing: DVec3::ONE,
            states_spacing: false,
            length_unit: None,
            frame_spacing: None,
        }
    }

    /// A file whose pages are slices.
    pub fn plain(pages: usize) -> Self {
        Self::ordered([Axis::Slice, Axis::Channel, Axis::Frame], pages, 1, 1)
    }

    /// Number of pages that the layout has.
    pub fn pages(&self) -> usize {
        self.slices.saturating_mul(self.frames).saturating_mul(self.channels)
    }

    /// Index of a page.
    pub fn page(&self, slice: usize, mut frame: usize, channel: usize) -> usize {
        let (mut page, mut step) = (0usize, 1usize);
        for &(axis, count) in &self.axes {
            let at = match axis {
                Axis::Channel => channel,
                Axis::Slice => slice,
                Axis::Frame => {
                    let at = frame % count.max(1);
                    frame /= count.max(1);
                    at
                }
            };
            page = at.saturating_mul(step).saturating_add(page);
            step = count.saturating_mul(step);
        }
        page
    }

    /// The layout that ImageJ describes of pages with `samples` samples per pixel. `pixels_per_unit` is the resolution that it writes.
    pub fn imagej(description: &str, samples: usize, pixels_per_unit: Option<[f64; 2]>) -> Self {
        let value = |key: &str| description.lines().find_map(|line| line.strip_prefix(key)?.strip_prefix('=')).map(str::trim);
        let count = |key: &str| value(key).and_then(|text| text.parse::<usize>().ok()).filter(|&n| n > 0);
        let along = |pixels: f64| Some(1.0 / pixels).filter(|h| h.is_finite() && *h > 0.0).unwrap_or(1.0);
        let pixels_per_unit = pixels_per_unit.filter(|_| value("unit").is_some());
        let [x, y] = pixels_per_unit.map_or([1.0; 2], |pixels| pixels.map(along));
        let z = value("spacing").and_then(|text| text.parse().ok()).map_or(1.0, f64::abs);
        let number = |key: &str| value(key).and_then(|text| text.parse::<f64>().ok());
        let sizes = ["slices", "frames", "channels"].map(|key| count(key).unwrap_or(1));
        // Some writers count the samples of a pixel as channels.
        let [slices, frames, channels] = if samples > 1 && sizes[2] == samples { [sizes[0], sizes[1], 1] } else { sizes };
        let pages = slices.saturating_mul(frames).saturating_mul(channels);
        let order = value("order").and_then(Axis::order).unwrap_or([Axis::Channel, Axis::Slice, Axis::Frame]);
        let found = match count("images") {
            Some(images) if images != pages && images != pages.saturating_mul(sizes[2]) => Self::plain(images),
            _ => Self::ordered(order, slices, frames, channels),
        };
        Self {
            kind: Kind::ImageJ,
            spacing: DVec3::new(x, y, if z > 0.0 { z } else { 1.0 }),
            states_spacing: pixels_per_unit.is_some(),
            length_unit: value("unit").filter(|_| pixels_per_unit.is_some()).and_then(length_unit),
            frame_spacing: number("finterval")
                .and_then(|interval| FrameSpacing::new(interval, Some(value("tunit").unwrap_or("s")))),
            ..found
        }
    }

    /// The layout of the array whose shape tifffile describes, `None` for another description. `page`: the sizes of a page, in which its
    /// last axes are stored.
    pub fn shaped(description: &str, page: &[usize]) -> Option<Self> {
        let (shape, axes) = shape(description)?;
        let of = |sizes: &[usize]| sizes.iter().try_fold(1usize, |n, &size| n.checked_mul(size));
        let inside = of(page).filter(|&n| n > 0)?;
        // The axes outside of a page are those before which the product of the others is that of a page.
        let outside = (0..=shape.len()).find(|&n| of(&shape[n..]) == Some(inside))?;
        let known = |n: usize| axes.as_ref().and_then(|axes| Axis::named(axes.chars().nth(n)?));
        let mut found: Vec<(Axis, usize)> = Vec::new();
        let has_slices = (0..outside).any(|n| known(n) == Some(Axis::Slice));
        for n in (0..outside).rev() {
            let has = |axis: Axis| found.iter().any(|(other, _)| *other == axis);
            let axis = match known(n) {
                Some(axis) if !has(axis) => axis,
                // Without a z axis, the fastest axis of unknown meaning is z, as in an array without names of axes.
                None if !has_slices && !has(Axis::Slice) => Axis::Slice,
                _ => Axis::Frame,
            };
            found.push((axis, shape[n]));
        }
        let size = |axis: Axis| found.iter().filter(|(other, _)| *other == axis).map(|(_, size)| size).product();
        let (slices, frames, channels) = (size(Axis::Slice), size(Axis::Frame), size(Axis::Channel));
        Some(Self { kind: Kind::Shaped, slices, frames, channels, axes: found, ..Self::plain(1) })
    }
}

/// The symbol of a unit that ImageJ names. It escapes letters beyond ASCII.
fn length_unit(name: &str) -> Option<String> {
    let name = name.replace("\\u00B5", "µ");
    let is_length = !["pixel", "pixels"].contains(&name.to_lowercase().as_str());
    is_length.then(|| lengths::symbol(&name).map_or(name, Into::into))
}

/// The shape of an array and the letters of its axes.
fn shape(description: &str) -> Option<(Vec<usize>, Option<String>)> {
    // As versions of 2015 write.
    if let Some(text) = description.trim().strip_prefix("shape=(").and_then(|text| text.strip_suffix(')')) {
        let sizes = text.split(',').map(str::trim).filter(|size| !size.is_empty()).map(|size| size.parse().ok());
        return Some((sizes.collect::<Option<_>>()?, None));
    }
    let Value::Object(found) = serde_json::from_str(description).ok().filter(|_| description.starts_with('{'))? else {
        return None;
    };
    let sizes = found.get("shape")?.as_array()?.iter().map(|size| usize::try_from(size.as_u64()?).ok());
    let sizes: Vec<usize> = sizes.collect::<Option<_>>()?;
    let axes = found.get("axes").and_then(Value::as_str).filter(|axes| axes.chars().count() == sizes.len());
    Some((sizes, axes.map(Into::into)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pages_are_counted_in_the_order_that_is_told() {
        let of = |order: &str| Layout::ordered(Axis::order(order).unwrap(), 5, 3, 2);
        assert_eq!((of("CZT").page(1, 0, 0), of("ZCT").page(1, 2, 1), of("TZC").page(2, 1, 1)), (2, 26, 22));
        assert_eq!((of("CZT").pages(), Axis::order("CZZ"), Axis::order("CZTT")), (30, None, None));
    }

    #[test]
    fn imagej_describes_hyperstacks() {
        let layout = |text: &str, samples: usize| Layout::imagej(&format!("ImageJ=1.5\n{text}"), samples, Some([4.0, 2.0]));
        let timed = layout("images=6\nslices=3\nframes=2\nfinterval=0.1\n", 1);
        assert_eq!(timed.frame_spacing, FrameSpacing::new(0.1, Some("s")));
        let spaced = layout("images=6\nslices=3\nframes=2\nunit=um\nspacing=0.5\n", 1);
        assert_eq!((spaced.page(2, 1, 0), spaced.spacing), (5, DVec3::new(0.25, 0.5, 0.5)));
        let unit = |name: &str| layout(&format!("images=6\nunit={name}\n"), 1).length_unit;
        assert_eq!((unit("micron"), unit("\\u00B5m"), unit("pixel")), (Some("µm".into()), Some("µm".into()), None));
        assert_eq!(layout("images=6\nslices=4\n", 1).slices, 6);
        let ordered = layout("images=6\nslices=3\nchannels=2\norder=zct\n", 1);
        assert_eq!((ordered.page(2, 0, 0), ordered.page(0, 0, 1)), (2, 3));
        let colours = layout("images=3\nslices=3\nchannels=3\n", 3);
        assert_eq!((colours.slices, colours.channels), (3, 1));
    }

    #[test]
    fn shapes_of_arrays_have_axes() {
        let sizes = |text: &str, page: &[usize]| {
            let layout = Layout::shaped(text, page)?;
            Some(([layout.slices, layout.frames, layout.channels], layout.page(1, 1, 0)))
        };
        assert_eq!(sizes(r#"{"shape": [2, 3, 4, 5, 6], "axes": "TZCYX"}"#, &[5, 6]), Some(([3, 2, 4], 16)));
        assert_eq!(sizes(r#"{"shape": [2, 3, 4, 5, 6], "axes": "CTZYX"}"#, &[5, 6]), Some(([4, 3, 2], 5)));
        // Without names of axes: frames, then z, as in an array of numpy.
        assert_eq!(sizes(r#"{"shape": [2, 3, 4, 5, 6]}"#, &[5, 6]), Some(([4, 6, 1], 5)));
        assert_eq!(sizes("shape=(4, 5, 6)", &[5, 6]), Some(([4, 1, 1], 1)));
        assert_eq!(sizes(r#"{"shape": [4, 5, 6, 3], "axes": "ZYXS"}"#, &[5, 6, 3]), Some(([4, 1, 1], 1)));
        assert_eq!(sizes(r#"{"shape": [4, 5, 6], "axes": "TYX"}"#, &[5, 6]), Some(([1, 4, 1], 1)));
        assert_eq!(sizes(r#"{"shape": [4, 5, 6], "axes": "QYX"}"#, &[5, 6]), Some(([4, 1, 1], 1)));
        for other in [
            r#"{"shape": [4, 5, 7]}"#,
            r#"{"shape": "x"}"#,
            "{}",
            "{",
            "shape=(a)",
            "",
            r#"{"shape": [99999999999, 99999999999, 5, 6]}"#,
        ] {
            assert_eq!(sizes(other, &[5, 6]).is_some(), other.contains("999"), "{other}");
        }
    }
}
