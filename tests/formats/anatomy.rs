//! Which files say that their world is a patient's.

use layersplat::glam::DVec3;
use layersplat::volume::{Grid, OpenOptions, Volume};
use std::path::Path;

fn has_anatomy(path: &Path) -> bool {
    let volume = Volume::open(path, &OpenOptions::default()).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    // A spacing that is given replaces the place in the world.
    let options = OpenOptions { spacing: Some(DVec3::ONE), ..OpenOptions::default() };
    assert!(!Volume::open(path, &options).unwrap().grid().has_anatomy(), "{}", path.display());
    volume.grid().has_anatomy()
}

/// A file of 2×2×2 bytes below a header.
fn with_header(name: &str, header: &str) -> bool {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, [header.as_bytes(), &[1, 2, 3, 4, 5, 6, 7, 8]].concat()).unwrap();
    has_anatomy(&path)
}

#[test]
fn nrrd_files_name_the_space() {
    let directions = "space directions: (1,0,0) (0,1,0) (0,0,2)";
    for (lines, expected) in [
        (format!("space: right-anterior-superior\n{directions}"), true),
        (format!("space: LPS\n{directions}"), true),
        (format!("space: left-anterior-superior\n{directions}"), true),
        (format!("space: scanner-xyz\n{directions}"), false),
        (format!("space: 3D-right-handed\n{directions}"), false),
        (format!("space: left-right-superior\n{directions}"), false),
        (format!("space dimension: 3\n{directions}"), false),
        // Without directions the space says nothing.
        ("space: LPS\nspacings: 1 1 2".into(), false),
        ("spacings: 1 1 2".into(), false),
    ] {
        let header = format!("NRRD0005\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nencoding: raw\n{lines}\n\n");
        assert_eq!(with_header("a.nrrd", &header), expected, "{lines}");
    }
}

#[test]
fn metaimages_name_the_axes() {
    for (orientation, expected) in [
        ("AnatomicalOrientation = RAI\n", true),
        ("AnatomicalOrientation = sla\n", true),
        ("AnatomicalOrientation = ???\n", false),
        ("AnatomicalOrientation = RLI\n", false),
        ("AnatomicalOrientation = RA\n", false),
        ("", false),
    ] {
        let header = format!(
            "ObjectType = Image\nNDims = 3\n{orientation}DimSize = 2 2 2\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n"
        );
        assert_eq!(with_header("a.mha", &header), expected, "{orientation}");
    }
}

/// The codes of a NIfTI file say whether its matrix or its quaternion leads to a patient's coordinates.
#[test]
fn nifti_files_have_codes() {
    let folder = tempfile::tempdir().unwrap();
    let grid = Grid::new([2; 3], DVec3::ONE).unwrap();
    let path = Volume::new("a", grid, vec![1u8, 2, 3, 4, 5, 6, 7, 8]).unwrap().save(folder.path().join("a.nii")).unwrap();
    let bytes = std::fs::read(&path).unwrap();
    for (codes, expected) in [([0, 1], true), ([1, 0], true), ([0, 4], true), ([0, 0], false)] {
        let mut bytes = bytes.clone();
        bytes[252..256].copy_from_slice(&codes.map(i16::to_le_bytes).concat());
        std::fs::write(&path, bytes).unwrap();
        assert_eq!(has_anatomy(&path), expected, "{codes:?}");
    }
}

#[cfg(feature = "dicom")]
#[test]
fn dicom_slices_have_positions() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/formats/files/dicom");
    assert!(has_anatomy(&folder.join("oblique")) && has_anatomy(&folder.join("uint16")));
}

/// Formats that know only a grid, and what a written file keeps.
#[test]
fn other_files_say_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let plain = Grid::new([2; 3], DVec3::ONE).unwrap();
    for (name, expected) in [("a.nrrd", true), ("a.nii", true), ("a.npy", false)] {
        for grid in [plain.clone().with_anatomy(), plain.clone()] {
            // All of NIfTI is about patients.
            let expected = expected && (grid.has_anatomy() || name.ends_with("nii"));
            let path = Volume::new("a", grid, vec![1u8, 2, 3, 4, 5, 6, 7, 8]).unwrap().save(folder.path().join(name)).unwrap();
            assert_eq!(has_anatomy(&path), expected, "{name}");
        }
    }
}
