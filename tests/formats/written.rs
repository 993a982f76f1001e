//! Written files are read back bit for bit.

use crate::files::{all, folder};
use layersplat::glam::{DMat3, DVec3};
use layersplat::volume::{Grid, OpenOptions, Volume, convert};
use std::path::Path;

/// Extensions of formats that store the placement of the grid.
const PLACED: [&str; 4] = ["nrrd", "nii", "nii.gz", "vti"];
/// NIfTI-1 stores positions as 32-bit floats.
const PLACE: f64 = 1e-5;

fn opened(path: &Path) -> Volume<'static> {
    Volume::open(path, &OpenOptions::default()).unwrap_or_else(|e| panic!("{e}"))
}

/// Every test file through every format that supports it: same values at the same positions.
#[test]
fn all_files_through_all_formats() {
    let temporary = tempfile::tempdir().unwrap();
    let mut count = 0;
    for expected in all() {
        for ending in ["nrrd", "nii", "nii.gz", "vti", "npy", "raw"] {
            if ending == "vti" && cfg!(not(feature = "vtk")) {
                continue;
            }
            let target = temporary.path().join(format!("a.{ending}"));
            let written = match convert(folder().join(&expected.file), &expected.options, &target) {
                Ok(written) => written,
                Err(e) if expected.file.contains("float16") => {
                    assert!(e.to_string().contains("float16"), "{e}");
                    continue;
                }
                Err(e) => panic!("{} to {ending}: {e}", expected.file),
            };
            let original = Volume::open(folder().join(&expected.file), &expected.options).unwrap();
            let again = opened(&written);
            let name = format!("{} as {ending}", expected.file);
            assert_eq!(again.grid().dims(), original.grid().dims(), "{name}");
            for index in 0..original.grid().voxel_count() {
                assert_eq!(again.value(index), original.value(index), "{name} at {index}");
            }
            if PLACED.contains(&ending) {
                let (found, place) = (again.grid().index_to_world(), original.grid().index_to_world());
                assert!(found.abs_diff_eq(place, PLACE), "{name}: {found}, expected {place}");
            }
            std::fs::remove_file(written).unwrap();
            count += 1;
        }
    }
    assert!(count > 500, "{count}");
    assert_eq!(std::fs::read_dir(temporary.path()).unwrap().count(), 0, "no files may be left behind");
}

/// Voxel bytes and types are preserved, for every type.
#[test]
fn voxels_keep_their_bits_and_their_type() {
    let temporary = tempfile::tempdir().unwrap();
    for name in ["uint8", "int8", "uint16", "int16", "uint32", "int32", "uint64", "int64", "float32", "float64"] {
        let size: usize = name.trim_start_matches(char::is_alphabetic).parse::<usize>().unwrap() / 8;
        // Any bits except NaN and infinity.
        let bytes: Vec<u8> = (0..24 * size).map(|i| if i % size == size - 1 { 64 } else { (i * 37 % 251) as u8 }).collect();
        let raw = temporary.path().join(format!("a_4x3x2_{name}.raw"));
        std::fs::write(&raw, &bytes).unwrap();
        for ending in ["nrrd", "nii", "npy", "vti"] {
            let target = temporary.path().join(format!("b.{ending}"));
            convert(&raw, &OpenOptions::default(), &target).unwrap();
            let written = std::fs::read(&target).unwrap();
            assert!(written.windows(bytes.len()).any(|part| part == bytes), "{name} in {ending}");
            if ending == "vti" && cfg!(not(feature = "vtk")) {
                continue;
            }
            let back = convert(&target, &OpenOptions::default(), temporary.path().join("back.raw")).unwrap();
            assert!(back.ends_with(format!("back_4x3x2_{name}.raw")), "{}", back.display());
            assert_eq!(std::fs::read(&back).unwrap(), bytes, "{name} through {ending}");
        }
    }
}

