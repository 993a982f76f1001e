//! Draws frames with the library.

use crate::camera::View;
use crate::colors::{Background, Pixels};
use crate::field::FieldKey;
use crate::objects::Handle;
use crate::types::DataType;
use crate::volume::Shown;
use anari_sys::ANARI_UFIXED8_VEC4;
use layersplat::glam::DAffine3;
use layersplat::renderer::{Accumulation, VolumeRenderer, volume_renderer};
use layersplat::settings::Settings;
use layersplat::{Cancel, Device, DeviceChoice, Error, Frame, TransferFunction, Viewport};
use std::sync::{Arc, Mutex, PoisonError};

/// A frame to draw.
pub struct Picture {
    pub viewport: Viewport,
    pub view: View,
    pub settings: Settings,
    /// `None`: the background alone.
    pub shown: Option<Shown>,
    pub background: Background,
    /// Type of the colours, if they are asked for.
    pub color: Option<DataType>,
    pub has_depth: bool,
    pub has_ids: bool,
    /// Rays per pixel.
    pub samples: u32,
    /// Earlier frames of the same scene, if frames are averaged.
    pub accumulated: Option<Arc<Mutex<Option<Accumulated>>>>,
}

/// The mean of frames of one scene.
pub struct Accumulated {
    scene: Scene,
    mean: Accumulation,
}

/// All that the colours of a frame depend on, without the background.
#[derive(Clone, PartialEq)]
struct Scene {
    viewport: Viewport,
    view: View,
    settings: Settings,
    field: FieldKey,
    placement: DAffine3,
    transfer: TransferFunction,
}

/// The channels of a drawn frame, row by row from the bottom.
#[derive(Debug)]
pub struct Channels {
    pub viewport: Viewport,
    pub color: Option<Pixels>,
    pub depth: Option<Vec<f32>>,
    pub ids: Option<Vec<u32>>,
    /// Share of the frames that are averaged.
    pub refinement: f32,
}

/// Id of pixels without an object.
const NO_OBJECT: u32 = u32::MAX;

/// Largest number of renderers, each with its voxels on the device.
const KEPT: usize = 4;

/// Renderers of the fields that were drawn last. The device is opened for the first frame.
#[derive(Default)]
pub struct Painter {
    device: Option<Device>,
    kept: Vec<Kept>,
}

type Renderer = dyn VolumeRenderer<'static> + Send;

/// A renderer and what it was made for.
struct Kept {
    field: FieldKey,
    placement: DAffine3,
    renderer: Box<Renderer>,
}

impl Painter {
    /// Draws a frame.
    ///
    /// # Errors
    /// Those of the library, and [`Error::Cancelled`].
    pub fn draw(&mut self, picture: &Picture, cancel: &Cancel) -> Result<Channels, Error> {
        let Some(shown) = &picture.shown else { return Ok(picture.blank()) };
        let renderer = self.renderer(shown)?;
        renderer.set_cancel(Some(cancel.clone()));
        let (color, refinement) = picture.colors(renderer, shown)?;
        let depth = if picture.has_depth || picture.has_ids { Some(picture.depths(renderer)?) } else { None };
        let ids = depth
            .as_ref()
            .filter(|_| picture.has_ids)
            .map(|depths| depths.iter().map(|depth| if depth.is_finite() { shown.id } else { NO_OBJECT }).collect());
        Ok(Channels { viewport: picture.viewport, color, depth: depth.filter(|_| picture.has_depth), ids, refinement })
    }

    /// Forgets what was made from an array, whose memory goes.
    pub fn forget(&mut self, array: Handle) {
        self.kept.retain(|kept| kept.field.array != array);
    }

    /// Forgets what was made from fields that are gone.
    pub fn forget_fields(&mut self, fields: &[Handle]) {
        self.kept.retain(|kept| !fields.contains(&kept.field.field));
    }

    /// Number of renderers, each with its voxels on the device.
    #[cfg(test)]
    pub fn count(&self) -> usize {
        self.kept.len()
    }

    /// The renderer of a volume, with its transfer function.
    fn renderer(&mut self, shown: &Shown) -> Result<&mut Renderer, Error> {
        let is_same = |kept: &Kept| kept.field == shown.field.key && kept.placement == shown.placement;
        let kept = match self.kept.iter().position(is_same) {
            Some(place) => self.kept.remove(place),
            None => self.make(shown)?,
        };
        self.kept.push(kept);
        let renderer = &mut self.kept.last_mut().expect("it was pushed").renderer;
        if *renderer.transfer_function() != shown.transfer {
            renderer.set_transfer_function(&shown.transfer);
        }
        Ok(renderer.as_mut())
    }

    /// A renderer for a volume: one whose voxels are out of date, or a new one.
    fn make(&mut self, shown: &Shown) -> Result<Kept, Error> {
        let volume = shown.field.volume(shown.placement)?;
        let (field, placement) = (shown.field.key, shown.placement);
        let is_stale = |kept: &Kept| kept.field.field == field.field;
        let stale = self.kept.iter().position(is_stale).or((self.kept.len() == KEPT).then_some(0));
        if let Some(place) = stale {
            let Kept { mut renderer, .. } = self.kept.remove(place);
            if renderer.set_volume(&volume).is_ok() {
                return Ok(Kept { field, placement, renderer });
            }
        }
        let device = match &self.device {
            Some(device) => device,
            None => self.device.insert(Device::open(&DeviceChoice::Default)?),
        };
        let renderer = match volume_renderer(device, &volume, &shown.transfer) {
            Err(_) if !self.kept.is_empty() => {
                self.kept.clear();
                volume_renderer(device, &volume, &shown.transfer)?
            }
            renderer => renderer?,
        };
        Ok(Kept { field, placement, renderer })
    }
}

