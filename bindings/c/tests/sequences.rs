//! Sequences of volumes in time.

mod common;

use common::{Scene, made, ok, refused};
use layersplat_c::*;
use std::ffi::{CString, c_char};
use std::path::Path;
use std::ptr::{null, null_mut};

const SIDE: usize = 8;
const STEPS: usize = 3;

/// Writes the steps as raw files, whose largest values are 100, 101 and 102, and returns their pattern.
fn write(folder: &Path) -> CString {
    for step in 0..STEPS {
        let value = |n: usize| if n == 9 { 100 + step } else { n * (step + 7) % 100 };
        let voxels: Vec<u8> = (0..SIDE * SIDE * SIDE).map(|n| value(n) as u8).collect();
        std::fs::write(folder.join(format!("s{step}_8x8x8_uint8.raw")), voxels).unwrap();
    }
    CString::new(folder.join("s%d_8x8x8_uint8.raw").to_str().unwrap()).unwrap()
}

fn open(sources: &[CString]) -> *mut Sequence {
    let sources: Vec<*const c_char> = sources.iter().map(|source| source.as_ptr()).collect();
    // SAFETY: all arguments are alive.
    made(|out| unsafe { layersplat_sequence_open(sources.as_ptr(), sources.len(), out) })
}

fn largest(volume: *const Volume) -> f64 {
    let (mut smallest, mut largest) = (0.0, 0.0);
    // SAFETY: all arguments are alive.
    ok(unsafe { layersplat_volume_range(volume, &mut smallest, &mut largest) });
    largest
}

#[test]
fn steps_are_opened_played_and_drawn() {
    let folder = tempfile::tempdir().unwrap();
    let pattern = write(folder.path());
    let single: Vec<CString> =
        (0..STEPS).map(|n| CString::new(pattern.to_str().unwrap().replace("%d", &n.to_string())).unwrap()).collect();
    // SAFETY: all arguments are alive, and each handle is freed once.
    unsafe {
        let [sequence, files] = [open(std::slice::from_ref(&pattern)), open(&single)];
        for sequence in [sequence, files] {
            let mut length = 0;
            ok(layersplat_sequence_length(sequence, &mut length));
            assert_eq!(length, STEPS);
            for step in 0..STEPS {
                let volume = made(|out| layersplat_sequence_step(sequence, step, out));
                assert_eq!(largest(volume), 100.0 + step as f64);
                layersplat_volume_free(volume);
            }
        }
        layersplat_sequence_free(files);
        let overview = made(|out| layersplat_sequence_overview(sequence, out));
        assert_eq!(largest(overview), 102.0);
        layersplat_volume_free(overview);

        // A renderer that goes from step to step draws what renderers of single steps draw.
        let expected: Vec<Vec<f32>> = single.iter().map(|file| drawn_alone(file.to_str().unwrap())).collect();
        assert!(expected[0] != expected[1] && expected[1] != expected[2]);
        let scene = Scene::open(single[0].to_str().unwrap());
        for step in [2, 1, 0] {
            ok(layersplat_renderer_set_step(scene.renderer, sequence, step));
            assert!(scene.floats(null()) == expected[step], "{step}");
        }
        let order = [1, 1, 2, 0];
        let playback = made(|out| layersplat_sequence_play(sequence, order.as_ptr(), order.len(), out));
        layersplat_sequence_free(sequence);
        for step in order {
            let volume = made(|out| layersplat_playback_next(playback, out));
            ok(layersplat_renderer_set_volume(scene.renderer, volume));
            layersplat_volume_free(volume);
            assert!(scene.floats(null()) == expected[step], "{step}");
        }
        let mut end = std::ptr::dangling_mut();
        ok(layersplat_playback_next(playback, &mut end));
        assert!(end.is_null());
        layersplat_playback_free(playback);
    }
}

/// The picture of a file with the transfer function of the first step.
fn drawn_alone(file: &str) -> Vec<f32> {
    let scene = Scene::open(file);
    let first = Scene::open(&file.replace("s1_", "s0_").replace("s2_", "s0_"));
    // SAFETY: all arguments are alive.
    ok(unsafe { layersplat_renderer_set_transfer(scene.renderer, first.transfer) });
    scene.floats(null())
}

#[test]
fn what_is_no_sequence_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let pattern = write(folder.path());
    let other = CString::new("builtin:cube@9").unwrap();
    // SAFETY: all arguments are alive, and each handle is freed once.
    unsafe {
        let sequence = open(std::slice::from_ref(&pattern));
        let mut volume = std::ptr::dangling_mut();
        let message = refused(layersplat_sequence_step(sequence, STEPS, &mut volume), Status::InvalidArgument);
        assert!(volume.is_null() && message.contains("step"), "{message}");
        let playback = made(|out| layersplat_sequence_play(sequence, [STEPS, 0].as_ptr(), 2, out));
        refused(layersplat_playback_next(playback, &mut volume), Status::InvalidArgument);
        let first = made(|out| layersplat_playback_next(playback, out));
        assert_eq!(largest(first), 100.0);
        layersplat_volume_free(first);
        layersplat_playback_free(playback);

        let mut opened = null_mut();
        let sources = [pattern.as_ptr(), other.as_ptr()];
        let message = refused(layersplat_sequence_open(sources.as_ptr(), 2, &mut opened), Status::File);
        assert!(message.contains("9x9x9"), "{message}");
        let message = refused(layersplat_sequence_open([null()].as_ptr(), 1, &mut opened), Status::NullArgument);
        assert!(message.contains("source 0 of sources"), "{message}");
        refused(layersplat_sequence_open(null(), 0, &mut opened), Status::InvalidArgument);
        refused(layersplat_sequence_open(null(), 1, &mut opened), Status::NullArgument);
        refused(layersplat_sequence_length(sequence, null_mut()), Status::NullArgument);
        refused(layersplat_renderer_set_step(null_mut(), sequence, 0), Status::NullArgument);
        refused(layersplat_sequence_play(sequence, null(), 1, &mut null_mut()), Status::NullArgument);
        layersplat_sequence_free(sequence);
        layersplat_sequence_free(null_mut());
        layersplat_playback_free(null_mut());
    }
}
