//! The voxels that sheets splat.

use super::kernels::Kernels;
use crate::device::launch::params::{Float4, VolumeView};
use crate::device::launch::{Pass, Place, SplatsArguments, SplatsKernel, VoxelBuffer};
use crate::device::{Buffer, Device};
use crate::error::Error;
use crate::layers::GAUSSIAN_OVERSHOOT;

/// The voxels that are splatted, in the order of a layout.
pub(super) struct SplatList {
    pub places: Buffer<Place>,
    pub contents: Buffer<Float4>,
    pub count: usize,
}

/// Which voxels a list holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Splatted {
    /// Those that are visible themselves: for classification before splatting.
    Visible,
    /// Those that any visible sample can see: for classification after it.
    InReach,
    /// All that differ from the background: the same without culling.
    All,
}

/// What a list is made of.
pub(super) struct SplatSource<'a> {
    pub voxels: &'a VoxelBuffer,
    pub view: VolumeView,
    /// See [`crate::device::launch::Visibility`].
    pub table: (f32, f32, i32),
    pub visible_before: &'a Buffer<u32>,
}

impl SplatList {
    /// Lists voxels in the order of their layout.
    pub fn new(device: &Device, kernels: &Kernels, from: &SplatSource, splatted: Splatted) -> Result<Self, Error> {
        let SplatSource { voxels, view, .. } = *from;
        if let Some(n) = view.dims.iter().find(|&&n| n > i32::from(u16::MAX)) {
            let problem = format!("sheets take up to 65535 voxels along an axis, not {n}: use another --algorithm");
            return Err(Error::Settings { problem });
        }
        let rows = view.dims[1] as usize * view.dims[2] as usize;
        let counts = Buffer::new(device, rows, "the splats per row")?;
        let total = Buffer::new(device, 1, "the number of splats")?;
        let mut list =
            Self { places: Buffer::new(device, 1, "the splats")?, contents: Buffer::new(device, 1, "the splats")?, count: 0 };
        let (reach, slack) = match splatted {
            Splatted::Visible => (0, 0.0),
            Splatted::InReach => (SplatsKernel::REACH, GAUSSIAN_OVERSHOOT as f32),
            Splatted::All => (-1, 0.0),
        };
        let launch = |pass: Pass, list: &Self| {
            let SplatList { places, contents, .. } = list;
            let arguments = SplatsArguments {
                voxels,
                view,
                reach,
                slack,
                table: from.table,
                visible_before: from.visible_before,
                counts: &counts,
                places,
                contents,
            };
            kernels.splats(device)?.launch(device, pass, &arguments)
        };
        launch(Pass::Count, &list)?;
        kernels.scan(device)?.launch(device, &counts, rows, 1, &total)?;
        list.count = read_total(device, &total, "the list of splats")?;
        list.places = Buffer::new(device, list.count, "the splats")?;
        list.contents = Buffer::new(device, list.count, "the splats")?;
        launch(Pass::Fill, &list)?;
        Ok(list)
    }
}

/// A total of splats, or an error where there are more than kernels can count.
pub(super) fn read_total(device: &Device, total: &Buffer<u64>, what: &str) -> Result<usize, Error> {
    let mut count = [0];
    total.read(device, &mut count)?;
    let count = count[0];
    if count > i32::MAX as u64 {
        let bytes = |entries: u64| entries.saturating_mul(size_of::<u32>() as u64);
        let device = device.info().name.clone();
        return Err(Error::DeviceMemory { what: what.into(), device, needed: bytes(count), available: bytes(i32::MAX as u64) });
    }
    Ok(count as usize)
}
