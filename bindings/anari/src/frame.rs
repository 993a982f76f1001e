//! Frames: from the scene to a picture, and their state.

use crate::camera::View;
use crate::handle::Handle;
use crate::objects::{Object, Objects};
use crate::painter::{Accumulated, Channels, Picture};
use crate::renderer::RendererSettings;
use crate::status::Problem;
use crate::worker::locked;
use crate::world;
use anari_sys::ANARI_UINT32_VEC2;
use layersplat::{Cancel, Viewport};
use std::ffi::{CStr, CString};
use std::sync::{Arc, Condvar, Mutex, PoisonError};

/// What a frame has beside parameters.
#[derive(Default)]
pub struct FrameState {
    /// The last frame that was begun.
    pub task: Option<Arc<Task>>,
    /// Channels that are mapped, by name.
    pub mapped: Vec<(CString, Arc<Channels>)>,
    pub accumulated: Arc<Mutex<Option<Accumulated>>>,
    /// The problems of the last frame, which are told once.
    pub told: Vec<Problem>,
}

/// A frame that is being drawn, or was.
#[derive(Default)]
pub struct Task {
    state: Mutex<TaskState>,
    changed: Condvar,
    pub cancel: Cancel,
}

#[derive(Default)]
struct TaskState {
    phase: Phase,
    channels: Option<Arc<Channels>>,
    /// Seconds.
    duration: f32,
}

/// Progress of a frame.
#[derive(Clone, Copy, Default, PartialEq, PartialOrd)]
pub enum Phase {
    #[default]
    Waiting,
    /// The channels can be mapped; the callback may still run.
    Drawn,
    Finished,
}

impl Task {
    /// Stores the channels.
    pub fn draw(&self, channels: Option<Channels>, duration: f32) {
        let mut state = locked(&self.state);
        (state.phase, state.channels, state.duration) = (Phase::Drawn, channels.map(Arc::new), duration);
        self.changed.notify_all();
    }

    /// Ends the frame, after its callback.
    pub fn finish(&self) {
        locked(&self.state).phase = Phase::Finished;
        self.changed.notify_all();
    }

    /// Whether the frame got so far.
    pub fn has_reached(&self, phase: Phase) -> bool {
        locked(&self.state).phase >= phase
    }

    /// Waits until the frame gets so far.
    pub fn wait(&self, phase: Phase) {
        let mut state = locked(&self.state);
        while state.phase < phase {
            state = self.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
    }

    pub fn channels(&self) -> Option<Arc<Channels>> {
        locked(&self.state).channels.clone()
    }

    pub fn duration(&self) -> f32 {
        locked(&self.state).duration
    }
}

/// The picture of a frame's scene as it is now. `accumulated`: earlier frames. Problems are what is drawn otherwise than it was asked for.
///
/// # Errors
/// Frames without a valid size, which have no pixels.
pub fn picture(
    objects: &Objects,
    handle: Handle,
    accumulated: Arc<Mutex<Option<Accumulated>>>,
    problems: &mut Vec<Problem>,
) -> Result<Picture, Problem> {
    let frame = objects.known(handle)?;
    let viewport = viewport(frame)?;
    let mut required = |name: &CStr| {
        let found = frame.object(name).and_then(|handle| objects.get(handle)).filter(|object| object.class.is_supported());
        if found.is_none() {
            let text = format!("the frame has no {}: the background is drawn", name.to_string_lossy());
            problems.push(Problem::argument(text));
        }
        found
    };
    let [world, camera, renderer] = [c"world", c"camera", c"renderer"].map(&mut required);
    let lights = world.and_then(|world| world::lights(objects, world, problems));
    let shown = world.map(|world| world::shown(objects, world, problems)).unwrap_or_default();
    let view = camera.and_then(|camera| View::from_object(camera, viewport, problems).map_err(|p| problems.push(p)).ok());
    let look =
        renderer.map(|renderer| RendererSettings::from_object(objects, renderer, lights, &shown, problems)).unwrap_or_default();
    let is_complete = view.is_some() && renderer.is_some();
    let view = view.unwrap_or_default();
    let mut settings = look.settings;
    settings.clipping = view.clipping;
    settings.pixel_aspect = view.pixel_aspect;
    settings.clipping.crop = shown.first().filter(|_| look.clips_to_bounds).map(|shown| shown.field.crop_box());
    // Others have factors to theirs.
    settings.unit_distance = shown.first().map(|shown| shown.unit_distance);
    Ok(Picture {
        viewport,
        view,
        settings,
        shown: if is_complete { shown } else { Vec::new() },
        background: look.background,
        color: frame.integer(c"channel.color"),
        has_depth: frame.integer(c"channel.depth").is_some(),
        has_ids: frame.integer(c"channel.objectId").is_some(),
        samples: look.samples,
        accumulated: frame.is_set(c"accumulation").then_some(accumulated),
    })
}

/// The size of a frame.
fn viewport(frame: &Object) -> Result<Viewport, Problem> {
    let none = || Problem::argument("the frame has no size: it is not drawn");
    let bytes = frame.bytes_of(c"size", ANARI_UINT32_VEC2).ok_or_else(none)?;
    let sides = bytes.as_chunks::<4>().0;
    let [width, height] = [0, 1].map(|side| u32::from_ne_bytes(sides[side]));
    Viewport::new(width, height).map_err(|error| Problem::argument(format!("the frame is not drawn: {error}")))
}
