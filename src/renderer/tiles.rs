//! Tiles of lattices and screens, and their sample counts.

use super::frame::{Arena, Resources, Slot};
use super::picture::FRAME;
use crate::device::launch::structs::Float4;
use crate::device::launch::{Cuts, Output};
use crate::device::{Buffer, Device, LatticeSchedule, Tuning};
use crate::error::Error;
use crate::layers::Lattice;
use crate::memory;
use crate::viewport::Viewport;
use std::sync::Arc;

/// Division of samples into tiles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Tiles {
    /// Samples per tile along both axes.
    pub size: [u32; 2],
    /// Number of tiles along both axes.
    pub numbers: [u32; 2],
    /// Number of tiles that are rendered one after another where they are in one row.
    run: u32,
    /// Rows from where the first tiles begin to the first of the lattice. Where columns of pixels lean, those of a tile begin at different
    /// rows, so that some tiles are partly outside the lattice.
    pub lead: u32,
}

impl Tiles {
    fn new(samples: [u32; 2], size: [u32; 2]) -> Self {
        Self { size, numbers: [0, 1].map(|i| samples[i].div_ceil(size[i])), run: 1, lead: 0 }
    }

    /// Tiles of a lattice with point-sampled layers.
    pub fn for_points(lattice: &Lattice, tuning: &Tuning) -> Self {
        match tuning.lattice_schedule {
            LatticeSchedule::Tiles => Self::for_tiled_points(lattice, tuning),
            LatticeSchedule::Samples => Self::for_rays(lattice, tuning.point_tile_rows, tuning),
        }
    }

    /// Tiles of a lattice with point-sampled layers whose kernels have a work-item per tile on every device.
    pub fn for_tiled_points(lattice: &Lattice, tuning: &Tuning) -> Self {
        let rows = tuning.point_tile_rows;
        let Some(pixel_rays) = &lattice.pixel_rays else {
            return Self { run: tuning.tile_run, ..Self::new(lattice.size, [tuning.vector_width, rows]) };
        };
        let lead = pixel_rays.lead(lattice.size, tuning.vector_width);
        let samples = [lattice.size[0], lattice.size[1] + 2 * lead];
        Self { run: tuning.tile_run, lead, ..Self::new(samples, [tuning.vector_width, Tuning::pixel_tile_rows(rows)]) }
    }

    /// Tiles of a lattice with splatted layers.
    pub fn for_splats(lattice: &Lattice, tuning: &Tuning) -> Self {
        Self::for_rays(lattice, tuning.tile_rows, tuning)
    }

    /// The same for kernels that have a work-item per tile on every device.
    pub fn for_tiled_splats(lattice: &Lattice, tuning: &Tuning) -> Self {
        Self::new(lattice.size, [tuning.vector_width, tuning.tile_rows])
    }

    fn for_rays(lattice: &Lattice, rows: u32, tuning: &Tuning) -> Self {
        let size = match tuning.lattice_schedule {
            LatticeSchedule::Tiles => [tuning.vector_width, rows],
            LatticeSchedule::Samples => tuning.sample_tile,
        };
        Self { run: tuning.tile_run, ..Self::new(lattice.size, size) }
    }

    /// Tiles of the screen.
    pub fn for_screen(viewport: Viewport, tuning: &Tuning) -> Self {
        Self::new([viewport.width, viewport.height], [tuning.vector_width, tuning.screen_tile_rows])
    }

    /// Screen tiles with one list of splats each.
    #[cfg(feature = "paper")]
    pub fn for_lists(viewport: Viewport, tuning: &Tuning) -> Self {
        Self::new([viewport.width, viewport.height], tuning.list_tile())
    }

    /// One tile per pixel of the screen.
    pub fn for_pixels(viewport: Viewport) -> Self {
        Self::new([viewport.width, viewport.height], [1; 2])
    }

    /// Total number of tiles.
    pub fn count(self) -> usize {
        self.numbers[0] as usize * self.numbers[1] as usize
    }

    /// Tiles of a run, and how many runs farther the next one lies in the picture. Steps of about a golden section of all runs spread any
    /// number of consecutive ones evenly; they have no factor in common with the number of runs, so that each is reached once.
    pub fn runs(self) -> [i32; 2] {
        let runs = (u64::from(self.numbers[0]) * u64::from(self.numbers[1]) / u64::from(self.run)).max(1);
        let golden = (runs as f64 * GOLDEN_SECTION).ceil() as u64;
        let next = (golden..).find(|&step| greatest_common_divisor(step, runs) == 1).expect("runs + 1, at the latest");
        [self.run as i32, next as i32]
    }

