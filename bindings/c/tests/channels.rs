//! Channels, colours and labels.

mod common;

use common::*;
use layersplat_c::*;
use std::ffi::{CString, c_void};
use std::ptr::{null, null_mut};

/// Largest difference of floats that are sums of the same terms in another order.
const ROUNDING: f32 = 1e-4;

fn uploaded(scene: &Scene) -> *mut Uploaded {
    // SAFETY: all arguments are alive.
    made(|out| unsafe { layersplat_uploaded_new(scene.device, scene.volume, out) })
}

fn channel(volume: *const Uploaded, transfer: *const Transfer) -> Channel {
    let mut channel = std::mem::MaybeUninit::uninit();
    // SAFETY: the call initialises the struct.
    unsafe {
        ok(layersplat_channel_default(volume, transfer, channel.as_mut_ptr(), size_of::<Channel>()));
        channel.assume_init()
    }
}

/// The picture of a renderer that a test has made.
fn floats(renderer: *mut Renderer, camera: &Camera) -> Vec<f32> {
    let mut pixels = vec![-1.0; FLOATS];
    // SAFETY: all arguments are alive.
    ok(unsafe { layersplat_render_floats(renderer, camera, WIDTH, HEIGHT, null(), pixels.as_mut_ptr(), FLOATS) });
    pixels
}

fn difference(a: &[f32], b: &[f32]) -> f32 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

#[test]
fn channels_add_and_are_replaced() {
    let scene = Scene::new();
    let expected = scene.floats(null());
    let voxels = uploaded(&scene);
    let whole = channel(voxels, scene.transfer);
    // SAFETY: all arguments are alive, and each handle is freed once.
    unsafe {
        let renderer = made(|out| layersplat_renderer_from_channels(&whole, 1, out));
        assert!(floats(renderer, &scene.camera) == expected, "one channel is the volume");
        let halves = [Channel { factor: 0.5, ..whole }; 2];
        ok(layersplat_renderer_set_channels(renderer, halves.as_ptr(), 2));
        assert!(difference(&floats(renderer, &scene.camera), &expected) < ROUNDING);
        let hidden = [whole, Channel { visible: 0, ..whole }];
        ok(layersplat_renderer_set_channels(renderer, hidden.as_ptr(), 2));
        assert!(floats(renderer, &scene.camera) == expected);
        ok(layersplat_renderer_set_channels(renderer, halves.as_ptr(), 1));
        assert!(difference(&floats(renderer, &scene.camera), &expected) > 100.0 * ROUNDING, "the test notices a factor");
        let steep = Channel { gradient_point_count: 1, gradient_opacity: [[0.0, 0.5]; 8], ..whole };
        ok(layersplat_renderer_set_channels(renderer, &steep, 1));
        assert!(floats(renderer, &scene.camera) != expected);
        // The renderer of a volume takes channels too, and goes on when their handles are gone.
        ok(layersplat_renderer_set_channels(scene.renderer, halves.as_ptr(), 1));
        layersplat_uploaded_free(voxels);
        assert!(scene.floats(null()) != expected);
        layersplat_renderer_free(renderer);
    }
}

#[test]
fn channels_get_colours_and_transfer_functions() {
    let scene = Scene::new();
    let dapi = CString::new("DAPI").unwrap();
    let names = [dapi.as_ptr(), null()];
    let mut colors = [-1.0; 6];
    // SAFETY: all arguments are alive, and each handle is freed once.
    unsafe {
        ok(layersplat_channel_colors(names.as_ptr(), 2, colors.as_mut_ptr(), 6));
        assert!(colors[2] > colors[0] && colors[3..] == [0.0, 1.0, 0.0], "{colors:?}");
        refused(layersplat_channel_colors(names.as_ptr(), 2, colors.as_mut_ptr(), 5), Status::TooSmall);
        let voxels = uploaded(&scene);
        let green = made(|out| layersplat_transfer_channel(scene.volume, colors[3..].as_ptr(), 0, out));
        let renderer = made(|out| layersplat_renderer_from_channels(&channel(voxels, green), 1, out));
        let picture = floats(renderer, &scene.camera);
        let sum = |c: usize| picture.iter().skip(c).step_by(4).sum::<f32>();
        assert!(sum(1) > 5.0 * sum(0).max(sum(2)), "{} {} {}", sum(0), sum(1), sum(2));
        let mut none = null_mut();
        refused(layersplat_transfer_channel(scene.volume, [0.0, 2.0, 0.0].as_ptr(), 0, &mut none), Status::InvalidArgument);
        refused(layersplat_transfer_channel(scene.volume, colors.as_ptr(), 2, &mut none), Status::InvalidArgument);
        layersplat_transfer_free(green);
        layersplat_uploaded_free(voxels);
        layersplat_renderer_free(renderer);
    }
}

