//! An image file of a series, with one or several frames.

use super::beginning::Encoding;
use super::dataset::{Dataset, Found, PixelData, Source};
use super::packed::{Packing, Shape};
use crate::error::Error;
use crate::volume::{FrameSpacing, ScalarType};
use dicom_core::Tag;
use dicom_dictionary_std::tags;
use dicom_encoding::TransferSyntaxIndex;
use dicom_transfer_syntax_registry::TransferSyntaxRegistry;
use glam::DVec3;
use std::path::{Path, PathBuf};

/// Limit of frames per file.
const MOST_FRAMES: usize = 1 << 20;

/// Encoding of the pixels of a file.
#[derive(Clone, Copy, PartialEq)]
pub(super) struct Kind {
    pub scalar: ScalarType,
    /// Whether a pixel takes one bit.
    pub is_bit: bool,
    /// Number of significant bits, and the position of the lowest one.
    pub bits: u32,
    pub shift: u32,
    pub signed: bool,
    pub big_endian: bool,
    /// Whether channels are stored as separate planes.
    pub planar: bool,
    pub packing: Option<Packing>,
    /// Whether colours are stored as luminance and chrominance.
    pub luminance: bool,
    /// Whether the channels are red, green and blue once they are decoded.
    pub are_colors: bool,
}

/// Geometry, rescaling and order of a slice.
#[derive(Clone)]
pub(super) struct Frame {
    /// Position of the first pixel, and directions of rows and columns, in LPS coordinates.
    pub position: Option<DVec3>,
    pub axes: Option<[DVec3; 2]>,
    /// Pixel spacing along x and y.
    pub spacing: Option<[f64; 2]>,
    /// Whether the frame has a position of its own.
    pub is_placed: bool,
    /// Stated distance between slices.
    pub between: Option<f64>,
    /// Distance between slices, for use if their positions do not give it.
    pub thickness: Option<f64>,
    pub slope: f64,
    pub intercept: f64,
    /// Sort key for slices at the same position.
    pub order: [i64; 3],
}

/// An image file.
#[derive(Clone)]
pub(super) struct Image {
    pub path: PathBuf,
    pub shape: Shape,
    pub kind: Kind,
    pub frames: Vec<Frame>,
    /// Colours of the stored numbers, 0 to 1, if they are indices of a palette.
    pub palette: Vec<[f64; 3]>,
    /// Distance between times of a series.
    pub frame_spacing: Option<FrameSpacing>,
    pub source: Source,
    pub pixels: PixelData,
}

impl Image {
    pub fn new(path: &Path, found: Found) -> Result<Self, Error> {
        let wrong = |problem: String| Error::volume(path, problem);
        let Found { dataset, pixels, source, syntax, encoding } = found;
        let pixels = pixels.ok_or_else(|| wrong("it has no pixels".into()))?;
        let size =
            |tag: Tag, name: &str| dataset.whole(tag).filter(|&n| n > 0).ok_or_else(|| wrong(format!("its image has no {name}")));
        let (rows, columns) = (size(tags::ROWS, "rows")?, size(tags::COLUMNS, "columns")?);
        let channels = dataset.whole(tags::SAMPLES_PER_PIXEL).unwrap_or(1);
        let kind = kind(&dataset, pixels, channels, &syntax, encoding).map_err(wrong)?;
        let count = frames_of(&dataset);
        if count > MOST_FRAMES || !(1..=4).contains(&channels) || rows > 65535 || columns > 65535 {
            return Err(wrong(format!(
                "it has {count} frames of {columns}x{rows} pixels with {channels} channels, which is not supported"
            )));
        }
        Ok(Self {
            path: path.into(),
            shape: Shape { columns, rows, channels, bytes: kind.scalar.bytes() },
            kind,
            frames: frames(&dataset, count),
            palette: palette(&dataset).map_err(wrong)?,
            frame_spacing: dataset.number(tags::TEMPORAL_RESOLUTION).and_then(|ms| FrameSpacing::new(ms, Some("ms"))),
            source,
            pixels,
        })
    }
}

/// Number of frames of a file.
pub(super) fn frames_of(dataset: &Dataset) -> usize {
    dataset.whole(tags::NUMBER_OF_FRAMES).unwrap_or(1).max(1)
}

