//! Slices of the C functions are bit-identical to those of the library.

mod common;

use common::{FLOATS, HEIGHT, SOURCE, Scene, WIDTH, made, ok, refused};
use layersplat::slice::{Slice as LibrarySlice, SliceAxis, SliceColors as LibraryColors};
use layersplat::{DeviceChoice, Kernel, OpenOptions, TransferFunction, Viewport};
use layersplat_c::*;
use std::mem::MaybeUninit;
use std::ptr::null;

fn slice_at(volume: *const Volume, axis: SliceAxisChoice, at: f64) -> Slice {
    let mut slice = MaybeUninit::uninit();
    // SAFETY: all arguments are alive, and the call initialises the struct.
    unsafe {
        ok(layersplat_slice_at(volume, axis as i32, at, WIDTH, HEIGHT, slice.as_mut_ptr()));
        slice.assume_init()
    }
}

#[test]
fn slices_have_the_bits_of_the_library() {
    let scene = Scene::new();
    let volume = layersplat::Volume::open(SOURCE, &OpenOptions::default()).unwrap();
    let device = layersplat::Device::open(&DeviceChoice::Default).unwrap();
    let mut renderer = layersplat::Renderer::new(&device, &volume, &TransferFunction::automatic(&volume)).unwrap();
    let viewport = Viewport::new(WIDTH, HEIGHT).unwrap();
    let slice = slice_at(scene.volume, SliceAxisChoice::Y, 8.25);
    let expected = LibrarySlice::at(volume.grid(), SliceAxis::Y, 8.25, viewport).unwrap();
    assert_eq!((slice.centre, slice.scale), (expected.centre.to_array(), expected.scale));
    assert_eq!(slice_at(scene.volume, SliceAxisChoice::X, f64::NAN), slice_at(scene.volume, SliceAxisChoice::X, 9.5));
    let given = |window_level, window_width, thickness| SliceColors { window_level, window_width, thickness };
    for (colors, library) in [
        (None, LibraryColors::TRANSFER),
        (Some(given(0.0, 0.0, 2.0)), LibraryColors::Transfer { thickness: 2.0 }),
        (Some(given(70.0, 90.0, 0.0)), LibraryColors::Window { level: 70.0, width: 90.0 }),
    ] {
        let frame = renderer.slice(&expected, viewport, Kernel::CatmullRom, library).unwrap();
        let mut pixels = vec![-1.0f32; FLOATS + 1];
        // SAFETY: all arguments are alive.
        ok(unsafe {
            let (pointer, count) = (pixels.as_mut_ptr(), pixels.len());
            let colors = colors.as_ref().map_or(null(), |colors| colors as *const SliceColors);
            layersplat_render_slice(
                scene.renderer,
                &slice,
                WIDTH,
                HEIGHT,
                KernelChoice::CatmullRom as i32,
                colors,
                pointer,
                count,
            )
        });
        assert!(pixels[..FLOATS] == *frame.pixels().as_flattened() && pixels[FLOATS] == -1.0, "{library:?}");
    }
    let found = renderer.slice_values(&expected, viewport, Kernel::Linear).unwrap();
    let mut values = vec![-1.0f32; viewport.pixels()];
    // SAFETY: all arguments are alive.
    ok(unsafe { layersplat_slice_values(scene.renderer, &slice, WIDTH, HEIGHT, 0, values.as_mut_ptr(), values.len()) });
    let bits = |values: &[f32]| values.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
    assert!(bits(&values) == bits(found.values()) && values.iter().any(|v| *v > 0.0));
}

#[test]
fn any_plane_has_a_slice() {
    let scene = Scene::new();
    let (point, normal, up) = ([9.5; 3], [1.0, 1.0, 0.5], [0.0, 1.0, 0.0]);
    let mut slice = MaybeUninit::<Slice>::uninit();
    // SAFETY: all arguments are alive.
    let mut facing = |normal: *const f64, up: *const f64| unsafe {
        layersplat_slice_facing(scene.volume, point.as_ptr(), normal, up, WIDTH, HEIGHT, slice.as_mut_ptr())
    };
    ok(facing(normal.as_ptr(), up.as_ptr()));
    assert!(refused(facing(normal.as_ptr(), normal.as_ptr()), Status::InvalidArgument).contains("span no plane"));
    assert!(refused(facing(null(), up.as_ptr()), Status::NullArgument).contains("normal"));
}

#[test]
fn bad_arguments_are_refused() {
    let scene = Scene::new();
    let slice = slice_at(scene.volume, SliceAxisChoice::Z, 5.0);
    let mut pixels = vec![0.0f32; FLOATS];
    // SAFETY: all arguments are alive.
    let mut draw = |slice: &Slice, kernel: i32, colors: &SliceColors, floats: usize| unsafe {
        layersplat_render_slice(scene.renderer, slice, WIDTH, HEIGHT, kernel, colors, pixels.as_mut_ptr(), floats)
    };
    let colors = SliceColors { window_level: 0.0, window_width: 0.0, thickness: 0.0 };
    assert_eq!(draw(&slice, 0, &colors, FLOATS - 1), Status::TooSmall);
    assert!(refused(draw(&slice, 77, &colors, FLOATS), Status::InvalidArgument).contains("77"));
    assert!(
        refused(draw(&Slice { scale: 0.0, ..slice }, 0, &colors, FLOATS), Status::InvalidArgument).contains("half the height")
    );
    let negative = SliceColors { window_width: -1.0, ..colors };
    assert!(refused(draw(&slice, 0, &negative, FLOATS), Status::InvalidArgument).contains("window"));
    let mut out = slice;
    // SAFETY: all arguments are alive.
    let mut at = |axis: i32, at: f64| unsafe { layersplat_slice_at(scene.volume, axis, at, WIDTH, HEIGHT, &mut out) };
    assert!(refused(at(0, 25.0), Status::InvalidArgument).contains("outside the volume"));
    assert!(refused(at(SliceAxisChoice::Axial as i32, 0.0), Status::InvalidArgument).contains("use x, y or z"));
    // A renderer that streams cannot draw slices.
    // SAFETY: all arguments are alive, and the handles are freed once.
    unsafe {
        let limited = made(|out| layersplat_device_with_memory(scene.device, 60_000, out));
        let streaming = made(|out| layersplat_renderer_new(limited, scene.volume, scene.transfer, out));
        let status = layersplat_render_slice(streaming, &slice, WIDTH, HEIGHT, 0, null(), pixels.as_mut_ptr(), FLOATS);
        refused(status, Status::NeedsWholeVolume);
        layersplat_renderer_free(streaming);
        layersplat_device_free(limited);
    }
}
