//! Several fields in one picture: components of a file, other files, and scenes of fields.

mod field;
mod opening;
mod scene_file;
mod spec;
mod steps;
mod transform;

use super::options::VolumeOptions;
use super::parse;
use super::values::Component;
use crate::annotation::{Legend, LegendEntry};
use crate::error::Error;
use crate::renderer::Channel;
use crate::settings::Blend;
use crate::shown::Shown;
use crate::transfer::TransferFunction;
use crate::viewport::Viewport;
use crate::volume::{ChannelDescription, OpenOptions, Volume};
use clap::Args;
pub(super) use field::{Field, FieldLook};
use opening::Opened;
use scene_file::SceneFile;
pub(super) use scene_file::SceneSurface;
use spec::{FieldChange, FieldSpec};
pub(super) use spec::{KEYS, Pairs, split};
use std::path::{Path, PathBuf};
pub(super) use steps::{FieldSteps, PlayedField};
pub(super) use transform::read_transform;

/// Fields that are drawn together with the volume.
#[derive(Args)]
#[command(next_help_heading = "Channels")]
pub(super) struct ChannelOptions {
    /// Draw these components of the file together, e.g. 0,2, DAPI,GFP, or all, in the colours that the file states or by their names; other options are for the first [default: the first alone]
    #[arg(long, value_parser = components, value_name = "N,NAME|all", conflicts_with_all = ["channel", "scene"])]
    channels: Option<Components>,
    /// Draw another volume together with this one. Keys: transfer, range, opacity, color, factor, iso, gradient-opacity, channel, frame, array, spacing, origin, at, mask, labels, label, colors, color-opacity, visible; see the guide. Repeatable
    #[arg(long, value_parser = FieldSpec::from_text, value_name = "FILE[,KEY=VALUE]", conflicts_with = "scene")]
    with: Vec<FieldSpec>,
    /// Draw the fields of a scene file together: JSON, see the guide
    #[arg(long, value_name = "FILE.json")]
    scene: Option<PathBuf>,
    /// Change how field N is shown, 0 for the first, or that of a name. Keys: transfer, range, opacity, color, factor, iso, gradient-opacity, visible, name. Repeatable
    #[arg(long, value_parser = FieldChange::from_text, value_name = "N|NAME,KEY=VALUE")]
    field: Vec<FieldChange>,
}

/// Components of a file.
#[derive(Clone)]
enum Components {
    All,
    Listed(Vec<Component>),
}

/// Parses `all`, or numbers and names.
fn components(text: &str) -> Result<Components, String> {
    if text == "all" {
        return Ok(Components::All);
    }
    let listed: Result<Vec<Component>, String> = text.split(',').map(parse::component).collect();
    let listed = listed.map_err(|_| format!("invalid channels '{text}'; use numbers from 0 or names, such as 0,2, or all"))?;
    let count = listed.len();
    if count > Channel::MOST {
        return Err(format!("{count} channels; at most {} are drawn together", Channel::MOST));
    }
    Ok(Components::Listed(listed))
}

/// Numbers of components, each of which occurs once. `all`: those of the file.
fn numbers_of(listed: &[Component], all: &[ChannelDescription], file: &Path) -> Result<Vec<usize>, Error> {
    let number = |component: &Component| match component {
        Component::Number(number) => Ok(*number),
        Component::Name(name) => ChannelDescription::named(all, name, file),
    };
    let numbers = listed.iter().map(number).collect::<Result<Vec<usize>, Error>>()?;
    let refuse = |problem| Err(Error::Settings { field: "channels", problem });
    if let Some(number) = numbers.iter().find(|&&number| number >= all.len()) {
        return refuse(format!("{number} is not in {}, whose channels are 0 to {}", file.display(), all.len() - 1));
    }
    match (1..numbers.len()).find(|&n| numbers[..n].contains(&numbers[n])) {
        Some(n) => refuse(format!("channel {} occurs twice", numbers[n])),
        None => Ok(numbers),
    }
}

/// The fields of a picture.
pub(super) struct Fields {
    /// Replaces the volume of the command, which names none, or of which a mask leaves a part.
    pub first: Option<Volume<'static>>,
    /// Colours or labels that it shows instead of values.
    pub first_shown: Option<Shown>,
    /// Transfer function and look of the first field, unless options choose the former.
    first_spec: FieldSpec,
    others: Vec<FieldSpec>,
    opened: Vec<Opened>,
    /// Of fields in time, the values of all steps.
    overviews: Vec<Volume<'static>>,
    /// Surfaces of the scene file.
    pub surfaces: Vec<SceneSurface>,
    /// Whether the fields are channels of one picture, each in its colour.
    has_channel_colors: bool,
}

impl ChannelOptions {
    /// The file's component that is the first field.
    pub fn first_component(&self) -> Option<Component> {
        match &self.channels {
            Some(Components::Listed(listed)) => listed.first().cloned(),
            Some(Components::All) => Some(Component::Number(0)),
            None => None,
        }
    }

