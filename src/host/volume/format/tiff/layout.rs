//! Assignment of pages to slices, channels and frames.

use crate::volume::FrameSpacing;
use glam::DVec3;

/// Order of pages.
pub(super) struct Layout {
    pub imagej: bool,
    pub slices: usize,
    pub frames: usize,
    pub channels: usize,
    /// Order of slices (Z), frames (T) and channels (C), fastest first.
    order: String,
    pub spacing: DVec3,
    pub states_spacing: bool,
    pub frame_spacing: Option<FrameSpacing>,
    /// Whether the file specifies this layout.
    declared: bool,
}

impl Layout {
    /// Parses the image description of pages with `samples` samples per pixel. `pixels_per_unit` is the resolution that ImageJ writes.
    pub fn new(description: &str, samples: usize, pixels_per_unit: Option<[f64; 2]>) -> Self {
        let plain = Self {
            imagej: false,
            slices: 1,
            frames: 1,
            channels: 1,
            order: "CZT".into(),
            spacing: DVec3::ONE,
            states_spacing: false,
            frame_spacing: None,
            declared: false,
        };
        if description.starts_with("ImageJ=") {
            imagej(description, pixels_per_unit, plain)
        } else {
            ome(description, samples, plain)
        }
    }

    /// Number of pages that the layout has.
    pub fn pages(&self) -> usize {
        self.slices.saturating_mul(self.frames).saturating_mul(self.channels)
    }

    /// Adapts the layout to a file with `pages` pages.
    pub fn with_pages(self, pages: usize) -> Result<Self, String> {
        match self.declared {
            true if self.pages() == pages => Ok(self),
            true if !self.imagej => Err(format!(
                "its OME-XML declares {} pages, but it has {pages}: the others are in other files or missing",
                self.pages()
            )),
            _ => Ok(Self { slices: pages, frames: 1, channels: 1, ..self }),
        }
    }

    /// Index of a page.
    pub fn page(&self, slice: usize, frame: usize, channel: usize) -> usize {
        let (mut page, mut step) = (0usize, 1usize);
        for axis in self.order.chars() {
            let (at, count) = match axis {
                'C' => (channel, self.channels),
                'Z' => (slice, self.slices),
                _ => (frame, self.frames),
            };
            page = at.saturating_mul(step).saturating_add(page);
            step = count.saturating_mul(step);
        }
        page
    }
}

fn imagej(description: &str, pixels_per_unit: Option<[f64; 2]>, plain: Layout) -> Layout {
    let value = |key: &str| description.lines().find_map(|line| line.strip_prefix(key)?.strip_prefix('=')).map(str::trim);
    let count = |key: &str| value(key).and_then(|text| text.parse::<usize>().ok()).filter(|&n| n > 0);
    let along = |pixels: f64| Some(1.0 / pixels).filter(|h| h.is_finite() && *h > 0.0).unwrap_or(1.0);
    let pixels_per_unit = pixels_per_unit.filter(|_| value("unit").is_some());
    let [x, y] = pixels_per_unit.map_or([1.0; 2], |pixels| pixels.map(along));
    let z = value("spacing").and_then(|text| text.parse().ok()).map_or(1.0, f64::abs);
    let number = |key: &str| value(key).and_then(|text| text.parse::<f64>().ok());
    let images = count("images");
    let found = Layout {
        imagej: true,
        slices: count("slices").unwrap_or(1),
        frames: count("frames").unwrap_or(1),
        channels: count("channels").unwrap_or(1),
        spacing: DVec3::new(x, y, if z > 0.0 { z } else { 1.0 }),
        states_spacing: pixels_per_unit.is_some(),
        frame_spacing: number("finterval").and_then(|interval| FrameSpacing::new(interval, Some(value("tunit").unwrap_or("s")))),
        declared: images.is_some(),
        ..plain
    };
    match images {
        Some(images) if images != found.pages() => Layout { slices: images, frames: 1, channels: 1, ..found },
        _ => found,
    }
}

