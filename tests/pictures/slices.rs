//! Slices: closed forms, the f64 reference, symmetries, and what is refused.

use crate::common::*;
use glam::{DMat3, DVec3};
use layersplat::layers::Kernel;
use layersplat::reference::Slices;
use layersplat::renderer::UploadedVolume;
use layersplat::slice::{Slice, SliceAxis, SliceColors};
use layersplat::volume::{Grid, Rescale, Voxels};
use layersplat::{Renderer, TransferFunction, Viewport, Volume};

/// Rounding of positions of up to a hundred voxels in floats, times the steepest field: a difference of neighbours as large as the range.
const ROUNDING: f64 = 4e-5;
/// A colour of the table is that of the nearest of 4096 entries; the steepest colours and opacities here change by 2 over the table, and
/// thickness multiplies the extinction.
const TABLE: f64 = 2e-3;
/// The Gaussian is cut off at two voxels, where its weight is 2.7e-4: rounding decides on which side a voxel lies.
const CUT_OFF: f64 = 3e-4;
/// A picture of a plane that is a twentieth of a voxel away differs at least by this share of the range.
const NOTICED: f64 = 1e-3;
/// Kernels that interpolate the voxels.
const INTERPOLATING: [Kernel; 4] = Kernel::OF_LAYERS;

fn size() -> Viewport {
    viewport(37, 29)
}

fn renderer(volume: &Volume) -> Renderer {
    Renderer::new(&device(), volume, &smooth_transfer()).unwrap()
}

/// Data values of a slice, NaN outside.
fn values(volume: &Volume, slice: &Slice, size: Viewport, kernel: Kernel) -> Vec<f64> {
    let values = renderer(volume).slice_values(slice, size, kernel).unwrap();
    values.values().iter().map(|&v| f64::from(v)).collect()
}

/// Noise of each type of voxels, on turned grids with several spacings; one mapping from stored numbers falls.
fn volumes() -> Vec<Volume<'static>> {
    let dims = [13, 9, 11];
    let noise = || random_bytes(dims, 77);
    let turn = DMat3::from_rotation_z(0.4) * DMat3::from_rotation_y(-0.7);
    let grid = |spacing| Grid::oriented(dims, spacing, DVec3::new(-3.0, 5.0, 40.0), turn).unwrap();
    let spacings = [DVec3::ONE, DVec3::new(0.5, 0.7, 2.0), DVec3::new(3.0, 1.0, 1.5)];
    let voxels = [
        Voxels::Uint8(noise()),
        Voxels::Int8(noise().iter().map(|&v| (i16::from(v) - 128) as i8).collect()),
        Voxels::Uint16(noise().iter().map(|&v| u16::from(v) * 37 + 900).collect()),
        Voxels::Int16(noise().iter().map(|&v| i16::from(v) * 16 - 1024).collect()),
        Voxels::Float32(noise().iter().map(|&v| f32::from(v) * 0.013 + 7.0).collect()),
    ];
    let volume = |(n, voxels)| Volume::new("noise", grid(spacings[n % 3]), voxels).unwrap();
    let mut all: Vec<_> = voxels.into_iter().enumerate().map(volume).collect();
    let falling = Volume::new("falling", grid(spacings[1]), Voxels::Uint8(noise())).unwrap();
    all.push(falling.with_rescale(Rescale::new(-0.5, 300.0).unwrap()));
    all
}

/// Planes in all directions through a point, larger and smaller than the volume.
fn planes(grid: &Grid) -> Vec<Slice> {
    let normals = [DVec3::new(0.3, -0.8, 0.5), DVec3::new(-0.9, 0.1, 0.2), DVec3::new(0.1, 0.2, 0.97)];
    let middle = grid.index_to_world().transform_point3(DVec3::new(5.3, 4.1, 6.2));
    let mut planes: Vec<Slice> =
        normals.iter().map(|&n| Slice::facing(grid, middle, n, DVec3::new(0.2, 1.0, 0.3), size()).unwrap()).collect();
    planes[1].scale *= 0.2;
    planes.extend([SliceAxis::X, SliceAxis::Y, SliceAxis::Z].map(|axis| Slice::at(grid, axis, 3.3, size()).unwrap()));
    planes
}

/// All kernels for the first volume, one each for the others: a program has one kernel and one type of voxels.
fn is_compared(volume: usize, kernel: Kernel) -> bool {
    volume == 0 || Kernel::ALL[volume % Kernel::ALL.len()] == kernel
}

