//! Segmentations (<https://dicom.nema.org/medical/dicom/current/output/chtml/part03/sect_A.51.html>): each frame has the pixels of one segment
//! in one slice, in any order, and slices without frames are background.

use super::dataset::{Dataset, Found};
use super::image::{Frame, Image};
use super::pixels::{self, Pixels};
use super::place::{self, EVEN, Located, SHIFTED, Slice, UNEVEN};
use crate::error::Error;
use crate::memory;
use crate::numbers::shortened;
use crate::volume::format::OpenOptions;
use crate::volume::format::parts::Parts;
use crate::volume::{Label, LabelTable, Rescale, ScalarType};
use dicom_dictionary_std::tags;
use glam::{DAffine3, DMat3, DVec3};
use std::collections::{BTreeMap, BTreeSet};
use std::io;
use std::path::{Path, PathBuf};

/// What the identifiers of segmentations and label maps begin with.
const CLASS: &[u8] = b"1.2.840.10008.5.1.4.1.1.66.";
/// Most segments of a file: their numbers have 16 bits.
const MOST: usize = 1 << 16;
/// Most layers that segments take which overlap.
const MOST_CHANNELS: usize = 256;
/// Most slices of a volume.
const MOST_SLICES: f64 = 65535.0;

/// Whether the first bytes of a file may be those of a segmentation.
pub(super) fn may_begin(start: &[u8]) -> bool {
    start.windows(CLASS.len()).any(|bytes| bytes == CLASS)
}

/// How the frames of a file hold its segments.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    /// A bit per pixel, and frames of each segment.
    Binary,
    /// A number per pixel, that of a segment.
    LabelMap,
    /// A number per pixel, and frames of each segment.
    Fractional,
}

/// Bits of slices that have a segment.
type Taken = BTreeMap<usize, Vec<u8>>;

/// A segmentation whose slices are located.
pub(super) struct Segmentation {
    path: PathBuf,
    image: Image,
    kind: Kind,
    table: Vec<Label>,
    /// Number of the segment of each frame; 0 in label maps.
    segments: Vec<u32>,
    /// Slice of each frame.
    places: Vec<usize>,
    pub slices: usize,
    pub index_to_world: DAffine3,
    pub rescale: Rescale,
    /// The segments of each channel. They do not overlap.
    channels: Vec<Vec<u32>>,
}

impl Segmentation {
    /// `None` if a file holds none.
    pub fn is_in(dataset: &Dataset) -> bool {
        dataset.text(tags::SEGMENTATION_TYPE).is_some()
    }

    pub fn new(path: &Path, found: Found, options: &OpenOptions) -> Result<Self, Error> {
        let wrong = |problem: String| Error::volume(path, problem);
        let kind = match found.dataset.text(tags::SEGMENTATION_TYPE).as_deref() {
            Some("BINARY") => Kind::Binary,
            Some("LABELMAP") => Kind::LabelMap,
            Some("FRACTIONAL") => Kind::Fractional,
            other => {
                let other = other.unwrap_or_default();
                return Err(wrong(format!("its segmentation is {other}: expected BINARY, LABELMAP or FRACTIONAL")));
            }
        };
        let table = labels(&found.dataset).map_err(wrong)?;
        let most = found.dataset.number(tags::MAXIMUM_FRACTIONAL_VALUE).filter(|_| kind == Kind::Fractional);
        let rescale = Rescale::new(1.0 / most.unwrap_or(1.0), 0.0).map_err(|e| wrong(e.to_string()))?;
        let count = super::image::frames_of(&found.dataset);
        let segments: Result<Vec<u32>, String> = (0..count).map(|frame| segment_of(&found.dataset, kind, frame)).collect();
        let segments = segments.map_err(wrong)?;
        let image = Image::new(path, found)?;
        let (places, slices, index_to_world) = placed(path, &image, options)?;
        let channels = Vec::new();
        let path = path.to_owned();
        let mut found = Self { path, image, kind, table, segments, places, slices, index_to_world, rescale, channels };
        found.check_frames()?;
        found.channels = found.apart()?;
        Ok(found)
    }

    pub fn dims(&self) -> [usize; 3] {
        [self.image.shape.columns, self.image.shape.rows, self.slices]
    }

    pub fn count(&self) -> usize {
        self.channels.len()
    }

    pub fn is_fractional(&self) -> bool {
        self.kind == Kind::Fractional
    }

