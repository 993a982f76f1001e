//! Floats that 32-bit floats of devices cannot hold as they are.

use layersplat::glam::DVec3;
use layersplat::volume::{Grid, OpenOptions, Volume};
use std::path::PathBuf;

/// Steps of a 32-bit float within the range of values.
const STEP: f64 = 1.0 / 8_388_608.0;

/// An array of NumPy of 4 x 3 x 2 numbers.
fn npy(kind: &str, numbers: &[u8]) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.npy");
    let header = format!("{:<117}\n", format!("{{'descr': '<{kind}', 'fortran_order': False, 'shape': (2, 3, 4)}}"));
    let bytes = [&b"\x93NUMPY\x01\x00\x76\x00"[..], header.as_bytes(), numbers].concat();
    std::fs::write(&path, bytes).unwrap();
    (folder, path)
}

fn doubles(numbers: &[f64]) -> (tempfile::TempDir, PathBuf) {
    npy("f8", &numbers.iter().flat_map(|n| n.to_le_bytes()).collect::<Vec<u8>>())
}

fn floats(numbers: &[f64]) -> (tempfile::TempDir, PathBuf) {
    npy("f4", &numbers.iter().flat_map(|&n| (n as f32).to_le_bytes()).collect::<Vec<u8>>())
}

/// Masses of halos in grams, and tiny densities: what is no fill value is a value, in memory and in a temporary file.
#[test]
fn values_of_any_magnitude_are_read() {
    type Write = fn(&[f64]) -> (tempfile::TempDir, PathBuf);
    let cases: [(f64, f64, Write); 7] = [
        (0.0, 1e33, floats),
        (-1e37, 1e38, floats),
        (0.0, 1e-36, floats),
        (0.0, 1e-60, doubles),
        (1e-60, 3e-60, doubles),
        (-1e300, 1e300, doubles),
        (0.0, 1e-310, doubles),
    ];
    for (lo, hi, write) in cases {
        let numbers: Vec<f64> = (0..24).map(|n| lo + (hi - lo) * f64::from(n) / 23.0).collect();
        let (_folder, path) = write(&numbers);
        for memory in [None, Some(0)] {
            let volume = Volume::open(&path, &OpenOptions { memory, ..OpenOptions::default() }).unwrap();
            assert_eq!(volume.invalid(), 0, "{lo} to {hi}");
            for (n, expected) in numbers.iter().enumerate() {
                let found = volume.value(n);
                assert!((found - expected).abs() <= STEP * (hi - lo), "{lo} to {hi}: {found} is not {expected}");
            }
            let stored = volume.description().rescale().stored(volume.range().1);
            assert!((0.5..=2.0).contains(&stored), "{lo} to {hi} is stored up to {stored}");
        }
    }
    let wide = Volume::from_wide("w", Grid::new([2, 1, 1], DVec3::ONE).unwrap(), &[1e-60f64, 2e-60]).unwrap();
    assert!(wide.value(0) == 1e-60 && (wide.value(1) - 2e-60).abs() < STEP * 1e-60);
}

/// A number far beyond all others that occurs more than once stands for missing ones.
#[test]
fn fill_values_are_no_values() {
    for fill in [1e35, -9.96921e36] {
        let mut numbers: Vec<f64> = (0..24).map(|n| 270.0 + f64::from(n)).collect();
        (numbers[3], numbers[17]) = (fill, fill);
        let (_folder, path) = floats(&numbers);
        let volume = Volume::open(&path, &OpenOptions::default()).unwrap();
        assert_eq!((volume.invalid(), volume.range(), volume.value(3)), (2, (270.0, 293.0), 270.0));
    }
}

#[test]
fn what_32_bits_cannot_store_is_converted() {
    let (folder, path) = doubles(&(0..24).map(|n| f64::from(n) * 1e-60).collect::<Vec<_>>());
    let volume = Volume::open(&path, &OpenOptions::default()).unwrap();
    for name in ["a.nii", "b.npy"] {
        let copy = Volume::open(volume.save(folder.path().join(name)).unwrap(), &OpenOptions::default()).unwrap();
        assert!((copy.value(23) - 23e-60).abs() < STEP * 23e-60, "{name}: {}", copy.value(23));
    }
}
