//! Voxel storage: ownership, memory layout, mapping to values and conversion do not change a picture.

use crate::common::*;
use glam::DVec3;
use layersplat::settings::Layered;
use layersplat::volume::{Endian, Grid, Rescale, ScalarType, Storage, VoxelType};
use layersplat::{Frame, OpenOptions, Settings, TransferFunction, Volume};
use std::path::Path;
use std::sync::Arc;

const DIMS: [usize; 3] = [9, 8, 7];

fn grid() -> Grid {
    Grid::new(DIMS, DVec3::new(1.0, 0.8, 1.3)).unwrap()
}

/// Numbers from −900 to 1650.
fn numbers() -> Vec<i16> {
    random_bytes(DIMS, 7).iter().map(|&b| i16::from(b) * 10 - 900).collect()
}

/// Pictures by all paths that read voxels: as a whole, strided along each axis, single voxels.
fn pictures(volume: &Volume, transfer: &TransferFunction) -> Vec<Frame> {
    let size = viewport(24, 22);
    let cameras =
        [(20.0, 10.0), (80.0, 20.0), (10.0, 70.0)].map(|(azimuth, elevation)| parallel(volume, size, azimuth, elevation));
    let choices = CLASSIFICATIONS.map(|classification| Settings::from(Layered { classification, ..Layered::default() }));
    let others = OTHERS.map(|algorithm| Settings { algorithm, ..Settings::default() });
    let every = cameras.iter().flat_map(|camera| choices.iter().map(move |settings| (camera, settings)));
    let every = every.chain(others.iter().map(|settings| (&cameras[0], settings)));
    every.map(|(camera, settings)| render(volume, transfer, camera, size, settings)).collect()
}

/// Compares all pictures bit for bit.
#[track_caller]
fn assert_same(what: &str, found: &[Frame], expected: &[Frame]) {
    for (a, b) in found.iter().zip(expected) {
        assert_close(what, a, b, 0.0);
    }
}

/// Bytes of a foreign allocation, at an odd offset.
struct Foreign(Vec<u8>);

impl AsRef<[u8]> for Foreign {
    fn as_ref(&self) -> &[u8] {
        &self.0[1..]
    }
}

#[test]
fn whoever_owns_them_and_however_they_lie() {
    let numbers = numbers();
    let [x, y, z] = DIMS;
    let at = |i: usize, j: usize, k: usize| numbers[i + x * (j + y * k)];
    let little: Vec<u8> = numbers.iter().flat_map(|v| v.to_le_bytes()).collect();
    let big: Vec<u8> = numbers.iter().flat_map(|v| v.to_be_bytes()).collect();
    let foreign = |bytes: &[u8]| Foreign([&[0], bytes].concat());
    let order = |places: Vec<[usize; 3]>| -> Vec<i16> { places.into_iter().map(|[i, j, k]| at(i, j, k)).collect() };
    let all = |a: usize, b: usize, c: usize| {
        (0..a).flat_map(move |i| (0..b).flat_map(move |j| (0..c).map(move |k| [i, j, k]))).collect::<Vec<_>>()
    };
    // z fastest, as in an array whose last index is z.
    let z_fastest = order(all(x, y, z));
    // x reversed, rows along y padded by two, z unchanged.
    let padded: Vec<i16> = (0..z)
        .flat_map(|k| (0..y).flat_map(move |j| (0..x + 2).map(move |i| [i, j, k])))
        .map(|[i, j, k]| if i < x { at(x - 1 - i, j, k) } else { -30_000 })
        .collect();
    let [x, y, z] = DIMS.map(|n| n as isize);
    let backwards = Storage::from(&padded).with_first(2 * (DIMS[0] - 1)).with_strides([-2, 2 * (x + 2), 2 * (x + 2) * y]);
    let storages: [(&str, Storage); 10] = [
        ("borrowed", Storage::from(&numbers[..])),
        ("shared", Arc::<[i16]>::from(numbers.clone()).into()),
        ("a shared vector", Arc::new(numbers.clone()).into()),
        ("borrowed by an owner", Storage::shared::<i16>(&numbers)),
        ("odd bytes", Storage::from_bytes(foreign(&little), VoxelType::Int16).with_endian(Endian::Little)),
        ("after a header", Storage::from_bytes([&[9; 5], &little[..]].concat(), VoxelType::Int16).with_first(5)),
        ("the other byte order", Storage::from_bytes(big.clone(), VoxelType::Int16).with_endian(Endian::Big)),
        ("odd bytes of the other order", Storage::from_bytes(foreign(&big), VoxelType::Int16).with_endian(Endian::Big)),
        ("z fastest", Storage::from(&z_fastest).with_strides([2 * y * z, 2 * z, 2])),
        ("backwards with gaps", backwards),
    ];
    let owned = Volume::new("owned", grid(), numbers.clone()).unwrap();
    let transfer = TransferFunction::builtin("fire", &owned).unwrap();
    let expected = pictures(&owned, &transfer);
    for (what, storage) in storages {
        let volume = Volume::new(what, grid(), storage).unwrap();
        assert_eq!((volume.range(), volume.statistics()), (owned.range(), owned.statistics()), "{what}");
        assert!((0..numbers.len()).all(|i| volume.value(i) == f64::from(numbers[i])), "{what}");
        assert_same(what, &pictures(&volume, &transfer), &expected);
    }
    // The wrong byte order gives different pictures.
    let wrong = Volume::new("wrong", grid(), Storage::from_bytes(big, VoxelType::Int16)).unwrap();
    assert_ne!(wrong.range(), owned.range());
}