#[test]
fn volumes_in_memory_are_written_with_their_place() {
    let temporary = tempfile::tempdir().unwrap();
    let turn = DMat3::from_rotation_z(0.4) * DMat3::from_rotation_x(-0.9);
    let mirrored = turn * DMat3::from_diagonal(DVec3::new(1.0, -1.0, 1.0));
    let grid = Grid::oriented([4, 3, 2], DVec3::new(0.5, 1.5, 2.5), DVec3::new(-3.0, 7.0, 11.0), mirrored).unwrap();
    let voxels: Vec<f32> = (0..24).map(|i| if i == 5 { f32::NAN } else { i as f32 * 0.1 }).collect();
    let volume = Volume::new("a name with <signs> & \"more\"", grid, &voxels).unwrap();
    for ending in ["nrrd", "nii", "vti"] {
        let path = volume.save(temporary.path().join(format!("a.{ending}"))).unwrap();
        if ending == "vti" && cfg!(not(feature = "vtk")) {
            continue;
        }
        let again = opened(&path);
        assert!(again.grid().index_to_world().abs_diff_eq(volume.grid().index_to_world(), PLACE), "{ending}");
        assert_eq!((again.invalid(), again.range()), (1, volume.range()), "{ending}");
        assert!((0..24).all(|i| again.value(i) == volume.value(i)), "{ending}");
    }
}

#[test]
fn what_cannot_be_written_leaves_nothing() {
    let temporary = tempfile::tempdir().unwrap();
    let to = |name: &str| convert("builtin:cube@4", &OpenOptions::default(), temporary.path().join(name));
    for (name, word) in [("a.tif", ".nrrd"), ("a_4x4x3_uint8.raw", "4x4x4"), ("missing/a.nrrd", "does not exist"), ("a", ".raw")]
    {
        let message = to(name).unwrap_err().to_string();
        assert!(message.contains(word), "{message}");
    }
    let long = Volume::new("long", Grid::new([40_000, 1, 1], DVec3::ONE).unwrap(), vec![0u8; 40_000]).unwrap();
    assert!(long.save(temporary.path().join("a.nii")).unwrap_err().to_string().contains("32767"));
    assert_eq!(std::fs::read_dir(temporary.path()).unwrap().count(), 0);
    assert!(to("a_4x4x4_uint8.raw").unwrap().ends_with("a_4x4x4_uint8.raw"));
}

/// Units of length are kept through reading and writing, by their symbols; a spacing that is given has none.
#[test]
fn units_of_length_are_kept() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    let nrrd =
        |units: &str| format!("NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nspacings: 1 1 2\n{units}encoding: raw\n\n");
    let unit_of = |header: &str| {
        std::fs::write(f.join("a.nrrd"), [header.as_bytes(), &[1, 2, 3, 4, 5, 6, 7, 8]].concat()).unwrap();
        opened(&f.join("a.nrrd")).length_unit().map(str::to_owned)
    };
    assert_eq!(unit_of(&nrrd("")), None);
    assert_eq!(unit_of(&nrrd("units: \"mm\" \"cm\" \"mm\"\n")), None);
    assert_eq!(unit_of(&nrrd("units: \"microns\" \"um\" \"µm\"\n")).as_deref(), Some("µm"));
    for target in ["b.nrrd", "b.nii"] {
        let written = convert(f.join("a.nrrd"), &OpenOptions::default(), f.join(target)).unwrap();
        assert_eq!(opened(&written).length_unit(), Some("µm"), "{target}");
        assert_eq!(
            opened(&opened(&written).save(f.join(format!("again_{target}"))).unwrap()).length_unit(),
            Some("µm"),
            "{target}"
        );
    }
    let given = OpenOptions { spacing: Some(DVec3::ONE), ..OpenOptions::default() };
    assert_eq!(Volume::open(f.join("a.nrrd"), &given).unwrap().length_unit(), None);
    // A patient is measured in millimetres.
    let space = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nspace: right-anterior-superior\nspace directions: (1,0,0) (0,1,0) (0,0,1)\nencoding: raw\n\n";
    assert_eq!(unit_of(space).as_deref(), Some("mm"));
}