    /// Whether options choose components of the file, which are values.
    pub fn choose_components(&self) -> bool {
        self.channels.is_some()
    }

    /// Whether options ask for several fields, or say how they are shown.
    pub fn are_given(&self) -> bool {
        self.name_fields() || self.change_fields()
    }

    /// Whether options change how fields are shown.
    pub fn change_fields(&self) -> bool {
        !self.field.is_empty()
    }

    /// Whether options name fields beside the volume, or instead of it.
    pub fn name_fields(&self) -> bool {
        self.channels.is_some() || self.scene.is_some() || !self.with.is_empty()
    }

    /// Whether a scene names the fields.
    pub fn has_scene(&self) -> bool {
        self.scene.is_some()
    }

    /// Opens the fields beside `first`, the volume of the command, of which colours or labels may be shown. `steps`: those of fields in time,
    /// else none.
    pub fn open(
        &self,
        options: &VolumeOptions,
        (first, shown): (&Volume, Option<&Shown>),
        size: Viewport,
        steps: &[FieldSteps],
    ) -> Result<Fields, Error> {
        let mut steps = steps.iter();
        // The field of a spec; in time, its first step.
        let mut open = |fields: &mut Fields, spec: FieldSpec, still: &dyn Fn(&FieldSpec) -> Result<Opened, Error>| {
            let opened = match steps.next() {
                Some(steps) => {
                    fields.overviews.push(steps.overview()?);
                    Opened { volume: steps.step(0)?, shown: None }
                }
                None => still(&spec)?,
            };
            fields.opened.push(opened);
            fields.others.push(spec);
            Ok::<_, Error>(())
        };
        let mut fields = Fields {
            first: None,
            first_shown: None,
            first_spec: FieldSpec::default(),
            others: Vec::new(),
            opened: Vec::new(),
            overviews: Vec::new(),
            surfaces: Vec::new(),
            has_channel_colors: self.channels.is_some(),
        };
        if let Some(components) = &self.channels {
            let all = options.channel_descriptions(Some(size))?;
            let numbers = match components {
                Components::All => (0..first.contents().channels).collect(),
                Components::Listed(listed) => numbers_of(listed, &all, &options.volume)?,
            };
            // A channel that is named is shown, though the file may hide it.
            let is_named = matches!(components, Components::Listed(_));
            let spec = |number: usize| {
                let described = all.get(number).cloned().unwrap_or_default();
                FieldSpec::from_description(number, ChannelDescription { active: described.active || is_named, ..described })
            };
            fields.first_spec = spec(numbers[0]);
            for &number in numbers.iter().skip(1) {
                open(&mut fields, spec(number), &|_| {
                    Ok(Opened { volume: options.open_component(&Component::Number(number), Some(size))?, shown: None })
                })?;
            }
        }
        let unstated = options.placement();
        let mut specs = self.with.clone();
        if let Some(path) = &self.scene {
            SceneFile { fields: specs, surfaces: fields.surfaces } = scene_file::read(path)?;
            if options.is_default() && specs.is_empty() {
                let problem = "it has surfaces alone: name a volume, or one of their files in its place".into();
                return Err(Error::Keys { path: path.clone(), problem });
            }
            if options.is_default() || specs.first().is_some_and(|first| first.file.is_none()) {
                let spec = specs.remove(0);
                match &spec.file {
                    Some(_) => {
                        let Opened { volume, shown } = spec.open_any(unstated)?;
                        (fields.first, fields.first_shown) = (Some(volume), shown);
                    }
                    None => fields.first = spec.masked(first, unstated)?,
                }
                fields.first_spec = spec;
            }
        }
        for spec in specs {
            open(&mut fields, spec, &|spec| spec.open_any(unstated))?;
        }
        self.field.iter().try_for_each(|change| fields.change(change))?;
        let first_file = fields.first_spec.file.as_deref().unwrap_or(&options.volume);
        let shown = if fields.first.is_some() && fields.first_spec.file.is_some() { fields.first_shown.as_ref() } else { shown };
        shown.map_or(Ok(()), |shown| fields.first_spec.check_shown(shown, first_file))?;
        let all = std::iter::once(shown).chain(fields.opened.iter().map(|opened| opened.shown.as_ref()));
        let counts = all.map(|shown| shown.map_or(Ok(1), |shown| Ok(shown.channel_count(&shown.tables(&[])?))));
        let count = counts.sum::<Result<usize, Error>>()?;
        if count > Channel::MOST && !fields.others.is_empty() {
            let problem = format!(
                "{count} fields; at most {} are drawn together, and labels count once for each opacity that they have: give several labels one",
                Channel::MOST
            );
            return Err(Error::Settings { field: "channels", problem });
        }
        for (spec, opened) in fields.others.iter().zip(&fields.opened) {
            let file = spec.file.as_deref().unwrap_or(&options.volume);
            opened.shown.as_ref().map_or(Ok(()), |shown| spec.check_shown(shown, file))?;
        }
        fields.choose_colors();
        Ok(fields)
    }
}