#[test]
fn places_beyond_the_bytes_are_refused() {
    let numbers = numbers();
    let refused = |storage: Storage| Volume::new("t", grid(), storage).unwrap_err().to_string();
    assert!(refused(Storage::from(&numbers[1..])).contains("504 voxels, found 503"));
    assert!(refused(Storage::from(&numbers).with_first(2)).contains("found 503"));
    for strides in [[2, 18, 146], [-2, 18, 144], [isize::MAX, 2, 2], [2, isize::MIN, 2]] {
        assert!(refused(Storage::from(&numbers).with_strides(strides)).contains("outside"), "{strides:?}");
    }
    assert!(refused(Storage::from(&numbers).with_first(usize::MAX).with_strides([2, 18, 144])).contains("outside"));
    assert!(Volume::new("t", grid(), Storage::from(&numbers).with_strides([0, 0, 0])).is_ok(), "one voxel everywhere");
}

/// Floats with invalid ones are copied in pieces; a volume of several pieces.
#[test]
fn many_voxels_in_pieces() {
    let dims = [129, 65, 70];
    let bytes = random_bytes(dims, 9);
    let with =
        |odd: f32| -> Vec<f32> { bytes.iter().enumerate().map(|(i, &b)| if i % 50_021 == 7 { odd } else { b.into() }).collect() };
    let grid = Grid::new(dims, DVec3::ONE).unwrap();
    let holes = Volume::new("holes", grid.clone(), with(f32::NAN)).unwrap().with_background(128.0).unwrap();
    let filled = Volume::new("filled", grid, with(128.0)).unwrap().with_background(128.0).unwrap();
    assert_eq!(holes.invalid(), (bytes.len() - 7).div_ceil(50_021));
    let size = viewport(80, 80);
    let camera = parallel(&filled, size, 30.0, 20.0);
    let [a, b] = [&holes, &filled].map(|volume| render(volume, &smooth_transfer(), &camera, size, &Settings::default()));
    assert_close("holes", &a, &b, 0.0);
    let mean = (0..bytes.len()).filter(|i| i % 50_021 != 7).map(|i| f64::from(bytes[i])).sum::<f64>();
    let mean = mean / (bytes.len() - holes.invalid()) as f64;
    assert!((holes.statistics().mean - mean).abs() < 1e-9);
}

/// The nearest table entry, of values or of stored numbers, may differ: one 8-bit step.
const RESCALED: f64 = 4e-3;
/// Tolerance for an opacity with a step.
const RESCALED_STEP: f64 = 0.05;
/// A sample on the other side of that step differs by its whole height: in one of 528 pixels, each of which has its own sample.
const ON_THE_STEP: usize = 1;
/// Height of the step.
const STEP: f64 = 0.4;