/// A function with the colours and opacities of `smooth_transfer` over the range of a volume.
fn stretched(volume: &Volume) -> TransferFunction {
    smooth_transfer().stretched(volume.range().0, volume.range().1).unwrap()
}

#[test]
fn values_are_those_of_the_reference() {
    for (n, volume) in volumes().into_iter().enumerate() {
        let transfer = stretched(&volume);
        let span = volume.range().1 - volume.range().0;
        for kernel in Kernel::ALL.into_iter().filter(|&kernel| is_compared(n, kernel)) {
            let reference = Slices::new(&volume, &transfer, kernel);
            for slice in planes(volume.grid()) {
                let what = format!("{:?} {kernel:?} {slice:?}", volume.voxel_type());
                let expected = reference.values(&slice, size()).unwrap();
                let moved = Slice { centre: slice.centre + slice.normal().unwrap() * 0.05 * volume.grid().spacing().x, ..slice };
                let moved = reference.values(&moved, size()).unwrap();
                let found = values(&volume, &slice, size(), kernel);
                let (mut largest, mut noticed, mut inside) = (0.0_f64, 0.0_f64, 0);
                for ((found, expected), moved) in found.iter().zip(&expected).zip(&moved) {
                    assert_eq!(found.is_nan(), expected.is_none(), "{what}: outside");
                    if let (Some(expected), Some(moved)) = (expected, moved) {
                        largest = largest.max((found - expected).abs() / span);
                        noticed = noticed.max((found - moved).abs() / span);
                        inside += 1;
                    }
                }
                assert!(inside > 100, "{what}: {inside} pixels");
                let tolerance = if kernel == Kernel::Gaussian { CUT_OFF } else { ROUNDING };
                assert!(largest < tolerance, "{what}: differs by {largest}");
                assert!(noticed > NOTICED, "{what}: a plane a twentieth of a voxel away must be noticed, {noticed}");
            }
        }
    }
}

#[test]
fn colours_are_those_of_the_reference() {
    for (n, volume) in volumes().into_iter().enumerate() {
        let (transfer, (lo, hi)) = (stretched(&volume), volume.range());
        let mut renderer = Renderer::new(&device(), &volume, &transfer).unwrap();
        let span = hi - lo;
        let window = |level: f64, width: f64| SliceColors::Window { level: lo + level * span, width: width * span };
        for (kernel, slice) in Kernel::ALL.into_iter().zip(planes(volume.grid())).filter(|&(kernel, _)| is_compared(n, kernel)) {
            let reference = Slices::new(&volume, &transfer, kernel);
            let shown = [
                window(0.5, 1.0),
                window(0.6, 0.3),
                SliceColors::Transfer { thickness: 1.0 },
                SliceColors::Transfer { thickness: 3.0 },
            ];
            let mut expected = Vec::new();
            for colors in shown {
                let what = format!("{:?} {kernel:?} {colors:?}", volume.voxel_type());
                let found = renderer.slice(&slice, size(), kernel, colors).unwrap();
                expected.push(reference.render(&slice, size(), colors).unwrap());
                assert_close(&what, &found, &expected[expected.len() - 1], TABLE);
            }
            for pair in expected.windows(2) {
                assert!(compare(&pair[0], &pair[1]).max_difference > 0.05, "other colours are noticed");
            }
        }
    }
}

/// Opaque wherever the transfer function has an opacity, however small, and empty elsewhere.
#[test]
fn an_infinite_layer_is_opaque() {
    let volume = random_volume([13, 9, 11], DVec3::ONE, 5);
    let faint = TransferFunction::new(
        "faint",
        vec![(0.0, [0.2, 0.4, 0.6])],
        vec![(0.0, 0.0), (100.0, 0.0), (100.0, 1e-4), (255.0, 1e-4)],
    )
    .unwrap();
    let mut renderer = Renderer::new(&device(), &volume, &faint).unwrap();
    let slice = Slice::at(volume.grid(), SliceAxis::Y, 4.0, size()).unwrap();
    let frame = renderer.slice(&slice, size(), Kernel::Linear, SliceColors::TRANSFER).unwrap();
    let values = renderer.slice_values(&slice, size(), Kernel::Linear).unwrap();
    let mut seen = [0; 2];
    for (pixel, &value) in frame.pixels().iter().zip(values.values()) {
        // The table's step is an entry wide.
        if (value - 100.0).abs() > 0.2 {
            let shown = value > 100.0;
            seen[usize::from(shown)] += 1;
            let expected = if shown { [0.2, 0.4, 0.6, 1.0] } else { [0.0; 4] };
            assert!(pixel.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6), "{pixel:?} for {value}");
        }
    }
    assert!(seen.iter().all(|&n| n > 50), "{seen:?}");
}

