//! Annotations of a page's pictures: those of the command's `--legend-place over`.

use super::drawn::CurrentLook;
use super::look::Look;
use super::painter::Painter;
use super::scene::SharedScene;
use crate::annotation::{AnnotatedView, Annotations};
use crate::camera::Camera;
use crate::error::Error;
use crate::image::Frame;
use crate::settings::Blend;

/// The annotations of a look, if it has any.
fn annotations_of(look: &Look, scene: &SharedScene) -> Result<Option<Annotations>, Error> {
    let list = if look.legend { scene.legend(look)? } else { None };
    Ok(Some(look.annotations(scene.length_units(), list)).filter(|annotations| !annotations.is_empty()))
}

/// A finished frame with the annotations and the curve of a look. `keeps_floats`: for a file of floats, which stays in linear light.
pub(super) fn annotated(
    frame: Frame,
    scene: &SharedScene,
    CurrentLook { look, transfers }: CurrentLook,
    camera: &Camera,
    blend: Blend,
    keeps_floats: bool,
) -> Result<Frame, Error> {
    let curve = scene.host.settings(look, None)?.curve();
    let Some(annotations) = annotations_of(look, scene)? else { return Ok(frame.with_curve(curve)) };
    let transfer = &transfers[0];
    let (grid, background) = (scene.opening.volume.grid(), look.background()?);
    let shown = AnnotatedView { camera, grid, transfer, blend, background };
    annotations.drawn(if keeps_floats { frame.with_curve(curve) } else { frame.coded(curve) }, shown)
}

impl Painter {
    /// Whether the look has annotations.
    pub(super) fn has_annotations(&self) -> bool {
        let Look { legend, bounding_box, axes, .. } = self.look;
        legend || bounding_box || axes
    }

    /// A finished frame with the annotations of the look.
    pub(super) fn annotated(&self, frame: Frame, camera: &Camera, blend: Blend) -> Result<Frame, Error> {
        annotated(frame, &self.scene, self.now(), camera, blend, false)
    }
}
