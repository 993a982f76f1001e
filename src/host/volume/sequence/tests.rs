use super::*;
use glam::DVec3;
use std::fs::write;

const DIMS: [usize; 3] = [5, 4, 3];
const VOXELS: usize = 60;

/// A file of `steps`, in which voxel `i` of step `n` is `n + i`.
fn nrrd(path: &Path, dims: [usize; 3], steps: u8) {
    let [x, y, z] = dims;
    let header = format!(
        "NRRD0004\ntype: uint8\ndimension: 4\nsizes: {x} {y} {z} {steps}\nkinds: domain domain domain time\nencoding: raw\n\n"
    );
    let voxels = (0..steps).flat_map(|n| (0..(x * y * z) as u8).map(move |i| n + i));
    write(path, header.into_bytes().into_iter().chain(voxels).collect::<Vec<u8>>()).unwrap();
}

#[test]
fn frames_of_all_files_follow_each_other() {
    let folder = tempfile::tempdir().unwrap();
    let paths = ["a.nrrd", "b.nrrd"].map(|name| folder.path().join(name));
    nrrd(&paths[0], DIMS, 3);
    nrrd(&paths[1], DIMS, 2);
    let sequence = Sequence::open(&paths, &OpenOptions::default()).unwrap();
    assert_eq!(sequence.len(), 5);
    let first = |step: Volume| step.value(0);
    let firsts: Vec<f64> = sequence.play((0..5).collect()).map(|step| first(step.unwrap())).collect();
    assert_eq!(firsts, [0.0, 1.0, 2.0, 0.0, 1.0]);
    assert_eq!((first(sequence.step(2).unwrap()), first(sequence.step(4).unwrap())), (2.0, 1.0));
    assert!(matches!(sequence.step(5), Err(Error::OutOfRange { .. })));
}

#[test]
fn the_overview_has_the_values_of_all_steps() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.nrrd");
    nrrd(&path, DIMS, 40);
    let sequence = Sequence::open(&[&path], &OpenOptions::default()).unwrap();
    let sampled = sequence.sampled_steps();
    assert_eq!((sampled.len(), sampled[0], sampled[15]), (16, 0, 39));
    assert!(sampled.windows(2).all(|pair| (2..=3).contains(&(pair[1] - pair[0]))), "{sampled:?}");
    let overview = sequence.overview().unwrap();
    assert_eq!((overview.grid().dims(), overview.range()), ([5, 4, 48], (0.0, 39.0 + 59.0)));
    assert_eq!((overview.value(VOXELS * 15), overview.grid().spacing()), (39.0, DVec3::ONE));
    // The first step alone has another range.
    assert_eq!(sequence.step(0).unwrap().range(), (0.0, 59.0));
    let three = Sequence::open(&[&path, &path], &OpenOptions::default()).unwrap();
    assert_eq!((three.len(), three.sampled_steps().len()), (80, 16));
}

#[test]
fn large_steps_are_thinned_and_keep_their_range() {
    let sequence = Sequence::open(&["builtin:cube@300x200x300"; 2], &OpenOptions::default()).unwrap();
    let overview = sequence.overview().unwrap();
    let (one, range) = (sequence.step(0).unwrap(), overview.range());
    assert_eq!((overview.grid().dims(), range), ([150, 100, 300], one.range()));
    assert_eq!(overview.grid().spacing(), one.grid().spacing() * 2.0);
}

#[test]
fn steps_of_different_kinds_become_floats() {
    let folder = tempfile::tempdir().unwrap();
    let paths = ["a.npy", "b.npy"].map(|name| folder.path().join(name));
    for (path, numbers) in paths.iter().zip([[0, 200], [-5, 70_000]]) {
        let shape = "{'descr': '<i4', 'fortran_order': False, 'shape': (1, 1, 2), }";
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend((shape.len() as u16).to_le_bytes());
        bytes.extend(shape.bytes());
        numbers.iter().for_each(|n: &i32| bytes.extend(n.to_le_bytes()));
        write(path, bytes).unwrap();
    }
    let overview = Sequence::open(&paths, &OpenOptions::default()).unwrap().overview().unwrap();
    assert_eq!((overview.voxel_type(), overview.range()), (crate::volume::VoxelType::Float32, (-5.0, 70_000.0)));
    assert_eq!([0, 1, 2, 3].map(|i| overview.value(i)), [0.0, 200.0, -5.0, 70_000.0]);
}

#[test]
fn sequences_that_are_none() {
    let folder = tempfile::tempdir().unwrap();
    let [a, b, short] = ["a.nrrd", "b.nrrd", "short.nrrd"].map(|name| folder.path().join(name));
    nrrd(&a, DIMS, 3);
    nrrd(&b, [5, 4, 2], 1);
    nrrd(&short, DIMS, 3);
    let bytes = std::fs::read(&short).unwrap();
    write(&short, &bytes[..bytes.len() - 1]).unwrap();
    let refused = |sources: &[&PathBuf], options: &OpenOptions, words: &[&str]| {
        let message = Sequence::open(sources, options).unwrap_err().to_string();
        assert!(words.iter().all(|word| message.contains(word)), "{message}");
    };
    let plain = OpenOptions::default();
    refused(&[&a, &b], &plain, &["b.nrrd", "step 3", "5x4x2 voxels", "a.nrrd", "5x4x3 voxels"]);
    refused(&[&short], &plain, &["short.nrrd", "truncated"]);
    refused(&[], &plain, &["steps", "none"]);
    refused(&[&a], &OpenOptions { frame: Some(0), ..plain.clone() }, &["frame", "omit"]);
    refused(&[&a, &folder.path().join("c.nrrd")], &plain, &["c.nrrd"]);
}
