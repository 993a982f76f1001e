//! A list of names with their colours.

use super::canvas::Canvas;
use super::extent::Extent;
use super::legend::{GAP, MARGIN, frame};
use glam::DVec2;
use std::ops::Range;

/// Height of a row, in heights of letters.
const ROW: f64 = 1.7;
/// Side of a swatch, in heights of letters.
const SWATCH: f64 = 1.1;
/// Distance of names from their swatches, in pixels at scale 1.
const NAME_GAP: f64 = 6.0;
/// Largest width of names as a fraction of the picture's width, and of the list as a fraction of its height.
const WIDEST: f64 = 0.35;
const HIGHEST: f64 = 0.8;

/// Names of labels or channels with their colours, drawn in place of the colour bar. Names that are too long end with "…". If there are more
/// entries than rows, the last row tells how many are left out.
///
/// ```
/// use layersplat::annotation::{Annotations, Legend, LegendEntry};
///
/// let entries = vec![LegendEntry::new("liver", [0.8, 0.2, 0.1]), LegendEntry::new("spleen", [0.4, 0.2, 0.6])];
/// let legend = Legend { entries };
/// let annotations = Annotations { legend: true, list: Some(legend), ..Annotations::default() };
/// # assert!(!annotations.is_empty());
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Legend {
    /// Entries from the top.
    pub entries: Vec<LegendEntry>,
}

/// A row of a [`Legend`].
#[derive(Clone, Debug, PartialEq)]
pub struct LegendEntry {
    /// Name.
    pub name: String,
    /// Red, green and blue, 0 to 1. Several are shown side by side.
    pub colors: Vec<[f64; 3]>,
}

impl LegendEntry {
    /// An entry of one colour.
    pub fn new(name: impl Into<String>, color: [f64; 3]) -> Self {
        Self { name: name.into(), colors: vec![color] }
    }
}

/// Rows of a list that fit into a picture: colours and texts. A row without colours tells how many do not.
pub(super) struct Rows(Vec<(Vec<[u8; 3]>, String)>);

/// Shapes of the list, in pixels of a picture.
pub(super) struct Layout {
    /// Upper left and lower right corners of swatches, and their colours.
    pub swatches: Vec<([DVec2; 2], [u8; 3])>,
    /// Borders of the swatches.
    pub lines: Vec<[DVec2; 2]>,
    /// Upper left corners and texts.
    pub labels: Vec<(DVec2, String)>,
}

impl Rows {
    /// Rows for a picture of this extent.
    pub fn new(legend: &Legend, extent: Extent) -> Self {
        let height = f64::from(extent.viewport.height) * HIGHEST;
        let most = ((height / row(extent)) as usize).max(1);
        let count = legend.entries.len();
        let shown = if count > most { most - 1 } else { count };
        let of = |entry: &LegendEntry| {
            let colors = entry.colors.iter().map(|color| color.map(|c| (c * 255.0 + 0.5) as u8)).collect();
            (colors, shortened(&entry.name, extent))
        };
        let rest = (count > shown).then(|| (Vec::new(), format!("and {} more", count - shown)));
        Self(legend.entries[..shown].iter().map(of).chain(rest).collect())
    }

    /// Width of the column at the right edge that the list takes.
    pub fn room(&self, extent: Extent) -> f64 {
        let widest = self.0.iter().map(|(_, name)| extent.measured(name).x).fold(0.0, f64::max);
        (MARGIN + NAME_GAP + GAP) * extent.scale + swatch(extent) + widest
    }

    /// Rows of a picture that the list takes, with a margin.
    pub fn rows(&self, extent: Extent) -> Range<u32> {
        let (height, margin) = (f64::from(extent.viewport.height), MARGIN * extent.scale);
        let top = self.top(extent);
        let end = top + self.0.len() as f64 * row(extent);
        ((top - margin).floor().max(0.0) as u32)..((end + margin).ceil().min(height) as u32)
    }

    fn top(&self, extent: Extent) -> f64 {
        ((f64::from(extent.viewport.height) - self.0.len() as f64 * row(extent)) / 2.0).round()
    }

