//! Channels: fields that are drawn together.

use crate::argument::{Argument, extract};
use crate::calls::abandonable;
use crate::camera::Framing;
use crate::device_volume::refuse_voxels_on_device;
use crate::errors::{Result, out_of_range};
use crate::settings::Settings;
use crate::transfer::{TransferFunction, checked_color};
use crate::uploads::Voxels;
use crate::volume::Volume;
use crate::warned::{warn, warned};
use layersplat::framing::Framing as OurFraming;
use layersplat::renderer::Channel as Ours;
use layersplat::settings::{Blend, GradientOpacity};
use layersplat::volume::ChannelDescription;
use layersplat::{Device, Error, OpenOptions, Settings as OurSettings, TransferFunction as Transfer, Volume as OurVolume};
use pyo3::prelude::*;
use std::path::PathBuf;

/// A volume that is drawn together with others, by Renderer([channel, …]): extinctions add, and colours are weighted by them.
///
/// volume: a Volume, or anything that Volume() takes. transfer: a TransferFunction, by default TransferFunction.channel(volume, color).
/// color: (red, green, blue), 0 … 1, by default white, instead of transfer. factor: factor of the extinction, at least 0. visible: hidden
/// channels cost nothing. iso: value of the iso-surface, instead of that of the settings. gradient_opacity: see Settings, which has that
/// of channels without one.
///
/// A renderer draws up to eight channels, with grids of their own. Channels made by replaced share the voxels on the device.
#[pyclass(frozen, module = "layersplat")]
pub struct Channel(Drawn);

/// A channel, independent of Python.
#[derive(Clone)]
pub struct Drawn {
    voxels: Voxels,
    transfer: Transfer,
    factor: f64,
    visible: bool,
    iso: Option<f64>,
    gradient_opacity: Option<GradientOpacity>,
}

impl Drawn {
    /// The channel on a device.
    ///
    /// # Errors
    /// If memory is insufficient.
    pub fn on(&self, device: &Device) -> std::result::Result<Ours, Error> {
        let channel = Ours::new(&self.voxels.on(device)?, &self.transfer);
        let channel = channel.with_factor(self.factor)?.with_visibility(self.visible);
        Ok(channel.with_gradient_opacity(self.gradient_opacity).with_iso(self.iso))
    }

    fn framing(&self, settings: &OurSettings) -> OurFraming {
        let volume = self.voxels.volume();
        match (settings.blend, self.iso) {
            (Blend::Composite, _) => OurFraming::visible(volume, &self.transfer, settings.unit_distance),
            (Blend::Iso(value), own) => OurFraming::iso(volume, own.unwrap_or(value)),
            _ => OurFraming::whole(volume),
        }
    }
}

impl Channel {
    pub fn drawn(&self) -> &Drawn {
        &self.0
    }
}

fn factor_from(factor: f64) -> Result<f64> {
    if (0.0..=f64::MAX).contains(&factor) {
        return Ok(factor);
    }
    Err(out_of_range("factor", factor, "a finite number that is at least 0"))
}

fn iso_from(iso: f64) -> Result<f64> {
    if iso.is_finite() { Ok(iso) } else { Err(out_of_range("iso", iso, "a finite number")) }
}

