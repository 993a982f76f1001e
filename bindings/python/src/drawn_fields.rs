//! What a renderer draws instead of one scalar volume.

use crate::calls::abandonable;
use crate::channel::{self, Channel};
use crate::colors::{self, Colors};
use crate::errors::{Result, conflict};
use crate::exclusive::AnyRenderer;
use crate::labels::{self, Labels};
use layersplat::renderer::Channel as OurChannel;
use layersplat::{Device, Error, Renderer};
use pyo3::prelude::*;
use pyo3::types::{PyList, PyTuple};

/// Channels, colours or labels, independent of Python.
pub enum DrawnFields {
    /// Fields that are drawn together.
    Together(Vec<Field>),
    Colors(colors::Drawn),
    Labels(labels::Drawn),
}

/// One of several fields.
#[derive(Clone)]
pub enum Field {
    Channel(Box<channel::Drawn>),
    Colors(colors::Drawn),
    Labels(labels::Drawn),
}

impl Field {
    fn from_object(object: &Bound<PyAny>) -> Option<Self> {
        if let Ok(channel) = object.cast::<Channel>() {
            return Some(Self::Channel(Box::new(channel.get().drawn().clone())));
        }
        if let Ok(colors) = object.cast::<Colors>() {
            return Some(Self::Colors(colors.get().drawn().clone()));
        }
        object.cast::<Labels>().ok().map(|labels| Self::Labels(labels.get().drawn().clone()))
    }

    /// The channels on a device: several of labels of several opacities.
    fn on(&self, device: &Device) -> std::result::Result<Vec<OurChannel>, Error> {
        match self {
            Self::Channel(channel) => Ok(vec![channel.on(device)?]),
            Self::Colors(colors) => Ok(vec![OurChannel::from_colors(&colors.on(device)?)?]),
            Self::Labels(labels) => labels.channels_on(device),
        }
    }
}

impl DrawnFields {
    /// A channel, colours or labels, or a list of these; `None` for everything else.
    ///
    /// # Errors
    /// For a list in which only some are these.
    pub fn from_object(object: &Bound<PyAny>) -> Result<Option<Self>> {
        match Field::from_object(object) {
            Some(Field::Colors(colors)) => return Ok(Some(Self::Colors(colors))),
            Some(Field::Labels(labels)) => return Ok(Some(Self::Labels(labels))),
            Some(channel) => return Ok(Some(Self::Together(vec![channel]))),
            None if !object.is_instance_of::<PyList>() && !object.is_instance_of::<PyTuple>() => return Ok(None),
            None => {}
        }
        let items: Vec<Bound<PyAny>> = object.extract()?;
        let fields: Vec<_> = items.iter().filter_map(Field::from_object).collect();
        if fields.is_empty() {
            return Ok(None);
        }
        if fields.len() < items.len() {
            return Err(conflict(
                "volume",
                "only some items of the list are a Channel, a Colors or a Labels: make a Channel of each volume, or use channels()",
            ));
        }
        Ok(Some(Self::Together(fields)))
    }

    /// A renderer on a device. `has_transfer`: whether the caller has given a transfer function.
    pub fn renderer(self, py: Python, has_transfer: bool, device: Device) -> Result<Box<AnyRenderer>> {
        if has_transfer {
            return Err(conflict("transfer", "leave it out: channels, colours and labels have their own"));
        }
        abandonable(py, move || {
            Ok(Box::new(match self {
                Self::Together(fields) => Renderer::from_channels(&uploaded(&fields, &device)?)?,
                Self::Colors(colors) => Renderer::from_colors(&colors.on(&device)?)?,
                Self::Labels(labels) => Renderer::from_colors(&labels.on(&device)?)?,
            }) as Box<AnyRenderer>)
        })
    }

    /// Replaces all that a renderer draws.
    ///
    /// # Errors
    /// For a renderer that streams, and those of the library.
    pub fn replace(self, renderer: &mut AnyRenderer) -> std::result::Result<(), Error> {
        let renderer = renderer.require_whole("Renderer.set_volume of channels, colours or labels")?;
        let device = renderer.device().clone();
        match self {
            Self::Together(fields) => renderer.set_channels(&uploaded(&fields, &device)?),
            Self::Colors(colors) => renderer.set_colors(&colors.on(&device)?),
            Self::Labels(labels) => renderer.set_colors(&labels.on(&device)?),
        }
    }
}

fn uploaded(fields: &[Field], device: &Device) -> std::result::Result<Vec<OurChannel>, Error> {
    let channels: std::result::Result<Vec<_>, _> = fields.iter().map(|field| field.on(device)).collect();
    Ok(channels?.into_iter().flatten().collect())
}
