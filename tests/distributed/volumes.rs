//! Reading of distributed volumes, and collective statistics.

use crate::common::*;
use glam::DVec3;
use layersplat::distributed::{Brick, DistributedError, Group, Renderer};
use layersplat::framing::{Fixed, Framing};
use layersplat::transfer::Value;
use layersplat::volume::{Grid, VoxelBox, convert};
use layersplat::{Error, OpenOptions, Orbit, Settings, TransferFunction, Volume};
use std::path::{Path, PathBuf};

/// A folder that rank 0 creates and all ranks use.
struct Folder(PathBuf, bool);

impl Folder {
    fn of(group: &Group, name: &str) -> Self {
        let mut number = std::process::id().to_string().into_bytes();
        group.broadcast(0, &mut number);
        let path = std::env::temp_dir().join(format!("layersplat-{name}-{}", String::from_utf8(number).unwrap()));
        if group.leads() {
            std::fs::create_dir_all(&path).unwrap();
        }
        group.wait();
        Self(path, group.leads())
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        if self.1 {
            let _ = std::fs::remove_dir_all(&self.0);
        }
    }
}

fn assert_alike(name: &str, alone: &Volume, shared: &Volume) {
    assert_eq!(shared.description(), alone.description(), "{name}");
    let (a, b) = (alone.statistics(), shared.statistics());
    assert_eq!((a.min, a.max, &a.histogram), (b.min, b.max, &b.histogram), "{name}");
    assert!((a.mean - b.mean).abs() <= 1e-12 * a.mean.abs().max(1.0), "{name}: {} and {}", a.mean, b.mean);
    let (one, all) = (TransferFunction::automatic(alone), TransferFunction::automatic(shared));
    for i in 0..=100 {
        let value = a.min + (a.max - a.min) * f64::from(i) / 100.0;
        assert!((one.opacity(value) - all.opacity(value)).abs() < 1e-6, "{name} at {value}");
    }
    for percent in [0.0, 1.0, 50.0, 99.5, 100.0] {
        let percentile = Value::Percentile(percent);
        assert_eq!(Value::finder(alone)(percentile), Value::finder(shared)(percentile), "{name}: p{percent}");
    }
    assert_eq!(one.effective_splats(alone), one.effective_splats(shared), "{name}");
    let orbit = Orbit { azimuth: 30.0, elevation: 20.0, roll: 0.0 };
    let camera = |framing: Framing| framing.parallel(orbit, viewport(64, 64), Fixed::default());
    assert_eq!(camera(Framing::visible(alone, &one, None)), camera(Framing::visible(shared, &one, None)), "{name}");
    let middle = (a.min + a.max) / 2.0;
    assert_eq!(camera(Framing::iso(alone, middle)), camera(Framing::iso(shared, middle)), "{name}");
}

pub fn are_looked_at_together(group: &Group) {
    for source in ["builtin:hydrogen@33", "builtin:shepp-logan@20x31x17", "builtin:gyroid@5x6x3", "builtin:cube@2"] {
        let shared = group.open(source, &OpenOptions::default()).unwrap();
        let alone = Volume::open(source, &OpenOptions::default()).unwrap();
        assert_alike(source, &alone, &shared);
        if group.size() == 5 && source.contains("@33") {
            let mut renderer = Renderer::new(group, &device(), &shared, &smooth_transfer()).unwrap();
            let camera = parallel(&shared, viewport(20, 20), 10.0, 10.0);
            let (_, report) = renderer.render(&camera, viewport(20, 20), &Settings::default()).unwrap();
            let most = report.ranks.iter().map(|rank| rank.read_bytes).max().unwrap();
            assert!((33 * 33 * 6..=33 * 33 * 15).contains(&most), "{most} bytes are most of the volume, or none");
        }
    }
}

pub fn are_read_in_parts(group: &Group) {
    let folder = Folder::of(group, "parts");
    let grid = Grid::new([18, 14, 21], DVec3::new(1.0, 2.0, 0.5)).unwrap();
    let floats: Vec<f32> =
        (0..grid.voxel_count()).map(|n| if n == 77 { f32::NAN } else { ((n * 31) % 101) as f32 / 7.0 - 3.0 }).collect();
    let wide: Vec<f64> = (0..grid.voxel_count()).map(|n| 1e6 + ((n * 17) % 89) as f64 / 3.0).collect();
    let raw = folder.0.join("wide_18x14x21_float64.raw");
    if group.leads() {
        let volume = Volume::new("floats", grid.clone(), floats).unwrap();
        volume.save(folder.0.join("start.nrrd")).unwrap();
        for name in ["a.vti", "a.nii", "a.npy", "a_18x14x21_float32.raw"] {
            convert(folder.0.join("start.nrrd"), &OpenOptions::default(), folder.0.join(name)).unwrap();
        }
        std::fs::write(&raw, wide.iter().flat_map(|n| n.to_le_bytes()).collect::<Vec<u8>>()).unwrap();
    }
    group.wait();
    let fixtures = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/formats/files");
    let mut sources: Vec<PathBuf> =
        ["start.nrrd", "a.vti", "a.nii", "a.npy", "a_18x14x21_float32.raw"].iter().map(|n| folder.0.join(n)).collect();
    sources.extend([
        raw,
        fixtures.join("zarr/3_gzip.zarr"),
        fixtures.join("zarr/big_i2.zarr"),
        fixtures.join("zarr/ome_04.zarr"),
    ]);
    for source in &sources {
        let shared = group.open(source, &OpenOptions::default()).unwrap();
        assert_alike(&source.display().to_string(), &Volume::open(source, &OpenOptions::default()).unwrap(), &shared);
    }
    group.wait();
}