/// Only distributed renderers return no picture.
const ONE_PROCESS: &str = "a single-process renderer returns the picture";

impl Picture {
    /// The background alone.
    pub fn blank(&self) -> Channels {
        let count = self.viewport.pixels();
        let color =
            self.color.map(|format| Pixels::new(format, &vec![[0.0; 4]; count], self.viewport.width as usize, &self.background));
        let depth = self.has_depth.then(|| vec![f32::INFINITY; count]);
        let ids = self.has_ids.then(|| vec![NO_OBJECT; count]);
        Channels { viewport: self.viewport, color, depth, ids, refinement: 1.0 }
    }

    /// The colours, and the share of averaged frames.
    fn colors(&self, renderer: &mut Renderer, shown: &Shown) -> Result<(Option<Pixels>, f32), Error> {
        let Some(format) = self.color else { return Ok((None, 1.0)) };
        let width = self.viewport.width as usize;
        let is_plain = self.view.part.is_none() && self.samples == 1 && self.accumulated.is_none();
        if let (true, ANARI_UFIXED8_VEC4, Some(color)) = (is_plain, format, self.background.opaque()) {
            let background = layersplat::Background::Color(color);
            let (bytes, _) = renderer.render_rgba8(&self.view.camera, self.viewport, &self.settings, background)?;
            return Ok((Some(Pixels::from_rgba8(&bytes.expect(ONE_PROCESS), width)), 1.0));
        }
        let (frame, refinement) = self.frame(renderer, shown)?;
        Ok((Some(Pixels::new(format, frame.pixels(), width, &self.background)), refinement))
    }

    /// The volume without a background.
    fn frame(&self, renderer: &mut Renderer, shown: &Shown) -> Result<(Frame, f32), Error> {
        let (camera, settings) = (&self.view.camera, &self.settings);
        if let Some(part) = &self.view.part {
            let [columns, rows] = [part.columns.clone(), part.rows.clone()];
            let whole = renderer.require_whole("an imageRegion of a perspective")?;
            return Ok((whole.render_part(camera, part.whole, [columns, rows], settings)?.0, 1.0));
        }
        if let Some(accumulated) = &self.accumulated {
            let mut accumulated = accumulated.lock().unwrap_or_else(PoisonError::into_inner);
            return self.accumulate(renderer, self.scene(shown), &mut accumulated);
        }
        if self.samples > 1 {
            let mut mean = Accumulation::new(self.viewport)?;
            while mean.frames() < self.samples {
                renderer.accumulate(camera, settings, &mut mean)?;
            }
            return Ok((mean.mean()?, 1.0));
        }
        let (frame, _) = renderer.render(camera, self.viewport, settings)?;
        Ok((frame.expect(ONE_PROCESS), 1.0))
    }

    fn scene(&self, shown: &Shown) -> Scene {
        Scene {
            viewport: self.viewport,
            view: self.view.clone(),
            settings: self.settings,
            field: shown.field.key,
            placement: shown.placement,
            transfer: shown.transfer.clone(),
        }
    }

    /// Adds a frame to those of the same scene, until there is one for each place in a pixel.
    fn accumulate(
        &self,
        renderer: &mut Renderer,
        scene: Scene,
        accumulated: &mut Option<Accumulated>,
    ) -> Result<(Frame, f32), Error> {
        let kept = match accumulated.take_if(|accumulated| accumulated.scene != scene) {
            None if accumulated.is_some() => accumulated.as_mut().expect("it was tested"),
            _ => accumulated.insert(Accumulated { scene, mean: Accumulation::new(self.viewport)? }),
        };
        for _ in 0..self.samples {
            if kept.mean.frames() < Accumulation::FRAMES {
                renderer.accumulate(&self.view.camera, &self.settings, &mut kept.mean)?;
            }
        }
        Ok((kept.mean.mean()?, kept.mean.frames() as f32 / Accumulation::FRAMES as f32))
    }

    /// Distances from the camera along rays, row by row from the bottom.
    fn depths(&self, renderer: &mut Renderer) -> Result<Vec<f32>, Error> {
        let part = self.view.part.as_ref();
        let whole = part.map_or(self.viewport, |part| part.whole);
        let depths = renderer.depths(&self.view.camera, whole, &self.settings)?;
        let stretch = self.view.stretch(whole);
        let columns = part.map_or(0..whole.width, |part| part.columns.clone());
        let rows = part.map_or(0..whole.height, |part| part.rows.clone());
        let at = |row: u32, column: u32| {
            let depth = depths.first()[row as usize * whole.width as usize + column as usize];
            (f64::from(depth) * stretch(column, row)) as f32
        };
        Ok(rows
            .rev()
            .flat_map(|row| columns.clone().map(move |column| (row, column)))
            .map(|(row, column)| at(row, column))
            .collect())
    }
}
