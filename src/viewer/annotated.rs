//! Annotations of a page's pictures: those of the command's `--legend-place over`.

use super::look::Look;
use super::painter::Painter;
use super::scene::Scene;
use crate::annotation::{Annotations, Shown};
use crate::camera::Camera;
use crate::error::Error;
use crate::image::Frame;
use crate::settings::Blend;
use crate::transfer::TransferFunction;

/// The annotations of a look, if it has any.
fn annotations_of(look: &Look, scene: &Scene) -> Option<Annotations> {
    Some(look.annotations(scene.length_units())).filter(|annotations| !annotations.is_empty())
}

/// A finished frame with the annotations of a look.
pub(super) fn annotated(
    frame: Frame,
    scene: &Scene,
    (look, transfer): (&Look, &TransferFunction),
    camera: &Camera,
    blend: Blend,
) -> Result<Frame, Error> {
    let Some(annotations) = annotations_of(look, scene) else { return Ok(frame) };
    let (grid, background) = (scene.opening.volume.grid(), look.background()?);
    annotations.drawn(frame, Shown { camera, grid, transfer, blend, background })
}

impl Painter {
    /// Whether the look has annotations.
    pub(super) fn has_annotations(&self) -> bool {
        annotations_of(&self.look, &self.scene).is_some()
    }

    /// A finished frame with the annotations of the look.
    pub(super) fn annotated(&self, frame: Frame, camera: &Camera, blend: Blend) -> Result<Frame, Error> {
        annotated(frame, &self.scene, (&self.look, self.renderer.transfer_function()), camera, blend)
    }
}
