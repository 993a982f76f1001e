//! Composited layers become pictures.

use super::super::picture::{OntoScreen, Picture, Share};
use super::super::range::LayerRange;
use super::super::tiles::read_samples;
use super::PartRenderer;
use super::view::LatticeView;
use crate::error::Error;
use crate::image::Frame;

/// A picture that several lattices are warped into, each by a renderer that holds voxels for it.
#[derive(Default)]
pub(crate) struct Shares {
    picture: Picture,
    added: bool,
}

impl Shares {
    /// In a picture's own buffer.
    pub(super) fn of(picture: Picture) -> Self {
        Self { picture, added: false }
    }

    pub(super) fn into_picture(self) -> Picture {
        self.picture
    }

    /// Begins another picture.
    #[cfg(feature = "mpi")]
    pub fn begin(&mut self) {
        self.added = false;
    }

    /// Warps the samples of all layers of a lattice, with its share of the picture.
    pub fn add(
        &mut self,
        renderer: &mut PartRenderer,
        view: &LatticeView,
        share: f64,
        samples: &[[f32; 4]],
    ) -> Result<(), Error> {
        renderer.draw(view, &LayerRange::end(), Some(samples))?;
        let device = renderer.0.device.clone();
        let onto = OntoScreen { lattice: &view.lattice, rays: &view.rays, viewport: view.viewport };
        let share = Share { share, added: std::mem::replace(&mut self.added, true) };
        self.picture.warp(&device, &mut renderer.0.target, onto, share, None)?;
        Ok(())
    }

    /// The picture of all: premultiplied floats, without a background.
    pub fn frame(&mut self, renderer: &PartRenderer, view: &LatticeView) -> Result<Frame, Error> {
        let device = &renderer.0.device;
        let warped = self.picture.warped(device, view.viewport)?;
        Ok(Frame::new(view.viewport, read_samples(warped, device, view.viewport.pixels())?))
    }
}
