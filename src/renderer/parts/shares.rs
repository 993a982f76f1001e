//! A picture into which several renderers warp lattices.

use super::super::light::LightOfParts;
use super::super::picture::{Finished, Share};
use super::super::tiles::read_samples;
use super::PartRenderer;
use super::view::LatticeView;
use crate::device::StageTimes;
use crate::error::Error;
use crate::image::Frame;

/// Picture of several lattices, each warped by a renderer that holds some of the voxels.
#[derive(Default)]
pub(crate) struct Shares {
    /// Sum of the lattices so far.
    picture: Option<Finished>,
    /// Buffer of the previous picture, for reuse.
    last: Option<(usize, Finished)>,
}

impl Shares {
    /// Begins a new picture.
    pub fn begin(&mut self) {
        self.picture = None;
    }

    /// Adds a lattice with its share of the picture; `samples` are the raw samples of all its layers. Returns the stage times, if
    /// measured.
    pub fn add(
        &mut self,
        renderer: &mut PartRenderer,
        view: &LatticeView,
        share: f64,
        samples: &[[f32; 4]],
        light: Option<&LightOfParts>,
    ) -> Result<StageTimes, Error> {
        let pixels = view.viewport.pixels();
        let added = self.picture.is_some();
        let again = self.last.take().filter(|(size, _)| *size == pixels).map(|(_, picture)| picture);
        let into = self.picture.take().or(again);
        let steps = renderer.warped(view, samples, Share { share, added }, light);
        let (picture, measured) = renderer.run(view, steps, into, |_, finished| Ok(finished.clone()))?;
        self.last = Some((pixels, picture.clone()));
        self.picture = Some(picture);
        Ok(measured.unwrap_or_default().stages)
    }

    /// The finished picture as premultiplied floats, without a background.
    pub fn frame(&mut self, renderer: &PartRenderer, view: &LatticeView) -> Result<Frame, Error> {
        let device = &renderer.engine.device;
        let picture = self.picture.as_ref().expect("a lattice was warped");
        let pixels = read_samples(picture.floats(), device, view.viewport.pixels())?;
        Ok(Frame::new(view.viewport, pixels).with_curve(view.settings.curve()))
    }
}
