//! Slices of colours.

use crate::device::Device;
use crate::error::Error;
use crate::image::Frame;
use crate::layers::Kernel;
use crate::renderer::Renderer;
use crate::slice::Slice;
use crate::transfer::TransferFunction;
use crate::viewport::Viewport;
use crate::volume::{Volume, VoxelType};

/// A slice of red, green, blue and possibly alpha, transparent outside the volume. Colours are interpolated after their multiplication by
/// alpha, so that transparent voxels do not bleed theirs.
///
/// # Errors
/// Insufficient memory, and directions of the slice that are invalid.
pub(super) fn slice_of_colors(
    device: &Device,
    components: &[Volume],
    slice: &Slice,
    size: Viewport,
    kernel: Kernel,
) -> Result<Frame, Error> {
    let full = match components[0].voxel_type() {
        VoxelType::Uint8 => f32::from(u8::MAX),
        VoxelType::Uint16 => f32::from(u16::MAX),
        VoxelType::Int8 | VoxelType::Int16 | VoxelType::Float32 => 1.0,
    };
    let values = |volume: &Volume| {
        let mut renderer = Renderer::new(device, volume, &TransferFunction::grey_ramp(volume))?;
        Ok(renderer.slice_values(slice, size, kernel)?.values().to_vec())
    };
    let sampled = |n: usize| match components.get(3) {
        Some(alpha) if n < 3 => values(&multiplied(&components[n], alpha, full)?),
        _ => values(&components[n]),
    };
    let channels = (0..components.len()).map(sampled).collect::<Result<Vec<_>, Error>>()?;
    let pixel = |n: usize| {
        let part = |channel: &Vec<f32>| (channel[n] / full).clamp(0.0, 1.0);
        let alpha = channels.get(3).map_or(1.0, part);
        let is_inside = !channels[0][n].is_nan();
        if is_inside { [part(&channels[0]), part(&channels[1]), part(&channels[2]), alpha] } else { [0.0; 4] }
    };
    Ok(Frame::new(size, (0..size.pixels()).map(pixel).collect()))
}

/// A colour multiplied by alpha, in its own unit.
fn multiplied(color: &Volume, alpha: &Volume, full: f32) -> Result<Volume<'static>, Error> {
    let all = |value: &(dyn Fn(usize) -> f64 + Sync)| (0..color.grid().voxel_count()).map(value).collect::<Vec<f64>>();
    let products = color.look(all).into_iter().zip(alpha.look(all)).map(|(color, alpha)| (color * alpha) as f32 / full);
    Volume::new(color.name(), color.grid().clone(), products.collect::<Vec<f32>>())
}
