//! Surfaces of other programs (make/surfaces.py) are read as they were written: a box, lines and points. Wrong files are refused.

use crate::files::folder;
use layersplat::glam::{DVec3, Vec3};
use layersplat::surface::{Per, PointData, Radius, Shape, Space, Surface, SurfaceFile, SurfaceOptions, open};
use layersplat::{OpenOptions, Volume};
use std::path::PathBuf;

const LOWEST: DVec3 = DVec3::new(1.0, -2.0, 3.0);
const SIZE: DVec3 = DVec3::new(1.5, 2.0, 4.0);

pub fn path(file: &str) -> PathBuf {
    folder().join("surfaces").join(file)
}

/// All files that this build supports.
pub fn all() -> Vec<String> {
    let entries = std::fs::read_dir(folder().join("surfaces")).unwrap();
    let names = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap());
    names.filter(|name| cfg!(feature = "vtk") || ![".vtp", ".gii"].iter().any(|ending| name.ends_with(ending))).collect()
}

fn surfaces(file: &str, options: &SurfaceOptions) -> Vec<Surface> {
    open(path(file), options).unwrap_or_else(|e| panic!("{file}: {e}"))
}

/// Six times the volume within the triangles, by the divergence theorem: negative if they are turned inside out.
fn volume(surface: &Surface) -> f64 {
    let Shape::Triangles(triangles) = surface.shape() else { panic!("no triangles: {surface:?}") };
    let corner = |n: u32| triangles.points()[n as usize] - LOWEST;
    triangles.indices().iter().map(|&[a, b, c]| corner(a).cross(corner(b)).dot(corner(c))).sum()
}

#[test]
fn boxes_are_closed_and_have_their_volume() {
    let mut seen = 0;
    for file in all().iter().filter(|file| !file.starts_with("points")) {
        let found = surfaces(file, &SurfaceOptions::default());
        let Shape::Triangles(triangles) = found[0].shape() else { panic!("{file}: {found:?}") };
        // Each of three pieces is the whole box.
        let boxes = if file.starts_with("pieces") { 3 } else { 1 };
        assert!(triangles.is_closed(), "{file}");
        assert_eq!((triangles.points().len(), triangles.indices().len()), (8 * boxes, 12 * boxes), "{file}");
        let bounds = found[0].bounds().unwrap();
        assert_eq!((bounds.lowest, bounds.highest), (LOWEST, LOWEST + SIZE), "{file}");
        assert_eq!(volume(&found[0]), 6.0 * SIZE.element_product() * boxes as f64, "{file}");
        seen += 1;
    }
    assert!(seen > 20);
}

/// Arrays are those of their points and cells, also behind triangulation and in pieces.
#[test]
fn arrays_belong_to_their_points_and_cells() {
    let mut seen = 0;
    for file in all() {
        let read = SurfaceFile::read(path(&file)).unwrap();
        for (n, name) in ["values", "from the corner", "cell"].into_iter().enumerate() {
            if read.array(name).is_err() {
                continue;
            }
            seen += 1;
            for surface in surfaces(&file, &SurfaceOptions { values: Some(name.into()), ..SurfaceOptions::default() }) {
                check_values(&file, &read, &surface, n);
            }
        }
    }
    assert!(seen > 60, "{seen}");
}

fn check_values(file: &str, read: &SurfaceFile, surface: &Surface, n: usize) {
    let points = match surface.shape() {
        Shape::Triangles(triangles) => triangles.points(),
        Shape::Spheres(spheres) => spheres.centres(),
        Shape::Tubes(tubes) => tubes.points(),
    };
    let expected: Vec<f32> = match n {
        0 => points.iter().map(|p| p.dot(DVec3::new(1.0, 10.0, 100.0)) as f32).collect(),
        1 => points.iter().map(|p| (*p - LOWEST).length() as f32).collect(),
        _ => {
            let numbers = match surface.shape() {
                Shape::Triangles(_) => &read.triangles.numbers,
                Shape::Spheres(_) => &read.vertices.numbers,
                Shape::Tubes(_) => &read.lines.numbers,
            };
            // Each piece counts its two lines and six sides.
            let count = if file.starts_with("pieces") { 8 } else { u32::MAX };
            numbers.iter().map(|number| (*number % count) as f32).collect()
        }
    };
    let (values, transfer) = surface.values().unwrap();
    assert_eq!(values, &if n < 2 { Per::Point(expected) } else { Per::Cell(expected) }, "{file}, {}", surface.name);
    assert!(transfer.range().0 < transfer.range().1);
}

