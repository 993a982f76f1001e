//! Steps of a frame on the device and their resources.

use super::super::layered::{points, splats};
use super::super::light::{self, BlockSlabs, LightOfParts, SweepGroup};
use super::super::picture::{Share, declare_displayed, declare_floats};
use super::super::plan::Plan;
use super::super::range::LayerRange;
use super::super::rays::{self, RayOutput};
use super::super::slice_pass::{SlicePlan, declare_slice};
use super::super::surfaces::{SurfaceSizes, declare_surfaces};
use super::declaring::Declaring;
use super::resources::Resources;
use crate::image::Background;
use crate::layers::{Axis, Kernel, Lattice};
use crate::settings::{Classification, Layered};
use crate::volume::VoxelBox;
use std::ops::Range;

/// A step of a frame.
#[derive(Clone)]
pub(in crate::renderer) enum Step<'a> {
    /// Replaces the voxels on the device by those of a box, in a buffer for `capacity` voxels.
    Hold { voxels: VoxelBox, capacity: usize },
    /// Sweeps light through slab number `slab` of a group, whose voxels are on the device.
    Sweep { light: &'a LightOfParts, group: &'a SweepGroup, slab: usize },
    /// Completes the light of parts.
    FinishLight(&'a LightOfParts),
    /// Sums the blocks of slab number `slab`, whose voxels and light are on the device.
    SumBlocks { light: &'a LightOfParts, slabs: &'a BlockSlabs, slab: usize },
    /// Scatters light between all blocks.
    Scatter(&'a LightOfParts),
    /// Uploads the light of a part that holds these layers of voxels along an axis.
    HoldLight { light: &'a LightOfParts, axis: Axis, voxels: Range<usize> },
    /// Uploads raw samples from which layers continue.
    Continue(&'a [[f32; 4]]),
    /// Composites layers of a lattice.
    Layers { lattice: &'a Lattice, layered: Layered, range: LayerRange },
    /// Renders screen pixels, without a lattice.
    Screen(&'a Plan, RayOutput),
    /// Renders screen pixels with surfaces. The steps draw the volume between two fragments.
    Surfaces(Steps<'a>, SurfaceSizes),
    /// Draws the plane on which the frame's rays begin.
    Slice(SlicePlan),
    /// Warps the lattice into the float picture, with its share.
    Warp { lattice: &'a Lattice, share: Share },
    /// Warps the lattice directly into the displayed picture.
    WarpDisplayed { lattice: &'a Lattice, background: Background },
    /// Converts the float picture to 8 bits over a background.
    Present(Background),
}

/// Output of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::renderer) enum Output {
    /// The lattice samples before the warp; with several lattices, those of the first one.
    Samples,
    /// A picture of premultiplied floats.
    Floats,
    /// An 8-bit picture over a background.
    Rgba8(Background),
}

/// Steps that share buffers.
#[derive(Clone, Default)]
pub(in crate::renderer) struct Stage<'a> {
    pub steps: Steps<'a>,
    pub resources: Resources,
}

/// The steps of a stage.
pub(in crate::renderer) type Steps<'a> = Vec<Step<'a>>;

impl<'a> Stage<'a> {
    /// A stage that renders a plan with all voxels on the device. With `bound`, the picture goes to the caller's memory.
    pub fn from_plan(plan: &'a Plan, output: Output, bound: bool, declaring: &Declaring) -> Self {
        let steps = match declaring.surfaces {
            Some(surfaces) => displayed(vec![Step::Surfaces(steps(plan, Output::Floats), surfaces)], output),
            None => steps(plan, output),
        };
        Self::new(steps, bound, declaring)
    }

    /// A stage of the given steps.
    pub fn new(steps: Steps<'a>, bound: bool, declaring: &Declaring) -> Self {
        let mut resources = Resources::default();
        resources.field(&declaring.shape);
        steps.iter().for_each(|step| step.declare(declaring, bound, &mut resources));
        Self { steps, resources }
    }

    /// Number of voxels of the buffer in which the stage holds parts; `None` if it renders the voxels that are there.
    pub fn capacity(&self) -> Option<usize> {
        capacity(&self.steps)
    }
}

fn capacity(steps: &[Step]) -> Option<usize> {
    steps.iter().find_map(|step| match step {
        Step::Hold { capacity, .. } => Some(*capacity),
        Step::Surfaces(volume, _) => capacity(volume),
        _ => None,
    })
}

/// The lattice that steps draw, and what they gather along rays.
pub(super) fn drawn_by<'a>(steps: &[Step<'a>]) -> (Option<&'a Lattice>, RayOutput) {
    let drawn = steps.iter().find_map(|step| match *step {
        Step::Layers { lattice, .. } => Some((Some(lattice), RayOutput::Colors)),
        Step::Screen(_, gathers) => Some((None, gathers)),
        _ => None,
    });
    drawn.unwrap_or((None, RayOutput::Colors))
}

/// The steps of a lattice, without the parts that lie beside these positions ([`LayerRange::meets`]).
pub(super) fn between<'a>(steps: &[Step<'a>], positions: [f32; 2]) -> Steps<'a> {
    let mut kept: Steps = Vec::new();
    let mut held = None;
    for step in steps {
        match step {
            Step::Hold { .. } => held = Some(step),
            Step::Layers { lattice, range, .. } if !range.meets(lattice, positions) => held = None,
            step => kept.extend(held.take().into_iter().chain([step]).cloned()),
        }
    }
    let mut ranges: Vec<_> =
        kept.iter_mut().filter_map(|step| if let Step::Layers { range, .. } = step { Some(range) } else { None }).collect();
    let last = ranges.len().saturating_sub(1);
    ranges.iter_mut().enumerate().for_each(|(n, range)| (range.continues, range.raw) = (n > 0, n < last));
    kept
}

fn steps(plan: &Plan, output: Output) -> Steps<'_> {
    let layers = |lattice, layered| Step::Layers { lattice, layered, range: LayerRange::whole(lattice) };
    match (plan, output) {
        (Plan::Lattice(lattice, layered), Output::Samples) => vec![layers(lattice, *layered)],
        (Plan::Lattice(lattice, layered), Output::Floats) => {
            vec![layers(lattice, *layered), Step::Warp { lattice, share: Share::WHOLE }]
        }
        (Plan::Lattice(lattice, layered), Output::Rgba8(background)) => {
            vec![layers(lattice, *layered), Step::WarpDisplayed { lattice, background }]
        }
        (Plan::Shared(parts, layered), Output::Samples) => vec![layers(&parts[0].0, *layered)],
        (Plan::Shared(parts, layered), output) => {
            let mut steps = Vec::new();
            for (n, (lattice, share)) in parts.iter().enumerate() {
                let share = Share { share: *share, added: n > 0 };
                steps.extend([layers(lattice, *layered), Step::Warp { lattice, share }]);
            }
            displayed(steps, output)
        }
        (plan, output) => displayed(vec![Step::Screen(plan, RayOutput::Colors)], output),
    }
}

