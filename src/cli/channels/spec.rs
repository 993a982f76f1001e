//! A field beside the volume, as text: `FILE,KEY=VALUE,…`.

use super::{FieldLook, open_options};
use crate::annotation::LegendEntry;
use crate::cli::options::Mask;
use crate::cli::parse;
use crate::cli::values::{Component, Opacities};
use crate::error::Error;
use crate::files;
use crate::settings::{Blend, GradientOpacity};
use crate::transfer::{TransferFunction, Value};
use crate::volume::{ChannelDescription, Grid, LabelChange, LabelField, Labels, OpenOptions, Placement, Sequence, Volume};
use glam::{DAffine3, DMat3, DVec3};
use std::path::{Path, PathBuf};

/// A field and how it is shown.
#[derive(Clone, Default)]
pub(super) struct FieldSpec {
    /// `None`: the volume of the command.
    pub file: Option<PathBuf>,
    pub channel: Option<Component>,
    pub frame: Option<usize>,
    pub array: Option<String>,
    pub spacing: Option<DVec3>,
    pub origin: Option<DVec3>,
    transfer: Option<PathBuf>,
    range: Option<(Value, Value)>,
    opacity: Option<Opacities>,
    color: Option<[f64; 3]>,
    factor: Option<f64>,
    iso: Option<Value>,
    gradient_opacity: Option<GradientOpacity>,
    /// File of the transform from its world to that of the scene.
    at: Option<PathBuf>,
    /// Labels within which it shows: `FILE` or `FILE:IDS`. Which of the two is known only once the file's folder is.
    mask: Option<String>,
    /// Voxels are ids of labels, with the names and colours of a table, or of their own.
    labels: Option<Option<PathBuf>>,
    label_changes: Vec<LabelChange>,
    /// Whether the field is one of labels: its values are their shares.
    is_label: bool,
    hidden: bool,
    name: Option<String>,
    /// Colour beside those of the other fields, unless `color` is given.
    pub channel_color: [f64; 3],
}

/// Keys, for messages.
const KEYS: &str = "transfer, range, opacity, color, factor, iso, gradient-opacity, channel, frame, array, spacing, origin, at, mask, labels, label, \
                    visible and name";

impl FieldSpec {
    /// Parses `FILE,KEY=VALUE,…`.
    pub fn from_text(text: &str) -> Result<Self, String> {
        let (file, pairs) = split(text)?;
        let file = Some(file).filter(|file| !file.is_empty()).ok_or("it names no file; use FILE,KEY=VALUE")?;
        let mut spec = Self { file: Some(file.into()), ..Self::default() };
        pairs.iter().try_for_each(|(key, value)| spec.set(key, value).map_err(|problem| format!("{key}: {problem}")))?;
        Ok(spec)
    }

    /// A component of the volume's file, as the file describes it.
    pub fn from_description(number: usize, described: ChannelDescription) -> Self {
        let ChannelDescription { name, color, window, active } = described;
        let range = window.map(|(lo, hi)| (Value::Number(lo), Value::Number(hi)));
        let name = name.or_else(|| Some(format!("channel {number}")));
        Self { name, color, range, hidden: !active, ..Self::default() }
    }

    /// Name and colour.
    pub fn description(&self) -> ChannelDescription {
        ChannelDescription { name: self.name.clone(), color: self.color, ..ChannelDescription::default() }
    }

    /// Whether it is drawn.
    pub fn is_visible(&self) -> bool {
        !self.hidden
    }

    /// Its line in a legend. `drawn`: its transfer function, unless that has the colour of the channel.
    pub fn legend_entry(&self, volume: &Volume, drawn: Option<&TransferFunction>) -> LegendEntry {
        let name = self.name.clone().unwrap_or_else(|| {
            let name = volume.name();
            name.strip_prefix("builtin:").unwrap_or(name).to_owned()
        });
        LegendEntry {
            name,
            color: self.color.or_else(|| drawn.map(TransferFunction::most_opaque_color)).unwrap_or(self.channel_color),
        }
    }