/// A linear function comes back from kernels that reproduce it, in the world of a turned grid; the paper's cubic has steps.
#[test]
fn ramps_are_ramps() {
    let dims = [40, 38, 36];
    let turn = DMat3::from_rotation_x(0.6) * DMat3::from_rotation_z(-0.2);
    let grid = Grid::oriented(dims, DVec3::new(0.8, 1.0, 1.7), DVec3::new(100.0, -20.0, 3.0), turn).unwrap();
    let slope = DVec3::new(0.7, -0.4, 0.2);
    let ramp = |n: usize| {
        let voxel = DVec3::new((n % 40) as f64, (n / 40 % 38) as f64, (n / 40 / 38) as f64);
        slope.dot(grid.index_to_world().transform_point3(voxel) - grid.centre()) as f32
    };
    let volume = Volume::new("ramp", grid.clone(), Voxels::Float32((0..dims.iter().product()).map(ramp).collect())).unwrap();
    let slice = Slice::facing(&grid, grid.centre(), DVec3::new(0.4, 0.5, 0.8), DVec3::Y, size()).unwrap();
    // Far from the edges, where the coefficients of the B-spline do not know of them.
    let slice = Slice { scale: 6.0, ..slice };
    let pixels = slice.pixels(size()).unwrap();
    let off = |kernel: Kernel| {
        let found = values(&volume, &slice, size(), kernel);
        let expected = (0..size().pixels()).map(|n| {
            let (x, y) = ((n % 37) as f64 + 0.5, (n / 37) as f64 + 0.5);
            slope.dot(pixels.point(x, y) - grid.centre())
        });
        found.iter().zip(expected).map(|(found, expected)| (found - expected).abs()).fold(0.0, f64::max)
    };
    for kernel in [Kernel::Linear, Kernel::CatmullRom, Kernel::BSpline] {
        assert!(off(kernel) < 1e-4, "{kernel:?}: off by {}", off(kernel));
    }
    assert!(off(Kernel::Cubic) > 0.05, "steps are noticed: {}", off(Kernel::Cubic));
}

/// Pixels on voxels have their values with every kernel that interpolates, at the edges too; half-way between two slices of voxels the
/// linear and the paper's kernel give the mean.
#[test]
fn voxels_have_their_values() {
    let volume = random_volume([13, 9, 11], DVec3::new(0.5, 0.5, 0.5), 5);
    let dims = volume.grid().dims();
    for (axis, sides) in [(SliceAxis::X, [1, 2]), (SliceAxis::Y, [0, 2]), (SliceAxis::Z, [0, 1])] {
        let size = viewport(dims[sides[0]] as u32, dims[sides[1]] as u32);
        let normal = 3 - sides[0] - sides[1];
        let voxel = |x: usize, y: usize, layer: usize| {
            let mut place = [layer; 3];
            (place[sides[0]], place[sides[1]]) = (x, dims[sides[1]] - 1 - y);
            volume.value(place[0] + dims[0] * (place[1] + dims[1] * place[2]))
        };
        for kernel in INTERPOLATING {
            for layer in [0, 4, dims[normal] - 1] {
                let slice = Slice::at(volume.grid(), axis, layer as f64, size).unwrap();
                for (n, found) in values(&volume, &slice, size, kernel).into_iter().enumerate() {
                    let (x, y) = (n % size.width as usize, n / size.width as usize);
                    let expected = voxel(x, y, layer);
                    assert!((found - expected).abs() < 255.0 * ROUNDING, "{axis:?} {kernel:?} {layer}: {found}, not {expected}");
                }
            }
        }
        for kernel in [Kernel::Linear, Kernel::Cubic] {
            let slice = Slice::at(volume.grid(), axis, 4.5, size).unwrap();
            for (n, found) in values(&volume, &slice, size, kernel).into_iter().enumerate() {
                let (x, y) = (n % size.width as usize, n / size.width as usize);
                let mean = (voxel(x, y, 4) + voxel(x, y, 5)) / 2.0;
                assert!((found - mean).abs() < 255.0 * ROUNDING, "{axis:?} {kernel:?}: {found}, not {mean}");
            }
        }
    }
}