    /// Rows, at most, by which columns of tiles begin before those of tiles without a lead.
    pub fn most_lead(self) -> u32 {
        2 * self.lead
    }

    /// Kernel argument.
    pub fn for_kernels(self) -> [i32; 2] {
        self.numbers.map(|n| n as i32)
    }
}

/// (√5 - 1) / 2.
const GOLDEN_SECTION: f64 = 0.618_033_988_749_895;

fn greatest_common_divisor(a: u64, b: u64) -> u64 {
    if b == 0 { a } else { greatest_common_divisor(b, a % b) }
}

/// RGBA of lattice samples or screen pixels.
const SAMPLES: Slot<Float4> = Slot::new("the samples of the picture");
/// Number of samples with opacity per tile.
const SAMPLE_COUNTS: Slot<u32> = Slot::new("the sample counts");

/// Declares a render target with this number of samples.
pub(super) fn declare_target(samples: usize, tiles: Tiles, resources: &mut Resources) {
    resources.frame(&SAMPLES, samples);
    resources.frame(&SAMPLE_COUNTS, tiles.count());
}

/// Render target: RGBA samples, the counts of those with opacity, and the other buffers that frames write.
#[derive(Default)]
pub(super) struct Target {
    pub arena: Arena,
    tiles: Tiles,
    /// Parts of rays to draw, if not all.
    pub cuts: Option<Arc<Buffer<[f32; 2]>>>,
}

/// Buffers of the render target.
pub(super) struct Drawn {
    pub samples: Arc<Buffer<Float4>>,
    pub active_samples: Arc<Buffer<u32>>,
    pub tiles: Tiles,
    cuts: Option<Arc<Buffer<[f32; 2]>>>,
}

impl Drawn {
    /// Kernel arguments.
    pub fn output(&self) -> Output<'_> {
        let cuts = self.cuts.as_deref().map(|cuts| Cuts { cuts });
        Output { target: &self.samples, active_samples: &self.active_samples, cuts }
    }
}

impl Target {
    /// Sets the tiles for the next pass.
    pub fn prepare(&mut self, tiles: Tiles) -> Drawn {
        self.tiles = tiles;
        self.drawn()
    }

    /// Uploads samples from which a kernel continues compositing.
    pub fn fill(&mut self, device: &Device, samples: &[[f32; 4]]) -> Result<(), Error> {
        let samples: Vec<Float4> = samples.iter().copied().map(Float4).collect();
        self.arena.fill(device, &SAMPLES, &samples)?;
        Ok(())
    }

    /// A target with these samples, all counted.
    #[cfg(test)]
    pub fn with_samples(device: &Device, samples: &[[f32; 4]], tiles: Tiles) -> Result<Self, Error> {
        let mut target = Self { tiles, ..Self::default() };
        target.fill(device, samples)?;
        target.arena.fill(device, &SAMPLE_COUNTS, &vec![1; tiles.count()])?;
        Ok(target)
    }

    /// The output of the last pass.
    pub fn drawn(&self) -> Drawn {
        Drawn {
            samples: self.arena.get(&SAMPLES),
            active_samples: self.arena.get(&SAMPLE_COUNTS),
            tiles: self.tiles,
            cuts: self.cuts.clone(),
        }
    }

    /// Drops all buffers except the float picture that several lattices are warped into.
    pub fn keep_picture(&mut self) {
        self.arena.keep_only(&FRAME);
    }

    /// Number of samples with opacity in the output of the last pass.
    pub fn count_active(&self, device: &Device) -> Result<u64, Error> {
        let mut counts = vec![0; self.tiles.count()];
        self.arena.get(&SAMPLE_COUNTS).read(device, &mut counts)?;
        Ok(counts.iter().map(|&c| u64::from(c)).sum())
    }
}

/// Samples per read. Reads go through a staging buffer because host floats lack the alignment of device vectors.
const PIECE: usize = 1 << 18;

/// Reads the first `count` samples of a buffer to the host.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_run_is_reached_once() {
        for numbers in [[1, 1], [2, 1], [3, 2], [19, 26], [32, 32], [31, 7], [4096, 4096]] {
            for run in [1, 3, 8, 4096] {
                let tiles = Tiles { run, ..Tiles::new(numbers, [1, 1]) };
                let [length, next] = tiles.runs().map(|n| n as usize);
                let runs = (numbers[0] * numbers[1]) as usize / length;
                let mut reached = vec![0; runs];
                (0..runs).for_each(|n| reached[n * next % runs] += 1);
                assert!(reached.iter().all(|&times| times == 1), "{numbers:?} tiles in runs of {run}");
            }
        }
    }
}
