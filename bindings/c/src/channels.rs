//! Channels: fields that are drawn together.

use crate::boundary::{Failure, Out, borrowed, copy, free, guard, require_capacity, text, values};
use crate::colors::Colors;
use crate::renderer::with_whole;
use crate::settings::{flag, gradient_points};
use crate::{Device, Renderer, Status, Transfer, Volume};
use layersplat::TransferFunction;
use layersplat::renderer::{self, UploadedVolume};
use layersplat::volume::ChannelDescription;
use std::ffi::c_char;

/// Voxels on a device, which several renderers and channels may share. It is immutable, and several threads may use it at the same time.
pub struct Uploaded(UploadedVolume);

/// A field that is drawn together with others, and how it is shown. Initialise it with layersplat_channel_default() before changing fields:
/// later versions have more of them.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct Channel {
    /// Size of this struct in bytes in the program's header. layersplat_channel_default() sets it; do not change it.
    pub size: usize,
    /// Its voxels; not read with `colors`.
    pub volume: *const Uploaded,
    /// Its transfer function; not read with `colors`.
    pub transfer: *const Transfer,
    /// Factor of the extinction, at least 0.
    pub factor: f64,
    /// 1, or 0 to hide it. A hidden channel costs nothing.
    pub visible: i32,
    /// 1: `iso_value` replaces that of the settings; 0: it does not.
    pub has_iso_value: i32,
    /// Value of its iso-surface.
    pub iso_value: f64,
    /// Number of points of `gradient_opacity` in use; 0: the gradient opacity of the settings.
    pub gradient_point_count: i32,
    /// Points of its gradient opacity function: gradient magnitude in values per world unit, ascending, and opacity factor.
    pub gradient_opacity: [[f64; 2]; 8],
    /// Null, or colours or labels that are drawn together with the other channels. Of labels of several opacities, make a channel for each.
    pub colors: *const Colors,
}

/// Size of the only version of the struct.
const SIZE: usize = size_of::<Channel>();

fn check_size(size: usize) -> Result<(), Failure> {
    if size == SIZE {
        return Ok(());
    }
    Err(Failure::invalid(format!(
        "a channel has {size} bytes, and this version of layersplat expects {SIZE}: initialise it with layersplat_channel_default(), \
         and use the library that matches the header"
    )))
}

impl Channel {
    unsafe fn checked(&self) -> Result<renderer::Channel, Failure> {
        // SAFETY: upheld by the caller, here and below.
        let channel = match unsafe { self.colors.as_ref() } {
            Some(colors) => renderer::Channel::from_colors(&colors.0)?,
            None => {
                let volume = unsafe { borrowed(self.volume, "volume of a channel") }?;
                let transfer = unsafe { borrowed(self.transfer, "transfer of a channel") }?;
                renderer::Channel::new(&volume.0, &transfer.0)
            }
        };
        let channel = channel.with_factor(self.factor)?.with_visibility(flag("visible", self.visible)?);
        let channel = channel.with_gradient_opacity(gradient_points(self.gradient_point_count, &self.gradient_opacity)?);
        Ok(channel.with_iso(flag("has_iso_value", self.has_iso_value)?.then_some(self.iso_value)))
    }
}

/// The channels of an array. The size of the first is checked before anything else is read.
unsafe fn checked(channels: *const Channel, count: usize) -> Result<Vec<renderer::Channel>, Failure> {
    if count > renderer::Channel::MOST {
        return Err(Failure::invalid(format!("there are {count} channels: a renderer draws 1 to {}", renderer::Channel::MOST)));
    }
    if count > 0 && !channels.is_null() {
        // SAFETY: upheld by the caller: an array begins with the size of its structs.
        check_size(unsafe { (&raw const (*channels).size).read() })?;
    }
    // SAFETY: upheld by the caller, here and below: the structs have the size of this version.
    let channels = unsafe { values(channels, count, "channels") }?;
    channels.iter().try_for_each(|channel| check_size(channel.size))?;
    channels.iter().map(|channel| unsafe { channel.checked() }).collect()
}

/// Uploads a volume to a device, for channels. The volume may be freed afterwards. To be freed by layersplat_uploaded_free().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_uploaded_new(
    device: *const Device,
    volume: *const Volume,
    uploaded: *mut *mut Uploaded,
) -> Status {
    guard(|| {
        // SAFETY: upheld by the caller, here and below.
        let out = unsafe { Out::handle(uploaded, "uploaded") }?;
        let device = unsafe { borrowed(device, "device") }?;
        let volume = unsafe { borrowed(volume, "volume") }?;
        out.set_handle(Uploaded(UploadedVolume::new(&device.0, &volume.0)?));
        Ok(())
    })
}

/// Frees voxels on a device. Renderers that draw them stay usable. Null is ignored.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_uploaded_free(uploaded: *mut Uploaded) {
    // SAFETY: upheld by the caller.
    unsafe { free(uploaded) }
}