    /// Type of the numbers of voxels.
    pub fn scalar(&self) -> ScalarType {
        match self.kind {
            Kind::Binary if self.segments.iter().all(|&segment| segment <= u8::MAX.into()) => ScalarType::Uint8,
            Kind::Binary => ScalarType::Uint16,
            Kind::LabelMap | Kind::Fractional => self.image.kind.scalar,
        }
    }

    /// Whether each slice has one frame of each segment at most.
    fn check_frames(&self) -> Result<(), Error> {
        let mut seen = BTreeSet::new();
        match self.segments.iter().zip(&self.places).find(|&frame| !seen.insert(frame)) {
            Some((segment, _)) => {
                let problem = format!("two of its frames show segment {segment} at one place: split them into files");
                Err(Error::volume(&self.path, problem))
            }
            None => Ok(()),
        }
    }

    /// The frames of each segment.
    fn frames(&self) -> BTreeMap<u32, Vec<usize>> {
        let mut frames = BTreeMap::<u32, Vec<usize>>::new();
        self.segments.iter().enumerate().for_each(|(frame, &segment)| frames.entry(segment).or_default().push(frame));
        frames
    }

    /// The segments of each channel: as few channels as segments that do not overlap take, one after another.
    fn apart(&self) -> Result<Vec<Vec<u32>>, Error> {
        let all = self.frames();
        if self.kind != Kind::Binary {
            return Ok(all.into_keys().map(|segment| vec![segment]).collect());
        }
        let failed = |e| super::unreadable(&self.path, e);
        let mut pixels = Pixels::new(vec![self.image.clone()], Vec::new(), 0, false).map_err(failed)?;
        let each = (self.image.shape.columns * self.image.shape.rows) as u64;
        memory::require(&self.path.display().to_string(), each.saturating_mul(self.segments.len() as u64))?;
        let mut channels: Vec<(Vec<u32>, Taken)> = Vec::new();
        for (segment, frames) in all {
            let frames: io::Result<Vec<_>> =
                frames.into_iter().map(|frame| Ok((self.places[frame], pixels.frame(0, frame)?))).collect();
            let frames = frames.map_err(failed)?;
            let is_free = |taken: &Taken| !frames.iter().any(|(at, bits)| overlap(taken.get(at), bits));
            let at = channels.iter().position(|(_, taken)| is_free(taken)).unwrap_or(channels.len());
            if at == MOST_CHANNELS {
                let problem = format!("its segments overlap in more than {MOST_CHANNELS} layers: split them into files");
                return Err(Error::volume(&self.path, problem));
            }
            if at == channels.len() {
                channels.push(Default::default());
            }
            let (segments, taken) = &mut channels[at];
            segments.push(segment);
            for (at, bits) in frames {
                match taken.get_mut(&at) {
                    Some(taken) => taken.iter_mut().zip(bits).for_each(|(taken, bit)| *taken |= bit),
                    None => _ = taken.insert(at, bits),
                }
            }
        }
        Ok(channels.into_iter().map(|(segments, _)| segments).collect())
    }

    /// The labels of each channel; `None` of fractions, which are values.
    pub fn tables(&self) -> Option<Result<Vec<LabelTable>, Error>> {
        let labels_of = |segments: &Vec<u32>| {
            let is_one = |label: &&Label| self.kind == Kind::LabelMap || segments.contains(&label.id);
            let labels: Vec<Label> = self.table.iter().filter(is_one).cloned().collect();
            LabelTable::new(labels).map_err(|e| Error::volume(&self.path, format!("its segments cannot be told apart: {e}")))
        };
        (!self.is_fractional()).then(|| self.channels.iter().map(labels_of).collect())
    }

    /// Name of the segment of each channel of fractions.
    pub fn names(&self) -> Vec<Option<String>> {
        let name = |segment: u32| self.table.iter().find(|label| label.id == segment).and_then(|label| label.name.clone());
        match self.kind {
            Kind::Fractional => self.channels.iter().map(|segments| name(segments[0])).collect(),
            Kind::Binary | Kind::LabelMap => Vec::new(),
        }
    }

    /// The voxels of a channel.
    pub fn voxels(self, channel: usize) -> io::Result<Voxels> {
        let (mut frames, of_segment) = (vec![Vec::new(); self.slices], self.frames());
        for &segment in &self.channels[channel] {
            of_segment[&segment].iter().for_each(|&frame| frames[self.places[frame]].push((frame, segment)));
        }
        let (scalar, is_binary) = (self.scalar(), self.kind == Kind::Binary);
        let [columns, rows, _] = self.dims();
        let each = (columns * rows * scalar.bytes()) as u64;
        let most = pixels::available(&self.image, each)?.saturating_mul(super::packed::LIMIT);
        Ok(Voxels { pixels: Pixels::new(vec![self.image], Vec::new(), 0, false)?, frames, scalar, is_binary, each, most })
    }
}