#[pymethods]
impl Channel {
    #[new]
    #[pyo3(
        signature = (
            volume, transfer = None, *, color = None, factor = Argument::Default(1.0), visible = Argument::Default(true), iso = None,
            gradient_opacity = None,
        ),
        text_signature = "(volume, transfer=None, *, color=None, factor=1.0, visible=True, iso=None, gradient_opacity=None)"
    )]
    fn new(
        volume: &Bound<PyAny>,
        transfer: Option<Argument<Bound<TransferFunction>>>,
        color: Option<Argument<[f64; 3]>>,
        factor: Argument<f64>,
        visible: Argument<bool>,
        iso: Option<Argument<f64>>,
        gradient_opacity: Option<Argument<Vec<(f64, f64)>>>,
    ) -> Result<Self> {
        extract!(transfer, color, factor, visible, iso, gradient_opacity);
        refuse_voxels_on_device(volume)?;
        let py = volume.py();
        let ours = match volume.cast::<Volume>() {
            Ok(volume) => volume.get().ours().clone(),
            Err(_) => Volume::from_data(volume)?.ours().clone(),
        };
        let transfer = match (transfer, color) {
            (Some(_), Some(_)) => return Err(crate::errors::conflict("color", "transfer has colours: give either")),
            (Some(transfer), None) => transfer.get().ours().clone(),
            (None, color) => {
                let color = checked_color(color.unwrap_or([1.0; 3]))?;
                let volume = ours.clone();
                abandonable(py, move || Ok(Transfer::channel(&volume, color)))?
            }
        };
        Ok(Self(Drawn {
            voxels: Voxels::new(ours),
            transfer,
            factor: factor_from(factor)?,
            visible,
            iso: iso.map(iso_from).transpose()?,
            gradient_opacity: gradient_opacity.map(|points| GradientOpacity::new(&points)).transpose()?,
        }))
    }

    /// Opens all channels of a file as a list. Colours, windows of values and hidden channels are those that the file states (OME-Zarr, OME-TIFF,
    /// ImageJ's TIFF); the other colours are those of channel_colors, the other windows automatic.
    #[staticmethod]
    fn open(py: Python, path: Argument<PathBuf>) -> Result<Vec<Self>> {
        extract!(path);
        let (channels, warnings) = warned(py, move || {
            let described = ChannelDescription::of_file(&path, &OpenOptions::default())?;
            let colors = ChannelDescription::colors(&described);
            let open = |(n, (channel, color)): (usize, (&ChannelDescription, [f64; 3]))| {
                let options = OpenOptions { channel: Some(n), ..OpenOptions::default() };
                let volume = OurVolume::open(&path, &options)?;
                let automatic = Transfer::channel(&volume, color);
                let transfer = match channel.window {
                    Some((lo, hi)) => automatic.stretched(lo, hi)?,
                    None => automatic,
                };
                let voxels = Voxels::new(volume);
                Ok(Self(Drawn { voxels, transfer, factor: 1.0, visible: channel.active, iso: None, gradient_opacity: None }))
            };
            described.iter().zip(colors).enumerate().map(open).collect::<Result<Vec<_>>>()
        })?;
        warn(py, warnings)?;
        Ok(channels)
    }

    /// A copy with other properties; what is None stays. The copy shares the voxels on the device.
    #[pyo3(signature = (*, transfer = None, factor = None, visible = None, iso = None, gradient_opacity = None))]
    fn replaced(
        &self,
        transfer: Option<Argument<Bound<TransferFunction>>>,
        factor: Option<Argument<f64>>,
        visible: Option<Argument<bool>>,
        iso: Option<Argument<f64>>,
        gradient_opacity: Option<Argument<Vec<(f64, f64)>>>,
    ) -> Result<Self> {
        extract!(transfer, factor, visible, iso, gradient_opacity);
        let mut drawn = self.0.clone();
        if let Some(transfer) = transfer {
            drawn.transfer = transfer.get().ours().clone();
        }
        if let Some(factor) = factor {
            drawn.factor = factor_from(factor)?;
        }
        drawn.visible = visible.unwrap_or(drawn.visible);
        if let Some(iso) = iso {
            drawn.iso = Some(iso_from(iso)?);
        }
        if let Some(points) = gradient_opacity {
            drawn.gradient_opacity = Some(GradientOpacity::new(&points)?);
        }
        Ok(Self(drawn))
    }

    /// The framing of what these settings show of the channel, see Framing.of. Clipping is not considered. Scans all voxels.
    #[pyo3(signature = (settings = None))]
    fn framing(&self, py: Python, settings: Option<Argument<Bound<Settings>>>) -> Result<Framing> {
        extract!(settings);
        let settings = settings.map_or_else(OurSettings::default, |settings| *settings.get().ours());
        let drawn = self.0.clone();
        Ok(Framing::from_library(abandonable(py, move || Ok(drawn.framing(&settings)))?))
    }

    /// The voxels.
    #[getter]
    fn volume(&self) -> Volume {
        Volume::from_library(self.0.voxels.volume().clone())
    }

    /// The transfer function.
    #[getter]
    fn transfer(&self) -> TransferFunction {
        TransferFunction::from_library(self.0.transfer.clone())
    }

    /// Factor of the extinction.
    #[getter]
    fn factor(&self) -> f64 {
        self.0.factor
    }

    /// Whether it is drawn.
    #[getter]
    fn visible(&self) -> bool {
        self.0.visible
    }

    /// Value of its own iso-surface; None: that of the settings.
    #[getter]
    fn iso(&self) -> Option<f64> {
        self.0.iso
    }

    fn __repr__(&self) -> String {
        let hidden = if self.0.visible { "" } else { ", hidden" };
        format!("<layersplat.Channel {}, factor {}{hidden}>", self.0.voxels.volume().name(), self.0.factor)
    }
}

/// Colours (red, green, blue) of channels that have these names, or None. A fluorophore in a name has its usual colour (DAPI is blue); others
/// get well separated ones, also for the colour-blind: green, magenta, cyan, yellow, red, blue. A single channel is white.
#[pyfunction]
pub fn channel_colors(names: Vec<Option<String>>) -> Vec<(f64, f64, f64)> {
    let described: Vec<_> = names.into_iter().map(|name| ChannelDescription { name, ..ChannelDescription::default() }).collect();
    ChannelDescription::colors(&described).into_iter().map(Into::into).collect()
}
