//! MetaImage, `.mha` and `.mhd` (<https://itk.org/Wiki/ITK/MetaIO/Documentation>).

mod data;

use super::keyed::Keyed;
use super::load::{self, Header, Opened};
use super::{Format, Found, OpenOptions};
use crate::error::Error;
use crate::volume::{Contents, Endian, FrameSpacing, ScalarType};
use glam::{DAffine3, DMat3, DVec3};

/// MetaImage.
pub(super) struct MetaImage;

/// Limit of axes.
const MOST: usize = 10;

impl Format for MetaImage {
    fn recognises(&self, file: &Found, _options: &OpenOptions) -> bool {
        let has = |word: &[u8]| file.start.windows(word.len()).any(|bytes| bytes == word);
        let first = file.start.split(|&byte| byte == b'\n').next().unwrap_or_default();
        first.contains(&b'=') && (has(b"NDims") || has(b"ObjectType")) && (has(b"DimSize") || file.ends_with(&[".mha", ".mhd"]))
    }

    fn open(&self, file: &Found, options: &OpenOptions) -> Result<Opened, Error> {
        let path = file.path;
        let fields = Keyed::read(path, '=', "ElementDataFile")?;
        let scalar = scalar(&fields)?;
        let channels = fields.number("ElementNumberOfChannels")?.unwrap_or(1usize);
        let sizes = sizes(&fields, scalar, channels)?;
        let size = |axis: usize| sizes.get(axis).copied().unwrap_or(1);
        let dims = [size(0), size(1), size(2)];
        let to_world = index_to_world(&fields, sizes.len())?;
        let grid = load::grid_of_patient(path, dims, to_world, is_anatomical(&fields), options)?;
        let states_spacing = fields.get(&["ElementSpacing", "ElementSize"]).is_some();
        let mut contents = Contents { states_spacing, ..Contents::default() };
        let frame = contents.choose_frame(path, options, sizes.iter().skip(3).product())?;
        let channel = contents.choose_component(path, options, channels, false)?;
        contents.frame_spacing = time_spacing(&fields, &sizes)?;
        let is_text = data::is_text(&fields);
        let endian = match fields.is_true(&["ElementByteOrderMSB", "BinaryDataByteOrderMSB"]) {
            _ if is_text => Endian::NATIVE,
            true => Endian::Big,
            false => Endian::Little,
        };
        let header = Header { endian, ..Header::new(grid, scalar) }.with_channels_inside(channel, channels).with_frame(frame);
        let header = header.with_contents(contents).with_magnitude(scalar.bytes() as u64);
        Ok(Opened { header, bytes: data::bytes(path, options, &fields, &sizes, (channels, scalar))?, exact: false })
    }
}

fn scalar(fields: &Keyed) -> Result<ScalarType, Error> {
    let name = fields.need("ElementType")?;
    match name {
        "MET_CHAR" => Ok(ScalarType::Int8),
        "MET_UCHAR" => Ok(ScalarType::Uint8),
        "MET_SHORT" => Ok(ScalarType::Int16),
        "MET_USHORT" => Ok(ScalarType::Uint16),
        "MET_INT" | "MET_LONG" => Ok(ScalarType::Int32),
        "MET_UINT" | "MET_ULONG" => Ok(ScalarType::Uint32),
        "MET_LONG_LONG" => Ok(ScalarType::Int64),
        "MET_ULONG_LONG" => Ok(ScalarType::Uint64),
        "MET_FLOAT" => Ok(ScalarType::Float32),
        "MET_DOUBLE" => Ok(ScalarType::Float64),
        _ => Err(fields.wrong(format!("its ElementType is '{name}': expected one from MET_CHAR to MET_DOUBLE"))),
    }
}

/// Sizes of all axes. Their product in bytes fits into 64 bits.
fn sizes(fields: &Keyed, scalar: ScalarType, channels: usize) -> Result<Vec<usize>, Error> {
    let axes = fields.number("NDims")?.filter(|n| (1..=MOST).contains(n));
    let axes = axes.ok_or_else(|| fields.wrong(format!("its NDims is not between 1 and {MOST}")))?;
    let sizes: Vec<usize> = fields.numbers(&["DimSize"], axes)?.ok_or_else(|| fields.wrong("its header has no DimSize"))?;
    let sizes = sizes[..axes].to_vec();
    let voxel_bytes = scalar.bytes() as u64;
    let all = sizes.iter().chain([&channels]).try_fold(voxel_bytes, |n, &size| n.checked_mul(size as u64).filter(|&n| n > 0));
    let problem = || fields.wrong(format!("its sizes {sizes:?} with {channels} channels are empty or too large"));
    all.ok_or_else(problem)?;
    Ok(sizes)
}

/// Spacing of the fourth axis, whose unit is not stated.
fn time_spacing(fields: &Keyed, sizes: &[usize]) -> Result<Option<FrameSpacing>, Error> {
    if sizes.len() != 4 {
        return Ok(None);
    }
    let spacing: Option<Vec<f64>> = fields.numbers(&["ElementSpacing"], 3)?;
    Ok(spacing.and_then(|spacing| FrameSpacing::new(*spacing.get(3)?, None)))
}

/// Whether the axes are named after a patient: `RAI` or other letters, one of each pair; `???` where they are unknown. As in ITK, the
/// names are only a copy of what the directions say.
fn is_anatomical(fields: &Keyed) -> bool {
    let letters = fields.get(&["AnatomicalOrientation"]).unwrap_or_default().to_ascii_uppercase();
    let has = |pair: [char; 2]| letters.contains(pair);
    letters.len() == 3 && has(['R', 'L']) && has(['A', 'P']) && has(['I', 'S'])
}

/// The file uses LPS coordinates, the world RAS.
fn index_to_world(fields: &Keyed, axes: usize) -> Result<DAffine3, Error> {
    let known = axes.min(3);
    let numbers = |keys: &[&str], least| fields.numbers::<f64>(keys, least);
    let vector =
        |numbers: &[f64], missing: f64| DVec3::from_array([0, 1, 2].map(|i| if i < known { numbers[i] } else { missing }));
    let spacing = match numbers(&["ElementSpacing"], known)? {
        Some(spacing) => Some(spacing),
        None => numbers(&["ElementSize"], known)?,
    };
    let spacing = spacing.map_or(DVec3::ONE, |spacing| vector(&spacing, 1.0));
    let origin = numbers(&["Offset", "Position", "Origin"], known)?.map_or(DVec3::ZERO, |origin| vector(&origin, 0.0));
    let directions = numbers(&["TransformMatrix", "Rotation", "Orientation"], axes * axes)?.map_or(DMat3::IDENTITY, |all| {
        let along = |axis: usize| {
            if axis < known { vector(&all[axis * axes..], 0.0) } else { DVec3::AXES[axis] }
        };
        DMat3::from_cols(along(0), along(1), along(2))
    });
    let to_world = DMat3::from_diagonal(DVec3::new(-1.0, -1.0, 1.0));
    Ok(DAffine3 { matrix3: to_world * directions * DMat3::from_diagonal(spacing), translation: to_world * origin })
}