impl Fields {
    /// Applies a change.
    fn change(&mut self, change: &FieldChange) -> Result<(), Error> {
        let count = 1 + self.others.len();
        let refuse = |problem| Error::Settings { field: "field", problem };
        let number = match &change.field {
            Component::Number(number) => *number,
            Component::Name(name) => {
                let described: Vec<ChannelDescription> = self.specs().map(FieldSpec::description).collect();
                let missing =
                    || refuse(format!("there is no field '{name}': name it by its channel, its key name, or its number"));
                ChannelDescription::named(&described, name, Path::new("")).map_err(|_| missing())?
            }
        };
        let spec = match number {
            0 => Some(&mut self.first_spec),
            n => self.others.get_mut(n - 1),
        };
        let missing = || refuse(format!("there is no field {number}: the picture has {count}, from 0"));
        change.apply(spec.ok_or_else(missing)?).map_err(refuse)
    }

    /// Gives a colour to each field that has none of its own.
    fn choose_colors(&mut self) {
        let mut specs: Vec<&mut FieldSpec> = std::iter::once(&mut self.first_spec).chain(&mut self.others).collect();
        let described: Vec<ChannelDescription> = specs.iter().map(|spec| spec.description()).collect();
        let colors = ChannelDescription::colors(&described);
        specs.iter_mut().zip(colors).for_each(|(spec, color)| spec.channel_color = color);
    }

    /// The transfer function of the first field, unless options choose one; `None` if it is that of a volume alone.
    pub fn first_transfer(&self, volume: &Volume, blend: Blend) -> Result<Option<TransferFunction>, Error> {
        if !self.has_channel_colors && !self.first_spec.chooses_transfer() {
            return Ok(None);
        }
        self.first_spec.transfer(volume, None, blend).map(Some)
    }

    /// The look of the first field.
    pub fn first_look(&self, volume: &Volume) -> FieldLook {
        self.first_spec.look(volume)
    }

    /// Name and colour of each field. `first`, `transfer`: the first one, and the transfer function with which it is drawn.
    pub fn entries(&self, first: &Volume, transfer: &TransferFunction) -> Result<Vec<LegendEntry>, Error> {
        let other = |(spec, Opened { volume, .. }): (&FieldSpec, &Opened)| {
            Ok(spec.legend_entry(volume, spec.named_transfer(volume)?.as_ref()))
        };
        let first = Ok(self.first_spec.legend_entry(first, Some(transfer)));
        std::iter::once(first).chain(self.others.iter().zip(&self.opened).map(other)).collect()
    }

    /// Name and colour of each visible field and label, if several are drawn; colours have none. `entries`: those of all fields; `first`:
    /// colours or labels of the first.
    pub fn legend(&self, entries: &[LegendEntry], first: Option<&Shown>) -> Result<Option<Legend>, Error> {
        if self.others.is_empty() {
            return Ok(None);
        }
        let shown = std::iter::once(first).chain(self.opened.iter().map(|opened| opened.shown.as_ref()));
        let mut listed = Vec::new();
        for ((_, entry), shown) in self.specs().zip(entries).zip(shown).filter(|((spec, _), _)| spec.is_visible()) {
            match shown {
                None => listed.push(entry.clone()),
                Some(shown) => listed.extend(shown.legend(&shown.tables(&[])?).into_iter().flat_map(|legend| legend.entries)),
            }
        }
        Ok(Some(Legend { entries: listed }))
    }

    fn specs(&self) -> impl Iterator<Item = &FieldSpec> {
        std::iter::once(&self.first_spec).chain(&self.others)
    }

    /// The other fields.
    pub fn into_others(self, blend: Blend) -> Result<Vec<Field>, Error> {
        let mut overviews = self.overviews.into_iter();
        let field = |(spec, Opened { volume, shown }): (FieldSpec, Opened)| {
            let overview = overviews.next();
            let values = overview.as_ref().unwrap_or(&volume);
            let (transfer, look) = (spec.transfer(values, shown.as_ref(), blend)?, spec.look(values));
            Ok(Field { volume, shown, transfer, look })
        };
        self.others.into_iter().zip(self.opened).map(field).collect()
    }
}

/// Options of a file that is named beside others.
fn open_options(spec: &FieldSpec) -> OpenOptions {
    let FieldSpec { frame, spacing, origin, .. } = *spec;
    let options = OpenOptions { frame, array: spec.array.clone(), spacing, origin, ..OpenOptions::default() };
    spec.channel.as_ref().map_or(options.clone(), |channel| channel.chosen(options))
}
