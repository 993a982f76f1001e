//! Vectors: by default, and by `magnitude`, a voxel is the norm of its components.

use flate2::Compression;
use flate2::write::GzEncoder;
use layersplat::renderer::volume_renderer;
use layersplat::volume::{Grid, OpenOptions, Volume, convert};
use layersplat::{Camera, Device, DeviceChoice, Error, Orbit, Settings, TransferFunction, Viewport};
use std::io::Write;
use std::path::{Path, PathBuf};

const DIMS: [usize; 3] = [5, 4, 3];
const VOXELS: usize = 60;

/// Component `n` of voxel `i`.
fn component(i: usize, n: usize) -> i16 {
    ((i * (7 + 5 * n) + 13 * n) % 101) as i16 - 50
}

/// Norms of the vectors, each component times `factor`.
fn norms(factor: f64) -> Vec<f32> {
    let square = |i: usize, n: usize| (factor * f64::from(component(i, n))).powi(2);
    (0..VOXELS).map(|i| (0..3).map(|n| square(i, n)).sum::<f64>().sqrt() as f32).collect()
}

/// All numbers, components first or last.
fn numbers(components_first: bool) -> Vec<i16> {
    let at = |k: usize| if components_first { component(k / 3, k % 3) } else { component(k % VOXELS, k / VOXELS) };
    (0..3 * VOXELS).map(at).collect()
}

fn bytes(numbers: &[i16]) -> Vec<u8> {
    numbers.iter().flat_map(|n| n.to_le_bytes()).collect()
}

fn text() -> String {
    numbers(true).iter().map(|n| format!("{n} ")).collect()
}

fn packed(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

fn write(path: &Path, name: &str, contents: impl AsRef<[u8]>) -> PathBuf {
    std::fs::write(path.join(name), contents).unwrap();
    path.join(name)
}

fn nrrd(kind: &str, encoding: &str, last: bool) -> Vec<u8> {
    let (sizes, kinds) = match last {
        false => ("3 5 4 3".to_owned(), format!("{kind} domain domain domain")),
        true => ("5 4 3 3".to_owned(), format!("domain domain domain {kind}")),
    };
    let head =
        format!("NRRD0004\ntype: int16\ndimension: 4\nsizes: {sizes}\nkinds: {kinds}\nendian: little\nencoding: {encoding}\n\n");
    let voxels = bytes(&numbers(!last));
    [head.as_bytes(), &if encoding == "gzip" { packed(&voxels) } else { voxels }].concat()
}

/// A NIfTI file of int16 with a fifth axis of components, whose values are half the numbers.
fn nifti(intent: i16) -> Vec<u8> {
    let mut header = [0u8; 352];
    header[0..4].copy_from_slice(&348i32.to_le_bytes());
    for (n, size) in [5, 5, 4, 3, 1, 3, 1, 1].into_iter().enumerate() {
        header[40 + 2 * n..42 + 2 * n].copy_from_slice(&(size as i16).to_le_bytes());
    }
    header[68..70].copy_from_slice(&intent.to_le_bytes());
    header[70..72].copy_from_slice(&4i16.to_le_bytes());
    header[72..74].copy_from_slice(&16i16.to_le_bytes());
    for n in 0..8 {
        header[76 + 4 * n..80 + 4 * n].copy_from_slice(&1f32.to_le_bytes());
    }
    header[108..112].copy_from_slice(&352f32.to_le_bytes());
    header[112..116].copy_from_slice(&0.5f32.to_le_bytes());
    header[344..348].copy_from_slice(b"n+1\0");
    [header.to_vec(), bytes(&numbers(false))].concat()
}

fn npy() -> Vec<u8> {
    let mut header = "{'descr': '<i2', 'fortran_order': False, 'shape': (3, 4, 5, 3), }".to_owned();
    header += &" ".repeat(117 - header.len());
    [b"\x93NUMPY\x01\x00\x76\x00".to_vec(), header.into_bytes(), b"\n".to_vec(), bytes(&numbers(true))].concat()
}

fn legacy(keyword: &str) -> String {
    format!(
        "# vtk DataFile Version 3.0\nvectors\nASCII\nDATASET STRUCTURED_POINTS\nDIMENSIONS 5 4 3\nORIGIN 0 0 0\nSPACING 1 1 1\n\
         POINT_DATA 60\n{keyword}\n{}\n",
        text()
    )
}

#[cfg(feature = "vtk")]
fn vti(marked: &str) -> String {
    format!(
        r#"<?xml version="1.0"?><VTKFile type="ImageData" version="0.1" byte_order="LittleEndian">
        <ImageData WholeExtent="0 4 0 3 0 2" Origin="0 0 0" Spacing="1 1 1"><Piece Extent="0 4 0 3 0 2"><PointData {marked}>
        <DataArray type="Int16" Name="velocity" NumberOfComponents="3" format="ascii">{}</DataArray>
        </PointData></Piece></ImageData></VTKFile>"#,
        text()
    )
}

fn open(path: &Path, options: &OpenOptions) -> Volume<'static> {
    Volume::open(path, options).unwrap_or_else(|error| panic!("{error}"))
}

