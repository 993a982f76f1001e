//! From what was drawn to the finished picture.

use super::scratch::Growing;
use super::tiles::{Target, Tiles};
use crate::device::launch::Launcher;
use crate::device::launch::picture::{Present, PresentArguments, Warp, WarpArguments, WarpDisplayed, WarpDisplayedArguments};
use crate::device::launch::structs::{Float4, WarpParams};
use crate::device::{Buffer, Device};
use crate::error::Error;
use crate::image::Background;
use crate::layers::{Lattice, Rays};
use crate::memory;
use crate::viewport::Viewport;

/// Most places per pixel and axis that are averaged where it covers many voxels.
const MOST_FILTERED: f64 = 16.0;

/// Warps lattices onto the screen, and presents pictures.
pub(super) struct Picture {
    warp: Launcher<Warp>,
    warp_displayed: Launcher<WarpDisplayed>,
    present: Launcher<Present>,
    /// In floats, of lattices.
    frame: Growing<Float4>,
    rgba: Growing<[u8; 4]>,
}

/// The share of a lattice in a frame.
#[derive(Clone, Copy)]
pub(super) struct Share {
    pub share: f64,
    /// Whether it is added to what the frame has of other lattices.
    pub added: bool,
}

impl Share {
    /// Of a lattice that makes the frame alone.
    pub const WHOLE: Share = Share { share: 1.0, added: false };
}

/// What a lattice needs on its way onto the screen.
#[derive(Clone, Copy)]
pub(super) struct OntoScreen<'a> {
    pub lattice: &'a Lattice,
    pub rays: &'a Rays,
    pub viewport: Viewport,
}

impl OntoScreen<'_> {
    fn params(self, tiles: Tiles, share: Share) -> WarpParams {
        let Self { lattice, rays, viewport } = self;
        WarpParams {
            from_screen: lattice.from_screen(rays).transpose().to_cols_array().map(|m| m as f32),
            lattice: lattice.size.map(|n| n as i32),
            frame: [viewport.width as i32, viewport.height as i32],
            forward: lattice.forward() as f32,
            tile: tiles.size.map(|n| n as i32),
            counts: tiles.counts as i32,
            share: share.share as f32,
            added: i32::from(share.added),
            on_pixels: i32::from(lattice.aligned[0]) | i32::from(lattice.aligned[1]) << 1,
            filter: rays.voxels_per_pixel(lattice.frame).ceil().clamp(1.0, MOST_FILTERED) as i32,
        }
    }
}

/// Bytes of a pixel on the host: as floats, and displayed.
pub(super) const FLOATS: u64 = size_of::<[f32; 4]>() as u64;
pub(super) const RGBA8: u64 = size_of::<[u8; 4]>() as u64;

impl Default for Picture {
    fn default() -> Self {
        Self {
            warp: Launcher::default(),
            warp_displayed: Launcher::default(),
            present: Launcher::default(),
            frame: Growing::of_frames(),
            rgba: Growing::of_frames(),
        }
    }
}

/// What is drawn `into`, where that is given, and a picture's own buffer elsewhere.
fn or_own<'a, T: Copy>(
    into: Option<&'a Buffer<T>>,
    own: &'a mut Growing<T>,
    device: &Device,
    viewport: Viewport,
    what: &str,
) -> Result<&'a Buffer<T>, Error> {
    match into {
        Some(into) => Ok(into),
        None => Ok(own.at_least(device, viewport.pixels(), what)?),
    }
}

impl Picture {
    /// Bytes that the frame of floats, and the displayed one, still need.
    pub fn missing(&self, device: &Device, viewport: Viewport) -> [u64; 2] {
        [self.frame.missing(device, viewport.pixels()), self.rgba.missing(device, viewport.pixels())]
    }

    /// Warps a lattice into a frame of floats.
    pub fn warp<'a>(
        &'a mut self,
        device: &Device,
        from: &mut Target,
        onto: OntoScreen,
        share: Share,
        into: Option<&'a Buffer<Float4>>,
    ) -> Result<&'a Buffer<Float4>, Error> {
        let (lattice, tiles, active_samples) = from.drawn(device)?;
        let picture = or_own(into, &mut self.frame, device, onto.viewport, "the frame")?;
        let background = Float4([0.0; 4]);
        let arguments = WarpArguments { lattice, active_samples, p: onto.params(tiles, share), background, picture };
        self.warp.launch(device, (), &arguments)?;
        Ok(picture)
    }

    /// The frame of floats that lattices were warped into.
    pub fn warped(&mut self, device: &Device, viewport: Viewport) -> Result<&Buffer<Float4>, Error> {
        or_own(None, &mut self.frame, device, viewport, "the frame")
    }

    /// Warps a lattice straight into an 8-bit picture.
    pub fn warp_displayed<'a>(
        &'a mut self,
        device: &Device,
        from: &mut Target,
        onto: OntoScreen,
        background: Background,
        into: Option<&'a Buffer<[u8; 4]>>,
    ) -> Result<&'a Buffer<[u8; 4]>, Error> {
        let (lattice, tiles, active_samples) = from.drawn(device)?;
        let picture = or_own(into, &mut self.rgba, device, onto.viewport, "the picture")?;
        let (p, background) = (onto.params(tiles, Share::WHOLE), for_kernels(background));
        let arguments = WarpDisplayedArguments { lattice, active_samples, p, background, picture };
        self.warp_displayed.launch(device, (), &arguments)?;
        Ok(picture)
    }

    /// The 8-bit picture of the frame of floats, or of what was drawn on the screen.
    pub fn present<'a>(
        &'a mut self,
        device: &Device,
        drawn: Option<&mut Target>,
        viewport: Viewport,
        background: Background,
        into: Option<&'a Buffer<[u8; 4]>>,
    ) -> Result<&'a Buffer<[u8; 4]>, Error> {
        let Self { present, frame, rgba, .. } = self;
        let frame = match drawn {
            Some(target) => target.drawn(device)?.0,
            None => frame.at_least(device, viewport.pixels(), "the frame")?,
        };
        let rgba = or_own(into, rgba, device, viewport, "the picture")?;
        let (pixels, background) = (viewport.pixels() as i32, for_kernels(background));
        present.launch(device, (), &PresentArguments { frame, background, pixels, rgba })?;
        Ok(rgba)
    }
}

/// A displayed picture, on the host.
pub(super) fn read_displayed(device: &Device, rgba: &Buffer<[u8; 4]>, viewport: Viewport) -> Result<Vec<u8>, Error> {
    let mut picture = memory::zeroed::<[u8; 4]>("the picture", viewport.pixels())?;
    rgba.read(device, &mut picture)?;
    Ok(picture.into_flattened())
}

fn for_kernels(background: Background) -> Float4 {
    match background {
        Background::Color([r, g, b]) => Float4([r, g, b, 1.0]),
        Background::Transparent => Float4([0.0; 4]),
    }
}
