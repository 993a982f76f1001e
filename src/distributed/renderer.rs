//! The distributed renderer.

mod frames;
mod light;
mod volume_renderer;

use super::compose::Composer;
use super::exchange::Boxes;
use super::group::Group;
use super::{Brick, partition, work};
use crate::camera::Camera;
use crate::device::{Cancel, Device};
use crate::error::Error;
use crate::layers::Axis;
use crate::memory;
use crate::renderer::{
    DeviceVoxels, Exchanged, LatticeView, LightOfParts, Measured, PartRenderer, SeenVolume, Shares, UploadedVolume,
};
use crate::settings::{Blend, Settings};
use crate::transfer::TransferFunction;
use crate::viewport::Viewport;
use crate::volume::{Description, Volume, VolumePart, VoxelBox};
use opencl3::event::Event;
use std::ops::Range;
use std::time::Duration;

/// Tolerated work of the busiest rank, relative to a balanced partition, before voxels are redistributed.
const MAX_IMBALANCE: f64 = 1.2;

/// Renders a volume distributed over the processes of a [`Group`]. Each process composites a range of layers on its own device,
/// and rank 0 receives the picture. All calls are collective, with the same arguments.
///
/// The partition balances the visible voxels under the transfer function. If a rank lacks layers, as after a change of the layer
/// axis, voxels are sent once and kept as long as there is memory for them.
///
/// With one process, pictures equal those of a [`Renderer`](crate::Renderer) bit for bit. With more, floats associate
/// differently, and a rank does not know which rays end in front of its layers. The difference is at most 2e-6 per channel
/// without early ray termination and 1/4096 with it. Pictures are reproducible bit for bit.
pub struct Renderer<'v> {
    group: Group,
    device: Device,
    source: Source<'v>,
    boxes: Boxes,
    transfer: TransferFunction,
    /// Estimated work per layer along x, y and z, and whether only voxels with opacity count.
    work: Option<(bool, [Vec<u64>; 3])>,
    partitions: [Option<Partition>; 3],
    composer: Composer,
    shares: Shares,
    balance: bool,
    keep: bool,
    measuring: bool,
    longest: Option<Duration>,
    cancel: Option<Cancel>,
}

/// Location of the voxels of this process.
enum Source<'v> {
    Host(Box<Volume<'v>>),
    Device(Box<UploadedVolume>),
}

/// The layers along an axis, partitioned among the ranks.
struct Partition {
    ranges: Vec<Range<usize>>,
    /// Ghost layers held on either side.
    around: usize,
    /// This rank's layers, split to fit the largest buffer of the device. Never empty.
    slabs: Vec<(Range<usize>, PartRenderer)>,
    /// The light that these layers look up.
    light: Option<LightOfParts>,
}

impl Partition {
    /// The raw samples of this rank's layers. Adds their statistics to `total`, if measured.
    fn raw(&mut self, view: &LatticeView, mut total: Option<&mut Measured>) -> Result<Vec<[f32; 4]>, Error> {
        let last = self.slabs.len() - 1;
        let mut done = None;
        for n in 0..=last {
            let (layers, renderer) = &mut self.slabs[if view.ascending() { n } else { last - n }];
            let (samples, measured) = renderer.raw(view, layers, done.as_deref(), self.light.as_ref())?;
            if let (Some(total), Some(measured)) = (total.as_deref_mut(), measured) {
                total.add_stages(measured.stages);
                total.active_samples += measured.active_samples;
            }
            done = Some(samples);
        }
        Ok(done.expect("at least one slab"))
    }

    /// A renderer that holds voxels of this axis.
    fn renderer(&mut self) -> &mut PartRenderer {
        &mut self.slabs[0].1
    }
}

impl<'v> Renderer<'v> {
    /// A renderer of a distributed volume ([`Group::open`], [`Group::volume`]). Uploads nothing yet.
    ///
    /// # Errors
    /// Voxels with several owners or none.
    pub fn new(group: &Group, device: &Device, volume: &Volume<'v>, transfer: &TransferFunction) -> Result<Self, Error> {
        let boxes = Boxes::from_volume(group, volume)?;
        Ok(Self::with_source(group, device, Source::Host(Box::new(volume.clone())), boxes, transfer))
    }

    /// A renderer of bricks that already reside on the devices and stay there. They must be whole slabs along one axis in rank
    /// order, with the ghost layers that the views need. The description must be the same on all ranks. Views along another layer
    /// axis are rejected.
    ///
    /// # Errors
    /// As [`UploadedVolume::in_place`]; voxels with several owners or none.
    pub fn in_place(
        group: &Group,
        device: &Device,
        description: &Description,
        brick: Brick,
        voxels: &DeviceVoxels,
        transfer: &TransferFunction,
    ) -> Result<Self, Error> {
        let boxes = Boxes::gather(group, description, brick)?;
        let uploaded = group.agree(UploadedVolume::part_in_place(device, description, brick.held, voxels))?;
        Ok(Self::with_source(group, device, Source::Device(Box::new(uploaded)), boxes, transfer))
    }

