//! The file of a field beside the volume: values, colours or labels.

use super::{FieldSpec, open_options};
use crate::cli::options::Mask;
use crate::cli::shown_steps::{colors_of, vectors_of};
use crate::cli::values::Colors;
use crate::error::Error;
use crate::renderer::ColorOpacity;
use crate::shown::{IndexedLabels, Shown};
use crate::volume::{ChannelDescription, Contents, Labels, OpenOptions, Placement, Sequence, Volume};
use std::path::Path;

/// What a file holds.
pub(super) struct Opened {
    /// Of colours and labels, the volume that stands for them.
    pub volume: Volume<'static>,
    /// Colours or labels instead of values.
    pub shown: Option<Shown>,
}

impl FieldSpec {
    /// Opens its file: values, colours or labels. `unstated`: the placement of files that state none.
    pub fn open_any(&self, unstated: Placement) -> Result<Opened, Error> {
        let options = OpenOptions { unstated, ..open_options(self) };
        let shown = if self.holds_labels(unstated)? {
            Some(Shown::Labels(self.labels(&options)?))
        } else if !self.label_changes.is_empty() {
            let problem =
                "its key label changes labels, and the file does not say that it holds any: add labels= or labels=TABLE";
            return Err(Error::volume(self.path(), problem));
        } else {
            self.colors(&options)?
        };
        let Some(shown) = shown else { return Ok(Opened { volume: self.open_values(unstated)?, shown: None }) };
        if self.at.is_some() && matches!(shown, Shown::Vectors { .. }) {
            let problem = "its directions are along its own axes, and the key at turns these: omit at, or colors=direction";
            return Err(Error::volume(self.path(), problem));
        }
        let transform = self.transform()?;
        let shown = shown.placed(|grid| transform.grid(grid))?;
        Ok(Opened { volume: shown.volume().clone(), shown: Some(shown) })
    }

    fn path(&self) -> &Path {
        self.file.as_deref().expect("a field beside the first one names its file")
    }

    fn holds_labels(&self, unstated: Placement) -> Result<bool, Error> {
        let options = OpenOptions { unstated, ..open_options(self) };
        Ok(self.labels.is_some() || Labels::are_declared(self.path(), &options)?)
    }

    fn labels(&self, options: &OpenOptions) -> Result<IndexedLabels, Error> {
        let mut labels = Labels::open(self.path(), options, self.labels.clone().flatten().as_deref())?;
        self.label_changes.iter().try_for_each(|change| labels.change(change))?;
        if labels.layers().iter().all(|layer| layer.present().all(|label| label.drawn_opacity() == 0.0)) {
            return Err(Error::volume(self.path(), "none of its labels is visible: show some"));
        }
        IndexedLabels::new(labels)
    }

    /// Whether its file says that it holds colours, and none of its channels is chosen.
    fn holds_colors(&self, options: &OpenOptions) -> bool {
        // The reader says what is wrong with a file.
        self.channel.is_none() && Contents::of_file(self.path(), options).is_ok_and(|contents| contents.are_colors)
    }

    /// Its colours, if it has some and values are not asked for.
    fn colors(&self, options: &OpenOptions) -> Result<Option<Shown>, Error> {
        let chosen = self.colors.or_else(|| self.holds_colors(options).then_some(Colors::Direct));
        let component = |number: usize| Volume::open(self.path(), &OpenOptions { channel: Some(number), ..options.clone() });
        let refuse = |problem: &str| Err(Error::volume(self.path(), problem));
        match chosen {
            Some(Colors::Direct | Colors::Direction) if self.channel.is_some() => {
                refuse("its key channel chooses values, and its key colors colours: omit one of both")
            }
            Some(Colors::Direct) => {
                let described = ChannelDescription::of_file(self.path(), options)?;
                colors_of(self.path(), &described, self.color_opacity, component).map(Some)
            }
            _ if self.color_opacity.is_some() => {
                refuse("its key color-opacity is for colours, and values are shown: add colors=direct, or omit it")
            }
            Some(Colors::Direction) => vectors_of(component).map(Some),
            Some(Colors::None) | None => Ok(None),
        }
    }

