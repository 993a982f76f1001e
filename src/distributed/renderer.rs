//! One renderer in several processes.

use super::compose::Composer;
use super::exchange::{Boxes, Exchanged};
use super::group::Group;
use super::report::{DistributedReport, Own};
use super::{Brick, cut, work};
use crate::camera::Camera;
use crate::device::{Cancel, Device};
use crate::error::Error;
use crate::image::{Depths, Frame};
use crate::layers::Axis;
use crate::memory;
use crate::renderer::{DeviceVoxels, FrameReport, LatticeView, PartRenderer, Shares, StreamPlan, UploadedVolume, VolumeRenderer};
use crate::settings::{Blend, Settings};
use crate::transfer::TransferFunction;
use crate::viewport::Viewport;
use crate::volume::{Description, Grid, Volume, VolumePart, VoxelBox};
use opencl3::event::Event;
use std::ops::Range;
use std::time::{Duration, Instant};

/// How much more work the busiest rank may have than it needs to, before voxels are sent for the sake of balance.
const UNEVEN: f64 = 1.2;

/// Renders a volume whose voxels are with the processes of a [`Group`]: each composites a range of layers on its own device, and rank 0
/// has the picture. All calls are collective, with the same arguments.
///
/// Ranges are cut by what shows under the transfer function. Where ranks do not have the layers that they need, as when the axis changes,
/// voxels are sent once, and stay as long as there is memory for them.
///
/// With one process a picture has the bits of a [`Renderer`](crate::Renderer)'s. With more, floats associate differently, and a rank does
/// not know what ends in front of it: without early termination it is that picture within 2e-6 per channel, with it within 1/4096; the
/// same bit for bit from run to run.
pub struct Renderer<'v> {
    group: Group,
    device: Device,
    source: Source<'v>,
    boxes: Boxes,
    transfer: TransferFunction,
    /// Work of each layer along x, y and z, where only what has opacity counts, or everything.
    work: Option<(bool, [Vec<u64>; 3])>,
    cuts: [Option<Cut>; 3],
    composer: Composer,
    shares: Shares,
    balance: bool,
    keep: bool,
    longest: Option<Duration>,
    cancel: Option<Cancel>,
    last_report: Option<DistributedReport>,
}

/// Where the voxels of a process are.
enum Source<'v> {
    Host(Volume<'v>),
    Device(UploadedVolume),
}

/// The layers of an axis, as they are shared out.
struct Cut {
    ranges: Vec<Range<usize>>,
    around: usize,
    /// This rank's, each with a buffer of its own: as many as devices need that have none for all of it. There is one at least.
    slabs: Vec<(Range<usize>, PartRenderer)>,
}

impl Cut {
    /// The raw samples of this rank's layers.
    fn raw(&mut self, view: &LatticeView) -> Result<Vec<[f32; 4]>, Error> {
        let last = self.slabs.len() - 1;
        let mut done = None;
        for n in 0..=last {
            let (layers, renderer) = &mut self.slabs[if view.ascending() { n } else { last - n }];
            done = Some(renderer.raw(view, layers, done.as_deref())?);
        }
        Ok(done.expect("there is one at least"))
    }

    /// One that holds voxels for views along the axis.
    fn renderer(&mut self) -> &mut PartRenderer {
        &mut self.slabs[0].1
    }
}

impl<'v> Renderer<'v> {
    /// Renders a volume of a group's ([`Group::open`], [`Group::volume`]). Nothing is uploaded yet.
    ///
    /// # Errors
    /// Bricks that overlap, or that leave voxels out.
    pub fn new(group: &Group, device: &Device, volume: &Volume<'v>, transfer: &TransferFunction) -> Result<Self, Error> {
        let boxes = Boxes::of(group, volume)?;
        Ok(Self::of(group, device, Source::Host(volume.clone()), boxes, transfer))
    }

