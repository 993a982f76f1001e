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
use super::uploaded::{SurfaceSizes, UploadedSurfaces};
use super::view::{ray_ends, surface_view};
use crate::device::launch::structs::{Float4, RayEnds, SurfaceSet, SurfaceView, WarpParams};
use crate::device::launch::surfaces::{
    Bins, BinsArguments, FRAGMENTS, Fragments, FragmentsArguments, OverFragments, OverFragmentsArguments, Pass, PlacePoints,
    PlacePointsArguments, SURFACE_TILE, Scan, ScanArguments,
};
use crate::device::launch::{Launcher, Rendering};
use crate::device::{Buffer, Tuning};
use crate::error::Error;
use crate::layers::{Kernel, Lattice};
use crate::settings::Settings;
use crate::viewport::Viewport;
use std::sync::Arc;

const POINTS: Slot<Float4> = Slot::new("the placed points of surfaces");
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
    frame: Option<FoundCells>,
}

/// The cells of a frame's tiles.
struct FoundCells {
    view: SurfaceView,
    sets: Buffer<SurfaceSet>,
    lists: Arc<Buffer<u32>>,
    /// What cuts surfaces, and where rays are in the volume.
    surface_ends: RayEnds,
    volume_ends: RayEnds,
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
        resources.host(&SAMPLE_CUTS, lattice.samples());
    }
    let pixels = viewport.pixels();
    let tiles: usize = [viewport.width, viewport.height].map(|n| n.div_ceil(SURFACE_TILE) as usize).iter().product();
    resources.host(&LISTS, (sizes.cells * tiles).min(ENTRIES_PER_CELL * sizes.cells + ENTRIES_PER_TILE * tiles));
    resources.frame(&POINTS, sizes.points);
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
    /// Lists the cells of each tile. Reads their number back, to allocate the lists.
    ///
    /// `lattice`: its samples are the pixels.
    pub fn begin(
        &mut self,
        scene: &Scene,
        surfaces: &UploadedSurfaces,
        lattice: Option<&Lattice>,
        target: &mut Target,
    ) -> Result<(), Error> {
        let Scene { device, field, rays, viewport, .. } = *scene;
        let view = surface_view(field.grid(), rays, viewport, lattice);
        if let Some(lattice) = lattice {
            // Samples beside the screen are not drawn.
            target.arena.fill(device, &SAMPLE_CUTS, &vec![[0.0; 2]; lattice.samples()])?;
        }
        let sets = surfaces.placed(field.grid(), field.world().unit());
        let sets = Buffer::from_slice(device, &sets, "the sets of surfaces")?;
        let arena = &mut target.arena;
        let (points, counts, total) = (arena.get(&POINTS), arena.get(&COUNTS), arena.get(&TOTAL));
        for (n, range) in surfaces.ranges().enumerate() {
            let arguments = PlacePointsArguments {
                own: &surfaces.own,
                sets: &sets,
                set: n as i32,
                first: range.start as i32,
                count: range.len() as i32,
                points: &points,
            };
            self.place.launch(device, (), &arguments)?;
        }
        let chunks = device.tuning().splat_chunks as i32;
        let mut entries = 1;
        for pass in [Pass::Count, Pass::Fill] {
            let arguments = BinsArguments {
                points: &points,
                cells: &surfaces.cells,
                count: surfaces.cell_count as i32,
                view,
                chunks,
                fill: pass.fill(),
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
        let region = Region::of_clipping(scene);
        let volume = Region::marched(scene, Kernel::Cubic, VOLUME_MARGIN);
        self.frame = Some(FoundCells {
            view,
            sets,
            lists: arena.counted(device, &LISTS, entries)?,
            surface_ends: ray_ends(&region, scene),
            volume_ends: ray_ends(&volume, scene),
        });
        Ok(())
    }

    /// Finds the first fragments of all rays, or the next ones of those that wait for them.
    pub fn find(&mut self, scene: &mut Scene, surfaces: &UploadedSurfaces, target: &Target, first: bool) -> Result<(), Error> {
        let (device, arena) = (scene.device, &target.arena);
        let found = self.frame.as_ref().expect("a frame begins");
        let illumination = scene.illumination()?;
        let table = scene.table(Kernel::Cubic)?;
        let sample = scene.surface_samples(&table, AXIS.frame());
        let rendering = Region::of_clipping(scene).rendering;
        let points = arena.get(&POINTS);
        let unused = Buffer::<u8>::new(device, 1, "no light")?;
        let arguments = FragmentsArguments {
            points: &points,
            cells: &surfaces.cells,
            sets: &found.sets,
            attributes: &surfaces.attributes,
            normals: &surfaces.normals,
            tables: &surfaces.tables,
            ends: &arena.get(&COUNTS),
            lists: &found.lists,
            chunks: device.tuning().splat_chunks as i32,
            first: i32::from(first),
            view: found.view,
            sample,
            ray_ends: found.surface_ends,
            light: illumination.arguments(&unused),
            depths: &arena.get(&DEPTHS),
            colors: &arena.get(&COLORS),
            crossings: &arena.get(&CROSSINGS),
            states: &arena.get(&STATES),
        };
        self.fragments.launch(device, Rendering { gradient_opacity: false, ..rendering }, &arguments)
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
        let found = self.frame.as_ref().expect("a frame begins");
        let pending = arena.get(&PENDING);
        let cuts = arena.get(&CUTS);
        let sample_cuts = Self::cuts(target, lattice.is_some());
        let is_linear = scene.settings.studio.is_some();
        let onto = |lattice| WarpInputs { lattice, rays: scene.rays, viewport: scene.viewport, is_linear };
        let arguments = OverFragmentsArguments {
            view: found.view,
            lattice: lattice.map_or(WarpParams::NONE, |lattice| onto(lattice).params(target.drawn().tiles, Share::WHOLE)),
            volume_ends: found.volume_ends,
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