    /// The transfer function that it names.
    pub fn named_transfer(&self, volume: &Volume) -> Result<Option<TransferFunction>, Error> {
        self.transfer.as_deref().map(|source| TransferFunction::open(source, volume)).transpose()
    }

    /// Sets a key to a value as text.
    pub fn set(&mut self, key: &str, value: &str) -> Result<(), String> {
        let number = || value.trim().parse().map_err(|_| format!("invalid number '{value}'; use one from 0"));
        match key {
            "file" => self.file = Some(value.into()),
            "channel" => self.channel = Some(parse::component(value)?),
            "frame" => self.frame = Some(number()?),
            "array" => self.array = Some(value.into()),
            "spacing" => self.spacing = Some(parse::spacing(value)?),
            "origin" => self.origin = Some(parse::vector(value)?),
            "transfer" => self.transfer = Some(value.into()),
            "range" => self.range = Some(parse::range(value)?),
            "opacity" => self.opacity = Some(parse::opacities(value)?),
            "color" => self.color = Some(parse::color(value)?),
            "factor" => {
                let expected = || format!("invalid factor '{value}'; use a number from 0");
                self.factor = Some(parse::finite(value).ok().filter(|factor| *factor >= 0.0).ok_or_else(expected)?);
            }
            "iso" => self.iso = Some(parse::value(value)?),
            "gradient-opacity" => self.gradient_opacity = Some(parse::gradient_opacity(value)?),
            "at" => self.at = Some(value.into()),
            "mask" => self.mask = Some(value.into()),
            "labels" => self.labels = Some(Some(value).filter(|value| !value.is_empty()).map(Into::into)),
            "label" => self.label_changes.push(parse::label(value)?),
            "name" => self.name = Some(value.into()),
            "visible" => self.hidden = !parse::switch(value)?,
            _ => return Err(format!("unknown key; keys are {KEYS}")),
        }
        Ok(())
    }

    /// Names of files relative to a folder.
    pub fn relative_to(mut self, folder: &Path) -> Self {
        let table = self.labels.as_mut().and_then(Option::as_mut);
        for file in [self.file.as_mut(), self.at.as_mut(), table]
            .into_iter()
            .flatten()
            .filter(|file| !file.to_string_lossy().contains(':'))
        {
            *file = folder.join(&*file);
        }
        if let Some(transfer) = self.transfer.as_mut().filter(|transfer| folder.join(transfer).exists()) {
            *transfer = folder.join(&*transfer);
        }
        self.mask = self.mask.map(|mask| folder.join(mask).to_string_lossy().into_owned());
        self
    }

    /// Opens the fields of its file: one, or of labels one for each look, `most` at most. `unstated`: the placement of files that state none.
    pub fn open_all(self, unstated: Placement, most: usize) -> Result<Vec<(Self, Volume<'static>)>, Error> {
        if self.holds_labels(unstated)? {
            return self.open_labels(unstated, most);
        }
        if !self.label_changes.is_empty() {
            let problem =
                "its key label changes labels, and the file does not say that it holds any: add labels= or labels=TABLE";
            return Err(Error::volume(self.path(), problem));
        }
        let volume = self.open_values(unstated)?;
        Ok(vec![(self, volume)])
    }

    fn path(&self) -> &Path {
        self.file.as_deref().expect("a field beside the first one names its file")
    }

    fn holds_labels(&self, unstated: Placement) -> Result<bool, Error> {
        let options = OpenOptions { unstated, ..open_options(self) };
        Ok(self.labels.is_some() || Labels::are_declared(self.path(), &options)?)
    }