    /// Places the list at the right edge of a picture.
    pub fn layout(&self, extent: Extent) -> Layout {
        let (scale, swatch, letters) = (extent.scale, swatch(extent), extent.measured("0").y);
        let left = (f64::from(extent.viewport.width) - self.room(extent) + GAP * scale).round();
        let mut layout = Layout { swatches: Vec::new(), lines: Vec::new(), labels: Vec::new() };
        for (n, (colors, name)) in self.0.iter().enumerate() {
            let middle = self.top(extent) + (n as f64 + 0.5) * row(extent);
            if !colors.is_empty() {
                let corner = DVec2::new(left, (middle - swatch / 2.0).round());
                let edge = |i: usize| (swatch * i as f64 / colors.len() as f64).round();
                let part = |i: usize| [corner + DVec2::new(edge(i), 0.0), corner + DVec2::new(edge(i + 1), swatch)];
                layout.swatches.extend(colors.iter().enumerate().map(|(i, color)| (part(i), *color)));
                layout.lines.extend(frame([corner, corner + DVec2::splat(swatch)], scale));
            }
            layout.labels.push((DVec2::new(left + swatch + NAME_GAP * scale, middle - letters / 2.0), name.clone()));
        }
        layout
    }

    /// Draws the list at the right edge.
    pub fn draw(&self, canvas: &mut Canvas) {
        let Layout { swatches, lines, labels } = self.layout(canvas.extent());
        for ([from, to], color) in swatches {
            canvas.area(from, to, color, 1.0);
        }
        let ink = canvas.ink();
        for [from, to] in lines {
            canvas.area(from, to, ink, 1.0);
        }
        for (at, label) in labels {
            canvas.text(at.to_array(), &label);
        }
    }
}

/// Height of a row.
fn row(extent: Extent) -> f64 {
    ROW * extent.measured("0").y
}

fn swatch(extent: Extent) -> f64 {
    (extent.measured("0").y * SWATCH).round()
}

/// A name, or as many of its letters as fit.
fn shortened(name: &str, extent: Extent) -> String {
    let widest = f64::from(extent.viewport.width) * WIDEST;
    if extent.measured(name).x <= widest {
        return name.to_owned();
    }
    let ends: Vec<usize> = name.char_indices().map(|(at, _)| at).collect();
    // Widths grow with the number of letters.
    let fitting = ends.partition_point(|&end| extent.measured(&format!("{}…", &name[..end])).x <= widest);
    format!("{}…", &name[..ends[fitting.saturating_sub(1)]])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::viewport::Viewport;

    fn legend(count: usize, name: &str) -> Legend {
        let entry = |n: usize| LegendEntry::new(format!("{name} {n}"), [1.0, n as f64 / count as f64, 0.0]);
        Legend { entries: (0..count).map(entry).collect() }
    }

    fn extent(width: u32, height: u32) -> Extent {
        Extent::new(Viewport { width, height }, None)
    }

    #[test]
    fn rows_lie_inside_the_picture() {
        for (count, size) in [(1, [200, 100]), (5, [400, 300]), (300, [640, 480]), (2, [20, 10])] {
            let extent = extent(size[0], size[1]);
            let list = Rows::new(&legend(count, "a name"), extent);
            let layout = list.layout(extent);
            let height = f64::from(size[1]);
            for ([from, to], _) in layout.swatches {
                assert!(from.y >= 0.0 && to.y <= height && from.x < to.x, "{count}: {from}, {to}");
            }
            let rows = list.rows(extent);
            assert!(rows.start < rows.end && rows.end <= size[1], "{rows:?}");
        }
    }

    #[test]
    fn entries_without_a_row_are_counted() {
        let Rows(all) = Rows::new(&legend(300, "label"), extent(640, 480));
        let (colors, text) = all.last().unwrap();
        assert_eq!((colors.len(), text.clone()), (0, format!("and {} more", 300 - (all.len() - 1))));
        assert_eq!(Rows::new(&legend(5, "label"), extent(640, 480)).0.len(), 5);
        assert!(Rows::new(&Legend::default(), extent(640, 480)).0.is_empty());
    }

    #[test]
    fn long_names_are_cut() {
        let extent = extent(320, 240);
        let name = "Left-Cerebral-White-Matter-über-alle-Maßen-lang-und-noch-viel-länger";
        let cut = shortened(name, extent);
        assert!(cut.ends_with('…') && name.starts_with(cut.trim_end_matches('…')) && cut.chars().count() > 5, "{cut}");
        assert!(extent.measured(&cut).x <= 320.0 * WIDEST);
        assert_eq!(shortened("short", extent), "short");
    }
}
