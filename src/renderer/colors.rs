//! Volumes of colours and of labels: extinction times colour, and extinction, are interpolated.

use super::check_whole;
use super::field::{Field, Layout, Placement, UploadedVolume, value_range};
use super::label_surfaces::LabelSurface;
use crate::device::launch::colors::{ColorFieldsOf, ColorVoxels, ColorVoxelsArguments, OtherColors};
use crate::device::launch::structs::{ColorVoxelParams, LabelParams};
use crate::device::launch::{Floats, Launcher, VoxelBuffer};
use crate::device::{Buffer, Device};
use crate::error::Error;
use crate::layers::{GradientEstimator, Kernel};
use crate::settings::{Algorithm, Classification, FieldKind, Layered, Settings};
use crate::transfer::TransferFunction;
use crate::volume::{Description, Grid, Volume, VoxelBox, VoxelType};

/// Largest opacity of a voxel that keeps its exact extinction; LARGEST_OPACITY in kernels/volume/color_voxels.cl.
const LARGEST_OPACITY: f64 = 0.99999;
/// Entries of an opacity function over the intensities.
const OPACITIES: usize = 4096;
/// Pieces of the opacity of an extinction. The largest is 11.5, so that of a piece is right to 2e-5.
const EXTINCTIONS: usize = 1024;
/// Standard deviation of the Gaussian that smooths gradients of labels, in voxels.
const LABEL_SMOOTHING: f64 = 1.5;

/// Opacity of the voxels of a volume of colours.
///
/// ```
/// use layersplat::renderer::ColorOpacity;
///
/// // White, the background of a histological section, is transparent.
/// let opacity = ColorOpacity::FromBackground([1.0; 3]);
/// assert_ne!(opacity, ColorOpacity::Alpha);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ColorOpacity {
    /// The fourth component, per smallest spacing.
    Alpha,
    /// The opacities of the transfer function at the luminance (BT.709) in units of the components.
    Luminance,
    /// The opacities of the transfer function at the largest difference of a component from this colour, in units of the components. The
    /// colour has components from 0 to 1.
    FromBackground([f64; 3]),
}

/// A volume of colours or labels on a device. Four floats per voxel; six of labels of several opacities.
#[derive(Clone)]
pub struct UploadedColors {
    pub(super) device: Device,
    /// Extinction; of labels with smooth surfaces, opacity.
    pub(super) shaded: Field,
    pub(super) fields: ColorFields,
}

/// The fields beside the one that makes the surfaces.
#[derive(Clone)]
pub(super) struct ColorFields {
    /// Colours or labels.
    pub kind: FieldKind,
    /// That field times red, green and blue.
    pub colors: [Field; 3],
    /// What makes the surfaces of labels smooth.
    pub labels: Option<LabelFields>,
}

/// Fields of labels with smooth surfaces.
#[derive(Clone)]
pub(super) struct LabelFields {
    /// Squared and cubed opacity, if opacities differ.
    pub powers: Option<[Field; 2]>,
    pub surface: LabelSurface,
}

impl ColorFields {
    /// What the fields are of.
    pub fn of(&self) -> ColorFieldsOf {
        match &self.labels {
            None => ColorFieldsOf::Colors,
            Some(LabelFields { powers: None, .. }) => ColorFieldsOf::Labels,
            Some(LabelFields { powers: Some(_), .. }) => ColorFieldsOf::VariedLabels,
        }
    }

    /// Red, green and blue, and the squared and the cubed opacity if opacities differ.
    pub fn all(&self) -> impl Iterator<Item = &Field> {
        self.colors.iter().chain(self.labels.iter().flat_map(|labels| labels.powers.iter().flatten()))
    }

    /// Arguments of a kernel. `layouts`: those of [`all`](Self::all).
    pub fn arguments<'a>(&self, layouts: &'a [Layout]) -> OtherColors<'a> {
        // Buffers and parameters that are not read are any.
        let voxels = |n: usize| &layouts.get(n).unwrap_or(&layouts[0]).voxels;
        let none = LabelParams { least: 0.0, most: 0.0, per_share: 0.0 };
        let labels = self.labels.as_ref().map_or(none, |labels| labels.surface.params());
        OtherColors { red: voxels(0), green: voxels(1), blue: voxels(2), second: voxels(3), third: voxels(4), labels }
    }
}

