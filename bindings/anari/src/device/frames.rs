//! Calls on frames.

use super::Device;
use crate::frame::{self, Phase, Task};
use crate::handle::Handle;
use crate::objects::Objects;
use crate::painter::{Channels, Painter, Picture};
use crate::status::{Problem, Reporter};
use crate::types::DataType;
use crate::warnings::gathered;
use anari_sys::{ANARI_FLOAT32, ANARI_FRAME, ANARI_UINT32};
use layersplat::Error;
use std::ffi::{CStr, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::time::Instant;

/// Draws a frame. Where that fails, the channels are those of the background.
fn drawn(painter: &mut Painter, picture: &Picture, task: &Task) -> (Channels, Option<Problem>) {
    if task.cancel.is_cancelled() {
        return (picture.blank(), None);
    }
    // Unwind safety: after a panic the painter is made anew.
    match catch_unwind(AssertUnwindSafe(|| painter.draw(picture, &task.cancel))) {
        Ok(Ok(channels)) => (channels, None),
        Ok(Err(Error::Cancelled { .. })) => (picture.blank(), None),
        Ok(Err(error)) => (picture.blank(), Some(Problem::drawing(error.to_string()))),
        Err(panic) => {
            *painter = Painter::default();
            (picture.blank(), Some(Problem::panic(&*panic)))
        }
    }
}

/// The application's function for completed frames.
type Completed = unsafe extern "C" fn(user: *const c_void, device: usize, frame: usize);

/// A mapped channel.
pub struct MappedChannel {
    pub pixels: *const c_void,
    pub size: [u32; 2],
    pub data_type: DataType,
}

/// What a frame does after it is drawn.
struct Completion {
    frame: Handle,
    function: Option<Completed>,
    user: usize,
    reporter: Reporter,
}

impl Device {
    /// The last frame that was begun of this object.
    pub fn task(&self, handle: Handle) -> Option<Arc<Task>> {
        self.call(|state| state.frames.get(&handle)?.task.clone())
    }

    /// Cancels a frame and waits for it, unless its own callback asks for that.
    pub fn end(&self, task: &Task) {
        task.cancel.cancel();
        if !self.worker.is_current() {
            task.wait(Phase::Finished);
        }
    }

    /// Begins to draw a frame, after the one before.
    pub fn render(&self, handle: Handle) {
        if let Some(task) = self.task(handle).filter(|_| !self.worker.is_current()) {
            task.wait(Phase::Finished);
        }
        let begun = self.try_call(handle, |state| {
            let not_a_frame = || Problem::operation("only frames are rendered");
            let accumulated = state.frame(handle)?.ok_or_else(not_a_frame)?.accumulated.clone();
            let mut problems = Vec::new();
            let picture = frame::picture(&state.objects, handle, accumulated, &mut problems);
            let reporter = state.reporter();
            let (picture, completion) = match picture {
                Ok(picture) => (Some(picture), completion(&state.objects, handle, reporter)),
                Err(problem) => {
                    problems.push(problem);
                    (None, None)
                }
            };
            let task = picture.is_some().then(|| Arc::new(Task::default()));
            let Some(frame) = state.frame(handle)? else { return Ok(None) };
            frame.task = task.clone();
            if frame.told != problems {
                frame.told = problems.clone();
                problems.into_iter().for_each(|problem| state.tell(handle, problem));
            }
            Ok(picture.zip(task).zip(completion))
        });
        if let Some(((picture, task), completion)) = begun {
            self.push(picture, task, completion);
        }
    }

    fn push(&self, picture: Picture, task: Arc<Task>, completion: Completion) {
        self.worker.push(Box::new(move |painter| {
            let started = Instant::now();
            let ((channels, problem), warnings) = gathered(|| drawn(painter, &picture, &task));
            let problems = warnings.into_iter().map(Problem::argument).chain(problem).collect();
            // The memory of arrays is given back before anyone learns that the frame is drawn.
            drop(picture);
            task.draw(Some(channels), started.elapsed().as_secs_f32());
            Box::new(move || {
                completion.run(problems);
                task.finish();
            })
        }));
    }

    /// Whether the last frame is complete; with `waits`, waits for it first.
    pub fn is_ready(&self, handle: Handle, waits: bool) -> bool {
        self.try_call(handle, |state| state.objects.known(handle).map(|_| ()));
        let Some(task) = self.task(handle) else { return true };
        if !waits {
            return task.has_reached(Phase::Drawn);
        }
        // A callback of a frame would wait for itself.
        task.wait(if self.worker.is_current() { Phase::Drawn } else { Phase::Finished });
        true
    }

    /// Cancels the last frame.
    pub fn discard(&self, handle: Handle) {
        if let Some(task) = self.task(handle) {
            task.cancel.cancel();
        }
    }

    /// Maps a channel, after the frame is drawn.
    pub fn map_channel(&self, handle: Handle, name: &CStr) -> Option<MappedChannel> {
        if let Some(task) = self.task(handle) {
            task.wait(Phase::Drawn);
        }
        self.try_call(handle, |state| {
            let frame = state.frame(handle)?.ok_or_else(|| Problem::operation("only frames have channels"))?;
            let channels = frame.task.as_ref().and_then(|task| task.channels());
            let channels = channels.ok_or_else(|| Problem::operation("the frame was not rendered: it has no channels"))?;
            let mapped = mapped(&channels, name).ok_or_else(|| {
                let name = name.to_string_lossy();
                Problem::argument(format!("{name} cannot be mapped: set it as a parameter and render the frame"))
            })?;
            frame.mapped.push((name.into(), channels));
            Ok(Some(mapped))
        })
    }

    /// Unmaps a channel.
    pub fn unmap_channel(&self, handle: Handle, name: &CStr) {
        self.try_call(handle, |state| {
            let Some(frame) = state.frame(handle)? else { return Ok(()) };
            if let Some(place) = frame.mapped.iter().position(|(mapped, _)| mapped.as_c_str() == name) {
                frame.mapped.swap_remove(place);
            }
            Ok(())
        });
    }
}

fn completion(objects: &Objects, handle: Handle, reporter: Reporter) -> Option<Completion> {
    let frame = objects.get(handle)?;
    let address = frame.pointer(c"frameCompletionCallback");
    // SAFETY: the application says that it is a function of this type; null is none.
    let function = unsafe { std::mem::transmute::<usize, Option<Completed>>(address) };
    Some(Completion { frame: handle, function, user: frame.pointer(c"frameCompletionCallbackUserData"), reporter })
}

impl Completion {
    fn run(self, problems: Vec<Problem>) {
        for problem in problems {
            self.reporter.report(&problem.of(self.frame, ANARI_FRAME));
        }
        if let Some(function) = self.function {
            // SAFETY: the application gave the function and its argument for this call.
            unsafe { function(self.user as *const c_void, self.reporter.device, self.frame.0) }
        }
    }
}

fn mapped(channels: &Channels, name: &CStr) -> Option<MappedChannel> {
    let (data_type, pixels): (DataType, *const c_void) = match name.to_bytes() {
        b"channel.color" => {
            let (data_type, pixels) = channels.color.as_ref()?.mapped();
            (data_type, pixels.cast())
        }
        b"channel.depth" => (ANARI_FLOAT32, channels.depth.as_ref()?.as_ptr().cast()),
        b"channel.objectId" => (ANARI_UINT32, channels.ids.as_ref()?.as_ptr().cast()),
        _ => return None,
    };
    Some(MappedChannel { pixels, size: [channels.viewport.width, channels.viewport.height], data_type })
}