/// Whether bits of a slice are taken.
fn overlap(taken: Option<&Vec<u8>>, bits: &[u8]) -> bool {
    taken.is_some_and(|taken| taken.iter().zip(bits).any(|(taken, bit)| taken & bit != 0))
}

/// Number of the segment that a frame shows; 0 in label maps.
fn segment_of(dataset: &Dataset, kind: Kind, frame: usize) -> Result<u32, String> {
    if kind == Kind::LabelMap {
        return Ok(0);
    }
    let own = dataset.item(tags::PER_FRAME_FUNCTIONAL_GROUPS_SEQUENCE, frame);
    let shared = dataset.item(tags::SHARED_FUNCTIONAL_GROUPS_SEQUENCE, 0);
    let stated = [own, shared].into_iter().flatten().find_map(|groups| groups.item(tags::SEGMENT_IDENTIFICATION_SEQUENCE, 0));
    let number = stated.and_then(|stated| stated.whole(tags::REFERENCED_SEGMENT_NUMBER));
    let number = number.filter(|&number| (1..MOST).contains(&number));
    number.map(|number| number as u32).ok_or_else(|| format!("its frame {frame} does not state the number of its segment"))
}

/// Names and colours of all segments but the background, which is 0 in label maps.
fn labels(dataset: &Dataset) -> Result<Vec<Label>, String> {
    let items = (0..=MOST).map_while(|index| dataset.item(tags::SEGMENT_SEQUENCE, index));
    let label = |item: &Dataset| {
        let number = item.whole(tags::SEGMENT_NUMBER).filter(|&number| number < MOST);
        let id = number.ok_or("one of its segments has no number from 1 to 65535")? as u32;
        let mut label = Label { name: item.text(tags::SEGMENT_LABEL), ..Label::new(id) };
        if let [l, a, b] = item.numbers(tags::RECOMMENDED_DISPLAY_CIE_LAB_VALUE)[..] {
            let part = |number: f64| number.clamp(0.0, 65535.0) / 65535.0;
            label.color = srgb([100.0 * part(l), 255.0 * part(a) - 128.0, 255.0 * part(b) - 128.0]);
        }
        Ok(label)
    };
    items.map(label).filter(|label| label.as_ref().is_ok_and(|label| label.id != 0) || label.is_err()).collect()
}

/// Red, green and blue of a colour in CIELAB. Its white is that of sRGB, D65: the standard means D50, but programs write colours so
/// (dcmqi, highdicom, dcmjs).
fn srgb([l, a, b]: [f64; 3]) -> [f64; 3] {
    const WHITE: DVec3 = DVec3::new(0.95047, 1.0, 1.08883);
    let to_linear = DMat3::from_cols_array(&[
        3.2404542, -0.9692660, 0.0556434, -1.5371385, 1.8760108, -0.2040259, -0.4985314, 0.0415560, 1.0572252,
    ]);
    let y = (l + 16.0) / 116.0;
    let cubed = |t: f64| if t > 6.0 / 29.0 { t.powi(3) } else { (t - 4.0 / 29.0) * 3.0 * (6.0f64 / 29.0).powi(2) };
    let encoded = |c: f64| if c <= 0.0031308 { 12.92 * c } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 };
    let linear = to_linear * (WHITE * DVec3::new(cubed(y + a / 500.0), cubed(y), cubed(y - b / 200.0)));
    linear.to_array().map(|c| encoded(c).clamp(0.0, 1.0))
}

