//! Labels whose surfaces lie where the interpolated share of a label is one half.

use super::check_whole;
use super::colors::{ColorFields, LabelFields, Out, UploadedColors, check_labels, color_buffer, emission, into_fields};
use super::field::UploadedVolume;
use crate::device::launch::colors::{
    LabelFields as Layers, LabelMoments, LabelMomentsArguments, LabelRuns, LabelRunsArguments, LabelVoxels, LabelVoxelsArguments,
};
use crate::device::launch::structs::{Float4, LabelParams, LabelVoxelParams};
use crate::device::launch::{Floats, Launcher};
use crate::device::{Buffer, Device};
use crate::error::Error;
use crate::settings::FieldKind;
use crate::transfer::TransferFunction;
use crate::volume::{Grid, LabelSurfaces};

/// Change of a share within which the opacity changes from that of one label to that of the other: a third of a voxel. Narrower surfaces
/// would be rough between samples; in wider ones the radius depends on the opacity. Shares of thick slices change more slowly.
const WIDTH: f64 = 0.2;
/// Slices are thick from this multiple of the larger spacing within them.
const THICK: f64 = 1.5;
/// Distances within thick slices that change shares: edges move by up to twice as much from one slice to the next. In multiples of the
/// thickness.
const REACH: f64 = 2.0;
/// Most opacities that shadows and depths tell apart. Of more, they mix them.
const MOST_LEVELS: usize = 64;
/// Opacities of labels that differ by less are one.
const SAME: f64 = 1e-6;

/// The opacities of labels with smooth surfaces.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct LabelSurface {
    /// Those of visible labels, ascending.
    levels: Vec<f64>,
    /// The largest, also where labels overlap.
    most: f64,
    /// Change of a share within which the opacity changes.
    width: f64,
}

impl LabelSurface {
    fn new(layers: &[(&UploadedVolume, &[[f64; 4]])], slices: Option<ThickSlices>) -> Self {
        let visible = |entry: &[f64; 4]| Some(opacity(entry)).filter(|&opacity| opacity > 0.0);
        let mut levels: Vec<f64> = layers.iter().flat_map(|(_, entries)| entries.iter().filter_map(visible)).collect();
        levels.sort_by(f64::total_cmp);
        levels.dedup_by(|b, a| *b - *a < SAME);
        let most_of = |entries: &[[f64; 4]]| entries.iter().map(opacity).fold(0.0, f64::max);
        let left: f64 = layers.iter().map(|(_, entries)| 1.0 - most_of(entries)).product();
        Self { levels, most: 1.0 - left, width: WIDTH / slices.map_or(1.0, |slices| slices.farthest) }
    }

    /// Means of opacities up to this show nothing: no label has more than half of the share, less half the width.
    fn least(&self) -> f64 {
        (0.5 - 0.5 * self.width) * self.levels.first().unwrap_or(&0.0)
    }

    /// The largest opacity.
    pub fn most(&self) -> f64 {
        self.most
    }

    pub fn params(&self) -> LabelParams {
        LabelParams { least: self.least() as f32, most: self.most as f32, per_share: (1.0 / self.width) as f32 }
    }

    /// The transfer function of mean opacities: between the opacities of two labels it changes as at their surface.
    pub fn visibility(&self) -> TransferFunction {
        // A little below, so that rounding hides nothing that kernels show.
        let mut points = vec![(0.0, 0.0), (0.99 * self.least(), 0.0)];
        if self.levels.len() <= MOST_LEVELS {
            let mut below = 0.0;
            for &level in &self.levels {
                let place = |share: f64| below + share * (level - below);
                points.push((place(0.5 - 0.5 * self.width), below));
                points.push((place(0.5 + 0.5 * self.width), level));
                below = level;
            }
        } else {
            points.extend(self.levels.iter().map(|&level| (level, level)));
        }
        TransferFunction::new("labels", vec![(0.0, [1.0; 3])], points).expect("values that ascend")
    }
}

/// The opacity of an entry as kernels have it.
fn opacity(entry: &[f64; 4]) -> f64 {
    -(-f64::from(emission(*entry)[3])).exp_m1()
}

/// Slices whose thickness is not that of their voxels.
#[derive(Clone, Copy)]
struct ThickSlices {
    /// Axis across them.
    axis: usize,
    /// Distance within a slice that changes shares, in smallest spacings.
    farthest: f64,
}

impl ThickSlices {
    fn of(grid: &Grid) -> Option<Self> {
        let spacing = grid.spacing().to_array();
        let axis = (0..3).max_by(|&a, &b| spacing[a].total_cmp(&spacing[b])).expect("three axes");
        let within = [spacing[(axis + 1) % 3], spacing[(axis + 2) % 3]];
        let farthest = REACH * spacing[axis] / within[0].min(within[1]);
        (spacing[axis] >= THICK * within[0].max(within[1])).then_some(Self { axis, farthest })
    }
}

impl UploadedColors {
    /// Makes colours of labels, in layers that may overlap, on one grid: of each layer, voxel n has entry n, a colour and an opacity per
    /// smallest spacing. Extinctions of layers add. `surfaces`: those of all.
    ///
    /// # Errors
    /// Without layers, for other grids or devices, for parts of volumes, for voxels that are not unsigned integers or have no entry, and for
    /// too little memory.
    pub fn from_labels(layers: &[(&UploadedVolume, &[[f64; 4]])], surfaces: LabelSurfaces) -> Result<Self, Error> {
        let Some((UploadedVolume { device, field }, _)) = layers.first().copied() else {
            return Err(Error::Settings { field: "labels", problem: "there are no layers: give at least one".into() });
        };
        let grid = field.description().grid();
        for (labels, entries) in layers {
            check_whole(labels)?;
            check_labels(labels.description(), entries, grid)?;
        }
        device.begin(&[])?;
        match surfaces {
            LabelSurfaces::Smooth => smooth(device, layers),
            LabelSurfaces::Voxels => as_they_are(device, layers)?.into_colors(device, field.description(), FieldKind::Labels),
        }
    }
}

