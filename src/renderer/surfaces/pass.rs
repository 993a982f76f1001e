//! The pass of surfaces.
//!
//! The fragments of a ray cut the volume: it is drawn interval by interval, each as a picture of its own, and composited with the fragments. So
//! every method that clips rays draws volumes around surfaces. Most frames have few intervals: opaque fragments end rays, and where there is no
//! volume between two fragments, nothing is drawn.

use super::super::frame::{Arena, Resources, Slot};
use super::super::picture::{Share, WarpInputs};
use super::super::rays::{AXIS, RayOutput};
use super::super::region::Region;
use super::super::scene::Scene;
use super::super::tiles::Target;
use super::uploaded::{SurfaceSizes, UploadedSurfaces};
use super::view::{ray_ends, surface_view};
use crate::device::launch::structs::{Float4, SurfaceSet, SurfaceView, WarpParams};
use crate::device::launch::surfaces::{
    Bins, BinsArguments, FRAGMENTS, Fragments, FragmentsArguments, OverFragments, OverFragmentsArguments, Pass, PlacePoints,
    PlacePointsArguments, SURFACE_TILE, Scan, ScanArguments,
};
use crate::device::launch::{Launcher, Rendering};
use crate::device::{Buffer, Device, Tuning};
use crate::error::Error;
use crate::layers::{Kernel, Lattice};
use crate::settings::Settings;
use crate::viewport::Viewport;
use std::sync::{Arc, Weak};

const POINTS: Slot<Float4> = Slot::new("the placed points of surfaces");
const ROUNDED: Slot<[i32; 2]> = Slot::new("the points of surfaces on the screen");
const BOUNDS: Slot<[u16; 4]> = Slot::new("the pixels of cells");
const COUNTS: Slot<u32> = Slot::new("the cells per tile");
const TOTAL: Slot<u64> = Slot::new("the number of cells in tiles");
/// Its size is known after the device has counted.
const LISTS: Slot<u32> = Slot::new("the cells of tiles");
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

/// Draws surfaces.
#[derive(Default)]
pub(in crate::renderer) struct SurfacePass {
    place: Launcher<PlacePoints>,
    bins: Launcher<Bins>,
    scan: Launcher<Scan>,
    fragments: Launcher<Fragments>,
    over: Launcher<OverFragments>,
    found: Option<FoundCells>,
}

/// The cells of tiles. Frames of the same view share them.
struct FoundCells {
    surfaces: Weak<UploadedSurfaces>,
    view: SurfaceView,
    placed: Vec<SurfaceSet>,
    sets: Buffer<SurfaceSet>,
    /// The buffers of the arena that hold them.
    points: Weak<Buffer<Float4>>,
    rounded: Weak<Buffer<[i32; 2]>>,
    bounds: Weak<Buffer<[u16; 4]>>,
    counts: Weak<Buffer<u32>>,
    lists: Weak<Buffer<u32>>,
}

impl FoundCells {
    /// Whether they are those of surfaces in a view, and still on the device.
    fn serve(&self, surfaces: &Arc<UploadedSurfaces>, view: &SurfaceView, placed: &[SurfaceSet], arena: &Arena) -> bool {
        is_same(&self.surfaces, surfaces)
            && self.view == *view
            && self.placed == placed
            && is_same(&self.points, &arena.get(&POINTS))
            && is_same(&self.rounded, &arena.get(&ROUNDED))
            && is_same(&self.bounds, &arena.get(&BOUNDS))
            && is_same(&self.counts, &arena.get(&COUNTS))
            && self.lists.strong_count() > 0
    }
}

fn is_same<T>(one: &Weak<T>, other: &Arc<T>) -> bool {
    std::ptr::eq(one.as_ptr(), Arc::as_ptr(other))
}

/// What a frame still needs.
#[derive(Clone, Copy, Default)]
pub(in crate::renderer) struct Pending {
    /// Parts of rays, all between these positions in the layers of a lattice, from that of the centre along rays.
    pub draw: Option<[f32; 2]>,
    /// Further fragments.
    pub find: bool,
}