    /// Renders bricks that lie on the processes' devices, and stay there: whole slabs along one axis, each on the rank behind the one
    /// below, with the ghost layers that a view needs. The description is the same on all. Views along another axis are refused.
    ///
    /// # Errors
    /// As [`UploadedVolume::in_place`], and bricks that overlap, or that leave voxels out.
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
        Ok(Self::of(group, device, Source::Device(uploaded), boxes, transfer))
    }

    fn of(group: &Group, device: &Device, source: Source<'v>, boxes: Boxes, transfer: &TransferFunction) -> Self {
        Self {
            group: group.clone(),
            device: device.clone(),
            source,
            boxes,
            transfer: transfer.clone(),
            work: None,
            cuts: [None, None, None],
            composer: Composer::default(),
            shares: Shares::default(),
            balance: true,
            keep: true,
            longest: None,
            cancel: None,
            last_report: None,
        }
    }

    /// Whether voxels are sent for the sake of balance, which they are unless this says otherwise, or only where a rank lacks them: where
    /// they change before every picture, as in simulations, they had better stay.
    pub fn balance(&mut self, balance: bool) {
        self.balance = balance;
    }

    /// Whether the layers of axes that a picture does not need stay on devices, as long as there is memory for them; they do unless this
    /// says otherwise.
    pub fn keep(&mut self, keep: bool) {
        self.keep = keep;
    }

    /// How long a process may take for its layers of a lattice from now on, as [`Renderer::limit`](crate::Renderer::limit).
    pub fn limit(&mut self, longest: Option<Duration>) {
        self.longest = longest;
    }

    /// Lets another thread of this process cancel its layers of a lattice, as [`Renderer::set_cancel`](crate::Renderer::set_cancel): the
    /// picture then fails in all processes.
    pub fn set_cancel(&mut self, cancel: Option<Cancel>) {
        self.cancel = cancel;
    }

    /// What the processes did for the last picture.
    pub fn last_report(&self) -> Option<&DistributedReport> {
        self.last_report.as_ref()
    }

    /// What is known of the whole volume.
    pub fn description(&self) -> &Description {
        match &self.source {
            Source::Host(volume) => volume.description(),
            Source::Device(uploaded) => uploaded.description(),
        }
    }

    /// Takes another transfer function from the next picture on.
    pub fn set_transfer_function(&mut self, transfer: &TransferFunction) {
        if self.transfer != *transfer {
            self.transfer = transfer.clone();
            self.work = None;
            self.renderers().for_each(|renderer| renderer.set_transfer_function(transfer));
        }
    }

    /// Takes other voxels, in the same bricks or others, and forgets those that were sent.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn set_volume(&mut self, volume: &Volume<'v>) -> Result<(), Error> {
        self.boxes = Boxes::of(&self.group, volume)?;
        self.source = Source::Host(volume.clone());
        self.work = None;
        self.cuts = [None, None, None];
        Ok(())
    }

    /// The voxels of bricks that lie on devices have changed, once `wait` is complete.
    ///
    /// # Errors
    /// What OpenCL answers.
    pub fn volume_changed(&mut self, wait: &[&Event]) -> Result<(), Error> {
        let told = self.renderers().try_for_each(|renderer| renderer.volume_changed(wait));
        self.group.agree(told)
    }

    /// Renders a picture: premultiplied floats, without a background, which rank 0 has.
    ///
    /// # Errors
    /// Views without a lattice, and what fails on any process.
    pub fn render(
        &mut self,
        camera: &Camera,
        viewport: Viewport,
        settings: &Settings,
    ) -> Result<(Option<Frame>, DistributedReport), Error> {
        let views = self.group.agree(LatticeView::all(self.description(), camera, viewport, settings))?;
        let read_bytes = match &self.source {
            Source::Host(volume) => volume.read_bytes(),
            Source::Device(_) => 0,
        };
        let mut own = Own { read_bytes, ..Own::default() };
        let (mut composed, mut compose_ms) = (Vec::new(), 0.0);
        self.shares.begin();
        for (view, share) in &views {
            let exchanged = self.hold(view, settings)?;
            own.exchanged.sent_bytes += exchanged.sent_bytes;
            own.exchanged.received_bytes += exchanged.received_bytes;
            let (longest, cancel) = (self.longest, self.cancel.clone());
            self.renderers().for_each(|renderer| {
                renderer.limit(longest);
                renderer.set_cancel(cancel.clone());
            });
            let Self { group, composer, cuts, shares, .. } = self;
            let cut = cuts[view.axis().index()].as_mut().expect("it is held now");
            let (layers, started) = (cut.ranges[group.rank()].clone(), Instant::now());
            let samples = cut.raw(view);
            own.layers += layers.len();
            own.render_ms += milliseconds(started);
            let mut samples = group.agree(samples)?;
            let started = Instant::now();
            composed.push(composer.compose(group, view, !layers.is_empty(), &mut samples));
            compose_ms += milliseconds(started);
            let added = if group.leads() { shares.add(cut.renderer(), view, *share, &samples) } else { Ok(()) };
            group.agree(added)?;
        }
        let (first, _) = &views[0];
        // Of the axes before, nothing may be held any more.
        let Self { group, cuts, shares, .. } = self;
        let last = views.last().and_then(|(view, _)| cuts[view.axis().index()].as_mut()).expect("it was drawn");
        let frame = group.leads().then(|| shares.frame(last.renderer(), first)).transpose();
        let frame = self.group.agree(frame)?;
        let axes = views.iter().map(|(view, _)| view.axis()).collect();
        let report = DistributedReport { lattice: first.report(), axes, ranks: own.gather(&self.group), composed, compose_ms };
        self.last_report = Some(report.clone());
        Ok((frame, report))
    }

    /// All that hold voxels on this rank.
    fn renderers(&mut self) -> impl Iterator<Item = &mut PartRenderer> {
        self.cuts.iter_mut().flatten().flat_map(|cut| cut.slabs.iter_mut().map(|(_, renderer)| renderer))
    }

    /// Sees to it that every rank has the layers that are its part of a view.
    fn hold(&mut self, view: &LatticeView, settings: &Settings) -> Result<Exchanged, Error> {
        let (axis, around) = (view.axis(), PartRenderer::around(settings));
        let kept = self.cuts[axis.index()].as_ref().filter(|cut| cut.around >= around).map(|cut| cut.ranges.clone());
        let ranges = self.ranges(axis, settings.blend, kept.as_deref());
        if kept.as_ref() == Some(&ranges) {
            return Ok(Exchanged::default());
        }
        let dims = self.description().grid().dims();
        let wanted: Vec<VoxelBox> = ranges.iter().map(|layers| slab(dims, axis, layers, settings)).collect();
        self.make_room(axis, wanted[self.group.rank()].count());
        let own = ranges[self.group.rank()].clone();
        let (slabs, exchanged) = match &self.source {
            Source::Host(volume) => {
                let (part, exchanged) = self.boxes.bring(&self.group, volume, &wanted)?;
                (self.group.agree(self.uploaded(&part, axis, &own, settings))?, exchanged)
            }
            Source::Device(uploaded) => {
                if let Some(rank) = (0..self.group.size()).find(|&rank| !self.boxes.held[rank].holds(&wanted[rank])) {
                    let (held, wanted) = (self.boxes.held[rank], wanted[rank]);
                    let problem = format!(
                        "the brick of rank {rank}, {held:?}, lies on its device without all of {wanted:?}, which layers along {axis:?} \
                         need: choose another axis, or hand over more ghost layers"
                    );
                    return Err(Error::Settings { field: "layer_axis", problem });
                }
                (vec![(own.clone(), PartRenderer::from_uploaded(uploaded, &self.transfer))], Exchanged::default())
            }
        };
        tracing::info!(
            "layers along {axis:?}: {own:?} are this rank's, in {} buffers; {} bytes sent, {} received",
            slabs.len(),
            exchanged.sent_bytes,
            exchanged.received_bytes
        );
        self.cuts[axis.index()] = Some(Cut { ranges, around, slabs });
        Ok(exchanged)
    }

    /// This rank's layers on its device, in as few buffers as that has room in one for.
    fn uploaded(
        &self,
        part: &VolumePart,
        axis: Axis,
        own: &Range<usize>,
        settings: &Settings,
    ) -> Result<Vec<(Range<usize>, PartRenderer)>, Error> {
        let dims = part.description().grid().dims();
        let layer = VoxelBox::whole(dims).count() / dims[axis.index()] * part.description().voxel_type().bytes();
        let most = (self.device.largest_buffer_bytes() / layer as u64).saturating_sub(2 * PartRenderer::around(settings) as u64);
        let pieces = own.len().div_ceil(most.max(1) as usize).max(1);
        let slabs = (0..pieces).map(|n| {
            let at = |n: usize| own.start + n * own.len() / pieces;
            let (layers, needed) = (at(n)..at(n + 1), slab(dims, axis, &(at(n)..at(n + 1)), settings));
            let uploaded = UploadedVolume::part(&self.device, &part.part(needed)?)?;
            Ok((layers, PartRenderer::from_uploaded(&uploaded, &self.transfer)))
        });
        slabs.collect()
    }

    /// The layers of each rank along an axis: those that they have, or had before, unless that leaves one with too much work.
    fn ranges(&mut self, axis: Axis, blend: Blend, kept: Option<&[Range<usize>]>) -> Vec<Range<usize>> {
        let there = kept.map(<[_]>::to_vec).or_else(|| self.boxes.slabs(axis, self.description().grid().dims()));
        if let Some(there) = there.as_ref().filter(|_| !self.balance || matches!(self.source, Source::Device(_))) {
            return there.clone();
        }
        let composited = blend == Blend::Composite;
        let Source::Host(volume) = &self.source else {
            return cut::even(self.description().grid().dims()[axis.index()], self.group.size());
        };
        if self.work.as_ref().is_none_or(|(of, _)| *of != composited) {
            let transfer = &self.transfer;
            let shows = |value: f64| !composited || transfer.opacity(value) > 0.0;
            self.work = Some((composited, work::of_layers(volume, shows)));
        }
        let work = &self.work.as_ref().expect("it was just found").1[axis.index()];
        let balanced = cut::balanced(work, self.group.size());
        let least = cut::heaviest(work, &balanced) as f64;
        there.filter(|there| cut::heaviest(work, there) as f64 <= UNEVEN * least).unwrap_or(balanced)
    }

    /// Forgets the layers of other axes where some rank has no memory to keep them. Collective.
    fn make_room(&mut self, axis: Axis, voxels: usize) {
        self.cuts[axis.index()] = None;
        let needed = 4 * (voxels * self.description().voxel_type().bytes()) as u64;
        let enough = self.keep && memory::available() / self.group.on_this_machine() as u64 > needed;
        if self.group.least(enough.into()) == 0 {
            self.cuts = [None, None, None];
        }
    }
}