/// Values and labels of the points, in files of their own.
#[test]
fn values_and_labels_are_added_to_their_points() {
    let data = |file: &str| folder().join("surface_data").join(file);
    let values: Vec<f32> =
        (0..8).map(|n| (1.0 + 1.5 * (n & 1) as f32) + 10.0 * ((n & 2) as f32 - 2.0) + 100.0 * (3.0 + (n & 4) as f32)).collect();
    for (file, name) in [("lh.thickness", "lh.thickness"), ("box.func.gii", "box.func.gii, 0")] {
        if cfg!(not(feature = "vtk")) && file.ends_with(".gii") {
            continue;
        }
        let mut read = SurfaceFile::read(path("lh.box")).unwrap();
        read.add(PointData::read(data(file)).unwrap()).unwrap();
        assert_eq!(read.array(name).unwrap().values, Per::Point(values.clone()), "{file}");
        if let Ok(vectors) = read.array("box.func.gii, 1") {
            let corners = (0..8).flat_map(|n| [1.5 * (n & 1) as f32, (n & 2) as f32, (n & 4) as f32]).collect();
            assert_eq!((vectors.components, &vectors.values), (3, &Per::Point(corners)), "they are stored by columns");
        }
    }
    for (file, alpha) in [("lh.parts.annot", 1.0), ("box.label.gii", 0.5)] {
        if cfg!(not(feature = "vtk")) && file.ends_with(".gii") {
            continue;
        }
        let mut read = SurfaceFile::read(path("trimesh.obj")).unwrap();
        read.add(PointData::read(data(file)).unwrap()).unwrap();
        let high = |point: &DVec3| point.z > LOWEST.z;
        let color = |point| if high(point) { [0.0, 0.0, 1.0, alpha] } else { [1.0, 0.0, 0.0, 1.0] };
        assert_eq!(read.colors, Some(Per::Point(read.points.iter().map(color).collect())), "{file}");
    }
    let message =
        SurfaceFile::read(path("points.ply")).unwrap().add(PointData { arrays: Vec::new(), colors: Some(vec![[1.0; 4]; 7]) });
    assert!(message.unwrap_err().to_string().contains("it has 8 points, and its data are of 7"));
    let message = PointData::read(path("text.ply")).unwrap_err().to_string();
    assert!(message.contains("it holds no values or labels of points"), "{message}");
}

/// Sides in the colours of the materials beside the file, whose names have blanks.
#[test]
fn materials_of_obj_have_colours() {
    let [surface] = open(folder().join("surface_data/materials.obj"), &SurfaceOptions::default()).unwrap().try_into().unwrap();
    assert_eq!(volume(&surface), 6.0 * SIZE.element_product());
    let color = |n: usize| if (n / 2).is_multiple_of(2) { [1.0, 0.0, 0.0, 0.5] } else { [0.0, 0.2, 1.0, 0.5] };
    assert_eq!(surface.colors(), Some(&Per::Cell((0..12).map(color).collect())));
}

/// The number of a triangle is that of the side on which it lies, behind points and lines.
#[test]
fn triangles_have_the_number_of_their_cell() {
    for (file, first) in [("text_42.vtk", 0), ("faces_big.ply", 0), ("all_binary_51.vtk", 4), ("all_text_42.vtk", 4)] {
        let read = SurfaceFile::read(path(file)).unwrap();
        let expected: Vec<u32> = (0..12).map(|n| first + n / 2).collect();
        assert_eq!(read.triangles.numbers, expected, "{file}");
        // Sides: z, y and x, in pairs.
        for (n, corners) in read.triangles.points.iter().enumerate() {
            let coordinates = corners.map(|corner| read.points[corner as usize][2 - n / 4]);
            assert!(coordinates.iter().all(|c| *c == coordinates[0]), "{file}: {n}");
        }
    }
}