fn values(volume: &Volume) -> Vec<f32> {
    (0..VOXELS).map(|i| volume.value(i) as f32).collect()
}

fn magnitude() -> OpenOptions {
    OpenOptions { magnitude: true, ..OpenOptions::default() }
}

/// Files whose header declares a vector, mapped, packed and as text; components side by side and in volumes of their own.
#[test]
fn declared_vectors_are_magnitudes() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    let mut files = vec![
        (write(f, "raw.nrrd", nrrd("3-vector", "raw", false)), 1.0),
        (write(f, "packed.nrrd", nrrd("vector", "gzip", false)), 1.0),
        (write(f, "last.nrrd", nrrd("covariant-vector", "raw", true)), 1.0),
        (write(f, "vector.nii", nifti(1007)), 0.5),
        (write(f, "vector.nii.gz", packed(&nifti(1006))), 0.5),
        (write(f, "vectors.vtk", legacy("VECTORS velocity short")), 1.0),
    ];
    #[cfg(feature = "vtk")]
    files.push((write(f, "velocity.vti", vti(r#"Vectors="velocity""#)), 1.0));
    files.shrink_to_fit();
    for (file, factor) in &files {
        let what = file.display();
        for options in [OpenOptions::default(), magnitude(), OpenOptions { memory: Some(64), ..OpenOptions::default() }] {
            let volume = open(file, &options);
            assert_eq!((volume.grid().dims(), values(&volume)), (DIMS, norms(*factor)), "{what}");
            assert!(volume.contents().magnitude && volume.contents().channels == 3, "{what}");
            // Statistics are those of the magnitude.
            let expected = norms(*factor)
                .into_iter()
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), norm| (lo.min(norm.into()), hi.max(norm.into())));
            assert_eq!(volume.range(), expected, "{what}");
        }
        for n in 0..3 {
            let volume = open(file, &OpenOptions { channel: Some(n), ..OpenOptions::default() });
            let expected: Vec<f32> = (0..VOXELS).map(|i| f32::from(component(i, n)) * *factor as f32).collect();
            assert_eq!(values(&volume), expected, "{what} {n}");
            assert_eq!((volume.contents().channel, volume.contents().magnitude), (n, false));
        }
    }
}

/// Components that are not declared as a vector have a magnitude if it is asked for.
#[test]
fn other_components_have_a_magnitude_on_request() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    let metaimage = "ObjectType = Image\nNDims = 3\nDimSize = 5 4 3\nElementType = MET_SHORT\nElementNumberOfChannels = 3\n\
                     ElementDataFile = LOCAL\n";
    let files = [
        (write(f, "colours.nrrd", nrrd("RGB-color", "raw", false)), 1.0),
        (write(f, "plain.nii", nifti(0)), 0.5),
        (write(f, "plain.npy", npy()), 1.0),
        (write(f, "plain.mha", [metaimage.as_bytes(), &bytes(&numbers(true))].concat()), 1.0),
        (write(f, "scalars.vtk", legacy("SCALARS velocity short 3\nLOOKUP_TABLE default")), 1.0),
    ];
    for (file, factor) in &files {
        let first: Vec<f32> = (0..VOXELS).map(|i| f32::from(component(i, 0)) * *factor as f32).collect();
        assert_eq!(values(&open(file, &OpenOptions::default())), first, "{}", file.display());
        assert_eq!(values(&open(file, &magnitude())), norms(*factor), "{}", file.display());
    }
    let scalar = write(f, "one_5x4x3_int16.raw", &bytes(&numbers(true))[..2 * VOXELS]);
    for (file, options, words) in
        [(&scalar, magnitude(), "one number"), (&files[0].0, OpenOptions { channel: Some(1), ..magnitude() }, "omit one")]
    {
        let error = Volume::open(file, &options).unwrap_err();
        assert!(matches!(error, Error::Settings { field: "channel", .. }) && error.to_string().contains(words), "{error}");
    }
    let cut = nrrd("3-vector", "raw", false);
    let error = Volume::open(write(f, "cut.nrrd", &cut[..cut.len() - 1]), &OpenOptions::default()).unwrap_err();
    assert!(error.to_string().contains("truncated"), "{error}");
}