#[test]
fn slope_and_intercept() {
    let numbers = numbers();
    for (slope, intercept) in [(0.01, 5.0), (-2.5, 100.0)] {
        let rescale = Rescale::new(slope, intercept).unwrap();
        let values: Vec<f32> = numbers.iter().map(|&v| rescale.value(v.into()) as f32).collect();
        let plain = Volume::new("values", grid(), values).unwrap();
        let rescaled = Volume::new("stored", grid(), numbers.clone()).unwrap().with_rescale(rescale);
        assert_eq!(rescaled.voxel_type(), VoxelType::Int16);
        for (a, b) in [(plain.range(), rescaled.range()), (plain.field_range(), rescaled.field_range())] {
            assert!((a.0 - b.0).abs() < 1e-3 && (a.1 - b.1).abs() < 1e-3, "{slope}: {a:?}, {b:?}");
        }
        let (lo, hi) = plain.range();
        let steps = vec![(lo, 0.0), (0.5 * (lo + hi), 0.0), (0.5 * (lo + hi), STEP), (hi, 0.3)];
        let colors = vec![(lo, [0.1, 0.2, 0.9]), (hi, [1.0, 0.6, 0.1])];
        let ramp = smooth_transfer().stretched(lo, hi).unwrap();
        let step = TransferFunction::new("step", colors, steps).unwrap();
        for (transfer, tolerance, most, spared) in [(&ramp, RESCALED, RESCALED, 0), (&step, RESCALED_STEP, STEP, ON_THE_STEP)] {
            for background in [None, Some(0.3 * lo + 0.7 * hi)] {
                let surrounded = |volume: &Volume<'static>| match background {
                    Some(value) => volume.clone().with_background(value).unwrap(),
                    None => volume.clone(),
                };
                let expected = pictures(&surrounded(&plain), transfer);
                let found = pictures(&surrounded(&rescaled), transfer);
                for (n, (a, b)) in found.iter().zip(&expected).enumerate() {
                    let what = format!("slope {slope}, background {background:?}, picture {n}");
                    assert_close(&what, a, b, most);
                    assert!(pixels_apart(a, b, tolerance) <= spared, "{what}: {} pixels", pixels_apart(a, b, tolerance));
                }
                let unscaled = pictures(&surrounded(&rescaled.clone().with_rescale(Rescale::default())), transfer);
                let noticed = unscaled.iter().zip(&expected).map(|(a, b)| pixels_apart(a, b, 2.0 * tolerance)).max();
                assert!(noticed > Some(10), "numbers without slope and intercept must be noticed: {noticed:?} pixels");
            }
        }
        let automatic = [&plain, &rescaled].map(TransferFunction::automatic);
        for value in [lo, 0.3 * lo + 0.7 * hi, hi] {
            assert!((automatic[0].opacity(value) - automatic[1].opacity(value)).abs() < 1e-3, "{slope}");
        }
    }
    assert!(Rescale::new(0.0, 1.0).is_err() && Rescale::new(f64::NAN, 1.0).is_err() && Rescale::new(1.0, f64::INFINITY).is_err());
}

/// Control points at 1e12 are rounded to 1e-4, and table entries with them; a sample between two nodes may take either.
const FAR: f64 = 2e-4;

/// A ramp of 4000 in a range of f64 where f32 values are 65536 apart.
#[test]
fn doubles_keep_the_detail_of_their_own_range() {
    let ramp: Vec<f64> = random_bytes(DIMS, 7).iter().map(|&b| f64::from(b) * 4000.0 / 255.0).collect();
    let base = 1e12;
    let far: Vec<f64> = ramp.iter().map(|v| base + v).collect();
    let smallest = ramp.iter().copied().fold(f64::INFINITY, f64::min);
    let near = Volume::new("near", grid(), ramp.iter().map(|v| (v - smallest) as f32).collect::<Vec<_>>()).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("far_9x8x7_float64.raw");
    std::fs::write(&file, far.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<_>>()).unwrap();
    let spacing = Some(grid().spacing());
    let read = Volume::open(file.to_str().unwrap(), &OpenOptions { spacing, ..Default::default() }).unwrap();
    for volume in [Volume::from_wide("far", grid(), &far).unwrap(), read] {
        assert_eq!(volume.voxel_type(), VoxelType::Float32);
        assert!((0..far.len()).all(|i| (volume.value(i) - far[i]).abs() < 1e-3), "values must be preserved");
        let [a, b] = [(&volume, base + smallest), (&near, 0.0)].map(|(volume, zero)| {
            let transfer = smooth_transfer().stretched(zero, zero + 4000.0 - smallest).unwrap();
            pictures(volume, &transfer)
        });
        for (a, b) in a.iter().zip(&b) {
            assert_close("1e12 away", a, b, FAR);
        }
    }
}

