//! What a renderer draws instead of one scalar volume.

use crate::calls::abandonable;
use crate::channel::{self, Channel};
use crate::colors::{self, Colors};
use crate::errors::{Result, conflict};
use crate::exclusive::AnyRenderer;
use crate::labels::{self, Labels};
use layersplat::{Device, Error, Renderer};
use pyo3::prelude::*;
use pyo3::types::{PyList, PyTuple};

/// Channels, colours or labels, independent of Python.
pub enum DrawnFields {
    Channels(Vec<channel::Drawn>),
    Colors(colors::Drawn),
    Labels(labels::Drawn),
}

impl DrawnFields {
    /// A list of channels, colours or labels; `None` for everything else.
    ///
    /// # Errors
    /// For a list in which only some are channels.
    pub fn from_object(object: &Bound<PyAny>) -> Result<Option<Self>> {
        if let Ok(colors) = object.cast::<Colors>() {
            return Ok(Some(Self::Colors(colors.get().drawn().clone())));
        }
        if let Ok(labels) = object.cast::<Labels>() {
            return Ok(Some(Self::Labels(labels.get().drawn().clone())));
        }
        if let Ok(channel) = object.cast::<Channel>() {
            return Ok(Some(Self::Channels(vec![channel.get().drawn().clone()])));
        }
        if !object.is_instance_of::<PyList>() && !object.is_instance_of::<PyTuple>() {
            return Ok(None);
        }
        let items: Vec<Bound<PyAny>> = object.extract()?;
        let channels: Vec<_> = items.iter().filter_map(|item| item.cast::<Channel>().ok()).collect();
        if channels.is_empty() {
            return Ok(None);
        }
        if channels.len() < items.len() {
            return Err(conflict(
                "volume",
                "only some items of the list are a Channel: make a Channel of each, or use channels()",
            ));
        }
        Ok(Some(Self::Channels(channels.iter().map(|channel| channel.get().drawn().clone()).collect())))
    }

    /// A renderer on a device. `has_transfer`: whether the caller has given a transfer function.
    pub fn renderer(self, py: Python, has_transfer: bool, device: Device) -> Result<Box<AnyRenderer>> {
        if has_transfer {
            return Err(conflict("transfer", "leave it out: channels, colours and labels have their own"));
        }
        abandonable(py, move || {
            Ok(Box::new(match self {
                Self::Channels(channels) => Renderer::from_channels(&uploaded(&channels, &device)?)?,
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
            Self::Channels(channels) => renderer.set_channels(&uploaded(&channels, &device)?),
            Self::Colors(colors) => renderer.set_colors(&colors.on(&device)?),
            Self::Labels(labels) => renderer.set_colors(&labels.on(&device)?),
        }
    }
}

fn uploaded(channels: &[channel::Drawn], device: &Device) -> std::result::Result<Vec<layersplat::renderer::Channel>, Error> {
    channels.iter().map(|channel| channel.on(device)).collect()
}