    fn with_source(group: &Group, device: &Device, source: Source<'v>, boxes: Boxes, transfer: &TransferFunction) -> Self {
        Self {
            group: group.clone(),
            device: device.clone(),
            source,
            boxes,
            transfer: transfer.clone(),
            work: None,
            partitions: [None, None, None],
            composer: Composer::default(),
            shares: Shares::default(),
            balance: true,
            keep: true,
            measuring: false,
            longest: None,
            cancel: None,
        }
    }

    /// Whether voxels are redistributed to balance work (the default), or only where a rank lacks them. Disable this if the
    /// voxels change before every frame, as in simulations.
    pub fn balance(&mut self, balance: bool) {
        self.balance = balance;
    }

    /// Whether layers along axes that a frame does not use stay on the devices while there is memory for them. The default is
    /// true.
    pub fn keep(&mut self, keep: bool) {
        self.keep = keep;
    }

    /// Enables frame statistics of every rank in reports ([`RankReport::measured`](super::RankReport::measured)), from the next frame
    /// on. Measured frames are slower.
    pub fn measure(&mut self, measuring: bool) {
        self.measuring = measuring;
    }

    /// Time limit for the layers of one process and one lattice, as [`Renderer::limit`](crate::Renderer::limit).
    pub fn limit(&mut self, longest: Option<Duration>) {
        self.longest = longest;
    }

    /// Lets another thread of this process cancel its layers, as [`Renderer::set_cancel`](crate::Renderer::set_cancel). The frame
    /// then fails in all processes.
    pub fn set_cancel(&mut self, cancel: Option<Cancel>) {
        self.cancel = cancel;
    }

    /// Description of the whole volume.
    pub fn description(&self) -> &Description {
        match &self.source {
            Source::Host(volume) => volume.description(),
            Source::Device(uploaded) => uploaded.description(),
        }
    }