fn uploaded_entries(device: &Device, entries: &[[f64; 4]]) -> Result<Buffer<Float4>, Error> {
    let entries: Vec<Float4> = entries.iter().map(|&entry| Float4(emission(entry))).collect();
    Buffer::from_slice(device, &entries, "the colours of labels")
}

/// Extinction times colour, and extinction, of each voxel.
fn as_they_are(device: &Device, layers: &[(&UploadedVolume, &[[f64; 4]])]) -> Result<Out, Error> {
    let grid = layers[0].0.description().grid();
    let out = Out::new(device, grid.voxel_count())?;
    for (n, (labels, entries)) in layers.iter().enumerate() {
        let arguments = LabelVoxelsArguments {
            labels: labels.field.voxels(),
            entries: &uploaded_entries(device, entries)?,
            p: LabelVoxelParams { adds: i32::from(n > 0), ..voxel_params(grid, None, entries.len()) },
            out_red: Floats(&out.red),
            out_green: Floats(&out.green),
            out_blue: Floats(&out.blue),
            out_extinction: Floats(&out.extinction),
        };
        Launcher::<LabelVoxels>::default().launch(device, labels.field.voxel_kind(), &arguments)?;
    }
    Ok(out)
}

fn voxel_params(grid: &Grid, slices: Option<ThickSlices>, entry_count: usize) -> LabelVoxelParams {
    let across = grid.spacing() / grid.spacing().min_element();
    // A Gaussian, one half at the smallest spacing. Thick slices are not mixed with each other.
    let mut beside = (across * across).to_array().map(|squared| (-squared).exp2() as f32);
    if let Some(ThickSlices { axis, .. }) = slices {
        beside[axis] = 0.0;
    }
    let farthest = slices.map_or(0.0, |slices| slices.farthest);
    let dims = grid.dims().map(|n| n as i32);
    LabelVoxelParams {
        dims,
        entry_count: entry_count as i32,
        adds: 0,
        varied: 0,
        beside,
        thick: slices.map_or(2, |slices| slices.axis as i32),
        across: across.as_vec3().to_array(),
        farthest: farthest as f32,
        reach: std::array::from_fn(|axis| ((farthest + 0.5) / across[axis]).ceil().min(f64::from(dims[axis])) as i32),
    }
}

/// Moments of the opacities around each voxel, and opacity times colour.
fn smooth(device: &Device, layers: &[(&UploadedVolume, &[[f64; 4]])]) -> Result<UploadedColors, Error> {
    let (labels, entries) = layers[0];
    let slices = ThickSlices::of(labels.description().grid());
    let surface = LabelSurface::new(layers, slices);
    let is_layered = layers.len() > 1;
    // Overlapping labels have opacities of their own.
    let is_varied = is_layered || surface.levels.len() > 1;
    let (description, count) = (labels.description(), labels.description().grid().voxel_count());
    let buffer = || color_buffer(device, count);
    let [first, red, green, blue] = [buffer()?, buffer()?, buffer()?, buffer()?];
    let powers = if is_varied { Some([buffer()?, buffer()?]) } else { None };
    let layered = if is_layered { Some(as_they_are(device, layers)?) } else { None };
    // Buffers that are not read or written are any.
    let (second, third) = powers.as_ref().map_or((&first, &first), |[second, third]| (second, third));
    let of_layers = layered.as_ref().map_or([&first; 4], |out| [&out.red, &out.green, &out.blue, &out.extinction]);
    let fields = Layers {
        labels: labels.field.voxels(),
        entries: &uploaded_entries(device, entries)?,
        red: Floats(of_layers[0]),
        green: Floats(of_layers[1]),
        blue: Floats(of_layers[2]),
        extinction: Floats(of_layers[3]),
        p: LabelVoxelParams { varied: i32::from(is_varied), ..voxel_params(description.grid(), slices, entries.len()) },
    };
    let kind = labels.field.voxel_kind();
    let runs = if slices.is_some() { Some(buffer()?) } else { None };
    if let Some(runs) = &runs {
        let arguments = LabelRunsArguments { labels: fields, out: Floats(runs) };
        Launcher::<LabelRuns>::default().launch(device, (kind, is_layered), &arguments)?;
    }
    let arguments = LabelMomentsArguments {
        labels: fields,
        runs: Floats(runs.as_ref().unwrap_or(&first)),
        out_red: Floats(&red),
        out_green: Floats(&green),
        out_blue: Floats(&blue),
        out_first: Floats(&first),
        out_second: Floats(second),
        out_third: Floats(third),
    };
    Launcher::<LabelMoments>::default().launch(device, (kind, is_layered, runs.is_some()), &arguments)?;
    let [shaded, red, green, blue] = into_fields(device, description, [first, red, green, blue])?;
    let powers = powers.map(|powers| into_fields(device, description, powers)).transpose()?;
    let fields =
        ColorFields { kind: FieldKind::Labels, colors: [red, green, blue], labels: Some(LabelFields { powers, surface }) };
    Ok(UploadedColors { device: device.clone(), shaded, fields })
}
