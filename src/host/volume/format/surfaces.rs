//! Files of surfaces, which are no volumes.

use super::load::Opened;
use super::{Format, Found, OpenOptions};
use crate::error::Error;
use std::path::Path;

/// A format of surfaces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SurfaceFormat {
    Stl,
    Ply,
    VtkXml,
    VtkLegacy,
    Obj,
    Gifti,
    FreeSurfer,
}

/// The first bytes of FreeSurfer's surfaces.
pub(crate) const FREESURFER_TRIANGLES: [u8; 3] = [0xff, 0xff, 0xfe];

/// Bytes of a binary STL file before its triangles, and per triangle.
pub(crate) const STL_BYTES: [u64; 2] = [84, 50];

impl SurfaceFormat {
    /// The format of a file, if it holds a surface.
    pub fn of_file(path: &Path) -> Result<Option<Self>, Error> {
        Found::look(path).map(|file| Self::of(&file))
    }

    fn of(file: &Found) -> Option<Self> {
        let (start, has) =
            (&file.start, |text: &[u8]| file.start.windows(text.len()).any(|part| part.eq_ignore_ascii_case(text)));
        match () {
            () if file.folder => None,
            () if file.ends_with(&[".ply"]) || start.starts_with(b"ply\n") || start.starts_with(b"ply\r") => Some(Self::Ply),
            () if file.ends_with(&[".obj"]) => Some(Self::Obj),
            () if file.ends_with(&[".gii"]) || has(b"<GIFTI") => Some(Self::Gifti),
            () if start.starts_with(&FREESURFER_TRIANGLES) || is_of_hemisphere(file) => Some(Self::FreeSurfer),
            () if file.ends_with(&[".vtp"]) || has(b"<VTKFile") && has(b"\"PolyData\"") => Some(Self::VtkXml),
            () if start.starts_with(b"# vtk DataFile") && has(b"DATASET POLYDATA") => Some(Self::VtkLegacy),
            () if file.ends_with(&[".stl", ".stlb"]) || start.starts_with(b"solid") && has(b"facet") => Some(Self::Stl),
            () => (stl_triangles(start) > 0 && has_stl_size(file)).then_some(Self::Stl),
        }
    }

    /// Name of the format.
    pub fn name(self) -> &'static str {
        match self {
            Self::Stl => "STL",
            Self::Ply => "PLY",
            Self::VtkXml | Self::VtkLegacy => "VTK PolyData",
            Self::Obj => "OBJ",
            Self::Gifti => "GIFTI",
            Self::FreeSurfer => "FreeSurfer",
        }
    }
}

/// The number of triangles that the start of a binary STL file states.
pub(crate) fn stl_triangles(start: &[u8]) -> u32 {
    start.get(80..84).map_or(0, |count| u32::from_le_bytes([count[0], count[1], count[2], count[3]]))
}

/// Whether it has FreeSurfer's values or labels of the points of a hemisphere.
fn is_of_hemisphere(file: &Found) -> bool {
    let name = file.path.file_name().unwrap_or_default().to_string_lossy();
    let is_one = name.starts_with("lh.") || name.starts_with("rh.");
    is_one && (file.start.starts_with(&[0xff; 3]) || name.ends_with(".annot"))
}

fn has_stl_size(file: &Found) -> bool {
    let [before, each] = STL_BYTES;
    std::fs::metadata(file.path).is_ok_and(|metadata| metadata.len() == before + each * u64::from(stl_triangles(&file.start)))
}

/// Refuses surfaces as volumes.
pub(super) struct Surfaces;

impl Format for Surfaces {
    fn recognises(&self, file: &Found, _options: &OpenOptions) -> bool {
        SurfaceFormat::of(file).is_some()
    }

    fn chooses(&self) -> &'static [&'static str] {
        &["array", "level", "region", "series"]
    }

    fn open(&self, file: &Found, _options: &OpenOptions) -> Result<Opened, Error> {
        let name = SurfaceFormat::of(file).map_or("", SurfaceFormat::name);
        let problem = format!("{} holds a surface ({name}), not a volume: give it as a surface", file.path.display());
        Err(Error::Settings { field: "surface", problem })
    }
}
