//! How lattices and screens are cut into tiles, and what these count.

use super::frame::{Arena, Resources, Slot};
use super::picture::FRAME;
use crate::device::launch::structs::Float4;
use crate::device::{Buffer, Device, LatticeSchedule, Tuning};
use crate::error::Error;
use crate::layers::{Lattice, Phases};
use crate::memory;
use crate::settings::Classification;
use crate::viewport::Viewport;
use std::sync::Arc;

/// Tiles of samples.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Tiles {
    /// Samples of a tile, along both axes. Of phases, which lie between each other, of the tiles of all.
    pub size: [u32; 2],
    /// Tiles along both axes.
    pub numbers: [u32; 2],
    /// Counts per tile.
    pub counts: u32,
}

impl Tiles {
    fn of(samples: [u32; 2], size: [u32; 2]) -> Self {
        Self { size, numbers: [0, 1].map(|i| samples[i].div_ceil(size[i])), counts: 1 }
    }

    /// Of a lattice of layers, however these are classified.
    pub fn of_lattice(lattice: &Lattice, classification: Classification, tuning: &Tuning) -> Self {
        match (classification, lattice.phases, tuning.lattice_schedule) {
            (Classification::Preintegrated { .. }, ..) => Self::of_points(lattice, tuning),
            (Classification::Post(_), Some(phases), LatticeSchedule::Tiles) => Self::of_phases(phases, tuning),
            (Classification::Post(_), ..) => Self::of_splats(lattice, tuning),
        }
    }

    /// Of a lattice with point-sampled layers.
    pub fn of_points(lattice: &Lattice, tuning: &Tuning) -> Self {
        Self::of_rays(lattice, tuning.point_tile_rows, tuning)
    }

    /// Of a lattice with splatted layers that is not drawn in phases.
    pub fn of_splats(lattice: &Lattice, tuning: &Tuning) -> Self {
        Self::of_rays(lattice, tuning.tile_rows, tuning)
    }

    fn of_rays(lattice: &Lattice, rows: u32, tuning: &Tuning) -> Self {
        let size = match tuning.lattice_schedule {
            LatticeSchedule::Tiles => [tuning.vector_width, rows],
            LatticeSchedule::Samples => tuning.sample_tile,
        };
        Self::of(lattice.size, size)
    }

    /// Of a lattice in phases: a tile of each phase counts for itself.
    pub fn of_phases(phases: Phases, tuning: &Tuning) -> Self {
        let [m_u, m_v] = phases.samples_per_voxel;
        let size = [tuning.tile_columns(), tuning.tile_rows];
        Self { size: [size[0] * m_u, size[1] * m_v], counts: m_u * m_v, ..Self::of(phases.columns, size) }
    }

    /// Of the screen.
    pub fn of_screen(viewport: Viewport, tuning: &Tuning) -> Self {
        Self::of([viewport.width, viewport.height], [tuning.vector_width, tuning.screen_tile_rows])
    }

    /// Of the screen, with a list of splats each.
    pub fn of_lists(viewport: Viewport, tuning: &Tuning) -> Self {
        Self::of([viewport.width, viewport.height], tuning.list_tile())
    }

    /// A tile for each pixel of the screen.
    pub fn of_pixels(viewport: Viewport) -> Self {
        Self::of([viewport.width, viewport.height], [1; 2])
    }

    /// How many numbers they count.
    pub fn all_counts(self) -> usize {
        self.numbers[0] as usize * self.numbers[1] as usize * self.counts as usize
    }

    /// As kernels take them.
    pub fn for_kernels(self) -> [i32; 2] {
        self.numbers.map(|n| n as i32)
    }
}

/// RGBA of a lattice's samples, or of the screen's pixels.
const SAMPLES: Slot<Float4> = Slot::new("the samples of the picture");
/// Samples with opacity, per tile.
const SAMPLE_COUNTS: Slot<u32> = Slot::new("the sample counts");

/// Declares a target of so many samples in tiles.
pub(super) fn declare_target(samples: usize, tiles: Tiles, resources: &mut Resources) {
    resources.frame(&SAMPLES, samples);
    resources.frame(&SAMPLE_COUNTS, tiles.all_counts());
}

/// Where kernels draw: samples of RGBA, and the counts of those that have opacity; and the other buffers that frames write.
#[derive(Default)]
pub(super) struct Target {
    pub arena: Arena,
    tiles: Tiles,
}

/// Samples that were drawn, or are to be drawn.
pub(super) struct Drawn {
    pub samples: Arc<Buffer<Float4>>,
    pub active_samples: Arc<Buffer<u32>>,
    pub tiles: Tiles,
}

impl Target {
    /// Begins to draw in tiles.
    pub fn prepare(&mut self, tiles: Tiles) -> Drawn {
        self.tiles = tiles;
        self.drawn()
    }

    /// Puts samples where a kernel goes on drawing.
    pub fn fill(&mut self, device: &Device, samples: &[[f32; 4]]) -> Result<(), Error> {
        let samples: Vec<Float4> = samples.iter().copied().map(Float4).collect();
        self.arena.fill(device, &SAMPLES, &samples)?;
        Ok(())
    }

    /// Holds these samples, all of which count.
    #[cfg(test)]
    pub fn holding(device: &Device, samples: &[[f32; 4]], tiles: Tiles) -> Result<Self, Error> {
        let mut target = Self { tiles, ..Self::default() };
        target.fill(device, samples)?;
        target.arena.fill(device, &SAMPLE_COUNTS, &vec![1; tiles.all_counts()])?;
        Ok(target)
    }

    /// What was drawn last.
    pub fn drawn(&self) -> Drawn {
        Drawn { samples: self.arena.get(&SAMPLES), active_samples: self.arena.get(&SAMPLE_COUNTS), tiles: self.tiles }
    }

    /// Drops all buffers but the picture in floats, into which several lattices are warped.
    pub fn keep_picture(&mut self) {
        self.arena.keep_only(&FRAME);
    }

    /// Number of samples with opacity in what was drawn last.
    pub fn count_active(&self, device: &Device) -> Result<u64, Error> {
        let mut counts = vec![0; self.tiles.all_counts()];
        self.arena.get(&SAMPLE_COUNTS).read(device, &mut counts)?;
        Ok(counts.iter().map(|&c| u64::from(c)).sum())
    }
}

/// Samples that are read at a time: floats on the host are not aligned as those of devices.
const PIECE: usize = 1 << 18;

/// The first `count` samples of a buffer, on the host.
pub(super) fn read_samples(buffer: &Buffer<Float4>, device: &Device, count: usize) -> Result<Vec<[f32; 4]>, Error> {
    let mut samples: Vec<[f32; 4]> = memory::zeroed("the picture", count)?;
    let mut piece = vec![Float4([0.0; 4]); count.min(PIECE)];
    for (n, samples) in samples.chunks_mut(PIECE).enumerate() {
        let piece = &mut piece[..samples.len()];
        buffer.read_at(device, n * PIECE, piece)?;
        samples.copy_from_slice(bytemuck::cast_slice(piece));
    }
    Ok(samples)
}