#[test]
fn wide_whole_numbers_become_the_narrowest_voxels() {
    let bytes = random_bytes(DIMS, 7);
    let (least, most) = (*bytes.iter().min().unwrap(), *bytes.iter().max().unwrap());
    assert!(least > 0 && most > 200);
    let narrow = Volume::new("narrow", grid(), bytes.clone()).unwrap();
    let transfer = smooth_transfer();
    let expected = pictures(&narrow, &transfer);
    for (factor, kind) in [(1, VoxelType::Uint8), (250, VoxelType::Uint16), (60_000, VoxelType::Float32)] {
        let base = -1_000_000_000;
        let numbers: Vec<i32> = bytes.iter().map(|&b| base + factor * i32::from(b)).collect();
        let wide = Volume::from_wide("wide", grid(), &numbers).unwrap();
        assert_eq!((wide.voxel_type(), wide.value(5)), (kind, f64::from(numbers[5])));
        let far = transfer.stretched(base.into(), f64::from(base) + 255.0 * f64::from(factor)).unwrap();
        for (a, b) in pictures(&wide, &far).iter().zip(&expected) {
            assert_close(&format!("times {factor}"), a, b, RESCALED);
        }
    }
    let unsigned: Vec<u32> = bytes.iter().map(|&b| u32::MAX - 255 + u32::from(b)).collect();
    let wide = Volume::from_wide("wide", grid(), &unsigned).unwrap();
    assert_eq!((wide.voxel_type(), wide.value(5)), (VoxelType::Uint8, f64::from(unsigned[5])));
}

/// Every type and byte order, plain and compressed, with and without a header, mapped or read.
#[test]
fn files_of_every_type() {
    use std::io::Write;
    let folder = tempfile::tempdir().unwrap();
    let bytes = random_bytes(DIMS, 7);
    let expected: Vec<f64> = bytes.iter().map(|&b| f64::from(b / 2)).collect();
    let number = |scalar: ScalarType, v: u8| -> Vec<u8> {
        match scalar {
            ScalarType::Uint8 => vec![v],
            ScalarType::Int8 => (v as i8).to_le_bytes().into(),
            ScalarType::Uint16 => u16::from(v).to_le_bytes().into(),
            ScalarType::Int16 => i16::from(v).to_le_bytes().into(),
            ScalarType::Uint32 => u32::from(v).to_le_bytes().into(),
            ScalarType::Int32 => i32::from(v).to_le_bytes().into(),
            ScalarType::Uint64 => u64::from(v).to_le_bytes().into(),
            ScalarType::Int64 => i64::from(v).to_le_bytes().into(),
            ScalarType::Float16 => half::f16::from(v).to_le_bytes().into(),
            ScalarType::Float32 => f32::from(v).to_le_bytes().into(),
            ScalarType::Float64 => f64::from(v).to_le_bytes().into(),
        }
    };
    let types = "uint8 int8 uint16 int16 uint32 int32 float32 float64".split(' ').map(|name| name.parse::<ScalarType>().unwrap());
    for scalar in types {
        for (endian, header, packed) in
            [(None, 0, false), (Some(Endian::Big), 5, false), (None, 3, true), (Some(Endian::Big), 0, true)]
        {
            let mut content = vec![77; header];
            for &b in &bytes {
                let mut number = number(scalar, b / 2);
                if endian == Some(Endian::Big) {
                    number.reverse();
                }
                content.extend(number);
            }
            let path =
                folder.path().join(if packed { format!("a_9x8x7_{scalar}.RAW.gz") } else { format!("a_9x8x7_{scalar}.raw") });
            if packed {
                // Two members, as in concatenated files.
                let mut file = Vec::new();
                for part in content.chunks(content.len() / 2 + 1) {
                    let mut member = flate2::write::GzEncoder::new(&mut file, flate2::Compression::fast());
                    member.write_all(part).unwrap();
                    member.finish().unwrap();
                }
                std::fs::write(&path, file).unwrap();
            } else {
                std::fs::write(&path, content).unwrap();
            }
            let open = |header_bytes| {
                let spacing = Some(grid().spacing());
                Volume::open(path.to_str().unwrap(), &OpenOptions { spacing, endian, header_bytes, ..Default::default() })
            };
            let volume = open(Some(header as u64)).unwrap();
            let values: Vec<f64> = (0..bytes.len()).map(|i| volume.value(i)).collect();
            assert_eq!(values, expected, "{scalar} {endian:?}, {header}, {packed}");
            let message = open(Some(header as u64 + 1)).unwrap_err().to_string();
            assert!(message.contains("header_bytes"), "{message}");
        }
    }
}