impl<'v> VolumeRenderer<'v> for Renderer<'v> {
    fn set_transfer_function(&mut self, transfer: &TransferFunction) {
        self.set_transfer_function(transfer);
    }

    fn set_volume(&mut self, volume: &Volume<'v>) -> Result<(), Error> {
        self.set_volume(volume)
    }

    fn grid(&self) -> &Grid {
        self.description().grid()
    }

    fn measure(&mut self, _: bool) {}

    fn limit(&mut self, longest: Option<Duration>) {
        self.limit(longest);
    }

    fn set_cancel(&mut self, cancel: Option<Cancel>) {
        self.set_cancel(cancel);
    }

    fn stream_plan(&self, camera: &Camera, viewport: Viewport, settings: &Settings) -> Result<Option<StreamPlan>, Error> {
        LatticeView::all(self.description(), camera, viewport, settings).map(|_| None)
    }

    fn render(
        &mut self,
        camera: &Camera,
        viewport: Viewport,
        settings: &Settings,
    ) -> Result<(Option<Frame>, FrameReport), Error> {
        let (frame, report) = self.render(camera, viewport, settings)?;
        Ok((frame, FrameReport { lattice: Some(report.lattice), measured: None, general_program: false }))
    }

    fn depths(&mut self, _: &Camera, _: Viewport, _: &Settings) -> Result<Depths, Error> {
        let problem = "depths need the whole volume on one device".into();
        Err(Error::Settings { field: "depth", problem })
    }
}

/// Whole layers with those around them; one where there are none: a renderer holds something.
fn slab(dims: [usize; 3], axis: Axis, layers: &Range<usize>, settings: &Settings) -> VoxelBox {
    let a = axis.index();
    let first = layers.start.min(dims[a] - 1);
    let needed = if layers.is_empty() { first..first + 1 } else { PartRenderer::needed(layers, dims[a], settings) };
    VoxelBox::layers(dims, a, &needed)
}

/// Refuses a view that processes cannot share: one without a lattice.
#[cfg(feature = "cli")]
pub(crate) fn check_view(
    description: &Description,
    camera: &Camera,
    viewport: Viewport,
    settings: &Settings,
) -> Result<(), Error> {
    LatticeView::all(description, camera, viewport, settings).map(drop)
}

fn milliseconds(since: Instant) -> f64 {
    since.elapsed().as_secs_f64() * 1e3
}