#[test]
fn colours_and_normals_are_read() {
    let mut seen = 0;
    let files = ["text.ply", "little.ply", "big.ply", "colors_text_42.vtk", "colors_binary_51.vtk", "colors.vtp"];
    for file in files.into_iter().filter(|file| all().iter().any(|other| other == file)) {
        let [surface] = surfaces(file, &SurfaceOptions::default()).try_into().unwrap();
        let Shape::Triangles(triangles) = surface.shape() else { panic!("{file}") };
        let corners: Vec<DVec3> = triangles.points().iter().map(|point| (*point - LOWEST) / SIZE).collect();
        let colors = corners.iter().map(|c| [c.x as f32, c.y as f32, c.z as f32, 1.0]).collect();
        assert_eq!(surface.colors(), Some(&Per::Point(colors)), "{file}");
        let normals: Vec<Vec3> = corners.iter().map(|c| (*c * 2.0 - 1.0).as_vec3()).collect();
        assert_eq!(triangles.normals(), Some(&normals[..]), "{file}");
        let [plain] =
            surfaces(file, &SurfaceOptions { color: Some([1.0, 0.0, 0.5]), ..SurfaceOptions::default() }).try_into().unwrap();
        assert_eq!((plain.colors(), plain.color), (None, [1.0, 0.0, 0.5]), "{file}");
        seen += 1;
    }
    assert!(seen >= 5);
    for file in ["faces_text.ply", "faces_big.ply", "faces_little.ply"] {
        let [surface] = surfaces(file, &SurfaceOptions::default()).try_into().unwrap();
        let color = |n: usize| [1.0, 0.0, 51.0 * (n / 2) as f32 / 255.0, 0.4];
        assert_eq!(surface.colors(), Some(&Per::Cell((0..12).map(color).collect())), "{file}");
        assert!(surface.is_translucent());
    }
}

#[test]
fn lines_are_tubes_and_points_are_spheres() {
    let default = SIZE.length() / 200.0;
    for file in all().iter().filter(|file| file.starts_with("all")) {
        let found = surfaces(file, &SurfaceOptions { name: Some("x".into()), ..SurfaceOptions::default() });
        let names: Vec<&str> = found.iter().map(|surface| surface.name.as_str()).collect();
        assert_eq!(names, ["x, triangles", "x, tubes", "x, spheres"], "{file}");
        let (Shape::Tubes(tubes), Shape::Spheres(spheres)) = (found[1].shape(), found[2].shape()) else { panic!("{file}") };
        assert_eq!(tubes.lines().collect::<Vec<_>>(), [0..5, 5..7], "{file}");
        assert_eq!(tubes.points()[4], LOWEST + SIZE * DVec3::new(0.0, 1.0, 1.0), "{file}");
        assert_eq!((tubes.radii()[0], spheres.centres().len()), (default, 3), "{file}");
    }
    for file in all().iter().filter(|file| file.starts_with("points")) {
        let radius = Some(Radius::from("values"));
        let [surface] =
            surfaces(file, &SurfaceOptions { radius: Some("0.5".into()), ..SurfaceOptions::default() }).try_into().unwrap();
        let Shape::Spheres(spheres) = surface.shape() else { panic!("{file}") };
        assert_eq!((spheres.centres().len(), spheres.radii()[7]), (8, 0.5), "{file}");
        let [surface] = surfaces(file, &SurfaceOptions { radius, ..SurfaceOptions::default() }).try_into().unwrap();
        let Shape::Spheres(spheres) = surface.shape() else { panic!("{file}") };
        assert_eq!(spheres.radii()[0], LOWEST.dot(DVec3::new(1.0, 10.0, 100.0)), "{file}");
    }
}

/// Coordinates are changed where both the file's axes and the world's are known.
#[test]
fn spaces_are_those_of_the_header_or_the_options() {
    let turned = |file: &str, space, is_anatomical| {
        let [surface] = surfaces(file, &SurfaceOptions { space, is_anatomical, ..SurfaceOptions::default() }).try_into().unwrap();
        assert_eq!(
            volume(&surface.clone().with_matrix(layersplat::glam::DMat4::IDENTITY).unwrap()),
            6.0 * SIZE.element_product()
        );
        surface.bounds().unwrap().highest == DVec3::new(-LOWEST.x, -LOWEST.y, LOWEST.z + SIZE.z)
    };
    assert!(turned("space.vtk", None, true) && !turned("space.vtk", None, false));
    assert!(!turned("text.ply", None, true) && !turned("text.ply", Some(Space::Ras), true));
    assert!(turned("text.stl", Some(Space::Lps), true) && !turned("text.stl", Some(Space::Lps), false));
    assert!(!turned("text.stl", None, true));
    for (file, expected) in [
        ("colors_text_51.vtk", Some(Space::Ras)),
        ("space.vtk", Some(Space::Lps)),
        ("big.ply", Some(Space::Ras)),
        ("binary_42.vtk", None),
        ("appended_zlib.vtp", Some(Space::Lps)),
        ("text_space.vtp", Some(Space::Ras)),
    ] {
        if all().iter().any(|other| other == file) {
            assert_eq!(SurfaceFile::read(path(file)).unwrap().space, expected, "{file}");
        }
    }
    let options = SurfaceOptions { space: Some(Space::Ras), ..SurfaceOptions::default() };
    let message = open(path("space.vtk"), &options).unwrap_err().to_string();
    assert!(message.starts_with("space: is RAS, but") && message.contains("states LPS"), "{message}");
}