/// Slice of each frame, the number of slices, and the transform from voxel to world.
fn placed(path: &Path, image: &Image, options: &OpenOptions) -> Result<(Vec<usize>, usize, DAffine3), Error> {
    let wrong = |problem: String| Error::volume(path, problem);
    let slices: Vec<Slice> = (0..image.frames.len()).map(|frame| (0, frame)).collect();
    let frame = |(_, frame): Slice| &image.frames[frame];
    let located = place::located(path, &slices, frame)?.filter(|_| image.frames.iter().all(|frame| frame.is_placed));
    let Some(Located { axes: [x, y], normal, heights }) = located else {
        let problem = "the frames of its segments have no positions: convert it together with the images that it belongs to";
        return Err(wrong(problem.into()));
    };
    let first = frame(heights[0].1);
    let spacing = first.spacing.unwrap_or([1.0; 2]);
    let pixel = spacing[0].min(spacing[1]);
    let origin = first.position.unwrap_or_default();
    let sideways = |frame: &Frame| {
        let way = frame.position.unwrap_or_default() - origin;
        (way - normal * way.dot(normal)).length()
    };
    if let Some(shifted) = image.frames.iter().map(sideways).find(|&shift| shift > SHIFTED * pixel) {
        return Err(wrong(format!(
            "its frames are shifted beside each other by {}, as tiles of a slide or with a tilted gantry: resample it onto slices",
            shortened(shifted)
        )));
    }
    let mut different: Vec<f64> = heights.iter().map(|(height, _)| height - heights[0].0).collect();
    different.dedup_by(|next, before| *next - *before <= place::SAME_PLACE * pixel);
    let between = if options.spacing.is_some() { None } else { Some(between(path, &different, first).map_err(wrong)?) };
    let slice_of = |height: f64| match between {
        Some(between) => (height / between).round() as usize,
        // Evenly spaced, whatever the positions say.
        None => different.partition_point(|&other| other <= height) - 1,
    };
    let mut places = vec![0; image.frames.len()];
    for &(height, (_, frame)) in &heights {
        places[frame] = slice_of(height - heights[0].0);
    }
    let count = places.iter().max().map_or(1, |last| last + 1);
    let axes = DMat3::from_cols(x * spacing[0], y * spacing[1], normal * between.unwrap_or(1.0));
    Ok((places, count, place::to_world(axes, origin)))
}

/// Distance of slices, of which some are missing where no segment is: the stated one, else the smallest of their positions.
fn between(path: &Path, heights: &[f64], frame: &Frame) -> Result<f64, String> {
    let least = heights.windows(2).map(|pair| pair[1] - pair[0]).fold(f64::INFINITY, f64::min);
    let last = heights[heights.len() - 1];
    if last == 0.0 {
        return Ok(frame.between.or(frame.thickness).unwrap_or(1.0));
    }
    let is_even = |&between: &f64| {
        // Frames may not share a slice.
        let is_fine = between > 0.0 && between <= least * (1.0 + UNEVEN);
        is_fine && last / between < MOST_SLICES && off(heights, between) <= UNEVEN
    };
    let mean = last / (last / least).round();
    let found = [frame.between, Some(least), Some(mean)].into_iter().flatten().find(is_even);
    if let Some(between) = found.filter(|&between| off(heights, between) > EVEN) {
        tracing::warn!("{}: its slices are not even: shown as if {} apart", path.display(), shortened(between));
    }
    found.ok_or_else(|| {
        let (least, last) = (shortened(least), shortened(last));
        format!(
            "its slices are {least} apart at least and {last} in all, which is no whole number of equal steps: resample it, or treat \
             them as evenly spaced by giving a spacing"
        )
    })
}

/// Largest deviation from whole multiples of a distance, as a fraction of it.
fn off(heights: &[f64], between: f64) -> f64 {
    heights.iter().map(|height| (height / between - (height / between).round()).abs()).fold(0.0, f64::max)
}

/// Slices of segments that do not overlap.
pub(super) struct Voxels {
    pixels: Pixels,
    /// Frames and segments of each slice.
    frames: Vec<Vec<(usize, u32)>>,
    scalar: ScalarType,
    is_binary: bool,
    each: u64,
    most: u64,
}

impl Parts for Voxels {
    fn most(&self) -> u64 {
        self.most
    }

    fn whole(&self) -> u64 {
        self.each.saturating_mul(self.frames.len() as u64)
    }

    fn each(&self) -> u64 {
        self.each
    }

    fn part(&mut self, index: usize) -> io::Result<Vec<u8>> {
        if !self.is_binary
            && let Some(&(frame, _)) = self.frames[index].first()
        {
            return self.pixels.numbers((0, frame));
        }
        let size = self.scalar.bytes();
        let mut ids = memory::zeroed("a slice of segments", self.each as usize).map_err(|e| io::Error::other(e.to_string()))?;
        for &(frame, segment) in &self.frames[index] {
            let bits = self.pixels.frame(0, frame)?;
            let id = &segment.to_le_bytes()[..size];
            ids.chunks_exact_mut(size).zip(bits).filter(|(_, bit)| *bit != 0).for_each(|(voxel, _)| voxel.copy_from_slice(id));
        }
        Ok(ids)
    }
}
