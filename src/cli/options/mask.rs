//! Labels within which a volume shows, as text: `FILE` or `FILE:IDS`.

use crate::Error;
use crate::cli::parse;
use crate::url;
use crate::volume::{LabelChange, Labels, OpenOptions, Placement, Sequence, Volume};
use std::path::{Path, PathBuf};

/// Whether what stands before a colon is the name of a file. That of an address stands after its last slash.
fn is_name(file: &str, ids: &str) -> bool {
    Path::new(file).exists() || url::is_url(Path::new(file)) && !ids.contains('/')
}

/// Labels within which a volume shows.
#[derive(Clone)]
pub(in crate::cli) struct Mask {
    file: PathBuf,
    /// Chosen labels; all if none.
    only: Option<LabelChange>,
}

impl Mask {
    /// Parses `FILE` or `FILE:IDS`. Names of files may have colons.
    pub fn from_text(text: &str) -> Result<Self, String> {
        let whole = || Ok(Self { file: text.into(), only: None });
        match text.rsplit_once(':').filter(|(file, ids)| is_name(file, ids) && !Path::new(text).exists()) {
            Some((file, ids)) => Ok(Self { file: file.into(), only: Some(parse::label(&format!("{ids}:only"))?) }),
            None => whole(),
        }
    }

    /// The labels, of which the chosen ones are visible. `unstated`: the placement of files that state none.
    ///
    /// # Errors
    /// As [`Labels::open`] and [`Labels::change`].
    fn labels(&self, unstated: Placement) -> Result<Labels, Error> {
        let mut labels = Labels::open(&self.file, &OpenOptions { unstated, ..OpenOptions::default() }, None)?;
        self.only.iter().try_for_each(|change| labels.change(change))?;
        Ok(labels)
    }

    /// A sequence whose steps show only what lies within the labels.
    ///
    /// # Errors
    /// As [`Labels::open`], [`Labels::change`] and [`Sequence::with_mask`].
    pub fn applied_to_steps(&self, sequence: Sequence, unstated: Placement) -> Result<Sequence, Error> {
        sequence.with_mask(&self.labels(unstated)?)
    }

    /// A copy of a volume that shows only what lies within the labels.
    ///
    /// # Errors
    /// As [`Labels::open`], [`Labels::change`] and [`Volume::masked`].
    pub fn applied_to(&self, volume: &Volume, unstated: Placement) -> Result<Volume<'static>, Error> {
        volume.masked(&self.labels(unstated)?)
    }
}
