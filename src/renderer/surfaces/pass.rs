//! The pass of surfaces.
//!
//! The fragments of a ray cut the volume: it is drawn interval by interval, each as a picture of its own, and composited with the fragments. So
//! every method that clips rays draws volumes around surfaces. Most frames have few intervals: opaque fragments end rays, and where there is no
//! volume between two fragments, nothing is drawn.

use super::super::frame::{Resources, Slot};
use super::super::picture::{Share, WarpInputs};
use super::super::rays::{AXIS, RayOutput};
use super::super::region::Region;
use super::super::scene::Scene;
use super::super::tiles::Target;
use super::cells::{BOUNDS, COUNTS, CellLists, FoundCells, LISTS, POINTS, ROUNDED, declare_cells};
use super::uploaded::{SurfaceSizes, UploadedSurfaces};
use super::view::{fragment_ends, ray_ends, surface_view};
use crate::device::launch::structs::{Float4, LightParams, RayEnds, WarpParams};
use crate::device::launch::surfaces::{FRAGMENTS, Fragments, FragmentsArguments, OverFragments, OverFragmentsArguments};
use crate::device::launch::{Launcher, Rendering};
use crate::device::{Buffer, Tuning};
use crate::error::Error;
use crate::layers::{Kernel, Lattice};
use crate::settings::Settings;
use crate::viewport::Viewport;
use std::sync::{Arc, Weak};

const DEPTHS: Slot<f32> = Slot::new("the depths of fragments");
const COLORS: Slot<[u16; 4]> = Slot::new("the colours of fragments");
const CROSSINGS: Slot<u32> = Slot::new("the last fragments");
const STATES: Slot<u8> = Slot::new("the numbers of fragments");
const NEXT: Slot<u8> = Slot::new("the next fragments");
const PENDING: Slot<Float4> = Slot::new("the rows with further fragments");
const CUTS: Slot<[f32; 2]> = Slot::new("the parts of rays");
const SAMPLE_CUTS: Slot<[f32; 2]> = Slot::new("the parts of rays of a lattice");
const PICTURE: Slot<Float4> = Slot::new("the picture with surfaces");

/// Voxels by which fields of any kernel end beyond that of the paper's cubic.
const VOLUME_MARGIN: f64 = 2.0;

/// Passes that an enqueued frame has at most.
const MOST_PASSES: usize = 256;

/// Times that fragments are found in a frame before the cells of tiles are sorted, which takes about as long as to find them once.
const FOUND_UNSORTED: usize = 2;

/// Draws surfaces.
#[derive(Default)]
pub(in crate::renderer) struct SurfacePass {
    cells: CellLists,
    fragments: Launcher<Fragments>,
    over: Launcher<OverFragments>,
    /// The cells of the frame.
    found: Option<Arc<FoundCells>>,
    /// The fragments that the last frame has left in its buffers, or those that this frame draws: all that are the first ones of rays.
    kept: Option<FoundFragments>,
    drawn: Option<FoundFragments>,
    /// Times that fragments have been found, if cells may be sorted: of enqueued frames, passes are bounded by exact numbers.
    times: Option<usize>,
}

/// What the first fragments of a frame depend on. Frames share them as long as it stays the same, but not in the light of volumes, which changes
/// in its buffers.
struct FoundFragments {
    cells: Weak<FoundCells>,
    /// The buffer that has their depths: frames in other memory have others.
    depths: Weak<Buffer<f32>>,
    light: LightParams,
    gradient_scale: [f32; 3],
    ray_ends: RayEnds,
    rendering: Rendering,
}

impl FoundFragments {
    fn are_of(&self, other: &Self) -> bool {
        self.cells.ptr_eq(&other.cells)
            && self.depths.ptr_eq(&other.depths)
            && (self.light, self.gradient_scale, self.ray_ends) == (other.light, other.gradient_scale, other.ray_ends)
            && self.rendering == other.rendering
    }
}

/// What a frame still needs.
#[derive(Clone, Copy, Default)]
pub(in crate::renderer) struct Pending {
    /// Parts of rays, all between these positions in the layers of a lattice, from that of the centre along rays.
    pub draw: Option<[f32; 2]>,
    /// Further fragments.
    pub find: bool,
}

impl Pending {
    /// Before anything is composited.
    pub const FIRST: Self = Self { draw: None, find: true };

    /// Whether it needs nothing.
    pub fn is_nothing(self) -> bool {
        self.draw.is_none() && !self.find
    }
}

/// The passes of a frame from which nothing is read back: as many as it can need. Those that have nothing to draw cost little.
pub(in crate::renderer) struct EnqueuedPasses {
    left: usize,
    /// Whether there can be more fragments than are found at first.
    find: bool,
}

