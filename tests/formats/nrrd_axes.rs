//! Axes of NRRD files outside of space: which choose frames, which channels.

use layersplat::volume::{OpenOptions, Volume};

/// Sizes of the axes x, y, z, and of a further one with three numbers.
const SPACE: [usize; 3] = [4, 3, 2];
const OTHERS: usize = 3;

/// A volume of 16-bit numbers that count from 0 in the order of the file, whose further axis is the first or the last.
fn file(first: bool, lines: &str) -> (tempfile::TempDir, std::path::PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("axes.nrrd");
    let [x, y, z] = SPACE;
    let sizes = if first { [OTHERS, x, y, z] } else { [x, y, z, OTHERS] };
    let sizes = sizes.map(|n| n.to_string()).join(" ");
    let header = format!("NRRD0005\ntype: uint16\ndimension: 4\nsizes: {sizes}\nendian: little\nencoding: raw\n{lines}\n\n");
    let numbers = (0..(x * y * z * OTHERS) as u16).flat_map(u16::to_le_bytes);
    std::fs::write(&path, header.into_bytes().into_iter().chain(numbers).collect::<Vec<u8>>()).unwrap();
    (folder, path)
}

/// Asserts that an option chooses the numbers along the further axis, and the other option none.
#[track_caller]
fn chosen_by(field: &str, first: bool, lines: &str) {
    let (_folder, path) = file(first, lines);
    let options = |n: usize, this: bool| match (field == "frame") == this {
        true => OpenOptions { frame: Some(n), ..OpenOptions::default() },
        false => OpenOptions { channel: Some(n), ..OpenOptions::default() },
    };
    let voxels: usize = SPACE.iter().product();
    for n in 0..OTHERS {
        let volume = Volume::open(&path, &options(n, true)).unwrap_or_else(|e| panic!("{lines}: {e}"));
        assert_eq!(volume.grid().dims(), SPACE, "{lines}");
        let wrong = (0..voxels).find(|&i| volume.value(i) != if first { OTHERS * i + n } else { i + voxels * n } as f64);
        assert_eq!(wrong, None, "{field} {n} of {lines}");
    }
    for options in [options(OTHERS, true), options(1, false)] {
        assert!(Volume::open(&path, &options).is_err(), "{lines}: {options:?}");
    }
}

const NONE_FIRST: &str = "space: RAS\nspace directions: none (1,0,0) (0,1,0) (0,0,2)";
const NONE_LAST: &str = "space: RAS\nspace directions: (1,0,0) (0,1,0) (0,0,2) none";

/// The kind of an axis tells what it is, wherever it stands.
#[test]
fn kinds_choose_frames_and_channels() {
    chosen_by("frame", true, &format!("{NONE_FIRST}\nkinds: time domain domain domain"));
    chosen_by("frame", true, "kinds: time space space space\nspacings: 0.1 1 1 2");
    for kind in ["list", "vector", "3-vector", "covariant-vector", "RGB-color", "3-gradient", "???"] {
        chosen_by("channel", true, &format!("{NONE_FIRST}\nkinds: {kind} domain domain domain"));
    }
    for kind in ["time", "list", "none"] {
        chosen_by("frame", false, &format!("{NONE_LAST}\nkinds: domain domain domain {kind}"));
    }
    for kind in ["vector", "RGB-color", "3-normal"] {
        chosen_by("channel", false, &format!("{NONE_LAST}\nkinds: domain domain domain {kind}"));
    }
    // Nothing tells what the axis is but its place.
    chosen_by("channel", true, NONE_FIRST);
    chosen_by("frame", false, NONE_LAST);
}

/// Seconds are time, where kinds do not say so.
#[test]
fn units_tell_times() {
    chosen_by("frame", true, "units: \"s\" \"mm\" \"mm\" \"mm\"");
    chosen_by("frame", true, "kinds: domain domain domain domain\nunits: \"ms\" \"mm\" \"mm\" \"mm\"");
    chosen_by("channel", true, &format!("{NONE_FIRST}\nkinds: vector domain domain domain\nunits: \"s\" \"mm\" \"mm\" \"mm\""));
}

/// Four numbers per direction, as SimpleITK writes films: the fourth is time.
#[test]
fn directions_of_four_dimensions_are_read() {
    let place = "space dimension: 4\nkinds: domain domain domain domain\nspace origin: (5,6,7,0)";
    chosen_by("frame", false, &format!("{place}\nspace directions: (1,0,0,0) (0,1,0,0) (0,0,2,0) (0,0,0,0.1)"));
    chosen_by("frame", true, &format!("{place}\nspace directions: (0,0,0,0.1) (1,0,0,0) (0,1,0,0) (0,0,2,0)"));
    let directions = "space: right-anterior-superior-time\nspace directions: (1,0,0,0) (0,1,0,0) (0,0,2,0) (0,0,0,1)";
    chosen_by("frame", false, directions);
    let (_folder, path) = file(false, &format!("{place}\nspace directions: (0,1,0,0) (1,0,0,0) (0,0,2,0) (0,0,0,1)"));
    let grid = Volume::open(&path, &OpenOptions { frame: Some(1), ..OpenOptions::default() }).unwrap().grid().clone();
    assert_eq!(grid.spacing().to_array(), [1.0, 1.0, 2.0]);
    assert_eq!(grid.index_to_world().transform_point3([1.0, 0.0, 1.0].into()).to_array(), [5.0, 7.0, 9.0]);
}
