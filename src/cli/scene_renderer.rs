//! Renderer of a scene: resident, streamed or distributed, behind one interface.

use super::channels::Field;
use super::scene::OpenedScene;
use crate::camera::Camera;
#[cfg(feature = "mpi")]
use crate::distributed;
use crate::error::Error;
use crate::renderer::{Channel, LabelColors, Renderer, StreamPlan, VolumeRenderer, volume_renderer};
use crate::settings::Settings;
use crate::viewport::Viewport;

/// Renderer of a scene, by this process or by several.
pub(super) struct SceneRenderer {
    renderer: Box<dyn VolumeRenderer<'static>>,
    is_streamed: bool,
}

impl SceneRenderer {
    /// Creates the renderer. Streams the volume if `--memory` is given or the device has no buffer large enough.
    pub fn new(scene: &OpenedScene) -> Result<Self, Error> {
        let OpenedScene { device, volume, transfer, time_limit, .. } = scene;
        #[cfg(feature = "mpi")]
        if let Some(team) = scene.processes.team() {
            scene.require_one_field("several processes")?;
            let mut renderer: Box<dyn VolumeRenderer> = Box::new(distributed::Renderer::new(team, device, volume, transfer)?);
            renderer.limit(*time_limit);
            renderer.set_surfaces(&scene.surfaces)?;
            return Ok(Self { renderer, is_streamed: false });
        }
        if let Some(mut renderer) = whole_renderer(scene)? {
            renderer.limit(*time_limit);
            renderer.set_surfaces(&scene.surfaces)?;
            return Ok(Self { renderer: Box::new(renderer), is_streamed: false });
        }
        let mut renderer = volume_renderer(device, volume, transfer)?;
        renderer.limit(*time_limit);
        renderer.set_surfaces(&scene.surfaces)?;
        Ok(Self { is_streamed: renderer.whole().is_none(), renderer })
    }

    pub fn renderer(&mut self) -> &mut dyn VolumeRenderer<'static> {
        self.renderer.as_mut()
    }

    /// Stream plan of a view, also printed to standard error. `None` if the view is not streamed.
    pub fn announce(&self, camera: &Camera, viewport: Viewport, settings: &Settings) -> Result<Option<StreamPlan>, Error> {
        if !self.is_streamed {
            return Ok(None);
        }
        let plan = self.renderer.stream_plan(camera, viewport, settings)?;
        match &plan {
            Some(plan) => eprintln!("memory: {plan}"),
            None => eprintln!("memory: this view needs the whole volume on the device, where it fits"),
        }
        Ok(plan)
    }

    /// Whether the volume is streamed.
    pub fn is_streamed(&self) -> bool {
        self.is_streamed
    }
}

/// The renderer of what is not streamed: of colours and labels, of several fields, and of a field in the colours of labels.
fn whole_renderer(scene: &OpenedScene) -> Result<Option<Renderer>, Error> {
    let OpenedScene { device, volume, transfer, .. } = scene;
    let mut renderer = match &scene.shown {
        Some(shown) if !scene.has_channels() => {
            Renderer::from_colors(&shown.colors(device, &shown.upload(device)?, transfer, &scene.labels)?)?
        }
        _ if scene.has_channels() => Renderer::from_channels(&channels(scene)?)?,
        _ if scene.label_colors.is_some() => Renderer::new(device, volume, transfer)?,
        _ => return Ok(None),
    };
    if let Some(labels) = &scene.label_colors {
        renderer.set_label_colors(Some(&LabelColors::from_labels(device, labels)?))?;
    }
    Ok(Some(renderer))
}

/// The fields of a scene. Hidden ones are not uploaded, but for the first.
fn channels(scene: &OpenedScene) -> Result<Vec<Channel>, Error> {
    let OpenedScene { device, volume, transfer, look, shown, .. } = scene;
    let mut channels = look.channels(device, volume, shown.as_ref(), transfer)?;
    for Field { volume, shown, transfer, look } in scene.others.iter().filter(|field| field.is_visible()) {
        channels.extend(look.channels(device, volume, shown.as_ref(), transfer)?);
    }
    Ok(channels)
}