    fn open_labels(self, unstated: Placement, most: usize) -> Result<Vec<(Self, Volume<'static>)>, Error> {
        let file = self.path();
        let is_changed = self.chooses_transfer() || self.iso.is_some() || self.gradient_opacity.is_some() || self.mask.is_some();
        if is_changed || self.channel.is_some() {
            let problem = "it holds labels, which have looks of their own: of the keys, label, labels, factor, at, frame, array, spacing, \
                           origin, visible and name go with them, as label=liver:#cc3311:0.4";
            return Err(Error::volume(file, problem));
        }
        let options = OpenOptions { unstated, ..open_options(&self) };
        let mut labels = Labels::open(file, &options, self.labels.clone().flatten().as_deref())?;
        self.label_changes.iter().try_for_each(|change| labels.change(change))?;
        let placement = self.placement()?;
        let spec = |field: LabelField| {
            let opacities = field.opacities().into_iter().map(|(share, opacity)| (Value::Number(share), opacity)).collect();
            let spec = Self {
                color: Some(field.color),
                opacity: Some(Opacities(opacities)),
                iso: Some(Value::Number(LabelField::SURFACE)),
                name: Some(self.name.as_ref().map_or(field.name.clone(), |name| format!("{name}: {}", field.name))),
                is_label: true,
                ..self.clone()
            };
            Ok((spec, placement.applied_to(field.volume)?))
        };
        labels.fields(most)?.into_iter().map(spec).collect()
    }

    /// Opens its file, which has values. `unstated`: the placement of files that state none.
    pub fn open(&self, unstated: Placement) -> Result<Volume<'static>, Error> {
        self.reject_labels(unstated)?;
        self.open_values(unstated)
    }

    fn open_values(&self, unstated: Placement) -> Result<Volume<'static>, Error> {
        let options = OpenOptions { unstated, ..open_options(self) };
        let volume = Volume::open(self.path(), &options)?;
        self.placement()?.applied_to(self.masked(&volume, unstated)?.unwrap_or(volume))
    }

    /// The steps of its file in time, or the one that it names. See [`open`](Self::open).
    pub fn sequence(&self, unstated: Placement) -> Result<Sequence, Error> {
        self.reject_labels(unstated)?;
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

    fn reject_labels(&self, unstated: Placement) -> Result<(), Error> {
        if !self.holds_labels(unstated)? {
            return Ok(());
        }
        let problem = "it holds labels, whose ids are no values: in a still picture, name a scan first and the labels by --with; a film draws a \
                       scan in their colours (--label-colors), or the labels alone";
        Err(Error::volume(self.path(), problem))
    }

    fn mask(&self) -> Result<Option<Mask>, Error> {
        let mask = self.mask.as_ref().map(|text| Mask::from_text(text)).transpose();
        mask.map_err(|problem| Error::Settings { field: "mask", problem })
    }

    /// What of a volume lies within the labels of the mask, or `None` without one. The mask is in the world of the field's file.
    pub fn masked(&self, volume: &Volume, unstated: Placement) -> Result<Option<Volume<'static>>, Error> {
        self.mask()?.map(|mask| mask.applied_to(volume, unstated)).transpose()
    }

    /// Where `at` places volumes.
    pub fn placement(&self) -> Result<FieldPlacement, Error> {
        let transform = self.at.as_deref().map(|path| Ok::<_, Error>((path.to_owned(), read_transform(path)?))).transpose()?;
        Ok(FieldPlacement(transform))
    }

    /// Whether the spec chooses colours or opacities.
    pub fn chooses_transfer(&self) -> bool {
        self.transfer.is_some() || self.color.is_some() || self.range.is_some() || self.opacity.is_some()
    }

    /// The transfer function.
    pub fn transfer(&self, volume: &Volume, blend: Blend) -> Result<TransferFunction, Error> {
        let color = self.color.unwrap_or(self.channel_color);
        if self.is_label && blend.gathers_values() {
            let problem = "takes values, and labels have none: hide them, or draw surfaces or the composited picture";
            return Err(Error::Settings { field: "blend", problem: problem.into() });
        }
        let mut transfer = match self.named_transfer(volume)? {
            Some(named) => named,
            None if blend.gathers_values() => TransferFunction::channel_ramp(volume, color),
            None => TransferFunction::channel(volume, color),
        };
        // One pass over the voxels finds all percentiles.
        let find = Value::finder(volume);
        if let Some((lo, hi)) = self.range {
            transfer = transfer.stretched(find(lo), find(hi))?;
        }
        if let Some(Opacities(points)) = &self.opacity {
            transfer = transfer.with_opacities(points.iter().map(|&(value, opacity)| (find(value), opacity)).collect())?;
        }
        Ok(transfer)
    }

    /// How the field is shown.
    pub fn look(&self, volume: &Volume) -> FieldLook {
        FieldLook {
            factor: self.factor.unwrap_or(1.0),
            visible: !self.hidden,
            iso: self.iso.map(Value::finder(volume)),
            gradient_opacity: self.gradient_opacity,
        }
    }
}

