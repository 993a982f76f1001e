//! A field beside the volume, as text: `FILE,KEY=VALUE,…`.

use super::FieldLook;
use crate::annotation::LegendEntry;
use crate::cli::parse;
use crate::cli::values::{Colors, Component, Opacities};
use crate::error::Error;
use crate::renderer::ColorOpacity;
use crate::settings::{Blend, GradientOpacity};
use crate::shown::Shown;
use crate::transfer::{TransferFunction, Value};
use crate::url;
use crate::volume::{ChannelDescription, LabelChange, Volume};
use clap::ValueEnum;
use glam::DVec3;
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
    pub(super) transfer: Option<PathBuf>,
    pub(super) range: Option<(Value, Value)>,
    pub(super) opacity: Option<Opacities>,
    pub(super) color: Option<[f64; 3]>,
    factor: Option<f64>,
    pub(super) iso: Option<Value>,
    pub(super) gradient_opacity: Option<GradientOpacity>,
    /// File of the transform from its world to that of the scene.
    pub(super) at: Option<PathBuf>,
    /// Labels within which it shows: `FILE` or `FILE:IDS`. Which of the two is known only once the file's folder is.
    pub(super) mask: Option<String>,
    /// Voxels are ids of labels, with the names and colours of a table, or of their own.
    pub(super) labels: Option<Option<PathBuf>>,
    pub(super) label_changes: Vec<LabelChange>,
    /// How components are drawn as colours, unless the file says it.
    pub(super) colors: Option<Colors>,
    pub(super) color_opacity: Option<ColorOpacity>,
    hidden: bool,
    name: Option<String>,
    /// Colour beside those of the other fields, unless `color` is given.
    pub channel_color: [f64; 3],
}

/// Keys, for messages.
pub(in crate::cli) const KEYS: &str = "transfer, range, opacity, color, factor, iso, gradient-opacity, channel, frame, array, spacing, origin, at, mask, labels, label, \
                    colors, color-opacity, visible and name";

impl FieldSpec {
    /// Parses `FILE,KEY=VALUE,…`.
    pub fn from_text(text: &str) -> Result<Self, String> {
        let (file, pairs) = split(text, KEYS)?;
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
        let color = self.color.or_else(|| drawn.map(TransferFunction::most_opaque_color)).unwrap_or(self.channel_color);
        LegendEntry::new(name, color)
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
            "colors" => {
                let names = || "expected direct, direction or none".to_owned();
                self.colors = Some(Colors::from_str(value, false).map_err(|_| names())?);
            }
            "color-opacity" => self.color_opacity = Some(parse::color_opacity(value)?),
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
        self.mask = self.mask.map(|mask| {
            if url::is_url(Path::new(&mask)) { mask.into() } else { folder.join(mask) }.to_string_lossy().into_owned()
        });
        self
    }

    /// Whether the spec chooses colours or opacities.
    pub fn chooses_transfer(&self) -> bool {
        self.transfer.is_some() || self.color.is_some() || self.range.is_some() || self.opacity.is_some()
    }

    /// The transfer function; of colours, their opacities. `volume`: with all values.
    pub fn transfer(&self, volume: &Volume, shown: Option<&Shown>, blend: Blend) -> Result<TransferFunction, Error> {
        let color = self.color.unwrap_or(self.channel_color);
        let mut transfer = match self.named_transfer(volume)?.or_else(|| shown?.opacities()) {
            Some(given) => given,
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
pub(in crate::cli) type Pairs = Vec<(String, String)>;

/// Splits `FIRST,KEY=VALUE,…`. A value may have commas: what lacks a key continues it.
pub(in crate::cli) fn split<'a>(text: &'a str, keys: &str) -> Result<(&'a str, Pairs), String> {
    let mut parts = text.split(',');
    let first = parts.next().unwrap_or_default();
    let mut pairs = Pairs::new();
    for part in parts {
        match (part.split_once('='), pairs.last_mut()) {
            (Some((key, value)), _) => pairs.push((key.trim().to_lowercase().replace('_', "-"), value.into())),
            (None, Some((_, value))) => value.extend([",", part]),
            (None, None) => return Err(format!("'{part}' is no KEY=VALUE; keys are {keys}")),
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
        let (field, pairs) = split(text, KEYS)?;
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
}