fn kind(dataset: &Dataset, pixels: PixelData, channels: usize, syntax: &str, encoding: Encoding) -> Result<Kind, String> {
    let packing = match syntax {
        "1.2.840.10008.1.2" | "1.2.840.10008.1.2.1" | "1.2.840.10008.1.2.1.99" | "1.2.840.10008.1.2.2" => None,
        "1.2.840.10008.1.2.5" => Some(Packing::Rle),
        "1.2.840.10008.1.2.4.50" | "1.2.840.10008.1.2.4.51" | "1.2.840.10008.1.2.4.57" | "1.2.840.10008.1.2.4.70" => {
            Some(Packing::Jpeg)
        }
        other => {
            let name = TransferSyntaxRegistry.get(other).map_or(other, |syntax| syntax.name());
            return Err(format!(
                "its pixels are compressed as {name}, which is not supported: decompress them, for example with gdcmconv"
            ));
        }
    };
    if pixels.len.is_some() != packing.is_none() {
        return Err("its transfer syntax and its pixel data disagree on whether the pixels are compressed".into());
    }
    if dataset.text(tags::IMAGE_TYPE).is_some_and(|kind| kind.split('\\').any(|word| word == "MOSAIC")) {
        return Err("its slices are tiles of one picture (a Siemens mosaic): separate them, for example with dcm2niix".into());
    }
    if dataset.item(tags::MODALITY_LUT_SEQUENCE, 0).is_some() {
        return Err(
            "a table maps its stored numbers to values (Modality LUT), which is not supported: apply it, for example with \
                    pydicom's apply_modality_lut"
                .into(),
        );
    }
    let photometric = dataset.text(tags::PHOTOMETRIC_INTERPRETATION).unwrap_or_default();
    let luminance = photometric.starts_with("YBR");
    let allocated = dataset.whole(tags::BITS_ALLOCATED).unwrap_or(0);
    if luminance && channels == 3 && packing != Some(Packing::Jpeg) && (photometric != "YBR_FULL" || allocated != 8) {
        return Err(format!(
            "its colours are {photometric} of {allocated} bits: convert them to RGB, or to one number per pixel"
        ));
    }
    let signed = dataset.whole(tags::PIXEL_REPRESENTATION) == Some(1);
    let (scalar, whole) = match (pixels.tag, allocated, signed) {
        (tags::FLOAT_PIXEL_DATA, ..) => (ScalarType::Float32, false),
        (tags::DOUBLE_FLOAT_PIXEL_DATA, ..) => (ScalarType::Float64, false),
        (_, 1, _) if packing.is_none() => (ScalarType::Uint8, true),
        (_, 8, false) => (ScalarType::Uint8, true),
        (_, 8, true) => (ScalarType::Int8, true),
        (_, 16, false) => (ScalarType::Uint16, true),
        (_, 16, true) => (ScalarType::Int16, true),
        (_, 32, false) => (ScalarType::Uint32, true),
        (_, 32, true) => (ScalarType::Int32, true),
        _ => return Err(format!("its pixels have {allocated} bits: expected 1, 8, 16 or 32; convert it")),
    };
    let is_bit = allocated == 1 && whole;
    let all = if is_bit { 1 } else { 8 * scalar.bytes() as u32 };
    let declared = |tag: Tag| dataset.whole(tag).and_then(|n| u32::try_from(n).ok()).filter(|_| whole);
    let bits = declared(tags::BITS_STORED).filter(|bits| (1..=all).contains(bits)).unwrap_or(all);
    let highest = declared(tags::HIGH_BIT).filter(|&highest| highest < all && highest + 1 >= bits).unwrap_or(bits - 1);
    let big_endian = encoding == Encoding::ExplicitBigEndian;
    if big_endian && pixels.words && scalar.bytes() == 1 {
        return Err("its bytes are stored in big-endian words: convert it to a little-endian transfer syntax".into());
    }
    let planar = dataset.whole(tags::PLANAR_CONFIGURATION) == Some(1) && packing.is_none();
    Ok(Kind {
        scalar,
        is_bit,
        bits,
        shift: highest + 1 - bits,
        signed,
        big_endian,
        planar,
        packing,
        luminance,
        are_colors: channels == 3,
    })
}

/// The colours of a palette; none if the image has none.
fn palette(dataset: &Dataset) -> Result<Vec<[f64; 3]>, String> {
    if dataset.text(tags::PHOTOMETRIC_INTERPRETATION).as_deref() != Some("PALETTE COLOR") {
        return Ok(Vec::new());
    }
    let wrong = || "its palette is missing, in segments or damaged: convert its colours to RGB".to_owned();
    let table = |descriptor: Tag, data: Tag| {
        let [entries, first, bits] = <[f64; 3]>::try_from(dataset.numbers(descriptor)).map_err(|_| wrong())?;
        let entries = if entries == 0.0 { 1 << 16 } else { entries as usize };
        let mut numbers = dataset.numbers(data);
        if numbers.len() < entries && bits == 8.0 {
            // Two to a word.
            numbers = numbers.iter().flat_map(|word| [word % 256.0, (word / 256.0).floor()]).collect();
        }
        if !(first >= 0.0 && [8.0, 16.0].contains(&bits) && numbers.len() >= entries && entries > 0) {
            return Err(wrong());
        }
        // Numbers before the first one have its colour.
        let before = std::iter::repeat_n(numbers[0], first as usize);
        Ok(before.chain(numbers[..entries].iter().copied()).map(|part| part / (bits.exp2() - 1.0)).collect::<Vec<f64>>())
    };
    let red = table(tags::RED_PALETTE_COLOR_LOOKUP_TABLE_DESCRIPTOR, tags::RED_PALETTE_COLOR_LOOKUP_TABLE_DATA)?;
    let green = table(tags::GREEN_PALETTE_COLOR_LOOKUP_TABLE_DESCRIPTOR, tags::GREEN_PALETTE_COLOR_LOOKUP_TABLE_DATA)?;
    let blue = table(tags::BLUE_PALETTE_COLOR_LOOKUP_TABLE_DESCRIPTOR, tags::BLUE_PALETTE_COLOR_LOOKUP_TABLE_DATA)?;
    if red.len() != green.len() || red.len() != blue.len() {
        return Err(wrong());
    }
    Ok((0..red.len()).map(|n| [red[n], green[n], blue[n]]).collect())
}