    /// The whole volume, and the transfer function.
    fn seen(&self) -> SeenVolume<'_> {
        SeenVolume { description: self.description(), transfer: &self.transfer }
    }

    /// Replaces the transfer function.
    pub fn set_transfer_function(&mut self, transfer: &TransferFunction) {
        if self.transfer != *transfer {
            self.transfer = transfer.clone();
            self.work = None;
            self.renderers().for_each(|renderer| renderer.set_transfer_function(transfer));
            self.forget_light();
        }
    }

    /// Replaces the volume, in the same bricks or others, and releases the redistributed voxels.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn set_volume(&mut self, volume: &Volume<'v>) -> Result<(), Error> {
        self.boxes = Boxes::from_volume(&self.group, volume)?;
        self.source = Source::Host(Box::new(volume.clone()));
        self.work = None;
        self.partitions = [None, None, None];
        Ok(())
    }

    /// Announces that bricks on the devices have new voxels once `wait` is complete.
    ///
    /// # Errors
    /// OpenCL errors.
    pub fn volume_changed(&mut self, wait: &[&Event]) -> Result<(), Error> {
        self.forget_light();
        let result = self.renderers().try_for_each(|renderer| renderer.volume_changed(wait));
        self.group.agree(result)
    }

    fn forget_light(&mut self) {
        self.partitions.iter_mut().flatten().for_each(|partition| partition.light = None);
    }

    /// All renderers that hold voxels on this rank.
    fn renderers(&mut self) -> impl Iterator<Item = &mut PartRenderer> {
        self.partitions.iter_mut().flatten().flat_map(|partition| partition.slabs.iter_mut().map(|(_, renderer)| renderer))
    }

    /// Ensures that every rank holds its layers of a view. Returns the voxel traffic. Collective.
    fn hold(&mut self, view: &LatticeView, settings: &Settings) -> Result<Exchanged, Error> {
        let (axis, around) = (view.axis(), PartRenderer::around(settings));
        let kept = self.partitions[axis.index()].as_ref().filter(|kept| kept.around >= around).map(|kept| kept.ranges.clone());
        let ranges = self.ranges(axis, settings.blend, kept.as_deref());
        if kept.as_ref() == Some(&ranges) {
            return Ok(Exchanged::default());
        }
        let dims = self.description().grid().dims();
        let wanted: Vec<VoxelBox> = ranges.iter().map(|layers| slab(dims, axis, layers, settings)).collect();
        self.release_other_axes(axis, wanted[self.group.rank()].count());
        let own = ranges[self.group.rank()].clone();
        let (slabs, exchanged) = match &self.source {
            Source::Host(volume) => {
                let (part, exchanged) = self.boxes.redistribute(&self.group, volume, &wanted)?;
                (self.group.agree(self.upload(&part, axis, &own, settings))?, exchanged)
            }
            Source::Device(uploaded) => {
                if let Some(rank) = (0..self.group.size()).find(|&rank| !self.boxes.held[rank].holds(&wanted[rank])) {
                    let (held, wanted) = (self.boxes.held[rank], wanted[rank]);
                    let problem = format!(
                        "the brick of rank {rank} on its device, {held:?}, lacks voxels of {wanted:?}, which layers along {axis:?} \
                         need: choose another axis or provide more ghost layers"
                    );
                    return Err(Error::Settings { field: "layer_axis", problem });
                }
                (vec![(own.clone(), PartRenderer::from_uploaded(uploaded, &self.transfer))], Exchanged::default())
            }
        };
        tracing::info!(
            "layers {own:?} along {axis:?} on this rank, in {} buffers; {} bytes sent, {} received",
            slabs.len(),
            exchanged.sent_bytes,
            exchanged.received_bytes
        );
        self.partitions[axis.index()] = Some(Partition { ranges, around, slabs, light: None });
        Ok(exchanged)
    }

    /// Uploads this rank's layers to its device, in as few buffers as the maximum buffer size allows.
    fn upload(
        &self,
        part: &VolumePart,
        axis: Axis,
        own: &Range<usize>,
        settings: &Settings,
    ) -> Result<Vec<(Range<usize>, PartRenderer)>, Error> {
        let dims = part.description().grid().dims();
        let layer = VoxelBox::whole(dims).count() / dims[axis.index()] * part.description().voxel_type().bytes();
        let max_layers =
            (self.device.largest_buffer_bytes() / layer as u64).saturating_sub(2 * PartRenderer::around(settings) as u64);
        let pieces = own.len().div_ceil(max_layers.max(1) as usize).max(1);
        let slabs = (0..pieces).map(|n| {
            let at = |n: usize| own.start + n * own.len() / pieces;
            let (layers, needed) = (at(n)..at(n + 1), slab(dims, axis, &(at(n)..at(n + 1)), settings));
            let uploaded = UploadedVolume::part(&self.device, &part.part(needed)?)?;
            Ok((layers, PartRenderer::from_uploaded(&uploaded, &self.transfer)))
        });
        slabs.collect()
    }

    /// The layers of each rank along an axis. Keeps the current or owned ranges unless these leave one rank with too much work.
    fn ranges(&mut self, axis: Axis, blend: Blend, kept: Option<&[Range<usize>]>) -> Vec<Range<usize>> {
        let current = kept.map(<[_]>::to_vec).or_else(|| self.boxes.slabs(axis, self.description().grid().dims()));
        if let Some(current) = current.as_ref().filter(|_| !self.balance || matches!(self.source, Source::Device(_))) {
            return current.clone();
        }
        let composited = blend == Blend::Composite;
        let Source::Host(volume) = &self.source else {
            return partition::even(self.description().grid().dims()[axis.index()], self.group.size());
        };
        if self.work.as_ref().is_none_or(|(estimated, _)| *estimated != composited) {
            let transfer = &self.transfer;
            let is_visible = |value: f64| !composited || transfer.opacity(value) > 0.0;
            self.work = Some((composited, work::estimate(volume, is_visible)));
        }
        let work = &self.work.as_ref().expect("estimated above").1[axis.index()];
        let balanced = partition::balanced(work, self.group.size());
        let least = partition::max_work(work, &balanced) as f64;
        current.filter(|current| partition::max_work(work, current) as f64 <= MAX_IMBALANCE * least).unwrap_or(balanced)
    }

    /// Releases the layers of `axis`, and those of other axes if some rank lacks the memory to keep them. Collective.
    fn release_other_axes(&mut self, axis: Axis, voxels: usize) {
        self.partitions[axis.index()] = None;
        let needed = 4 * (voxels * self.description().voxel_type().bytes()) as u64;
        let enough = self.keep && memory::available() / self.group.on_this_machine() as u64 > needed;
        if self.group.min(enough.into()) == 0 {
            self.partitions = [None, None, None];
        }
    }
}

/// The box of `layers` with their ghost layers. At least one layer, since a renderer cannot hold an empty box.
fn slab(dims: [usize; 3], axis: Axis, layers: &Range<usize>, settings: &Settings) -> VoxelBox {
    let a = axis.index();
    let first = layers.start.min(dims[a] - 1);
    let needed = if layers.is_empty() { first..first + 1 } else { PartRenderer::needed(layers, dims[a], settings) };
    VoxelBox::layers(dims, a, &needed)
}

/// Rejects views without a lattice, which cannot be distributed.
#[cfg(feature = "cli")]
pub(crate) fn check_view(seen: SeenVolume, camera: &Camera, viewport: Viewport, settings: &Settings) -> Result<(), Error> {
    LatticeView::all(seen, camera, viewport, settings).map(drop)
}