/// A component without a value makes the voxel one without a value.
#[test]
fn invalid_components_make_invalid_voxels() {
    let folder = tempfile::tempdir().unwrap();
    let head = "NRRD0004\ntype: float\ndimension: 4\nsizes: 3 2 2 2\nkinds: vector domain domain domain\nendian: little\nencoding: raw\n\n";
    let numbers = (0..24).flat_map(|n| if n == 7 { f32::NAN } else { n as f32 }.to_le_bytes()).collect::<Vec<_>>();
    let volume = open(&write(folder.path(), "nan.nrrd", [head.as_bytes(), &numbers].concat()), &OpenOptions::default());
    assert_eq!((volume.invalid(), volume.range().0), (1, 5f64.sqrt() as f32 as f64));
}

/// Pictures are those of a volume that has the magnitudes as its voxels: whole, and in parts.
#[test]
fn pictures_and_converted_files_are_those_of_the_magnitude() {
    let folder = tempfile::tempdir().unwrap();
    let f = folder.path();
    let file = write(f, "velocity.nrrd", nrrd("vector", "raw", false));
    let vectors = open(&file, &OpenOptions::default());
    let norms = Volume::new("norms", Grid::new(DIMS, layersplat::glam::DVec3::ONE).unwrap(), norms(1.0)).unwrap();
    let transfer = TransferFunction::automatic(&norms);
    assert_eq!(transfer.opacities(), TransferFunction::automatic(&vectors).opacities());
    let size = Viewport::new(24, 20).unwrap();
    let device = Device::open(&DeviceChoice::Default).unwrap();
    for azimuth in [10.0, 80.0] {
        let orbit = Orbit { azimuth, elevation: 20.0, roll: 0.0 };
        let camera = Camera::fit_parallel(norms.grid().centre(), norms.grid().diagonal(), size, orbit);
        let mut pictures = Vec::new();
        for device in [device.clone(), device.with_memory(4_000_000)] {
            for volume in [&norms, &vectors] {
                let mut renderer = volume_renderer(&device, volume, &transfer).unwrap();
                pictures.push(renderer.render(&camera, size, &Settings::default()).unwrap().0.unwrap());
            }
        }
        assert!(pictures.iter().all(|picture| *picture == pictures[0]));
        assert!(pictures[0].pixels().iter().any(|pixel| pixel[3] > 0.1));
    }
    let written = convert(&file, &OpenOptions::default(), f.join("norms.nrrd")).unwrap();
    assert_eq!(values(&open(&written, &OpenOptions::default())), values(&norms));
}
