//! Sequences of volumes in time.

use crate::boundary::{Failure, Out, borrowed, free, guard, text, values};
use crate::{Renderer, Status, Volume, renderer};
use layersplat::OpenOptions;
use layersplat::volume;
use std::ffi::c_char;
use std::sync::{Mutex, TryLockError};

/// Volumes of one size and type in the order of time. It is immutable, and several threads may use it at the same time.
pub struct Sequence(volume::Sequence);

/// Steps of a sequence that are read ahead on a thread. Only one thread may use it at a time: concurrent calls return
/// LAYERSPLAT_STATUS_BUSY.
pub struct Playback(Mutex<volume::Playback>);

/// Opens the frames of `count` sources as one sequence. A source is what layersplat_volume_open() takes: a file with a time axis has a step
/// per frame, and a .pvd of ParaView and NAME%d.EXT have those of all their files. Only headers are read; a step is read when it is asked
/// for. All steps must have the same size and type. To be freed by layersplat_sequence_free().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_sequence_open(
    sources: *const *const c_char,
    count: usize,
    sequence: *mut *mut Sequence,
) -> Status {
    guard(|| {
        // SAFETY: upheld by the caller, here and below.
        let out = unsafe { Out::handle(sequence, "sequence") }?;
        let sources = unsafe { values(sources, count, "sources") }?;
        let source = |(n, &source): (usize, &*const c_char)| unsafe { text(source, &format!("source {n} of sources")) };
        let sources: Vec<&str> = sources.iter().enumerate().map(source).collect::<Result<_, Failure>>()?;
        out.set_handle(Sequence(volume::Sequence::open(&sources, &OpenOptions::default())?));
        Ok(())
    })
}

/// Number of steps, at least 1.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_sequence_length(sequence: *const Sequence, length: *mut usize) -> Status {
    guard(|| {
        // SAFETY: upheld by the caller, here and below.
        let steps = unsafe { borrowed(sequence, "sequence") }?.0.len();
        unsafe { Out::new(length, "length") }?.set(steps);
        Ok(())
    })
}

/// Reads a step, counted from 0. To be freed by layersplat_volume_free().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_sequence_step(sequence: *const Sequence, step: usize, volume: *mut *mut Volume) -> Status {
    guard(|| {
        // SAFETY: upheld by the caller, here and below.
        let out = unsafe { Out::handle(volume, "volume") }?;
        out.set_handle(Volume(unsafe { borrowed(sequence, "sequence") }?.0.step(step)?));
        Ok(())
    })
}

/// A volume with the values of all steps, or of 16 from the first to the last, for layersplat_transfer_automatic() and
/// layersplat_transfer_open(). It is not to be drawn. To be freed by layersplat_volume_free().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_sequence_overview(sequence: *const Sequence, volume: *mut *mut Volume) -> Status {
    guard(|| {
        // SAFETY: upheld by the caller, here and below.
        let out = unsafe { Out::handle(volume, "volume") }?;
        out.set_handle(Volume(unsafe { borrowed(sequence, "sequence") }?.0.overview()?));
        Ok(())
    })
}

/// Frees a sequence. Volumes and playbacks that were made from it stay usable. Null is ignored.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_sequence_free(sequence: *mut Sequence) {
    // SAFETY: upheld by the caller.
    unsafe { free(sequence) }
}

/// Reads a step and makes it the volume of a renderer, effective from the next frame, as layersplat_renderer_set_volume() does.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_renderer_set_step(renderer: *mut Renderer, sequence: *const Sequence, step: usize) -> Status {
    guard(|| {
        // SAFETY: upheld by the caller, here and below.
        let sequence = unsafe { borrowed(sequence, "sequence") }?;
        unsafe { renderer::with(renderer, |renderer| Ok(renderer.set_volume(&sequence.0.step(step)?)?)) }
    })
}

/// Starts to read `count` steps, in any order, on a thread of its own: each while the program uses the one before. The sequence may be freed
/// afterwards. To be freed by layersplat_playback_free().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_sequence_play(
    sequence: *const Sequence,
    steps: *const usize,
    count: usize,
    playback: *mut *mut Playback,
) -> Status {
    guard(|| {
        // SAFETY: upheld by the caller, here and below.
        let out = unsafe { Out::handle(playback, "playback") }?;
        let sequence = unsafe { borrowed(sequence, "sequence") }?;
        let steps = unsafe { values(steps, count, "steps") }?;
        out.set_handle(Playback(Mutex::new(sequence.0.play(steps.to_vec()))));
        Ok(())
    })
}

/// The next step, once it is read: a volume to be freed by layersplat_volume_free(), or null after the last one. Fails if the step cannot be
/// read; the next call returns the step after it.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_playback_next(playback: *mut Playback, volume: *mut *mut Volume) -> Status {
    guard(|| {
        // SAFETY: upheld by the caller, here and below.
        let out = unsafe { Out::handle(volume, "volume") }?;
        let playback = unsafe { borrowed(playback, "playback") }?;
        let next = match playback.0.try_lock() {
            Ok(mut playback) => playback.next(),
            Err(TryLockError::WouldBlock) => {
                return Err(Failure::new(Status::Busy, "the playback is in use by another thread"));
            }
            Err(TryLockError::Poisoned(_)) => {
                return Err(Failure::new(Status::Panic, "layersplat panicked in this playback before: free it"));
            }
        };
        if let Some(step) = next.transpose()? {
            out.set_handle(Volume(step));
        }
        Ok(())
    })
}

/// Frees a playback, after the step that is being read. Null is ignored.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_playback_free(playback: *mut Playback) {
    // SAFETY: upheld by the caller.
    unsafe { free(playback) }
}