/// Keys and values.
type Pairs = Vec<(String, String)>;

/// Splits `FIRST,KEY=VALUE,…`. A value may have commas: what lacks a key continues it.
fn split(text: &str) -> Result<(&str, Pairs), String> {
    let mut parts = text.split(',');
    let first = parts.next().unwrap_or_default();
    let mut pairs = Pairs::new();
    for part in parts {
        match (part.split_once('='), pairs.last_mut()) {
            (Some((key, value)), _) => pairs.push((key.trim().to_lowercase().replace('_', "-"), value.into())),
            (None, Some((_, value))) => value.extend([",", part]),
            (None, None) => return Err(format!("'{part}' is no KEY=VALUE; keys are {KEYS}")),
        }
    }
    Ok((first, pairs))
}

/// A change of how one of the fields is shown: `N,KEY=VALUE,…` or `NAME,KEY=VALUE,…`.
#[derive(Clone)]
pub(super) struct FieldChange {
    /// Number of the field, of which 0 is the first, or its name.
    pub field: Component,
    pairs: Pairs,
}

impl FieldChange {
    /// Keys that say how a field is shown.
    const KEYS: [&str; 9] = ["transfer", "range", "opacity", "color", "factor", "iso", "gradient-opacity", "visible", "name"];

    /// Parses `N,KEY=VALUE,…` or `NAME,KEY=VALUE,…`.
    pub fn from_text(text: &str) -> Result<Self, String> {
        let (field, pairs) = split(text)?;
        let field =
            parse::component(field).map_err(|_| format!("invalid field '{field}'; use N,KEY=VALUE; 0 is the first field"))?;
        if pairs.is_empty() {
            return Err("it changes nothing; use N,KEY=VALUE".into());
        }
        if let Some((key, _)) = pairs.iter().find(|(key, _)| !Self::KEYS.contains(&key.as_str())) {
            return Err(format!("{key}: unknown key; keys are {}", Self::KEYS.join(", ")));
        }
        let change = Self { field, pairs };
        change.apply(&mut FieldSpec::default())?;
        Ok(change)
    }

    /// Changes a field. A transfer function replaces range and opacities, unless these follow it.
    pub fn apply(&self, spec: &mut FieldSpec) -> Result<(), String> {
        for (key, value) in &self.pairs {
            if key == "transfer" {
                (spec.range, spec.opacity) = (None, None);
            }
            spec.set(key, value).map_err(|problem| format!("{key}: {problem}"))?;
        }
        Ok(())
    }
}

/// A transform from the world of a field's file to that of the scene, and its file.
pub(super) struct FieldPlacement(Option<(PathBuf, DAffine3)>);