fn frames(dataset: &Dataset, count: usize) -> Vec<Frame> {
    let offsets = dataset.numbers(tags::GRID_FRAME_OFFSET_VECTOR);
    let instance = dataset.whole(tags::INSTANCE_NUMBER).unwrap_or(0) as i64;
    let temporal = dataset.whole(tags::TEMPORAL_POSITION_IDENTIFIER).unwrap_or(0) as i64;
    let frame_at = |index: usize| {
        let groups = Groups { dataset, index };
        let axes = vectors(&groups.numbers(tags::PLANE_ORIENTATION_SEQUENCE, tags::IMAGE_ORIENTATION_PATIENT));
        let axes = <[DVec3; 2]>::try_from(axes).ok().filter(|axes| axes.iter().all(|axis| axis.length() > 0.5));
        let declared = vectors(&groups.numbers(tags::PLANE_POSITION_SEQUENCE, tags::IMAGE_POSITION_PATIENT)).first().copied();
        let measures = tags::PIXEL_MEASURES_SEQUENCE;
        let between = groups.numbers(measures, tags::SPACING_BETWEEN_SLICES);
        let thickness = groups.numbers(measures, tags::SLICE_THICKNESS);
        let thickness = between.first().or(thickness.first()).copied().filter(|h| h.is_finite() && *h != 0.0);
        let own = count == 1 || groups.own().is_some();
        let is_placed = count == 1 || groups.own().is_some_and(|own| own.item(tags::PLANE_POSITION_SEQUENCE, 0).is_some());
        // Frames without a position follow the first one along the normal.
        let behind = offsets.get(index).copied().or(thickness.map(|h| h * index as f64));
        let position = match (declared, axes) {
            (Some(declared), _) if own => Some(declared),
            (Some(declared), Some([x, y])) => behind.map(|h| declared + x.cross(y).normalize_or_zero() * h),
            _ => None,
        };
        let spacing = groups.numbers(measures, tags::PIXEL_SPACING);
        let spacing = if spacing.is_empty() { dataset.numbers(tags::IMAGER_PIXEL_SPACING) } else { spacing };
        let spacing = <[f64; 2]>::try_from(spacing).ok().filter(|h| h.iter().all(|h| h.is_finite() && *h > 0.0));
        let values = tags::PIXEL_VALUE_TRANSFORMATION_SEQUENCE;
        let scaling = dataset.number(tags::DOSE_GRID_SCALING);
        let slope = groups.numbers(values, tags::RESCALE_SLOPE).first().copied().or(scaling);
        let intercept = groups.numbers(values, tags::RESCALE_INTERCEPT).first().copied();
        let time = groups.numbers(tags::FRAME_CONTENT_SEQUENCE, tags::TEMPORAL_POSITION_INDEX).first().map(|&n| n as i64);
        Frame {
            position: position.filter(|position| position.is_finite()),
            axes,
            spacing: spacing.map(|[y, x]| [x, y]),
            is_placed,
            between: between.first().map(|h| h.abs()).filter(|h| h.is_finite() && *h > 0.0),
            thickness: thickness.map(f64::abs),
            slope: slope.filter(|slope| slope.is_finite() && *slope != 0.0).unwrap_or(1.0),
            intercept: intercept.filter(|intercept| intercept.is_finite()).unwrap_or(0.0),
            order: [time.unwrap_or(temporal), instance, index as i64],
        }
    };
    (0..count).map(frame_at).collect()
}

fn vectors(numbers: &[f64]) -> Vec<DVec3> {
    numbers.chunks_exact(3).map(DVec3::from_slice).collect()
}

/// Sources of the attributes of a frame.
struct Groups<'a> {
    dataset: &'a Dataset,
    index: usize,
}

impl Groups<'_> {
    /// Attributes of this frame alone.
    fn own(&self) -> Option<&Dataset> {
        self.dataset.item(tags::PER_FRAME_FUNCTIONAL_GROUPS_SEQUENCE, self.index)
    }

    /// Attribute of this frame, else of all frames, else of the image.
    fn numbers(&self, group: Tag, tag: Tag) -> Vec<f64> {
        let shared = self.dataset.item(tags::SHARED_FUNCTIONAL_GROUPS_SEQUENCE, 0);
        let declared = [self.own(), shared].into_iter().flatten().filter_map(|groups| groups.item(group, 0));
        let found = declared.map(|group| group.numbers(tag)).find(|numbers| !numbers.is_empty());
        found.unwrap_or_else(|| self.dataset.numbers(tag))
    }
}