/// Entries of lists that are declared, for each cell and for each tile. Cells are in as many tiles as they cover: usually one or two.
const ENTRIES_PER_CELL: usize = 3;
const ENTRIES_PER_TILE: usize = 16;

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
    let pixels = viewport.pixels();
    let tiles: usize = [viewport.width, viewport.height].map(|n| n.div_ceil(SURFACE_TILE) as usize).iter().product();
    resources.host(&LISTS, (sizes.cells * tiles).min(ENTRIES_PER_CELL * sizes.cells + ENTRIES_PER_TILE * tiles));
    resources.frame(&POINTS, sizes.points);
    resources.frame(&ROUNDED, sizes.points);
    resources.frame(&BOUNDS, sizes.cells);
    resources.frame(&COUNTS, tuning.splat_chunks * tiles);
    resources.frame(&TOTAL, 1);
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
    /// Begins a frame: lists the cells of each tile.
    ///
    /// `lattice`: its samples are the pixels.
    pub fn begin(
        &mut self,
        scene: &Scene,
        surfaces: &Arc<UploadedSurfaces>,
        lattice: Option<&Lattice>,
        target: &mut Target,
    ) -> Result<(), Error> {
        let Scene { device, field, rays, viewport, .. } = *scene;
        if let Some(lattice) = lattice {
            // Samples beside the screen are not drawn.
            target.arena.get(&SAMPLE_CUTS).fill(device, [0.0; 2], lattice.samples())?;
        }
        let view = surface_view(field.grid(), rays, viewport, lattice);
        let placed = surfaces.placed(field.grid(), field.world().unit());
        if !self.found.as_ref().is_some_and(|found| found.serve(surfaces, &view, &placed, &target.arena)) {
            self.found = None;
            self.found = Some(self.find_cells(device, surfaces, (view, placed), &mut target.arena)?);
        }
        Ok(())
    }

    /// Lists the cells of each tile. Reads their number back, to allocate the lists.
    fn find_cells(
        &mut self,
        device: &Device,
        surfaces: &Arc<UploadedSurfaces>,
        (view, placed): (SurfaceView, Vec<SurfaceSet>),
        arena: &mut Arena,
    ) -> Result<FoundCells, Error> {
        let sets = Buffer::from_slice(device, &placed, "the sets of surfaces")?;
        let (points, rounded) = (arena.get(&POINTS), arena.get(&ROUNDED));
        let (bounds, counts, total) = (arena.get(&BOUNDS), arena.get(&COUNTS), arena.get(&TOTAL));
        for (n, range) in surfaces.ranges().enumerate() {
            let arguments = PlacePointsArguments {
                own: &surfaces.own,
                sets: &sets,
                set: n as i32,
                first: range.start as i32,
                count: range.len() as i32,
                view,
                points: &points,
                rounded: &rounded,
            };
            self.place.launch(device, (), &arguments)?;
        }
        let chunks = device.tuning().splat_chunks as i32;
        let mut entries = 1;
        for pass in [Pass::Count, Pass::Fill] {
            let arguments = BinsArguments {
                points: &points,
                rounded: &rounded,
                cells: &surfaces.cells,
                count: surfaces.cell_count as i32,
                view,
                chunks,
                fill: pass.fill(),
                bounds: &bounds,
                counts: &counts,
                lists: &*arena.counted(device, &LISTS, entries)?,
            };
            self.bins.launch(device, (), &arguments)?;
            if pass == Pass::Count {
                let scan = ScanArguments { counts: &counts, chunks, buckets: view.tiles[0] * view.tiles[1], total: &total };
                self.scan.launch(device, (), &scan)?;
                entries = total.read_count(device, "the cells of tiles")?;
            }
        }
        let lists = arena.counted(device, &LISTS, entries)?;
        Ok(FoundCells {
            surfaces: Arc::downgrade(surfaces),
            view,
            placed,
            sets,
            points: Arc::downgrade(&points),
            rounded: Arc::downgrade(&rounded),
            bounds: Arc::downgrade(&bounds),
            counts: Arc::downgrade(&counts),
            lists: Arc::downgrade(&lists),
        })
    }

    /// Finds the first fragments of all rays, or the next ones of those that wait for them.
    pub fn find(&mut self, scene: &mut Scene, surfaces: &UploadedSurfaces, target: &Target, first: bool) -> Result<(), Error> {
        let (device, arena) = (scene.device, &target.arena);
        let found = self.found.as_ref().expect("a frame begins");
        let illumination = scene.illumination()?;
        let table = scene.table(Kernel::Cubic)?;
        let sample = scene.surface_samples(&table, AXIS.frame());
        let region = Region::of_clipping(scene);
        let unused = Buffer::<u8>::new(device, 1, "no light")?;
        let arguments = FragmentsArguments {
            points: &arena.get(&POINTS),
            cells: &surfaces.cells,
            sets: &found.sets,
            attributes: &surfaces.attributes,
            normals: &surfaces.normals,
            tables: &surfaces.tables,
            rounded: &arena.get(&ROUNDED),
            bounds: &arena.get(&BOUNDS),
            ends: &arena.get(&COUNTS),
            lists: &arena.get(&LISTS),
            chunks: device.tuning().splat_chunks as i32,
            first: i32::from(first),
            view: found.view,
            sample,
            ray_ends: ray_ends(&region, scene),
            light: illumination.arguments(&unused),
            depths: &arena.get(&DEPTHS),
            colors: &arena.get(&COLORS),
            crossings: &arena.get(&CROSSINGS),
            states: &arena.get(&STATES),
        };
        self.fragments.launch(device, Rendering { gradient_opacity: false, ..region.rendering }, &arguments)
    }

    /// Composites what was drawn, and the fragments behind it, and cuts rays at the next ones.
    pub fn composite(
        &mut self,
        scene: &Scene,
        (drawn, lattice): (&Buffer<Float4>, Option<&Lattice>),
        target: &Target,
        gathers: RayOutput,
        first: bool,
    ) -> Result<Pending, Error> {
        let (device, arena) = (scene.device, &target.arena);
        let found = self.found.as_ref().expect("a frame begins");
        let pending = arena.get(&PENDING);
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
            pending: &pending,
        };
        self.over.launch(device, gathers == RayOutput::Depths, &arguments)?;
        let mut rows = vec![Float4([0.0; 4]); scene.viewport.height as usize];
        pending.read(device, &mut rows)?;
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
