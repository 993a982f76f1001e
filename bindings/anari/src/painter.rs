//! Draws frames with the library.

use crate::camera::View;
use crate::colors::{Background, Pixels};
use crate::handle::Handle;
use crate::kept::{Kept, Renderer, Renderers};
use crate::types::DataType;
use crate::volume::{DrawnVolume, Place};
use anari_sys::{ANARI_FLOAT32_VEC4, ANARI_UFIXED8_VEC4};
use layersplat::renderer::Accumulation;
use layersplat::settings::Settings;
use layersplat::{Cancel, Error, Frame, TransferFunction, Viewport};
use std::sync::{Arc, Mutex, PoisonError};

/// A frame to draw.
pub struct Picture {
    pub viewport: Viewport,
    pub view: View,
    pub settings: Settings,
    /// Volumes that are drawn together; none: the background alone.
    pub shown: Vec<DrawnVolume>,
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
    key: AccumulationKey,
    mean: Accumulation,
}

/// All that the colours of a frame depend on, without the background.
#[derive(Clone, PartialEq)]
struct AccumulationKey {
    viewport: Viewport,
    view: View,
    settings: Settings,
    /// Places, transfer functions and unit distances.
    volumes: Vec<(Place, TransferFunction, f64)>,
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

/// Draws with renderers that stay from frame to frame.
#[derive(Default)]
pub struct Painter {
    renderers: Renderers,
}

impl Painter {
    /// Draws a frame.
    ///
    /// # Errors
    /// Those of the library, and [`Error::Cancelled`].
    pub fn draw(&mut self, picture: &Picture, cancel: &Cancel) -> Result<Channels, Error> {
        if picture.shown.is_empty() {
            return Ok(picture.blank());
        }
        let kept = self.renderers.get(&picture.shown)?;
        kept.renderer.set_cancel(Some(cancel.clone()));
        picture.channels(kept)
    }

    /// Forgets what was made from an array, whose memory goes.
    pub fn forget(&mut self, array: Handle) {
        self.renderers.forget(array);
    }

    /// Forgets what was made from fields that are gone.
    pub fn forget_fields(&mut self, fields: &[Handle]) {
        self.renderers.forget_fields(fields);
    }

    /// Number of renderers, each with its voxels on the device.
    #[cfg(test)]
    pub fn count(&self) -> usize {
        self.renderers.count()
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

    /// Everything that is asked for.
    fn channels(&self, kept: &mut Kept) -> Result<Channels, Error> {
        let (color, refinement) = self.colors(kept.renderer.as_mut())?;
        let has_depth = self.has_depth || self.has_ids;
        let depth = if has_depth { Some(self.depths(kept.renderer.as_mut())?) } else { None };
        let ids = match &depth {
            Some(depth) if self.has_ids => Some(self.ids(kept, depth)?),
            _ => None,
        };
        Ok(Channels { viewport: self.viewport, color, depth: depth.filter(|_| self.has_depth), ids, refinement })
    }

    /// The colours, and the share of averaged frames.
    fn colors(&self, renderer: &mut Renderer) -> Result<(Option<Pixels>, f32), Error> {
        let Some(format) = self.color else { return Ok((None, 1.0)) };
        let width = self.viewport.width as usize;
        let is_plain = self.view.part.is_none() && self.samples == 1 && self.accumulated.is_none();
        if let (true, ANARI_UFIXED8_VEC4, Some(color)) = (is_plain, format, self.background.opaque()) {
            let background = layersplat::Background::Color(color);
            let (bytes, _) = renderer.render_rgba8(&self.view.camera, self.viewport, &self.settings, background)?;
            return Ok((Some(Pixels::from_rgba8(&bytes.expect(ONE_PROCESS), width)), 1.0));
        }
        let (frame, refinement) = self.frame(renderer)?;
        let frame = if format == ANARI_FLOAT32_VEC4 { frame } else { frame.with_curve(self.settings.curve()) };
        Ok((Some(Pixels::new(format, frame.curved().pixels(), width, &self.background)), refinement))
    }

    /// The volumes without a background.
    fn frame(&self, renderer: &mut Renderer) -> Result<(Frame, f32), Error> {
        let (camera, settings) = (&self.view.camera, &self.settings);
        if let Some(part) = &self.view.part {
            let [columns, rows] = [part.columns.clone(), part.rows.clone()];
            let whole = renderer.require_whole("an imageRegion of a perspective")?;
            return Ok((whole.render_part(camera, part.whole, [columns, rows], settings)?.0, 1.0));
        }
        if let Some(accumulated) = &self.accumulated {
            let mut accumulated = accumulated.lock().unwrap_or_else(PoisonError::into_inner);
            return self.accumulate(renderer, self.accumulation_key(), &mut accumulated);
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

    fn accumulation_key(&self) -> AccumulationKey {
        let volume = |shown: &DrawnVolume| (shown.place(), shown.transfer.clone(), shown.unit_distance);
        AccumulationKey {
            viewport: self.viewport,
            view: self.view.clone(),
            settings: self.settings,
            volumes: self.shown.iter().map(volume).collect(),
        }
    }

    /// Adds a frame to those of the same scene, until there is one for each place in a pixel.
    fn accumulate(
        &self,
        renderer: &mut Renderer,
        key: AccumulationKey,
        accumulated: &mut Option<Accumulated>,
    ) -> Result<(Frame, f32), Error> {
        let kept = match accumulated.take_if(|accumulated| accumulated.key != key) {
            None if accumulated.is_some() => accumulated.as_mut().expect("it was tested"),
            _ => accumulated.insert(Accumulated { key, mean: Accumulation::new(self.viewport)? }),
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

    /// Ids, where there is a depth: of the volume that alone would have the nearest one; of the first, if none would have any.
    fn ids(&self, kept: &mut Kept, depths: &[f32]) -> Result<Vec<u32>, Error> {
        let mut nearest = vec![(f32::INFINITY, self.shown[0].id); depths.len()];
        for which in (0..self.shown.len()).filter(|_| self.shown.len() > 1) {
            kept.show_only(&self.shown, which)?;
            let own = self.depths(kept.renderer.as_mut())?;
            for (nearest, depth) in nearest.iter_mut().zip(own).filter(|(nearest, depth)| *depth < nearest.0) {
                *nearest = (depth, self.shown[which].id);
            }
        }
        let id = |(&depth, (_, id)): (&f32, (f32, u32))| if depth.is_finite() { id } else { NO_OBJECT };
        Ok(depths.iter().zip(nearest).map(id).collect())
    }
}
