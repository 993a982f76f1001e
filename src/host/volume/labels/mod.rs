//! Labels: volumes whose voxels are ids of named things, such as organs or cells, and the tables of these.

mod change;
mod ids;
mod mask;
mod open;
mod place;
mod table;

pub use change::{LabelChange, LabelVisibility};
pub(in crate::volume) use mask::Mask;
pub use open::{LabelLayer, Labels};
#[doc(hidden)]
pub use place::grid_over;
pub(in crate::volume) use table::Declared;
#[cfg(feature = "zarr")]
pub(in crate::volume) use table::image_label;

use super::colors;
use crate::choice::choices;
use crate::error::Error;
use std::path::Path;

/// Limit of labels in a table.
const MOST: usize = 1 << 20;

/// A label: an id that voxels have, and how it looks.
#[derive(Clone, Debug, PartialEq)]
pub struct Label {
    /// Number of its voxels, at least 1: 0 is the background.
    pub id: u32,
    /// Name, if one is known.
    pub name: Option<String>,
    /// Red, green and blue, 0 to 1, as transfer functions hold colours.
    pub color: [f64; 3],
    /// Opacity, 0 to 1.
    pub opacity: f64,
    /// Whether it is drawn.
    pub visible: bool,
}

impl Label {
    /// An opaque, visible label without a name, in the [default colour](LabelTable::default_color) of its id.
    pub fn new(id: u32) -> Self {
        Self { id, name: None, color: LabelTable::default_color(id), opacity: 1.0, visible: true }
    }

    /// The opacity, or 0 if the label is hidden.
    pub fn drawn_opacity(&self) -> f64 {
        if self.visible { self.opacity } else { 0.0 }
    }
}

/// Surfaces of labels that are drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LabelSurfaces {
    /// Surfaces lie where the interpolated share of a label is one half, whatever its opacity. Shares of voxels are those among the 27 voxels
    /// around them, or those of distances within thick slices. Labels that are one voxel thin stay. Gradients are smoothed unless the settings
    /// state them.
    #[default]
    Smooth,
    /// Each voxel has the extinction and colour of its label.
    Voxels,
}

choices! { LabelSurfaces, "label_surfaces"; Smooth = "smooth", Voxels = "voxels" }

/// Labels by ascending id. Ids may be sparse. Id 0 is the background, which no table holds: it is never drawn.
///
/// ```
/// use layersplat::volume::{Label, LabelTable};
///
/// let liver = Label { name: Some("liver".into()), color: [0.8, 0.2, 0.1], ..Label::new(1200) };
/// let mut table = LabelTable::new([Label::new(7), liver])?;
/// table.change(&"liver:0.5".parse()?)?;
/// assert_eq!(table.get(1200).map(|label| label.opacity), Some(0.5));
/// # Ok::<(), layersplat::Error>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LabelTable {
    labels: Vec<Label>,
}

impl LabelTable {
    /// Creates a table from labels in any order.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for id 0, and colours and opacities outside 0 to 1; [`Error::Settings`] if two labels have one id, or there
    /// are more than 1048576.
    pub fn new(labels: impl IntoIterator<Item = Label>) -> Result<Self, Error> {
        let mut sorted: Vec<Label> = labels.into_iter().take(MOST + 1).collect();
        let wrong = |problem: String| Error::Settings { field: "labels", problem };
        if sorted.len() > MOST {
            return Err(wrong(format!("more than {MOST} labels: leave out those that no voxel has")));
        }
        sorted.sort_by_key(|label| label.id);
        for label in &sorted {
            let numbers = label.color.iter().chain([&label.opacity]);
            if let Some(bad) = numbers.into_iter().find(|n| !(0.0..=1.0).contains(*n)) {
                return Err(wrong(format!("label {} has a colour or an opacity of {bad}: expected 0 to 1", label.id)));
            }
        }
        if sorted.first().is_some_and(|label| label.id == 0) {
            return Err(Error::OutOfRange {
                name: "label id",
                value: "0".into(),
                expected: "1 to 4294967295; 0 is the background",
            });
        }
        if let Some(pair) = sorted.windows(2).find(|pair| pair[0].id == pair[1].id) {
            return Err(wrong(format!("two labels have the id {}: give each a separate one", pair[0].id)));
        }
        Ok(Self { labels: sorted })
    }