fn ome(description: &str, samples: usize, plain: Layout) -> Layout {
    let tag = ["<Pixels ", "<OME:Pixels "].iter().find_map(|start| description.split_once(start));
    let Some(tag) = tag.and_then(|(_, rest)| rest.split_once('>')).map(|(tag, _)| format!(" {tag}")) else { return plain };
    let value = |key: &str| {
        let rest = tag.split_once(&format!(" {key}="))?.1;
        let quote = rest.chars().next().filter(|c| ['"', '\''].contains(c))?;
        rest[1..].split_once(quote).map(|(value, _)| value)
    };
    let count = |key: &str| value(key).and_then(|text| text.parse::<usize>().ok()).filter(|&n| n > 0).unwrap_or(1);
    // Micrometres by default.
    let size = |axis: &str| {
        let unit = match value(&format!("PhysicalSize{axis}Unit")) {
            Some("nm") => 1e-3,
            Some("mm") => 1e3,
            Some("cm") => 1e4,
            Some("m") => 1e6,
            _ => 1.0,
        };
        let size: f64 = value(&format!("PhysicalSize{axis}"))?.parse().ok()?;
        Some(size * unit).filter(|h| h.is_finite() && *h > 0.0)
    };
    let order = value("DimensionOrder")
        .and_then(|order| order.strip_prefix("XY"))
        .filter(|order| order.len() == 3 && "CZT".chars().all(|axis| order.contains(axis)));
    let x = size("X").unwrap_or(1.0);
    Layout {
        slices: count("SizeZ"),
        frames: count("SizeT"),
        channels: (count("SizeC") / samples).max(1),
        order: order.unwrap_or("CZT").into(),
        spacing: DVec3::new(x, size("Y").unwrap_or(x), size("Z").unwrap_or(x)),
        states_spacing: size("X").is_some(),
        frame_spacing: value("TimeIncrement")
            .and_then(|interval| FrameSpacing::new(interval.parse().ok()?, Some(value("TimeIncrementUnit").unwrap_or("s")))),
        declared: true,
        ..plain
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pages_are_counted_in_the_order_that_is_told() {
        let ome = |order: &str| {
            let text = format!(
                "<OME><Image><Pixels ID='a' DimensionOrder=\"XY{order}\" SizeC='2' SizeT='3' SizeZ='5' PhysicalSizeZ='2'>"
            );
            Layout::new(&text, 1, None)
        };
        assert_eq!((ome("CZT").page(1, 0, 0), ome("ZCT").page(1, 2, 1), ome("TZC").page(2, 1, 1)), (2, 26, 22));
        assert_eq!((ome("CZT").pages(), ome("CZT").spacing), (30, DVec3::new(1.0, 1.0, 2.0)));
        assert!(ome("CZT").with_pages(29).is_err());
        // Times are in seconds by default.
        let every = |attributes: &str| {
            let text = format!("<OME><Image><Pixels ID='a' SizeT='3' PhysicalSizeX='0.5' {attributes}>");
            let layout = Layout::new(&text, 1, None);
            assert!(layout.states_spacing && !ome("CZT").states_spacing);
            layout.frame_spacing
        };
        assert_eq!(every("TimeIncrement='0.5'"), FrameSpacing::new(0.5, Some("s")));
        assert_eq!(every("TimeIncrement='20' TimeIncrementUnit='ms'"), FrameSpacing::new(20.0, Some("ms")));
        assert_eq!((every(""), every("TimeIncrement='x'")), (None, None));
        let imagej = Layout::new("ImageJ=1.5\nimages=6\nslices=3\nframes=2\nfinterval=0.1\n", 1, None);
        assert_eq!(imagej.frame_spacing, FrameSpacing::new(0.1, Some("s")));
        let layout = Layout::new("ImageJ=1.5\nimages=6\nslices=3\nframes=2\nunit=um\nspacing=0.5\n", 1, Some([4.0, 2.0]));
        assert_eq!((layout.page(2, 1, 0), layout.spacing), (5, DVec3::new(0.25, 0.5, 0.5)));
        assert_eq!(layout.with_pages(4).unwrap().slices, 4);
    }
}