/// Appends the conversion to the output format to steps that end in a float picture.
fn displayed(mut steps: Steps<'_>, output: Output) -> Steps<'_> {
    if let Output::Rgba8(background) = output {
        steps.push(Step::Present(background));
    }
    steps
}

impl Step<'_> {
    /// Declares the resources of this step. With `bound`, the finished picture goes to the caller's memory.
    fn declare(&self, declaring: &Declaring, bound: bool, resources: &mut Resources) {
        match self {
            Step::Hold { .. } | Step::HoldLight { .. } | Step::FinishLight(_) | Step::Scatter(_) | Step::Continue(_) => {}
            Step::Sweep { group, .. } => group.declare(declaring, group.most_layers(), resources),
            Step::SumBlocks { slabs, .. } => slabs.declare(declaring, slabs.most_layers(), resources),
            Step::Layers { lattice, layered, .. } => {
                light::declare(declaring, resources);
                match layered.classification {
                    Classification::Preintegrated { kernel, .. } => {
                        points::declare_lattice(declaring, (lattice, layered.evaluation), kernel, resources)
                    }
                    Classification::Post(correction) => splats::declare_lattice(declaring, lattice, correction, resources),
                }
            }
            Step::Screen(plan, _) => {
                light::declare(declaring, resources);
                declare_screen(plan, declaring, resources);
            }
            Step::Surfaces(volume, surfaces) => {
                volume.iter().for_each(|step| step.declare(declaring, false, resources));
                let (lattice, _) = drawn_by(volume);
                declare_surfaces(*surfaces, lattice, declaring.viewport, declaring.tuning, resources);
                declaring.table(Kernel::Cubic, resources);
            }
            Step::Slice(plan) => declare_slice(declaring, plan.kernel, resources),
            Step::Warp { .. } if !bound => declare_floats(declaring.viewport, resources),
            Step::WarpDisplayed { .. } | Step::Present(_) if !bound => declare_displayed(declaring.viewport, resources),
            Step::Warp { .. } | Step::WarpDisplayed { .. } | Step::Present(_) => {}
        }
    }
}

fn declare_screen(plan: &Plan, declaring: &Declaring, resources: &mut Resources) {
    match plan {
        Plan::Direct(axis, layered) => match layered.classification {
            Classification::Preintegrated { kernel, .. } => points::declare_pixels(declaring, *axis, kernel, resources),
            Classification::Post(correction) => {
                splats::declare_pixels(declaring, *axis, correction, layered.footprints, resources);
            }
        },
        #[cfg(feature = "paper")]
        Plan::Paper(plan) => plan.declare(declaring, resources),
        Plan::Raycast(kernel, _) | Plan::CastValues(kernel, _) => rays::declare_casting(declaring, *kernel, resources),
        Plan::CastSegments(kernel, _) => rays::declare_segments(declaring, *kernel, resources),
        Plan::Lattice(..) | Plan::Shared(..) => unreachable!("lattices are rendered as layers"),
    }
}