    /// Reads a table of names and colours. Formats recognised by content: colour look-up tables of FreeSurfer, label descriptions of
    /// ITK-SNAP, colour tables of 3D Slicer, OME-Zarr's `image-label` in JSON, and a list in JSON:
    ///
    /// ```json
    /// {"labels": [{"id": 3, "name": "liver", "color": "#cc3311", "opacity": 0.4, "visible": true}]}
    /// ```
    ///
    /// All keys but `id` are optional. Entries for the background, id 0, are left out.
    ///
    /// # Errors
    /// [`Error::Read`]; [`Error::Labels`] with the line if the table is malformed, or an id occurs twice.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, Error> {
        table::read(path.as_ref())
    }

    /// All labels, by ascending id.
    pub fn labels(&self) -> &[Label] {
        &self.labels
    }

    /// The label of an id.
    pub fn get(&self, id: u32) -> Option<&Label> {
        self.position(id).map(|at| &self.labels[at])
    }

    fn position(&self, id: u32) -> Option<usize> {
        self.labels.binary_search_by_key(&id, |label| label.id).ok()
    }

    /// Adds labels for those of these ids that have none, in the colours of a palette of the first ids, else in default ones. Returns the added
    /// ids.
    pub(super) fn complete(&mut self, ids: impl IntoIterator<Item = u32>, palette: &[[f64; 3]]) -> Vec<u32> {
        let missing: Vec<u32> = ids.into_iter().filter(|&id| id > 0 && self.get(id).is_none()).collect();
        let label = |&id: &u32| {
            let label = Label::new(id);
            Label { color: palette.get(id as usize).copied().unwrap_or(label.color), ..label }
        };
        self.labels.extend(missing.iter().map(label));
        self.labels.sort_by_key(|label| label.id);
        missing
    }

    /// The colour of an id without a declared one. It depends on the id only. Ids 1 to 7 differ for all kinds of colour vision (B. Wong,
    /// Color blindness, Nature Methods 8, 2011); others differ in lightness as well as in hue.
    pub fn default_color(id: u32) -> [f64; 3] {
        colors::of_label(id)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_are_sorted_and_checked() {
        let table = LabelTable::new([Label::new(9), Label::new(2), Label::new(u32::MAX)]).unwrap();
        assert_eq!(table.labels().iter().map(|label| label.id).collect::<Vec<_>>(), [2, 9, u32::MAX]);
        assert!(table.get(9).is_some() && table.get(3).is_none() && table.get(0).is_none());
        for (bad, expected) in [
            (vec![Label::new(0)], "label id is 0: expected 1"),
            (vec![Label::new(3), Label::new(4), Label::new(3)], "two labels have the id 3"),
            (vec![Label { opacity: 1.5, ..Label::new(3) }], "label 3 has a colour or an opacity of 1.5"),
            (vec![Label { color: [0.0, f64::NAN, 0.0], ..Label::new(3) }], "of NaN"),
        ] {
            let message = LabelTable::new(bad).unwrap_err().to_string();
            assert!(message.contains(expected), "{message}");
        }
    }

    #[test]
    fn missing_labels_are_added_with_their_colours() {
        let mut table = LabelTable::new([Label { color: [1.0; 3], ..Label::new(5) }]).unwrap();
        assert_eq!(table.complete([0, 3, 5, 70_000], &[]), [3, 70_000]);
        assert_eq!(table.get(5).unwrap().color, [1.0; 3]);
        assert_eq!(table.get(70_000), Some(&Label::new(70_000)));
        assert_eq!(table.labels().len(), 3);
        table.complete([1, 2], &[[0.0; 3], [0.0, 0.5, 1.0]]);
        assert_eq!((table.get(1).unwrap().color, table.get(2)), ([0.0, 0.5, 1.0], Some(&Label::new(2))));
    }
}