/// A visible channel with factor 1. `volume` and `transfer` are kept by the struct, and must stay until a call has used it; null for a channel
/// whose `colors` are set then. Pass
/// sizeof(layersplat_channel) as `size`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_channel_default(
    volume: *const Uploaded,
    transfer: *const Transfer,
    channel: *mut Channel,
    size: usize,
) -> Status {
    guard(|| {
        check_size(size)?;
        let default = Channel {
            size,
            volume,
            transfer,
            factor: 1.0,
            visible: 1,
            has_iso_value: 0,
            iso_value: 0.0,
            gradient_point_count: 0,
            gradient_opacity: [[0.0; 2]; 8],
            colors: std::ptr::null(),
        };
        // SAFETY: upheld by the caller: a struct of `size` bytes, which was compared.
        unsafe { Out::new(channel, "channel") }?.set_first(default, size);
        Ok(())
    })
}

/// Creates a renderer that draws 1 to 8 channels together, on the device of their voxels. Extinctions add, and colours are weighted by them;
/// the order does not matter. The grids may differ. Volumes and transfer functions may be freed afterwards. To be freed by
/// layersplat_renderer_free().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_renderer_from_channels(
    channels: *const Channel,
    count: usize,
    renderer: *mut *mut Renderer,
) -> Status {
    guard(|| {
        // SAFETY: upheld by the caller, here and below.
        let out = unsafe { Out::handle(renderer, "renderer") }?;
        let channels = unsafe { checked(channels, count) }?;
        out.set_handle(Renderer::new(Box::new(layersplat::Renderer::from_channels(&channels)?)));
        Ok(())
    })
}

/// Replaces all that a renderer draws by 1 to 8 channels, effective from the next frame. What belongs to voxels and transfer functions that
/// stay is not computed again. After an error the renderer keeps what it draws. Renderers that stream their volume return
/// LAYERSPLAT_STATUS_NEEDS_WHOLE_VOLUME.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_renderer_set_channels(
    renderer: *mut Renderer,
    channels: *const Channel,
    count: usize,
) -> Status {
    guard(|| {
        // SAFETY: upheld by the caller, here and below.
        let channels = unsafe { checked(channels, count) }?;
        let set = |renderer: &mut layersplat::Renderer| Ok(renderer.set_channels(&channels)?);
        unsafe { with_whole(renderer, "layersplat_renderer_set_channels", set) }
    })
}

/// A transfer function for a channel: one colour (red, green, blue), 0 to 1, and an opacity that rises from the end of the background's noise
/// to the 99.9th percentile of the voxels. `ramp` 1: colours rise from black too, for LAYERSPLAT_BLEND_MAXIMUM, _MINIMUM and _AVERAGE; else
/// 0. To be freed by layersplat_transfer_free().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_transfer_channel(
    volume: *const Volume,
    color: *const f64,
    ramp: i32,
    transfer: *mut *mut Transfer,
) -> Status {
    guard(|| {
        // SAFETY: upheld by the caller, here and below.
        let out = unsafe { Out::handle(transfer, "transfer") }?;
        let volume = unsafe { borrowed(volume, "volume") }?;
        let color = color_from(unsafe { values(color, 3, "color") }?)?;
        let made = if flag("ramp", ramp)? { TransferFunction::channel_ramp } else { TransferFunction::channel };
        out.set_handle(Transfer(made(&volume.0, color)));
        Ok(())
    })
}

/// A colour whose components are in range.
pub(crate) fn color_from(values: &[f64]) -> Result<[f64; 3], Failure> {
    match *values {
        [r, g, b] if values.iter().all(|c| (0.0..=1.0).contains(c)) => Ok([r, g, b]),
        _ => Err(Failure::invalid(format!("a color is {values:?}: expected red, green and blue from 0 to 1"))),
    }
}

/// Colours of `count` channels, red, green and blue each, for layersplat_transfer_channel(). A fluorophore in a name has its usual colour (DAPI
/// is blue); other channels get well separated ones, also for the colour-blind. A single channel is white. Names may be null. `capacity` is the
/// number of values of `colors`, at least 3 `count`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_channel_colors(
    names: *const *const c_char,
    count: usize,
    colors: *mut f64,
    capacity: usize,
) -> Status {
    guard(|| {
        require_capacity(count.saturating_mul(3), colors, capacity, "colors")?;
        // SAFETY: upheld by the caller, here and below.
        let names = unsafe { values(names, count, "names") }?;
        let described = names.iter().enumerate().map(|(n, &name)| {
            let name = (!name.is_null()).then(|| unsafe { text(name, &format!("name {n} of names")) }).transpose()?;
            Ok(ChannelDescription { name: name.map(String::from), ..ChannelDescription::default() })
        });
        let described = described.collect::<Result<Vec<_>, Failure>>()?;
        let found: Vec<f64> = ChannelDescription::colors(&described).into_iter().flatten().collect();
        unsafe { copy(&found, colors, capacity, "colors") }
    })
}
