//! Colours of the voxels of a field that is drawn together with others.

use super::super::colors::UploadedColors;
use super::Channel;
use crate::device::launch::Launcher;
use crate::device::launch::colors::{PackColors, PackColorsArguments};
use crate::device::launch::structs::PackedColorParams;
use crate::device::{Buffer, Device};
use crate::error::Error;
use crate::layers::AxisFrame;
use std::path::Path;
use std::sync::Arc;

/// Bytes of a voxel.
const BYTES: usize = 4;
/// Largest number of voxels: kernels count bytes in 32 bits.
const MOST_VOXELS: usize = (1 << 31) / BYTES - 1;

/// Red, green, blue and the weight of each voxel, on a device.
#[derive(Clone)]
pub(in crate::renderer) struct PackedColors {
    pub bytes: Arc<Buffer<u8>>,
    dims: [usize; 3],
}

impl PackedColors {
    fn new(device: &Device, colors: &UploadedColors) -> Result<Self, Error> {
        let description = colors.description();
        let (dims, count) = (description.grid().dims(), description.grid().voxel_count());
        if count > MOST_VOXELS {
            let problem = format!(
                "it has {count} voxels, and at most {MOST_VOXELS} are drawn in colours of their own beside other fields: crop it or make it coarser"
            );
            return Err(Error::volume(Path::new(description.name()), problem));
        }
        let bytes = Buffer::new(device, BYTES * count, "the colours of voxels")?;
        let [red, green, blue] = &colors.fields.colors;
        let arguments = PackColorsArguments {
            red: red.voxels(),
            green: green.voxels(),
            blue: blue.voxels(),
            extinction: colors.shaded.voxels(),
            p: PackedColorParams { dims: dims.map(|n| n as i32), largest: (description.range().1 as f32).max(f32::MIN_POSITIVE) },
            out: &bytes,
        };
        Launcher::<PackColors>::default().launch(device, red.voxel_kind(), &arguments)?;
        Ok(Self { bytes: Arc::new(bytes), dims })
    }

    /// Bytes from a voxel to the next along the axes of `frame`.
    pub fn strides(&self, frame: AxisFrame) -> [i32; 3] {
        let [x, y, _] = self.dims;
        [frame.u, frame.v, frame.a].map(|axis| (BYTES * [1, x, x * y][axis]) as i32)
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
        let packed = PackedColors::new(&device, colors)?;
        // Renderers have sequences of their own, which do not wait for this one.
        device.finish()?;
        let (volume, transfer) = colors.visibility();
        let channel = Self { colors: Some(packed), ..Self::new(&volume, &transfer) };
        Ok(match colors.surface() {
            Some(value) => channel.with_iso(value),
            None => channel,
        })
    }
}