/// A mapped file in native byte order and device type is not copied before rendering.
#[test]
fn mapped_files_look_as_read_ones() {
    use std::io::Write;
    let folder = tempfile::tempdir().unwrap();
    let content: Vec<u8> = numbers().iter().flat_map(|v| v.to_le_bytes()).collect();
    let [plain, packed] = ["a_9x8x7_int16.raw", "a_9x8x7_int16.raw.gz"].map(|name| folder.path().join(name));
    std::fs::write(&plain, &content).unwrap();
    let mut file = flate2::write::GzEncoder::new(std::fs::File::create(&packed).unwrap(), flate2::Compression::fast());
    file.write_all(&content).unwrap();
    file.finish().unwrap();
    let open = |path: &Path| Volume::open(path.to_str().unwrap(), &OpenOptions::default()).unwrap();
    let [mapped, read] = [open(&plain), open(&packed)];
    let transfer = TransferFunction::builtin("fire", &read).unwrap();
    assert_same("mapped", &pictures(&mapped, &transfer), &pictures(&read, &transfer));
    // A clone outlives the original, and the file's name.
    let clone = mapped.clone();
    drop(mapped);
    std::fs::remove_file(&plain).unwrap();
    assert_eq!(clone.statistics(), read.statistics());
}

/// Two renderers of voxels on the device share them, and give the pictures of separate renderers.
#[test]
fn voxels_on_the_device_are_shared() {
    use layersplat::Renderer;
    use layersplat::renderer::UploadedVolume;
    // A separate device, whose bytes are counted.
    let device = layersplat::Device::open(&layersplat::DeviceChoice::Default).unwrap();
    let volume = Volume::new("shared", grid(), numbers()).unwrap();
    let (size, camera) = (viewport(24, 22), parallel(&volume, viewport(24, 22), 20.0, 10.0));
    let transfers = ["fire", "viridis"].map(|name| TransferFunction::builtin(name, &volume).unwrap());
    let uploaded = UploadedVolume::new(&device, &volume).unwrap();
    let bytes = device.allocated_bytes();
    assert_eq!(bytes, 2 * DIMS.iter().product::<usize>() as u64);
    let mut renderers = transfers.each_ref().map(|transfer| Renderer::from_uploaded(&uploaded, transfer).unwrap());
    assert_eq!(device.allocated_bytes(), bytes);
    drop(uploaded);
    for (renderer, transfer) in renderers.iter_mut().zip(&transfers) {
        let (frame, _) = renderer.render(&camera, size, &Settings::default()).unwrap();
        assert_close(transfer.name(), &frame, &render(&volume, transfer, &camera, size, &Settings::default()), 0.0);
    }
    let part = UploadedVolume::part(&device, &volume.part([0, 0, 1], [9, 8, 3]).unwrap()).unwrap();
    assert!(
        !part.is_whole() && Renderer::from_uploaded(&part, &transfers[0]).err().unwrap().to_string().contains("PartRenderer")
    );
}

/// Floats that 32-bit sums cannot hold, or cannot tell apart, are told once for each volume; others are not.
#[test]
fn values_beyond_sums_of_floats_warn_once() {
    let count = DIMS.iter().product::<usize>();
    let ramp = |n: usize| n as f32 / count as f32;
    let floats = |value: &dyn Fn(usize) -> f32| (0..count).map(value).collect::<Vec<f32>>();
    let warnings = |voxels: Storage<'static>| {
        crate::told::warnings(|| {
            let volume = Volume::new("some", grid(), voxels).unwrap();
            // Only opening it warns.
            volume.statistics();
            TransferFunction::automatic(&volume);
        })
    };
    let invalid = floats(&|n| match n {
        3 => 2e30,
        7 => f32::NEG_INFINITY,
        9 => f32::NAN,
        _ => ramp(n),
    });
    for (voxels, words) in [
        (invalid, &["3 voxels are NaN, infinite or beyond 1e30", "background"][..]),
        (floats(&|n| 1e6 + ramp(n)), &["far from 0", "about 16 values apart", "subtract 1000000"]),
        (floats(&|n| -1e6 - ramp(n)), &["far from 0", "about 16 values apart"]),
        (floats(&|n| 1e29 * (1e4 + ramp(n)) / 1e4), &["far from 0"]),
    ] {
        let found = warnings(voxels.into());
        let [one] = &found[..] else { panic!("{found:?}") };
        assert!(one.starts_with("some: ") && words.iter().all(|word| one.contains(word)), "{one}");
    }
    for voxels in [floats(&ramp), floats(&|n| 400.0 + ramp(n)), floats(&|n| 1e29 * ramp(n)), floats(&|_| 1e9)] {
        assert_eq!(warnings(voxels.into()), [""; 0]);
    }
    assert_eq!(warnings(numbers().into()), [""; 0]);
    // These are stored as differences to the smallest.
    let wide: Vec<f64> = (0..count).map(|n| 1e9 + f64::from(ramp(n))).collect();
    assert_eq!(crate::told::warnings(|| drop(Volume::from_wide("some", grid(), &wide).unwrap())), [""; 0]);
}
