//! Labels whose surfaces lie where the interpolated share of a label is one half.

use super::check_whole;
use super::colors::{ColorFields, LabelFields, Out, UploadedColors, check_labels, color_buffer, emission, into_fields};
use super::field::UploadedVolume;
use crate::device::launch::colors::{LabelMoments, LabelMomentsArguments, LabelVoxels, LabelVoxelsArguments};
use crate::device::launch::structs::{Float4, LabelParams, LabelVoxelParams};
use crate::device::launch::{Floats, Launcher};
use crate::device::{Buffer, Device};
use crate::error::Error;
use crate::transfer::TransferFunction;
use crate::volume::{Grid, LabelSurfaces};

/// Change of a share within which the opacity changes from that of one label to that of the other: a third of a voxel. Narrower surfaces
/// would be rough between samples; in wider ones the radius depends on the opacity.
const WIDTH: f64 = 0.2;
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
}

impl LabelSurface {
    fn new(layers: &[(&UploadedVolume, &[[f64; 4]])]) -> Self {
        let visible = |entry: &[f64; 4]| Some(opacity(entry)).filter(|&opacity| opacity > 0.0);
        let mut levels: Vec<f64> = layers.iter().flat_map(|(_, entries)| entries.iter().filter_map(visible)).collect();
        levels.sort_by(f64::total_cmp);
        levels.dedup_by(|b, a| *b - *a < SAME);
        let most_of = |entries: &[[f64; 4]]| entries.iter().map(opacity).fold(0.0, f64::max);
        let left: f64 = layers.iter().map(|(_, entries)| 1.0 - most_of(entries)).product();
        Self { levels, most: 1.0 - left }
    }

    /// Means of opacities up to this show nothing: no label has more than half of the share, less half the width.
    fn least(&self) -> f64 {
        (0.5 - 0.5 * WIDTH) * self.levels.first().unwrap_or(&0.0)
    }

    pub fn params(&self) -> LabelParams {
        LabelParams { least: self.least() as f32, most: self.most as f32, per_share: (1.0 / WIDTH) as f32 }
    }

    /// The transfer function of mean opacities: between the opacities of two labels it changes as at their surface.
    pub fn visibility(&self) -> TransferFunction {
        // A little below, so that rounding hides nothing that kernels show.
        let mut points = vec![(0.0, 0.0), (0.99 * self.least(), 0.0)];
        if self.levels.len() <= MOST_LEVELS {
            let mut below = 0.0;
            for &level in &self.levels {
                let place = |share: f64| below + share * (level - below);
                points.push((place(0.5 - 0.5 * WIDTH), below));
                points.push((place(0.5 + 0.5 * WIDTH), level));
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

/// Weights of the neighbours of a voxel along each axis, against its own: those of a Gaussian, one half at the smallest spacing. Thick slices
/// are not mixed with each other.
fn beside(grid: &Grid) -> [f32; 3] {
    let spacing = grid.spacing();
    let relative = spacing / spacing.min_element();
    (relative * relative).to_array().map(|squared| (-squared).exp2() as f32)
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
            LabelSurfaces::Voxels => as_they_are(device, layers)?.into_colors(device, field.description()),
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
            p: voxel_params(grid, entries.len(), n > 0, false),
            out_red: Floats(&out.red),
            out_green: Floats(&out.green),
            out_blue: Floats(&out.blue),
            out_extinction: Floats(&out.extinction),
        };
        Launcher::<LabelVoxels>::default().launch(device, labels.field.voxel_kind(), &arguments)?;
    }
    Ok(out)
}

fn voxel_params(grid: &Grid, entry_count: usize, adds: bool, varied: bool) -> LabelVoxelParams {
    LabelVoxelParams {
        dims: grid.dims().map(|n| n as i32),
        entry_count: entry_count as i32,
        adds: i32::from(adds),
        varied: i32::from(varied),
        beside: beside(grid),
    }
}

/// Moments of the opacities around each voxel, and opacity times colour.
fn smooth(device: &Device, layers: &[(&UploadedVolume, &[[f64; 4]])]) -> Result<UploadedColors, Error> {
    let (labels, entries) = layers[0];
    let surface = LabelSurface::new(layers);
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
    let arguments = LabelMomentsArguments {
        labels: labels.field.voxels(),
        entries: &uploaded_entries(device, entries)?,
        red: Floats(of_layers[0]),
        green: Floats(of_layers[1]),
        blue: Floats(of_layers[2]),
        extinction: Floats(of_layers[3]),
        p: voxel_params(description.grid(), entries.len(), false, is_varied),
        out_red: Floats(&red),
        out_green: Floats(&green),
        out_blue: Floats(&blue),
        out_first: Floats(&first),
        out_second: Floats(second),
        out_third: Floats(third),
    };
    Launcher::<LabelMoments>::default().launch(device, (labels.field.voxel_kind(), is_layered), &arguments)?;
    let [shaded, red, green, blue] = into_fields(device, description, [first, red, green, blue])?;
    let powers = powers.map(|powers| into_fields(device, description, powers)).transpose()?;
    let fields = ColorFields { colors: [red, green, blue], labels: Some(LabelFields { powers, surface }) };
    Ok(UploadedColors { device: device.clone(), shaded, fields })
}