    /// Refuses keys for values where colours or labels are shown.
    pub fn check_shown(&self, shown: &Shown, file: &Path) -> Result<(), Error> {
        let values = [
            ("color", self.color.is_some()),
            ("range", self.range.is_some()),
            ("iso", self.iso.is_some()),
            ("gradient-opacity", self.gradient_opacity.is_some()),
            ("mask", self.mask.is_some()),
        ];
        let has_opacities = !matches!(shown, Shown::Labels(_) | Shown::Components(_, ColorOpacity::Alpha));
        let opacities = [("transfer", self.transfer.is_some()), ("opacity", self.opacity.is_some())];
        let given = values.into_iter().chain(opacities.into_iter().filter(|_| !has_opacities)).find(|(_, is_given)| *is_given);
        let Some((key, _)) = given else { return Ok(()) };
        let problem = match shown {
            Shown::Labels(_) => {
                format!("its key {key} is for values, and it holds labels: change these, as label=liver:#cc3311:0.4")
            }
            _ if opacities.iter().any(|(name, _)| *name == key) => format!(
                "its key {key} is for values, and its colours have the opacity of their alpha: omit it, or add color-opacity=luminance"
            ),
            _ => format!("its key {key} is for values, and it holds colours: omit it, or choose one component by channel=N"),
        };
        Err(Error::volume(file, problem))
    }

    fn open_values(&self, unstated: Placement) -> Result<Volume<'static>, Error> {
        let options = OpenOptions { unstated, ..open_options(self) };
        let volume = Volume::open(self.path(), &options)?;
        self.transform()?.applied_to(self.masked(&volume, unstated)?.unwrap_or(volume))
    }

    /// The steps of its file in time, or the one that it names. See [`open_any`](Self::open_any).
    pub fn sequence(&self, unstated: Placement) -> Result<Sequence, Error> {
        self.require_values(unstated)?;
        let file = self.path();
        let options = OpenOptions { unstated, frame: None, ..open_options(self) };
        let sequence = Sequence::open(&[file], &options)?;
        let sequence = match self.frame {
            Some(frame) => sequence.only(frame)?,
            None => sequence,
        };
        match self.mask()? {
            Some(mask) => mask.applied_to_steps(sequence, unstated),
            None => Ok(sequence),
        }
    }

    /// Refuses what films do not play beside the first field.
    fn require_values(&self, unstated: Placement) -> Result<(), Error> {
        let refuse = |problem: &str| Err(Error::volume(self.path(), problem));
        if self.holds_labels(unstated)? {
            return refuse(
                "it holds labels, whose ids are no values: in a still picture, --with draws them beside a scan; a film draws a scan in their \
                 colours (--label-colors), or the labels alone",
            );
        }
        let options = OpenOptions { unstated, ..open_options(self) };
        match self.colors {
            Some(Colors::None) => Ok(()),
            None if !self.holds_colors(&options) => Ok(()),
            _ => refuse(
                "it holds colours, which films do not play beside other fields: choose a component by channel=N, or draw a still picture",
            ),
        }
    }

    fn mask(&self) -> Result<Option<Mask>, Error> {
        let mask = self.mask.as_ref().map(|text| Mask::from_text(text)).transpose();
        mask.map_err(|problem| Error::Settings { field: "mask", problem })
    }

    /// What of a volume lies within the labels of the mask, or `None` without one. The mask is in the world of the field's file.
    pub fn masked(&self, volume: &Volume, unstated: Placement) -> Result<Option<Volume<'static>>, Error> {
        self.mask()?.map(|mask| mask.applied_to(volume, unstated)).transpose()
    }
}
