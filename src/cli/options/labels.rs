//! Options for volumes of labels.

use super::mask::Mask;
use crate::Error;
use crate::cli::{names, parse};
use crate::volume::{LabelChange, LabelSurfaces, LabelTable, Labels, OpenOptions, Placement, Sequence, Volume};
use clap::Args;
use std::path::{Path, PathBuf};

/// Labels of the voxels, and changes of how they look.
#[derive(Args)]
#[command(next_help_heading = "Labels")]
pub(in crate::cli) struct LabelOptions {
    /// Voxels are ids of labels, with the names and colours of TABLE: a text file of FreeSurfer, ITK-SNAP or 3D Slicer, or JSON [default: if
    /// the file says so, with its own table]
    #[arg(long, value_name = "TABLE", num_args = 0..=1, require_equals = true)]
    labels: Option<Option<PathBuf>>,
    /// Change labels: IDS are ids, ranges and names, as 3,7-9,liver; then #rrggbb, an opacity, and show, hide, only or highlight. Repeatable
    #[arg(long, value_name = "IDS:CHANGES", value_parser = parse::label)]
    label: Vec<LabelChange>,
    /// Draw the volume in the colours of the labels of FILE, with its own opacities; --labels and --label then mean FILE
    #[arg(long, value_name = "FILE")]
    label_colors: Option<PathBuf>,
    /// Surfaces of labels that are drawn by themselves: smooth ones, or those of the voxels [default: smooth]
    #[arg(long, value_name = "NAME", value_parser = names::of::<LabelSurfaces>(), conflicts_with = "label_colors")]
    label_surfaces: Option<LabelSurfaces>,
    /// Show only what lies within labels of FILE: all of them, or IDS as for --label
    #[arg(long, value_name = "FILE[:IDS]", value_parser = Mask::from_text)]
    mask: Option<Mask>,
}

impl LabelOptions {
    /// Whether `--label-surfaces` is given.
    pub fn has_surfaces(&self) -> bool {
        self.label_surfaces.is_some()
    }

    /// Whether `--mask` is given.
    pub fn has_mask(&self) -> bool {
        self.mask.is_some()
    }

    /// Applies `--mask`. `unstated`: the placement of files that state none.
    pub fn masked(&self, volume: Volume<'static>, unstated: Placement) -> Result<Volume<'static>, Error> {
        let Some(mask) = &self.mask else { return Ok(volume) };
        mask.applied_to(&volume, unstated)
    }

    /// Applies `--mask` to all steps.
    pub fn masked_steps(&self, sequence: Sequence, unstated: Placement) -> Result<Sequence, Error> {
        match &self.mask {
            Some(mask) => mask.applied_to_steps(sequence, unstated),
            None => Ok(sequence),
        }
    }

    /// Whether the options say that the voxels of the volume are labels.
    pub fn is_given(&self) -> bool {
        self.label_colors.is_none() && (self.labels.is_some() || !self.label.is_empty() || self.label_surfaces.is_some())
    }

    /// Whether labels are drawn, colour the volume or mask it.
    pub fn are_given(&self) -> bool {
        self.is_given() || self.label_colors.is_some() || self.mask.is_some()
    }

    /// The labels that colour the volume, with all changes.
    pub fn label_colors(&self, unstated: Placement) -> Result<Option<Labels>, Error> {
        let Some(file) = &self.label_colors else { return Ok(None) };
        self.changed(Labels::open(file, &OpenOptions { unstated, ..OpenOptions::default() }, self.table())?).map(Some)
    }

    /// The table of names and colours.
    fn table(&self) -> Option<&Path> {
        self.labels.as_ref().and_then(|table| table.as_deref())
    }

    /// Labels with the changes that the options ask for.
    fn changed(&self, mut labels: Labels) -> Result<Labels, Error> {
        self.label.iter().try_for_each(|change| labels.change(change))?;
        Ok(labels.with_surfaces(self.label_surfaces.unwrap_or_default()))
    }

    /// Opens labels of a step in time and applies all changes. `all`: the names and looks of the labels of all steps.
    pub fn open_step(&self, path: &Path, options: &OpenOptions, all: Option<&LabelTable>) -> Result<Labels, Error> {
        self.changed_step(self.open_unchanged(path, options)?, all)
    }

    /// Labels of a step in time with all changes.
    pub fn changed_step(&self, labels: Labels, all: Option<&LabelTable>) -> Result<Labels, Error> {
        self.changed(match all {
            Some(table) => labels.with_table(table),
            None => labels,
        })
    }

    /// Opens the labels of a file, with the names and looks of their table.
    pub fn open_unchanged(&self, path: &Path, options: &OpenOptions) -> Result<Labels, Error> {
        Labels::open(path, options, self.table())
    }

    /// Opens the labels of a file and applies all changes; `None` if neither the options nor the file say that its voxels are labels.
    pub fn open(&self, path: &Path, options: &OpenOptions) -> Result<Option<Labels>, Error> {
        let is_asked = self.is_given();
        if self.label_colors.is_some() && Labels::are_declared(path, options).unwrap_or(false) {
            let problem = "colour values, and the volume holds labels itself: omit it, or name the scan as the volume".into();
            return Err(Error::Settings { field: "label_colors", problem });
        }
        if self.label_colors.is_some() || (!is_asked && !Labels::are_declared(path, options).unwrap_or(true)) {
            return Ok(None);
        }
        match self.open_unchanged(path, options) {
            // A file that is refused as labels is still a volume of values.
            Err(e) if !is_asked => {
                tracing::warn!("its labels cannot be listed: {e}");
                Ok(None)
            }
            opened => self.changed(opened?).map(Some),
        }
    }
}