/// A volume with its axes exchanged has the same slices along the exchanged axis.
#[test]
fn exchanged_axes_have_equal_slices() {
    let dims = [13, 9, 11];
    let bytes = random_bytes(dims, 8);
    let spacing = DVec3::new(0.5, 0.8, 1.1);
    // y, z, x.
    let turned = |n: usize| {
        let [y, z, x] = [n % 9, n / 9 % 11, n / 99];
        bytes[x + 13 * (y + 9 * z)]
    };
    let cycled = volume([9, 11, 13], DVec3::new(0.8, 1.1, 0.5), Voxels::Uint8((0..bytes.len()).map(turned).collect()));
    let original = volume(dims, spacing, Voxels::Uint8(bytes.clone()));
    for kernel in Kernel::ALL {
        let slices = |volume: &Volume, axis: SliceAxis| {
            let slice = Slice::at(volume.grid(), axis, 6.3, size()).unwrap();
            values(volume, &slice, size(), kernel)
        };
        // Both show y to the right and z up, or x and y.
        let (one, other) = (slices(&original, SliceAxis::X), slices(&cycled, SliceAxis::Z));
        let off = one.iter().zip(&other).filter(|(a, b)| !a.is_nan() || !b.is_nan());
        let off = off.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(off < 255.0 * ROUNDING, "{kernel:?}: {off}");
        let different = slices(&original, SliceAxis::Z);
        assert!(one.iter().zip(&different).any(|(a, b)| (a - b).abs() > 10.0), "{kernel:?}: another axis is noticed");
    }
}

#[test]
fn volumes_of_one_voxel_have_slices() {
    for dims in [[1, 1, 1], [5, 1, 1], [4, 5, 1]] {
        let volume =
            volume(dims, DVec3::ONE, Voxels::Uint8((0..dims.iter().product::<usize>()).map(|n| n as u8 * 9 + 7).collect()));
        for kernel in INTERPOLATING {
            let slice = Slice::at(volume.grid(), SliceAxis::Z, 0.2, viewport(dims[0] as u32, dims[1] as u32)).unwrap();
            let found = values(&volume, &slice, viewport(dims[0] as u32, dims[1] as u32), kernel);
            let expected = (0..dims[1]).rev().flat_map(|y| (0..dims[0]).map(move |x| (x + dims[0] * y) as f64 * 9.0 + 7.0));
            for (found, expected) in found.iter().zip(expected) {
                assert!((found - expected).abs() < 0.01, "{dims:?} {kernel:?}: {found}, not {expected}");
            }
        }
    }
}

/// Renderers of one uploaded volume share its voxels with its slices, and a slice leaves pictures as they are.
#[test]
fn slices_and_pictures_share_a_renderer() {
    let volume = random_volume([13, 9, 11], DVec3::ONE, 6);
    let uploaded = UploadedVolume::new(&device(), &volume).unwrap();
    let transfer = smooth_transfer();
    let mut renderer = Renderer::from_uploaded(&uploaded, &transfer).unwrap();
    let camera = parallel(&volume, size(), 30.0, 20.0);
    let settings = layersplat::Settings::default();
    let before = renderer.render(&camera, size(), &settings).unwrap().0;
    let slice = Slice::at(volume.grid(), SliceAxis::Z, 4.0, size()).unwrap();
    let first = renderer.slice(&slice, size(), Kernel::BSpline, SliceColors::TRANSFER).unwrap();
    assert!(renderer.render(&camera, size(), &settings).unwrap().0 == before);
    let mut other = Renderer::from_uploaded(&uploaded, &transfer).unwrap();
    assert!(other.slice(&slice, size(), Kernel::BSpline, SliceColors::TRANSFER).unwrap() == first, "the same bits");
}

#[test]
fn bad_slices_are_refused() {
    let volume = random_volume([5, 5, 5], DVec3::ONE, 6);
    let mut renderer = renderer(&volume);
    let good = Slice::at(volume.grid(), SliceAxis::Z, 2.0, size()).unwrap();
    for (slice, colors, field) in [
        (Slice { up: good.right, ..good }, SliceColors::TRANSFER, "plane"),
        (Slice { scale: f64::NAN, ..good }, SliceColors::TRANSFER, "plane"),
        (good, SliceColors::Window { level: 0.0, width: -1.0 }, "window"),
        (good, SliceColors::Transfer { thickness: -1.0 }, "thickness"),
    ] {
        assert_eq!(renderer.slice(&slice, size(), Kernel::Linear, colors).unwrap_err().fields(), [field]);
    }
    // Far away and very large planes are empty or small, but no error.
    for slice in [Slice { centre: DVec3::splat(1e30), ..good }, Slice { scale: 1e30, ..good }, Slice { scale: 1e-30, ..good }] {
        renderer.slice(&slice, size(), Kernel::CatmullRom, SliceColors::TRANSFER).unwrap();
    }
}