#[test]
fn surfaces_are_no_volumes_and_volumes_no_surfaces() {
    for file in all() {
        assert!(SurfaceFile::is_one(path(&file)), "{file}");
        let message = Volume::open(path(&file), &OpenOptions::default()).unwrap_err().to_string();
        assert!(message.starts_with("surface: ") && message.contains(&file) && message.contains("not a volume"), "{message}");
    }
    for file in ["vtk/legacy_30.vtk", "vtk/ascii_plain.vti", "nrrd/raw.nrrd", "png/words", "numpy/int16.npy"] {
        assert!(!SurfaceFile::is_one(folder().join(file)), "{file}");
        assert!(SurfaceFile::read(folder().join(file)).is_err(), "{file}");
    }
}

/// A file with some bytes replaced.
fn changed(file: &str, change: impl FnOnce(&mut Vec<u8>)) -> (tempfile::TempDir, PathBuf) {
    let temporary = tempfile::tempdir().unwrap();
    let mut bytes = std::fs::read(path(file)).unwrap();
    change(&mut bytes);
    let to = temporary.path().join(file);
    std::fs::write(&to, bytes).unwrap();
    (temporary, to)
}

/// A binary file whose header begins as that of a text does is read by its size.
#[test]
fn binary_files_may_begin_with_solid() {
    let (_temporary, path) = changed("binary.stl", |bytes| bytes[..18].copy_from_slice(b"solid x SPACE=LPS\n"));
    let file = SurfaceFile::read(&path).unwrap();
    assert_eq!((file.format.as_str(), file.triangles.points.len(), file.space), ("STL, binary", 12, Some(Space::Lps)));
    let (_temporary, path) = changed("binary.stl", |bytes| bytes.extend([0; 7]));
    assert_eq!(SurfaceFile::read(&path).unwrap().triangles.points.len(), 12);
}

