//! Colours of the voxels of a field that is drawn together with others.

use super::super::colors::{ColorFields, UploadedColors};
use super::super::field::Field;
use super::Channel;
use super::inputs::VoxelColors;
use crate::device::launch::Launcher;
use crate::device::launch::colors::{PackColors, PackColorsArguments};
use crate::device::launch::structs::PackedColorParams;
use crate::device::{Buffer, Device};
use crate::error::Error;
use crate::layers::AxisFrame;
use crate::settings::FieldKind;
use glam::DAffine3;
use std::path::Path;
use std::sync::Arc;

pub(in crate::renderer) const VOXEL_COLORS: &str = "the colours of voxels";

/// Bytes of a voxel.
const BYTES: usize = 4;
/// Largest number of voxels: kernels count bytes in 32 bits.
const MOST_VOXELS: usize = (1 << 31) / BYTES - 1;

/// Red, green, blue and the weight of each voxel, on a device.
#[derive(Clone)]
pub(in crate::renderer) struct PackedColors {
    bytes: Arc<Buffer<u8>>,
    dims: [usize; 3],
    /// Whether they are those of labels.
    pub of_labels: bool,
    /// Where the voxels of the field that has these colours lie among theirs.
    of_field: DAffine3,
}

impl PackedColors {
    /// Those of the voxels of colours. `shaded`: their extinction, or their opacity.
    pub fn new(device: &Device, shaded: &Field, colors: &ColorFields) -> Result<Self, Error> {
        let description = shaded.description();
        let (dims, count) = (description.grid().dims(), description.grid().voxel_count());
        if count > MOST_VOXELS {
            let problem = format!(
                "it has {count} voxels, and at most {MOST_VOXELS} are drawn in colours of their own beside other fields: crop it or make it coarser"
            );
            return Err(Error::volume(Path::new(description.name()), problem));
        }
        let bytes = Buffer::new(device, BYTES * count, VOXEL_COLORS)?;
        let [red, green, blue] = &colors.colors;
        let arguments = PackColorsArguments {
            red: red.voxels(),
            green: green.voxels(),
            blue: blue.voxels(),
            extinction: shaded.voxels(),
            p: PackedColorParams { dims: dims.map(|n| n as i32), largest: (description.range().1 as f32).max(f32::MIN_POSITIVE) },
            out: &bytes,
        };
        Launcher::<PackColors>::default().launch(device, red.voxel_kind(), &arguments)?;
        Ok(Self { bytes: Arc::new(bytes), dims, of_labels: colors.kind == FieldKind::Labels, of_field: DAffine3::IDENTITY })
    }

    /// Bytes of the colours of this many voxels.
    pub fn size(dims: [usize; 3]) -> usize {
        BYTES * dims.iter().product::<usize>()
    }

    /// The same colours for a field at other voxels, which lie there among theirs.
    pub fn for_field(&self, of_field: Option<DAffine3>) -> Self {
        Self { of_field: of_field.unwrap_or_default(), ..self.clone() }
    }

    /// Kernel argument: where the voxels of the field lie among those that have the colours.
    pub fn placement(&self) -> [[f32; 4]; 3] {
        [0, 1, 2].map(|i| self.of_field.matrix3.row(i).extend(self.of_field.translation[i]).as_vec4().to_array())
    }

    /// Kernel arguments, along the axes of `frame`.
    pub fn along(&self, frame: AxisFrame) -> VoxelColors {
        let [x, y, _] = self.dims;
        let along = |numbers: [usize; 3]| [frame.u, frame.v, frame.a].map(|axis| numbers[axis] as i32);
        VoxelColors { bytes: self.bytes.clone(), strides: along([1, x, x * y].map(|n| BYTES * n)), dims: along(self.dims) }
    }
}

impl Channel {
    /// A visible channel in the colours of voxels: those of a volume of colours or labels. Its extinction is theirs, and so is its surface. Of
    /// labels of several opacities, make a channel for each: between two labels, those of the opacities in between would be passed.
    ///
    /// Composited pre-integrated layers and cast rays draw it. Of labels, the blend mode [`Iso`](crate::settings::Blend::Iso) draws the
    /// surfaces. The colours take four bytes per voxel on the device beside the extinction, which takes four.
    ///
    /// # Errors
    /// For more than 2^29 voxels, and for too little memory.
    pub fn from_colors(colors: &UploadedColors) -> Result<Self, Error> {
        let device = colors.device.with_own_sequence();
        device.begin(&[])?;
        let packed = PackedColors::new(&device, &colors.shaded, &colors.fields)?;
        // Renderers have sequences of their own, which do not wait for this one.
        device.finish()?;
        let (volume, transfer) = colors.visibility();
        Ok(Self { colors: Some(packed), ..Self::new(&volume, &transfer) }.with_iso(colors.surface()))
    }
}