const SIDE: usize = 12;

/// Voxels with `components` values, of a box in the middle.
fn middle(value: &[u8]) -> Vec<u8> {
    let inside = |n: usize| [n % SIDE, n / SIDE % SIDE, n / SIDE / SIDE].iter().all(|i| (4..8).contains(i));
    (0..SIDE * SIDE * SIDE).flat_map(|n| value.iter().map(move |&v| if inside(n) { v } else { 0 })).collect()
}

/// The sums of red, green and blue in the picture of colours, which are freed.
fn drawn(colors: *mut Colors) -> [f32; 3] {
    let mut grid = layersplat_grid_at_origin(0, 0, 0, 0.0, 0.0, 0.0);
    let mut camera = EMPTY;
    // SAFETY: all arguments are alive, and each handle is freed once.
    unsafe {
        ok(layersplat_colors_grid(colors, &mut grid));
        ok(layersplat_camera_fit_grid(&grid, FROM, 0.0, WIDTH, HEIGHT, &mut camera));
        let renderer = made(|out| layersplat_renderer_from_colors(colors, out));
        layersplat_colors_free(colors);
        let picture = floats(renderer, &camera);
        layersplat_renderer_free(renderer);
        [0, 1, 2].map(|c| picture.iter().skip(c).step_by(4).sum::<f32>())
    }
}

#[test]
fn colours_and_labels_are_drawn() {
    let scene = Scene::new();
    let grid = layersplat_grid_at_origin(SIDE, SIDE, SIDE, 1.0, 1.0, 1.0);
    let uint8 = VoxelType::Uint8 as i32;
    let colors = |voxels: &[u8], components: i32, options: *const ColorOptions| {
        let (first, bytes) = (voxels.as_ptr().cast::<c_void>(), voxels.len());
        // SAFETY: all arguments are alive.
        made(|out| unsafe { layersplat_colors_new(scene.device, first, bytes, uint8, components, &grid, options, out) })
    };
    // Without shading's white highlight, one component stays 0.
    let [r, g, b] = drawn(colors(&middle(&[200, 0, 100, 250]), 4, null()));
    assert!(r > 1.5 * b && b > 5.0 * g && b > 1.0, "{r} {g} {b}");
    let [r, g, b] = drawn(colors(&middle(&[0, 250, 0]), 3, null()));
    assert!(g > 5.0 * r.max(b) && g > 1.0, "{r} {g} {b}");
    let background = ColorOptions { opacity: ColorOpacityChoice::Background as i32, background: [0.0; 3], transfer: null() };
    let [_, _, b] = drawn(colors(&middle(&[0, 0, 250]), 3, &background));
    assert!(b > 1.0);

    let ids = middle(&[9]);
    let labels_with = |table: &[Label], surfaces: i32| {
        let (first, bytes) = (ids.as_ptr().cast::<c_void>(), ids.len());
        // SAFETY: all arguments are alive.
        made(|out| unsafe {
            layersplat_labels_new(scene.device, first, bytes, uint8, &grid, table.as_ptr(), table.len(), surfaces, out)
        })
    };
    let labels = |table: &[Label]| labels_with(table, LabelSurfacesChoice::Smooth as i32);
    let blue = Label { id: 9, color: [0.0, 0.0, 1.0], opacity: 1.0 };
    let [r, _, b] = drawn(labels(&[blue, Label { id: 300, ..blue }]));
    assert!(b > 3.0 * r && b > 1.0, "{r} {b}");
    assert_eq!(drawn(labels(&[Label { opacity: 0.0, ..blue }])), [0.0; 3]);
    assert!(drawn(labels(&[])).iter().sum::<f32>() > 1.0);
    assert!(drawn(labels_with(&[blue], LabelSurfacesChoice::Voxels as i32)) != drawn(labels(&[blue])));

    // Beside the volume, in one picture. The volume is blue.
    let (voxels, beside) = (uploaded(&scene), labels(&[Label { color: [1.0, 0.0, 0.0], ..blue }]));
    let thin = Channel { factor: 1e-3, ..channel(voxels, scene.transfer) };
    let both = [thin, Channel { colors: beside, ..channel(null(), null()) }];
    // SAFETY: all arguments are alive, and each handle is freed once.
    unsafe {
        let renderer = made(|out| layersplat_renderer_from_channels(both.as_ptr(), 2, out));
        let red = || floats(renderer, &scene.camera).iter().step_by(4).sum::<f32>();
        let together = red();
        ok(layersplat_renderer_set_channels(renderer, &thin, 1));
        assert!(together > 2.0 * red(), "{together}, alone {}", red());
        layersplat_colors_free(beside);
        layersplat_uploaded_free(voxels);
        layersplat_renderer_free(renderer);
    }

    let folder = tempfile::tempdir().unwrap();
    let section = folder.path().join("section.nrrd");
    let header = "NRRD0004\ntype: uint8\ndimension: 4\nsizes: 3 4 4 4\nkinds: RGB-color domain domain domain\nencoding: raw\n\n";
    std::fs::write(&section, [header.as_bytes(), &[[0, 255, 255]; 64].concat()].concat()).unwrap();
    let source = CString::new(section.to_str().unwrap()).unwrap();
    // SAFETY: all arguments are alive.
    let [r, _, b] = drawn(made(|out| unsafe { layersplat_colors_open(scene.device, source.as_ptr(), null(), out) }));
    assert!(b > 3.0 * r && b > 1.0, "{r} {b}");
    let file = folder.path().join("ids_12x12x12_uint8.raw");
    std::fs::write(&file, &ids).unwrap();
    let source = CString::new(file.to_str().unwrap()).unwrap();
    let change = CString::new("9:#ff0000").unwrap();
    // SAFETY: all arguments are alive.
    unsafe {
        let opened = |out| layersplat_labels_open(scene.device, source.as_ptr(), null(), [change.as_ptr()].as_ptr(), 1, 0, out);
        let [r, _, b] = drawn(made(opened));
        assert!(r > 3.0 * b && r > 1.0, "{r} {b}");
        // The renderer of a volume takes colours too.
        let before = scene.floats(null());
        let blue = labels(&[blue]);
        ok(layersplat_renderer_set_colors(scene.renderer, blue));
        layersplat_colors_free(blue);
        assert!(scene.floats(null()) != before);
    }
}