impl EnqueuedPasses {
    /// With a bound on the translucent fragments of a ray.
    fn new(most_translucent: usize) -> Result<Self, Error> {
        // With an opaque one behind them, or the volume.
        let most = most_translucent.saturating_add(1);
        // A pass draws one interval of each ray, or finds fragments.
        let further = most.div_ceil(FRAGMENTS) - 1;
        let passes = most.saturating_add(further);
        if passes <= MOST_PASSES {
            return Ok(Self { left: passes, find: further > 0 });
        }
        let problem = format!(
            "rays cross up to {most_translucent} translucent surfaces, so this frame would have {passes} passes. Frames that are \
             enqueued without reading back what is still to draw have at most {MOST_PASSES}: use `render`"
        );
        Err(Error::Settings { field: "surfaces", problem })
    }

    /// What to do in the next pass.
    pub fn next(&mut self) -> Pending {
        let Some(left) = self.left.checked_sub(1) else { return Pending::default() };
        self.left = left;
        Pending { draw: Some([f32::NEG_INFINITY, f32::INFINITY]), find: self.find }
    }
}

/// Declares the resources of [`SurfacePass`].
pub(in crate::renderer) fn declare_surfaces(
    sizes: SurfaceSizes,
    lattice: Option<&Lattice>,
    viewport: Viewport,
    tuning: &Tuning,
    resources: &mut Resources,
) {
    if let Some(lattice) = lattice {
        resources.frame(&SAMPLE_CUTS, lattice.samples());
    }
    declare_cells(sizes, viewport, tuning, resources);
    let pixels = viewport.pixels();
    resources.frame(&DEPTHS, FRAGMENTS * pixels);
    resources.frame(&COLORS, FRAGMENTS * pixels);
    resources.frame(&CROSSINGS, pixels);
    resources.frame(&STATES, pixels);
    resources.frame(&NEXT, pixels);
    resources.frame(&PENDING, viewport.height as usize);
    resources.frame(&CUTS, pixels);
    resources.frame(&PICTURE, pixels);
}

impl SurfacePass {
    /// Begins a frame: lists the cells of each tile. Returns the passes of a frame from which nothing is read back.
    ///
    /// `lattice`: its samples are the pixels.
    pub fn begin(
        &mut self,
        scene: &Scene,
        surfaces: &Arc<UploadedSurfaces>,
        lattice: Option<&Lattice>,
        is_enqueued: bool,
        target: &Target,
    ) -> Result<Option<EnqueuedPasses>, Error> {
        let Scene { device, field, rays, viewport, .. } = *scene;
        (self.found, self.drawn) = (None, None);
        self.times = (!is_enqueued).then_some(0);
        let view = surface_view(field.grid(), rays, viewport, lattice);
        let placed = surfaces.placed(field.grid(), field.world().unit());
        let (found, passes) = if is_enqueued {
            let found = self.cells.counted(device, surfaces, view, placed)?;
            let passes = EnqueuedPasses::new(found.most_translucent.expect("they are counted"))?;
            (found, Some(passes))
        } else {
            (self.cells.found(device, surfaces, view, placed)?, None)
        };
        self.found = Some(found);
        if let Some(lattice) = lattice {
            // Samples beside the screen are not drawn.
            target.arena.get(&SAMPLE_CUTS).fill(device, [0.0; 2], lattice.samples())?;
        }
        Ok(passes)
    }

    /// Drops what frames of the same view share.
    pub fn drop_cached(&mut self) {
        (self.found, self.kept, self.drawn) = (None, None, None);
        self.cells.clear();
    }

    /// Ends a frame that has been waited for: the next one may draw its fragments.
    pub fn end(&mut self) {
        self.kept = self.drawn.take();
    }