impl UploadedColors {
    /// Uploads the components red, green, blue, and possibly alpha, which have one grid and one type. Integers are intensities from 0 to the
    /// largest number of their type; floats from 0 to 1. `transfer` gives opacities unless they are alpha.
    ///
    /// # Errors
    /// For other numbers of components, other grids or types, signed integers, and too little memory.
    pub fn new(
        device: &Device,
        components: &[Volume],
        opacity: ColorOpacity,
        transfer: &TransferFunction,
    ) -> Result<Self, Error> {
        let descriptions: Vec<&Description> = components.iter().map(Volume::description).collect();
        check_components(&descriptions, opacity)?;
        device.begin(&[])?;
        let uploaded = components.iter().map(|volume| UploadedVolume::new(device, volume)).collect::<Result<Vec<_>, _>>()?;
        Self::from_components(&uploaded, opacity, transfer)
    }

    /// As [`new`](Self::new), of components that are on a device. They are not changed.
    ///
    /// # Errors
    /// As for `new`, and for parts of volumes.
    pub fn from_components(
        components: &[UploadedVolume],
        opacity: ColorOpacity,
        transfer: &TransferFunction,
    ) -> Result<Self, Error> {
        components.iter().try_for_each(check_whole)?;
        let descriptions: Vec<&Description> = components.iter().map(UploadedVolume::description).collect();
        let full = check_components(&descriptions, opacity)?;
        let device = &components[0].device;
        let opacities: Vec<f32> =
            (0..OPACITIES).map(|n| transfer.opacity(full * n as f64 / (OPACITIES - 1) as f64) as f32).collect();
        let (opacity_from, background) = match opacity {
            ColorOpacity::Alpha => (0, [0.0; 3]),
            ColorOpacity::Luminance => (1, [0.0; 3]),
            ColorOpacity::FromBackground(color) => (2, color.map(|c| c as f32)),
        };
        device.begin(&[])?;
        let voxels = |n: usize| components.get(n).unwrap_or(&components[0]).field.voxels();
        let count = descriptions[0].grid().voxel_count();
        let out = Out::new(device, count)?;
        let arguments = ColorVoxelsArguments {
            red: voxels(0),
            green: voxels(1),
            blue: voxels(2),
            alpha: voxels(3),
            opacities: &Buffer::from_slice(device, &opacities, "opacities of colours")?,
            p: ColorVoxelParams {
                count: count as i64,
                per_step: (1.0 / full) as f32,
                opacity_from,
                background,
                opacity_count: OPACITIES as i32,
            },
            out_red: Floats(&out.red),
            out_green: Floats(&out.green),
            out_blue: Floats(&out.blue),
            out_extinction: Floats(&out.extinction),
        };
        Launcher::<ColorVoxels>::default().launch(device, components[0].field.voxel_kind(), &arguments)?;
        out.into_colors(device, descriptions[0], FieldKind::Colors)
    }

    /// Description of the extinction; of labels with smooth surfaces, of the opacity.
    pub fn description(&self) -> &Description {
        self.shaded.description()
    }

    /// The value at the surface of labels that have one opacity: half of it.
    pub(super) fn surface(&self) -> Option<f64> {
        self.fields.labels.as_ref().map(|labels| 0.5 * labels.surface.most())
    }

    /// The extinction as a field, and the transfer function of which it is the extinction: 1 − e^(−τ); or the opacity of labels, and the one
    /// that has their surfaces. It shows where there is any, and what dims the light; colours are drawn without it.
    pub(super) fn visibility(&self) -> (UploadedVolume, TransferFunction) {
        let volume = UploadedVolume { device: self.device.clone(), field: self.shaded.clone() };
        if let Some(labels) = &self.fields.labels {
            return (volume, labels.surface.visibility());
        }
        let largest = self.description().range().1.max(f64::from(f32::MIN_POSITIVE));
        let opacity = |n: usize| {
            let extinction = largest * n as f64 / EXTINCTIONS as f64;
            (extinction, -(-extinction).exp_m1())
        };
        let transfer = TransferFunction::new("extinction", vec![(0.0, [1.0; 3])], (0..=EXTINCTIONS).map(opacity).collect());
        (volume, transfer.expect("values that ascend"))
    }
}

/// Extinction times colour, and extinction, of a colour and an opacity.
pub(super) fn emission([r, g, b, opacity]: [f64; 4]) -> [f32; 4] {
    let extinction = -(-opacity.clamp(0.0, LARGEST_OPACITY)).ln_1p();
    [extinction * r, extinction * g, extinction * b, extinction].map(|c| c as f32)
}

