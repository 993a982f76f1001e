//! FreeSurfer's MGH, and MGZ, which is MGH with gzip (<https://surfer.nmr.mgh.harvard.edu/fswiki/FsTutorial/MghFormat>).

use super::bytes::{self, Bytes, Gzip, Packed, Packing, Plain};
use super::load::{self, Header, Opened};
use super::{Format, Found, OpenOptions};
use crate::error::Error;
use crate::volume::{Contents, Endian, ScalarType};
use glam::{DAffine3, DMat3, DVec3};
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

/// MGH and MGZ.
pub(super) struct Mgh;

/// Byte of the first voxel.
const FIRST: u64 = 284;
/// Bytes of the header that are used.
const USED: usize = 90;
/// The header begins with its version.
const MARK: [u8; 4] = [0, 0, 0, 1];

impl Format for Mgh {
    fn recognises(&self, file: &Found, _options: &OpenOptions) -> bool {
        file.ends_with(&[".mgh", ".mgz", ".mgh.gz"]) && file.unpacked.as_ref().unwrap_or(&file.start).starts_with(&MARK)
    }

    fn open(&self, file: &Found, options: &OpenOptions) -> Result<Opened, Error> {
        let path = file.path;
        let is_packed = file.unpacked.is_some();
        let fields = Fields::read(path, is_packed)?;
        let wrong = |problem: String| Error::volume(path, problem);
        let scalar = match fields.whole(20) {
            0 => ScalarType::Uint8,
            1 => ScalarType::Int32,
            3 => ScalarType::Float32,
            4 => ScalarType::Int16,
            10 => ScalarType::Uint16,
            code => {
                return Err(wrong(format!("its type is {code}: expected 0, 1, 3, 4 or 10; convert it (mri_convert -odt float)")));
            }
        };
        let sizes = [4, 8, 12, 16].map(|at| usize::try_from(fields.whole(at)).ok().filter(|&n| n > 0));
        let [Some(x), Some(y), Some(z), Some(frames)] = sizes else {
            return Err(wrong("its sizes are empty or negative".into()));
        };
        let all = [x, y, z, frames].iter().try_fold(scalar.bytes() as u64, |n, &size| n.checked_mul(size as u64));
        all.ok_or_else(|| wrong("its sizes are too large".into()))?;
        let has_place = fields.short(28) != 0;
        let place = fields.index_to_world([x, y, z], has_place);
        let grid = load::grid_of_patient(path, [x, y, z], place, true, options)?;
        let length_unit = has_place.then(|| "mm".to_owned());
        let mut contents = Contents { states_spacing: has_place, length_unit, ..Contents::default() };
        let frame = contents.choose_frame(path, options, frames)?;
        let header = Header { endian: Endian::Big, ..Header::new(grid, scalar) }.with_contents(contents).with_frame(frame);
        let failed = |e| Error::read(path, e);
        let bytes: Box<dyn Bytes> = if is_packed {
            Box::new(Packed::<Gzip>::new(path, 0, FIRST).map_err(failed)?)
        } else {
            Box::new(Plain::new(File::open(path).map_err(failed)?, FIRST).map_err(failed)?)
        };
        Ok(Opened { header, bytes, exact: false })
    }
}

/// The header, big-endian.
struct Fields([u8; USED]);

impl Fields {
    fn read(path: &Path, is_packed: bool) -> Result<Self, Error> {
        let failed = |e| Error::read(path, e);
        let mut fields = [0; USED];
        let mut file = File::open(path).map_err(failed)?;
        let found = if is_packed {
            bytes::fill(&mut Gzip::unpack(BufReader::new(file)), &mut fields)
        } else {
            bytes::fill(&mut file, &mut fields)
        };
        if found.map_err(failed)? < USED {
            return Err(Error::volume(path, "its header is truncated"));
        }
        Ok(Self(fields))
    }

    fn get<const N: usize>(&self, at: usize) -> [u8; N] {
        self.0[at..].first_chunk().copied().unwrap_or([0; N])
    }

    fn whole(&self, at: usize) -> i32 {
        i32::from_be_bytes(self.get(at))
    }

    fn short(&self, at: usize) -> i16 {
        i16::from_be_bytes(self.get(at))
    }

    fn vector(&self, at: usize) -> DVec3 {
        DVec3::from_array([0, 4, 8].map(|i| f32::from_be_bytes(self.get(at + i)).into()))
    }

    /// Transform to RAS coordinates: spacings, directions of the axes, and the position of the voxel at half of the sizes. Without these, voxels of
    /// size 1 lie coronally.
    fn index_to_world(&self, dims: [usize; 3], has_place: bool) -> DAffine3 {
        let (spacing, axes, centre) = if has_place {
            (self.vector(30), DMat3::from_cols(self.vector(42), self.vector(54), self.vector(66)), self.vector(78))
        } else {
            (DVec3::ONE, DMat3::from_cols(DVec3::NEG_X, DVec3::NEG_Z, DVec3::Y), DVec3::ZERO)
        };
        let matrix3 = axes * DMat3::from_diagonal(spacing);
        DAffine3 { matrix3, translation: centre - matrix3 * (DVec3::from_array(dims.map(|n| n as f64)) / 2.0) }
    }
}