impl FieldPlacement {
    /// The volume where the transform places it.
    pub fn applied_to(&self, volume: Volume<'static>) -> Result<Volume<'static>, Error> {
        let Some((path, transform)) = &self.0 else { return Ok(volume) };
        let index_to_world = *transform * volume.grid().index_to_world();
        match Grid::from_affine(volume.grid().dims(), index_to_world) {
            Ok(grid) => volume.with_grid(grid),
            // Axes that are not at right angles.
            Err(_) => volume.covering(index_to_world, false).map_err(|error| Error::volume(path, error.to_string())),
        }
    }
}

/// Largest file of a transform in bytes.
const MAX_BYTES: u64 = 1 << 16;

/// Reads a 4 x 4 or 3 x 4 matrix, row by row, whose numbers are separated by spaces, commas or line ends.
fn read_transform(path: &Path) -> Result<DAffine3, Error> {
    let text = files::read_text(path, MAX_BYTES)?;
    let wrong =
        |problem: String| Error::volume(path, format!("{problem}; a transform has 4 rows of 4 numbers, the last 0 0 0 1"));
    let words = text.split(|c: char| c.is_whitespace() || c == ',').filter(|word| !word.is_empty());
    let number =
        |word: &str| word.parse::<f64>().ok().filter(|n| n.is_finite()).ok_or_else(|| wrong(format!("'{word}' is no number")));
    let numbers = words.map(number).collect::<Result<Vec<_>, _>>()?;
    if !(numbers.len() == 12 || (numbers.len() == 16 && numbers[12..] == [0.0, 0.0, 0.0, 1.0])) {
        return Err(wrong(format!("it has {} numbers, or another last row", numbers.len())));
    }
    let row = |n: usize| DVec3::new(numbers[4 * n], numbers[4 * n + 1], numbers[4 * n + 2]);
    let matrix3 = DMat3::from_cols(row(0), row(1), row(2)).transpose();
    Ok(DAffine3 { matrix3, translation: DVec3::new(numbers[3], numbers[7], numbers[11]) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_may_have_commas() {
        let spec = FieldSpec::from_text("pet.nii,transfer=hot,range=1,p99.5,opacity=0:0,9:0.5,factor=2,visible=off").unwrap();
        assert_eq!((spec.file.unwrap(), spec.transfer.unwrap()), ("pet.nii".into(), PathBuf::from("hot")));
        assert_eq!(spec.range, Some((Value::Number(1.0), Value::Percentile(99.5))));
        assert_eq!(spec.opacity.unwrap().0, [(Value::Number(0.0), 0.0), (Value::Number(9.0), 0.5)]);
        assert!(spec.factor == Some(2.0) && spec.hidden);
    }

    #[test]
    fn mistakes_are_named() {
        for (text, problem) in [
            (",factor=2", "names no file"),
            ("a.nii,2", "no KEY=VALUE"),
            ("a.nii,size=2", "size: unknown key"),
            ("a.nii,factor=-1", "factor: invalid factor"),
            ("a.nii,range=2", "range: invalid range"),
            ("a.nii,channel=-1", "channel: invalid channel '-1'; use a number from 0, or the name of a channel"),
        ] {
            let message = FieldSpec::from_text(text).err().unwrap();
            assert!(message.contains(problem), "{text}: {message}");
        }
    }

    #[test]
    fn changes_replace_what_a_field_had() {
        let mut spec = FieldSpec::from_text("a.nii,range=1,2,opacity=0:0,9:0.5,color=#ff0000").unwrap();
        FieldChange::from_text("1,transfer=hot,factor=3,visible=off").unwrap().apply(&mut spec).unwrap();
        assert_eq!((spec.transfer, spec.range, spec.factor), (Some(PathBuf::from("hot")), None, Some(3.0)));
        assert!(spec.opacity.is_none() && spec.hidden && spec.color == Some([1.0, 0.0, 0.0]));
        for (text, problem) in [
            ("-1,factor=2", "invalid field '-1'"),
            ("1", "changes nothing"),
            ("1,file=b.nii", "file: unknown key"),
            ("1,factor=-1", "factor: invalid factor"),
        ] {
            let message = FieldChange::from_text(text).err().unwrap();
            assert!(message.contains(problem), "{text}: {message}");
        }
    }

    #[test]
    fn transforms_are_matrices() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("at.txt");
        std::fs::write(&path, "0 -1 0 5\n1 0 0 6\n0 0 1 7\n0 0 0 1\n").unwrap();
        let transform = read_transform(&path).unwrap();
        assert_eq!(transform.transform_point3(DVec3::new(1.0, 2.0, 3.0)), DVec3::new(3.0, 7.0, 10.0));
        for text in ["1 2 3", "a", &"1 ".repeat(16), "1 0 0 0 0 1 0 0 0 0 1 nan"] {
            std::fs::write(&path, text).unwrap();
            assert!(read_transform(&path).is_err(), "{text}");
        }
    }
}