#[test]
fn labels_color_a_volume() {
    let scene = Scene::new();
    let mut grid = layersplat_grid_at_origin(0, 0, 0, 0.0, 0.0, 0.0);
    // SAFETY: all arguments are alive.
    ok(unsafe { layersplat_volume_grid(scene.volume, &mut grid) });
    let uint8 = VoxelType::Uint8 as i32;
    let ids = vec![9u8; grid.dims.iter().product()];
    let colors = |table: &[Label]| {
        let (first, bytes) = (ids.as_ptr().cast::<c_void>(), ids.len());
        let new = layersplat_label_colors_new;
        // SAFETY: all arguments are alive.
        made(|out| unsafe { new(scene.device, first, bytes, uint8, &grid, table.as_ptr(), table.len(), out) })
    };
    let sums = |picture: &[f32]| [0, 1, 2, 3].map(|c| picture.iter().skip(c).step_by(4).sum::<f32>());
    let plain = scene.floats(null());
    let blue = Label { id: 9, color: [0.0, 0.0, 1.0], opacity: 1.0 };
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("ids_20x20x20_uint8.raw");
    std::fs::write(&file, &ids).unwrap();
    let source = CString::new(file.to_str().unwrap()).unwrap();
    let change = CString::new("9:#0000ff").unwrap();
    // SAFETY: all arguments are alive, and each handle is freed once.
    unsafe {
        let set = |colors: *mut LabelColors| {
            ok(layersplat_renderer_set_label_colors(scene.renderer, colors));
            layersplat_label_colors_free(colors);
            scene.floats(null())
        };
        let tinted = set(colors(&[blue]));
        let ([r, g, b, alpha], [.., opacity]) = (sums(&tinted), sums(&plain));
        assert!(b > 3.0 * r.max(g) && b > 1.0 && alpha == opacity, "{r} {g} {b} {alpha} {opacity}");
        let opened =
            made(|out| layersplat_label_colors_open(scene.device, source.as_ptr(), null(), [change.as_ptr()].as_ptr(), 1, out));
        assert!(set(opened) == tinted);
        // Hidden labels keep the volume's colours, and so does none.
        assert!(set(colors(&[Label { opacity: 0.0, ..blue }])) == plain);
        assert!(set(colors(&[blue])) == tinted && set(null_mut()) == plain);

        // Labels beside the volume, and those of no file.
        let far = Grid { origin: [900.0, 0.0, 0.0], ..grid };
        let (first, bytes) = (ids.as_ptr().cast::<c_void>(), ids.len());
        let beside = made(|out| layersplat_label_colors_new(scene.device, first, bytes, uint8, &far, &blue, 1, out));
        let message = refused(layersplat_renderer_set_label_colors(scene.renderer, beside), Status::File);
        assert!(message.contains("lie outside"), "{message}");
        layersplat_label_colors_free(beside);
        let mut out = null_mut();
        let missing = CString::new("none.nrrd").unwrap();
        refused(layersplat_label_colors_open(scene.device, missing.as_ptr(), null(), null(), 0, &mut out), Status::File);
        let int8 = VoxelType::Int8 as i32;
        let message = refused(
            layersplat_label_colors_new(scene.device, first, bytes, int8, &grid, &blue, 1, &mut out),
            Status::InvalidArgument,
        );
        assert!(message.contains("int8") && out.is_null(), "{message}");
        assert!(scene.floats(null()) == plain, "the renderer keeps its colours");
    }
}