#[test]
fn wrong_files_are_refused() {
    let nan = &f32::NAN.to_le_bytes()[..];
    let cases: &[(&str, &[u8], &[u8], &str)] = &[
        ("text.stl", b"vertex 1 -2 3", b"vertex 1 -2", "is no vertex"),
        ("text.stl", b"  vertex 1", b"  vertex nan", "is [NaN"),
        ("text.stl", b"outer", b"ou\xffter", "begins with"),
        ("text.stl", b"endsolid", b"", "truncated"),
        ("binary.stl", b"\x0c\0\0\0", b"\x00\xca\x9a\x3b", "1000000000 triangles"),
        ("binary.stl", b"\x0c\0\0\0", b"\x0d\0\0\0", "13 triangles"),
        ("binary.stl", &2.5f32.to_le_bytes(), nan, "NaN"),
        ("faces_text.ply", b"ply\n", b"plx\n", "no PLY file"),
        ("faces_text.ply", b"ascii", b"utf-8", "utf-8"),
        ("faces_text.ply", b"element vertex 8", b"element vertex -8", "'-8' of vertex"),
        ("faces_text.ply", b"element vertex 8", b"element vertex 1000000000", "1000000000 are declared"),
        ("faces_text.ply", b"element face 6", b"element face 1000000000", "1000000000 are declared"),
        ("faces_big.ply", b"element face 6", b"element face 1000000000", "1000000000 are declared"),
        ("faces_big.ply", b"element face 6", b"element face 7", "element face"),
        ("faces_text.ply", b"\n4 0 2 3 1", b"\n4 0 2 3 8", "point 8 of 8"),
        ("faces_text.ply", b"\n4 0 2 3 1", b"\n4 0 2 3 -1", "point -1"),
        ("faces_text.ply", b"\n4 0 2 3 1", b"\n-4 0 2 3 1", "list of -4"),
        ("faces_text.ply", b"\n4 0 2 3 1", b"\n1e9 0 2 3 1", "list of 1000000000"),
        ("faces_text.ply", b"property double x", b"property double w", "no x, y and z"),
        ("faces_text.ply", b"property double x", b"property real x", "declares no type"),
        ("faces_text.ply", b"end_header", b"end_of", "begins with 'end_of'"),
        ("faces_text.ply", b"element face", b"element vertex", "its element vertex"),
        ("text_42.vtk", b"POINTS 8", b"POINTS 80", "lacks"),
        ("text_42.vtk", b"POINTS 8 double\n1 ", b"POINTS 8 double\nnan ", "point 0 is [NaN"),
        ("text_42.vtk", b"4 0 2 3 1", b"4 0 2 3 9", "point 9 of 8"),
        ("text_42.vtk", b"4 0 2 3 1", b"9 0 2 3 1", "it is damaged"),
        ("text_42.vtk", b"POLYGONS 6", b"POLYGONS 7", "declares 7"),
        ("text_42.vtk", b"POLYGONS 6 30", b"POLYGONS 6 3000000000", "lacks"),
        ("binary_42.vtk", b"POINTS 8", b"POINTS 1000000000", "beyond its end"),
        ("binary_51.vtk", b"POLYGONS 7", b"POLYGONS 1000000000", "beyond its end"),
        ("text_51.vtk", b"0 4 8 12", b"0 4 12 8", "the points 12 to 8"),
        ("text_51.vtk", b"OFFSETS", b"OFSETS", "expected OFFSETS"),
    ];
    for &(file, from, to, word) in cases {
        refused(file, from, to, word);
    }
    #[cfg(feature = "vtk")]
    for (file, from, to, word) in [
        ("text.vtp", "NumberOfPoints=\"8\"", "NumberOfPoints=\"9\"", "ends after"),
        ("text.vtp", "NumberOfPoints=\"8\"", "NumberOfPoints=\"1000000000\"", "numbers are declared"),
        ("text.vtp", "NumberOfPolys=\"6\"", "NumberOfPolys=\"-6\"", "is not 1 numbers"),
        ("text.vtp", "NumberOfPoints=\"8\"", "NumberOfPoints=\"0\"", "no points"),
        ("text.vtp", "NumberOfVerts=\"0\"", "NumberOfVerts=\"2\"", "ends after 0 of 2"),
        ("inline.vtp", "NumberOfPolys=\"6\"", "NumberOfPolys=\"1000000000\"", "it is damaged"),
        ("appended.vtp", "NumberOfPoints=\"8\"", "NumberOfPoints=\"1000000000\"", "it is damaged"),
        ("appended_lz4.vtp", "NumberOfPoints=\"8\"", "NumberOfPoints=\"1000000000\"", "truncated or damaged"),
        ("text.vtp", "type=\"PolyData\"", "type=\"PolyDate\"", "it holds PolyDate"),
    ] {
        refused(file, from.as_bytes(), to.as_bytes(), word);
    }
    for name in ["a.stl", "a.ply", "a.vtp", "a.vtk"] {
        let temporary = tempfile::tempdir().unwrap();
        let path = temporary.path().join(name);
        std::fs::write(&path, "").unwrap();
        let message = SurfaceFile::read(&path).unwrap_err().to_string();
        assert!(message.contains(name), "{message}");
    }
}

#[track_caller]
fn refused(file: &str, from: &[u8], to: &[u8], word: &str) {
    let what = format!("{file} with {}", String::from_utf8_lossy(to));
    let (_temporary, path) = changed(file, |bytes| {
        let at = bytes.windows(from.len()).position(|part| part == from).unwrap_or_else(|| panic!("{what}: nothing to change"));
        bytes.splice(at..at + from.len(), to.iter().copied());
    });
    let message = match SurfaceFile::read(&path) {
        Ok(found) => panic!("{what} is read: {found:?}"),
        Err(e) => e.to_string(),
    };
    assert!(message.contains(word), "{what}: '{word}' is not in: {message}");
    assert!(message.contains(path.to_str().unwrap()), "{what}: {message}");
}

#[test]
fn wrong_options_are_refused() {
    let message = |options| open(path("all_binary_51.vtk"), &options).unwrap_err().to_string();
    let options = SurfaceOptions::default();
    let unknown = message(SurfaceOptions { values: Some("pressure".into()), ..options.clone() });
    assert!(unknown.contains("no array 'pressure': use cell, values, from the corner"), "{unknown}");
    assert!(message(SurfaceOptions { radius: Some("cell".into()), ..options.clone() }).contains("one of cells"));
    assert!(message(SurfaceOptions { radius: Some(Radius::All(-1.0)), ..options }).contains("0 or positive"));
}