/// Rejects a layer of labels whose voxels are no entries of a table, on another grid, or with entries that are no colours.
pub(super) fn check_labels(description: &Description, entries: &[[f64; 4]], grid: &Grid) -> Result<(), Error> {
    let wrong = |problem: String| Err(Error::volume(std::path::Path::new(description.name()), problem));
    if description.grid() != grid {
        return wrong("its grid is not that of the first layer of labels".into());
    }
    if !matches!(description.voxel_type(), VoxelType::Uint8 | VoxelType::Uint16) {
        return wrong(format!("its voxels are {}; labels are uint8 or uint16", description.voxel_type()));
    }
    let largest = description.stored().range.1 as usize;
    if largest >= entries.len() {
        return wrong(format!("label {largest} has no colour: the table has {} entries", entries.len()));
    }
    let bad = entries.iter().enumerate().find(|(_, entry)| entry.iter().any(|c| !(0.0..=1.0).contains(c)));
    if let Some((label, entry)) = bad {
        return wrong(format!("label {label} has the colour and opacity {entry:?}: expected 0 to 1"));
    }
    Ok(())
}

/// Checks descriptions of components; returns the largest intensity of their type.
fn check_components(components: &[&Description], opacity: ColorOpacity) -> Result<f64, Error> {
    let wanted = if opacity == ColorOpacity::Alpha { 4..=4 } else { 3..=4 };
    if !wanted.contains(&components.len()) {
        let problem = format!("there are {} components, and colours have 3, or 4 with alpha", components.len());
        return Err(Error::Settings { field: "colors", problem });
    }
    let first = components[0];
    for other in components {
        if other.grid() != first.grid() || other.voxel_type() != first.voxel_type() {
            let problem = format!("its grid or its type is not that of {}", first.name());
            return Err(Error::volume(std::path::Path::new(other.name()), problem));
        }
    }
    match first.voxel_type() {
        VoxelType::Uint8 => Ok(255.0),
        VoxelType::Uint16 => Ok(65535.0),
        VoxelType::Float32 => Ok(1.0),
        other => {
            let problem = format!("its components are {other}; colours are uint8, uint16 or float32");
            Err(Error::volume(std::path::Path::new(first.name()), problem))
        }
    }
}

/// Buffers of the four fields.
pub(super) struct Out {
    pub red: VoxelBuffer,
    pub green: VoxelBuffer,
    pub blue: VoxelBuffer,
    pub extinction: VoxelBuffer,
}

impl Out {
    pub fn new(device: &Device, count: usize) -> Result<Self, Error> {
        let buffer = || color_buffer(device, count);
        Ok(Self { red: buffer()?, green: buffer()?, blue: buffer()?, extinction: buffer()? })
    }

    pub fn into_colors(self, device: &Device, source: &Description, kind: FieldKind) -> Result<UploadedColors, Error> {
        let Self { red, green, blue, extinction } = self;
        let [shaded, red, green, blue] = into_fields(device, source, [extinction, red, green, blue])?;
        let fields = ColorFields { kind, colors: [red, green, blue], labels: None };
        Ok(UploadedColors { device: device.clone(), shaded, fields })
    }
}

/// A buffer of a number per voxel.
pub(super) fn color_buffer(device: &Device, count: usize) -> Result<VoxelBuffer, Error> {
    VoxelBuffer::new(device, count, VoxelType::Float32, "the colours of voxels")
}

/// Fields on the grid of `source`, whose voxels have numbers from 0 to the largest of the first.
pub(super) fn into_fields<const N: usize>(
    device: &Device,
    source: &Description,
    buffers: [VoxelBuffer; N],
) -> Result<[Field; N], Error> {
    let grid = source.grid();
    let placed = Placement::dense(grid.dims());
    device.begin(&[])?;
    let ((_, largest), _) = value_range(device, &buffers[0], placed, grid.dims(), &[])?;
    let description = Description::new(source.name(), grid.clone(), VoxelType::Float32, (0.0, largest))?;
    Ok(buffers.map(|voxels| Field::new(&description, VoxelBox::whole(grid.dims()), voxels, placed, false)))
}

/// The settings of a frame of colours. Kernels with negative weights would make negative extinctions: the paper's cubic replaces them.
pub(super) fn color_settings(settings: Settings, fields: &ColorFields) -> Settings {
    let positive = |kernel| if matches!(kernel, Kernel::CatmullRom | Kernel::BSpline) { Kernel::Cubic } else { kernel };
    let algorithm = match settings.algorithm {
        Algorithm::Layered(layered @ Layered { classification: Classification::Preintegrated { kernel, .. }, .. }) => {
            Layered { classification: layered.classification.with_kernel(positive(kernel)), ..layered }.into()
        }
        Algorithm::Raycast { kernel, step } => Algorithm::Raycast { kernel: positive(kernel), step },
        other => other,
    };
    let smoothed = fields.labels.is_some().then_some(GradientEstimator::Gaussian(LABEL_SMOOTHING));
    Settings { algorithm, gradient: settings.gradient.or(smoothed), ..settings }
}
