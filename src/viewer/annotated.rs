//! Annotations of a page's pictures: those of the command's `--legend-place over`.

use super::painter::Painter;
use crate::annotation::{Annotations, Shown};
use crate::camera::Camera;
use crate::error::Error;
use crate::image::Frame;
use crate::settings::Blend;

impl Painter {
    /// The annotations of the look, if it has any.
    pub(super) fn annotations(&self) -> Option<Annotations> {
        Some(self.look.annotations(self.scene.length_units())).filter(|annotations| !annotations.is_empty())
    }

    /// Draws annotations on a finished frame.
    pub(super) fn annotated(
        &self,
        frame: Frame,
        annotations: &Annotations,
        camera: &Camera,
        blend: Blend,
    ) -> Result<Frame, Error> {
        let grid = self.scene.opening.volume.grid();
        let (transfer, background) = (self.renderer.transfer_function(), self.look.background()?);
        annotations.drawn(frame, Shown { camera, grid, transfer, blend, background })
    }
}