pub fn are_refused_on_all(group: &Group) {
    let folder = Folder::of(group, "refused");
    let rank = |result: Result<(), Error>| match result {
        Err(Error::Distributed(DistributedError::Rank { rank, message, own })) => {
            assert_eq!(own.is_some(), rank == group.rank());
            (rank, message)
        }
        Err(error) if group.size() == 1 => (0, error.to_string()),
        other => panic!("{other:?}"),
    };
    let open = |name: &str| group.open(folder.0.join(name), &OpenOptions::default()).map(drop);
    // All ranks would have to read compressed files.
    if group.leads() {
        let volume = Volume::open("builtin:hydrogen@12", &OpenOptions::default()).unwrap();
        volume.save(folder.0.join("a_12x12x12_uint8.raw")).unwrap();
        let bytes = std::fs::read(folder.0.join("a_12x12x12_uint8.raw")).unwrap();
        std::fs::write(folder.0.join("short_12x12x12_uint8.raw"), &bytes[..900]).unwrap();
        std::fs::write(
            folder.0.join("a.nrrd"),
            "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nencoding: ascii\n\n1 2 3 4 5 6 7 8\n",
        )
        .unwrap();
    }
    group.wait();
    let (first, message) = rank(open("a.nrrd"));
    assert!(first == 0 && message.contains("layersplat convert"), "{message}");
    assert!(rank(open("short_12x12x12_uint8.raw")).1.contains("900"));
    assert!(rank(open("none.nrrd")).1.contains("none.nrrd"));
    // Only the last rank looks for another file.
    let last = group.size() - 1;
    let name = if group.rank() == last { "missing.raw" } else { "a_12x12x12_uint8.raw" };
    let (failed, message) = rank(open(name));
    assert!(failed == last && message.contains("missing.raw"), "{failed}: {message}");
    // Bricks owned by two ranks or by none.
    let grid = Grid::new([4, 4, 8], DVec3::ONE).unwrap();
    let all = VoxelBox::whole([4, 4, 8]);
    let transfer = smooth_transfer();
    if group.size() > 1 {
        let volume = group.volume("twice", grid.clone(), Brick { own: all, held: all }, vec![1u8; 128]).unwrap();
        assert!(rank(Renderer::new(group, &device(), &volume, &transfer).map(drop)).1.contains("both own"));
    }
    let half = VoxelBox { first: [0, 0, group.rank()], dims: [2, 4, 1] };
    let volume = group.volume("half", grid.clone(), Brick { own: half, held: half }, vec![1u8; 8]).unwrap();
    assert!(rank(Renderer::new(group, &device(), &volume, &transfer).map(drop)).1.contains("each voxel needs an owner"));
    assert!(
        rank(group.volume("outside", grid, Brick { own: all, held: half }, vec![1u8; 8]).map(drop)).1.contains("invalid boxes")
    );
    // A view without a lattice, then one with a lattice.
    let volume = group.open("builtin:hydrogen@40", &OpenOptions::default()).unwrap();
    let mut renderer = Renderer::new(group, &device(), &volume, &transfer).unwrap();
    let (size, camera) = (viewport(24, 24), parallel(&volume, viewport(24, 24), 10.0, 10.0));
    let cast = layersplat::settings::Algorithm::Slicing { step: 0.5 }.into();
    assert!(rank(renderer.render(&camera, size, &cast).map(drop)).1.contains("only layers on a lattice"));
    assert!(renderer.render(&camera, size, &Settings::default()).unwrap().0.is_some() == group.leads());
    // Another renderer cannot render a part alone.
    if group.size() > 1 {
        let refused = layersplat::Renderer::new(&device(), &volume, &transfer).map(drop).unwrap_err().to_string();
        assert!(refused.contains("only a part"), "{refused}");
    }
    group.wait();
}
