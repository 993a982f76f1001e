//! A sample of all steps as one volume, for ranges and transfer functions.

use super::{Grid, Sequence};
use crate::error::Error;
use crate::volume::{Rescale, Volume, VoxelType, Voxels};

/// Largest number of steps that are read.
const STEPS: usize = 16;
/// Largest number of voxels of the sample.
const VOXELS: usize = 1 << 24;

impl Sequence {
    /// The steps that stand for the whole sequence: all of up to 16, else 16 from the first to the last, evenly spaced.
    pub fn sampled_steps(&self) -> Vec<usize> {
        let (last, count) = (self.len() - 1, self.len().min(STEPS));
        (0..count).map(|n| (2 * n * last + count.max(2) - 1) / (2 * (count.max(2) - 1))).collect()
    }

    /// A volume with the values of the whole sequence, from which statistics and transfer functions can be derived. Its voxels are those of the
    /// [sampled steps](Self::sampled_steps), one step after the other along z, every second, third … along each axis if they are more than
    /// 2^24. Its range is the exact one of these steps.
    ///
    /// # Errors
    /// Those of [`step`](Self::step).
    pub fn overview(&self) -> Result<Volume<'static>, Error> {
        let steps = self.sampled_steps();
        let mut sample: Option<Sample> = None;
        for step in self.play(steps.clone()) {
            let step = step?;
            let step = step.overview();
            sample.get_or_insert_with(|| Sample::new(step.grid(), steps.len())).add(step);
        }
        let volume = sample.expect("a sequence has a step").volume(self.steps[0].path.display().to_string())?;
        match self.background {
            Some(value) => volume.with_background(value),
            None => Ok(volume),
        }
    }
}

/// Voxels of the steps so far.
struct Sample {
    grid: Grid,
    every: usize,
    /// Type and rescale of the first step.
    kind: Option<(VoxelType, Rescale)>,
    /// Stored numbers while all steps have one type and rescale, and values.
    stored: Option<Vec<f32>>,
    values: Vec<f32>,
    stored_range: (f64, f64),
    range: (f64, f64),
}

const NO_RANGE: (f64, f64) = (f64::INFINITY, f64::NEG_INFINITY);

fn joined(a: (f64, f64), b: (f64, f64)) -> (f64, f64) {
    (a.0.min(b.0), a.1.max(b.1))
}

impl Sample {
    fn new(grid: &Grid, steps: usize) -> Self {
        let count = |every: usize| grid.dims().iter().map(|n| n.div_ceil(every)).product::<usize>() * steps;
        let every = (1..).find(|&every| count(every) <= VOXELS.max(steps)).expect("one voxel per step is few enough");
        Self {
            grid: grid.clone(),
            every,
            kind: None,
            stored: Some(Vec::new()),
            values: Vec::new(),
            stored_range: NO_RANGE,
            range: NO_RANGE,
        }
    }

    fn add(&mut self, step: &Volume) {
        let kind = (step.voxel_type(), step.description().rescale());
        if *self.kind.get_or_insert(kind) != kind {
            self.stored = None;
        }
        let ([x, y, z], every) = (self.grid.dims(), self.every);
        for k in (0..z).step_by(every) {
            for j in (0..y).step_by(every) {
                let indices = (0..x).step_by(every).map(|i| i + x * (j + y * k));
                if let Some(stored) = &mut self.stored {
                    stored.extend(indices.clone().map(|index| step.voxels.number(index) as f32));
                }
                self.values.extend(indices.map(|index| step.value(index) as f32));
            }
        }
        self.stored_range = joined(self.stored_range, step.description().stored_range);
        self.range = joined(self.range, step.range());
    }

    fn volume(self, name: String) -> Result<Volume<'static>, Error> {
        let along = self.grid.dims().map(|n| n.div_ceil(self.every));
        let steps = self.values.len() / along.iter().product::<usize>();
        let grid = Grid::new([along[0], along[1], along[2] * steps], self.grid.spacing() * self.every as f64)?;
        let grid = grid.with_unit(self.grid.unit());
        match (self.stored, self.kind) {
            (Some(stored), Some((voxel_type, rescale))) => {
                let mut volume = Volume::new(name, grid, of_type(voxel_type, stored))?;
                volume.description.stored_range = self.stored_range;
                Ok(volume.with_rescale(rescale))
            }
            _ => {
                let mut volume = Volume::new(name, grid, Voxels::Float32(self.values))?;
                volume.description.stored_range = self.range;
                Ok(volume)
            }
        }
    }
}

/// Stored numbers as voxels of the type that they came from.
fn of_type(voxel_type: VoxelType, stored: Vec<f32>) -> Voxels {
    match voxel_type {
        VoxelType::Uint8 => Voxels::Uint8(stored.into_iter().map(|n| n as u8).collect()),
        VoxelType::Int8 => Voxels::Int8(stored.into_iter().map(|n| n as i8).collect()),
        VoxelType::Uint16 => Voxels::Uint16(stored.into_iter().map(|n| n as u16).collect()),
        VoxelType::Int16 => Voxels::Int16(stored.into_iter().map(|n| n as i16).collect()),
        VoxelType::Float32 => Voxels::Float32(stored),
    }
}