    /// Finds the first fragments of all rays, or the next ones of those that wait for them.
    pub fn find(&mut self, scene: &mut Scene, surfaces: &UploadedSurfaces, target: &Target, first: bool) -> Result<(), Error> {
        let (device, arena) = (scene.device, &target.arena);
        let found = self.found.as_ref().expect("a frame begins");
        let (cells, depths) = (&found.buffers, arena.get(&DEPTHS));
        let illumination = scene.illumination()?;
        let table = scene.table(Kernel::Cubic)?;
        let sample = scene.surface_samples(&table, AXIS.frame());
        let region = Region::of_clipping(scene);
        let rendering = Rendering { gradient_opacity: false, ..region.rendering };
        let ray_ends = fragment_ends(&region, scene);
        let fragments = FoundFragments {
            cells: Arc::downgrade(found),
            depths: Arc::downgrade(&depths),
            light: sample.light,
            gradient_scale: sample.field.gradient,
            ray_ends,
            rendering,
        };
        let kept = self.kept.take().filter(|kept| first && kept.are_of(&fragments));
        let are_kept = kept.is_some();
        self.drawn = kept.or_else(|| Some(fragments).filter(|_| first && !rendering.light_volume && !rendering.studio));
        if are_kept {
            return Ok(());
        }
        let unused = Buffer::<u8>::new(device, 1, "no light")?;
        let unsorted = Buffer::<f32>::new(device, 1, "no depths")?;
        self.times.iter_mut().for_each(|times| *times += 1);
        let sorted = match self.times {
            Some(times) if times > FOUND_UNSORTED => self.cells.sorted(device, surfaces, found)?,
            _ => None,
        };
        let [nearest, farthest] = sorted.unwrap_or([&unsorted; 2]);
        let arguments = FragmentsArguments {
            points: &cells.get(&POINTS),
            cells: &surfaces.cells,
            sets: &found.sets,
            attributes: &surfaces.attributes,
            normals: &surfaces.normals,
            tables: &surfaces.tables,
            rounded: &cells.get(&ROUNDED),
            bounds: &cells.get(&BOUNDS),
            ends: &cells.get(&COUNTS),
            lists: &cells.get(&LISTS),
            nearest,
            farthest,
            chunks: device.tuning().splat_chunks as i32,
            first: i32::from(first),
            view: found.view,
            sample,
            ray_ends,
            light: illumination.arguments(&unused),
            depths: &depths,
            colors: &arena.get(&COLORS),
            crossings: &arena.get(&CROSSINGS),
            states: &arena.get(&STATES),
        };
        self.fragments.launch(device, (rendering, sorted.is_some()), &arguments)
    }

    /// Composites what was drawn, and the fragments behind it, and cuts rays at the next ones.
    pub fn composite(
        &mut self,
        scene: &Scene,
        (drawn, lattice): (&Buffer<Float4>, Option<&Lattice>),
        target: &Target,
        gathers: RayOutput,
        first: bool,
    ) -> Result<(), Error> {
        let (device, arena) = (scene.device, &target.arena);
        let found = self.found.as_ref().expect("a frame begins");
        let cuts = arena.get(&CUTS);
        let sample_cuts = Self::cuts(target, lattice.is_some());
        let is_linear = scene.settings.studio.is_some();
        let onto = |lattice| WarpInputs { lattice, rays: scene.rays, viewport: scene.viewport, is_linear };
        let arguments = OverFragmentsArguments {
            view: found.view,
            lattice: lattice.map_or(WarpParams::NONE, |lattice| onto(lattice).params(target.drawn().tiles, Share::WHOLE)),
            volume_ends: ray_ends(&Region::marched(scene, Kernel::Cubic, VOLUME_MARGIN), scene),
            opaque: if scene.settings.early_termination { Settings::OPAQUE as f32 } else { 0.0 },
            over_all: i32::from(scene.settings.blend.gathers_values()),
            first: i32::from(first),
            drawn,
            depths: &arena.get(&DEPTHS),
            colors: &arena.get(&COLORS),
            states: &arena.get(&STATES),
            next: &arena.get(&NEXT),
            picture: &arena.get(&PICTURE),
            cuts: &cuts,
            sample_cuts: &sample_cuts,
            pending: &arena.get(&PENDING),
        };
        self.over.launch(device, gathers == RayOutput::Depths, &arguments)
    }

    /// What the last composition has left. Reads it back.
    pub fn pending(scene: &Scene, target: &Target) -> Result<Pending, Error> {
        let mut rows = vec![Float4([0.0; 4]); scene.viewport.height as usize];
        target.arena.get(&PENDING).read(scene.device, &mut rows)?;
        let none = [f32::INFINITY, f32::NEG_INFINITY];
        let layers = rows.iter().fold(none, |[from, to], row| [from.min(row.0[1]), to.max(row.0[2])]);
        Ok(Pending { draw: Some(layers).filter(|layers| *layers != none), find: rows.iter().any(|row| row.0[0] != 0.0) })
    }

    /// The parts of rays to draw, of pixels or of the samples of a lattice.
    pub fn cuts(target: &Target, of_lattice: bool) -> Arc<Buffer<[f32; 2]>> {
        target.arena.get(if of_lattice { &SAMPLE_CUTS } else { &CUTS })
    }

    /// The picture with all surfaces.
    pub fn picture(target: &Target) -> Arc<Buffer<Float4>> {
        target.arena.get(&PICTURE)
    }
}
