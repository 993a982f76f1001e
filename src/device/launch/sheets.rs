//! Launchers of view_sheets.cl and axis_sheets.cl.

use super::params::{Float4, SampleParams, ScreenParams, SplatParams, VolumeView};
use super::{Splat, launch, screen_defines};
use crate::device::{Buffer, Device, program::source};
use crate::error::Error;
use opencl3::kernel::Kernel;

/// What both kinds of sheets read and write.
pub(crate) struct SheetArguments<'a> {
    pub sorted: &'a Buffer<Splat>,
    /// Where the lists of tiles end, per chunk.
    pub ends: &'a Buffer<u32>,
    pub lists: &'a Buffer<u32>,
    pub screen: ScreenParams,
    pub params: SplatParams,
    pub sample: SampleParams,
    pub frame: &'a Buffer<Float4>,
    /// One count per tile.
    pub active_samples: &'a Buffer<u32>,
}

impl SheetArguments<'_> {
    fn tiles(&self) -> usize {
        self.screen.tiles.iter().map(|&n| n as usize).product()
    }
}

/// Splats onto image-aligned sheets.
pub(crate) struct ViewSheetsKernel(Kernel);

impl ViewSheetsKernel {
    /// Fractions, less one, that slab weights are given for.
    pub const SLAB_STEPS: usize = 256;

    /// For splats that reach up to `sheets` sheets, with gradients or without.
    pub fn new(device: &Device, sheets: usize, shading: bool) -> Result<Self, Error> {
        let defines = format!(
            "-DVW={} {} -DSHEETS={sheets} -DSLAB_STEPS={} -DCHANNELS={} -DPER_RAY_STEP",
            device.tuning().vector_width,
            screen_defines(device),
            Self::SLAB_STEPS,
            if shading { 4 } else { 1 }
        );
        let source =
            source!("view_sheets", "elementary", "volume", "table_entries", "shading", "sample", "screen", "splat", "sheet");
        Ok(Self(device.kernel(&source, &defines)?))
    }

    /// `slabs`: `sheets` weights for each of [`Self::SLAB_STEPS`] + 1 fractions; `table`: (r, g, b, τ) per value.
    pub fn launch(
        &self,
        device: &Device,
        view: &VolumeView,
        slabs: &Buffer<f32>,
        table: &Buffer<Float4>,
        a: &SheetArguments,
    ) -> Result<(), Error> {
        let chunks = device.tuning().splat_chunks as i32;
        launch(
            device,
            "sheets",
            &self.0,
            a.tiles(),
            device.tuning().tile_group,
            &[view, a.sorted, a.ends, a.lists, &chunks, slabs, table, &a.screen, &a.params, &a.sample, a.frame, a.active_samples],
        )
    }
}

/// Splats onto axis-aligned sheets.
pub(crate) struct AxisSheetsKernel(Kernel);

impl AxisSheetsKernel {
    pub fn new(device: &Device) -> Result<Self, Error> {
        let defines = format!("-DVW={} {}", device.tuning().vector_width, screen_defines(device));
        let source = source!("axis_sheets", "elementary", "volume", "shading", "screen", "splat", "sheet");
        Ok(Self(device.kernel(&source, &defines)?))
    }

    pub fn launch(&self, device: &Device, a: &SheetArguments) -> Result<(), Error> {
        let chunks = device.tuning().splat_chunks as i32;
        launch(
            device,
            "sheets",
            &self.0,
            a.tiles(),
            device.tuning().tile_group,
            &[a.sorted, a.ends, a.lists, &chunks, &a.screen, &a.params, &a.sample, a.frame, a.active_samples],
        )
    }
}