#[test]
fn wrong_channels_and_colours_are_refused() {
    let scene = Scene::new();
    let voxels = uploaded(&scene);
    let whole = channel(voxels, scene.transfer);
    let before = scene.floats(null());
    let set = |channels: &[Channel], expected| {
        // SAFETY: all arguments are alive.
        refused(unsafe { layersplat_renderer_set_channels(scene.renderer, channels.as_ptr(), channels.len()) }, expected)
    };
    let invalid = |channel| set(&[channel], Status::InvalidArgument);
    assert!(invalid(Channel { factor: -1.0, ..whole }).contains("factor"));
    assert!(invalid(Channel { visible: 2, ..whole }).contains("visible"));
    assert!(invalid(Channel { gradient_point_count: 9, ..whole }).contains("gradient_point_count"));
    assert!(invalid(Channel { size: 8, ..whole }).contains("layersplat_channel_default"));
    set(&[whole; 9], Status::InvalidArgument);
    set(&[], Status::InvalidArgument);
    set(&[Channel { volume: null(), ..whole }], Status::NullArgument);
    set(&[Channel { transfer: null(), ..whole }], Status::NullArgument);
    assert!(scene.floats(null()) == before, "the renderer keeps its volume");
    let grid = layersplat_grid_at_origin(2, 2, 2, 1.0, 1.0, 1.0);
    let zeros = [0u8; 32];
    let mut out = null_mut();
    let mut refused_colors = |bytes: usize, voxel_type: VoxelType, components: i32, options: Option<&ColorOptions>| {
        let options = options.map_or(null(), |options| options as *const _);
        let first = zeros.as_ptr().cast();
        // SAFETY: all arguments are alive.
        let status =
            unsafe { layersplat_colors_new(scene.device, first, bytes, voxel_type as i32, components, &grid, options, &mut out) };
        refused(status, Status::InvalidArgument)
    };
    assert!(refused_colors(32, VoxelType::Uint8, 5, None).contains("components"));
    assert!(refused_colors(31, VoxelType::Uint8, 4, None).contains("32 bytes"));
    assert!(refused_colors(32, VoxelType::Int8, 4, None).contains("int8"));
    let alpha = ColorOptions { opacity: ColorOpacityChoice::Alpha as i32, background: [0.0; 3], transfer: null() };
    refused_colors(24, VoxelType::Uint8, 3, Some(&alpha));
    refused_colors(24, VoxelType::Uint8, 3, Some(&ColorOptions { opacity: 3, ..alpha }));
    refused_colors(24, VoxelType::Uint8, 3, Some(&ColorOptions { opacity: 2, background: [2.0; 3], ..alpha }));
    // SAFETY: all arguments are alive, and each handle is freed once.
    unsafe {
        let (device, first, uint8) = (scene.device, zeros.as_ptr().cast(), VoxelType::Uint8 as i32);
        let bad = Label { id: 0, color: [0.0; 3], opacity: 1.0 };
        let message =
            refused(layersplat_labels_new(device, first, 8, uint8, &grid, &bad, 1, 0, &mut out), Status::InvalidArgument);
        assert!(message.contains("label id"), "{message}");
        let message =
            refused(layersplat_labels_new(device, first, 8, uint8, &grid, null(), 0, 2, &mut out), Status::InvalidArgument);
        assert!(message.contains("label_surfaces is 2: expected 0 (smooth), 1 (voxels)"), "{message}");
        let missing = CString::new("none.nrrd").unwrap();
        refused(layersplat_labels_open(device, missing.as_ptr(), null(), null(), 0, 0, &mut out), Status::File);
        refused(layersplat_renderer_from_colors(null(), &mut null_mut()), Status::NullArgument);
        layersplat_uploaded_free(voxels);
        layersplat_uploaded_free(null_mut());
        layersplat_colors_free(null_mut());
    }
}
