//! Scattered light: the radiance in cubic cells, from sweeps along ordinates that are repeated until it hardly changes.

use super::cells::{CellGrid, ScatterGrids};
use crate::device::launch::Launcher;
use crate::device::launch::scatter::{
    LAYERS, MEDIUM_PLANES, ScatterCells, ScatterCellsArguments, ScatterLayers, ScatterLayersArguments, ScatterSource,
    ScatterSourceArguments, ScatterSweep, ScatterSweepArguments,
};
use crate::device::launch::structs::{ScatterCellsParams, ScatterLayersParams, ScatterSourceParams, ScatterSweepParams};
use crate::device::{Buffer, Device, Tuning};
use crate::error::Error;
use crate::layers::OrdinatePair;
use crate::settings::LightGrid;
use glam::DVec3;
use std::ops::Range;

pub(super) const LIGHT_FIELD: &str = "the scattered light";
pub(super) const CELLS: &str = "the cells of scattered light";

/// Bytes of a cell of the light field.
const PACKED: usize = 16;
/// Planes of the radiance, and of the radiance along x and y with its flux.
const RADIANCE: usize = 3;
const WITH_FLUX: usize = 9;

/// Sweeps of the coarser grid before those of the finer one, and before the last one where that grid is alone.
const SWEEPS: usize = 8;
const FEW_SWEEPS: usize = 3;
/// Largest share of the radiance that a sweep is assumed to keep, in Chebyshev's iteration (Golub & Varga 1961). The larger it is, the slower
/// converges what keeps less.
const KEPT: f64 = 0.9;

/// Kernels of scattered light.
#[derive(Default)]
pub(super) struct ScatterKernels {
    cells: Launcher<ScatterCells>,
    source: Launcher<ScatterSource>,
    sweep: Launcher<ScatterSweep>,
    layers: Launcher<ScatterLayers>,
}

/// The light in a volume of scattering cells.
pub(super) struct Scattering<'a> {
    pub device: &'a Device,
    pub kernels: &'a mut ScatterKernels,
    pub grids: ScatterGrids,
    /// Radiances that enter along each ordinate, and along the opposite one.
    pub entering: Vec<[DVec3; 2]>,
    /// Factor of the albedo.
    pub scattering: f64,
}

/// A grid of cells with the medium in them, and what is computed of it.
struct Cells {
    grid: CellGrid,
    /// All planes, or those of the optical depth alone where cells begin with the radiance of a coarser grid.
    medium: Buffer<f32>,
    /// The light that cells scatter.
    source: Buffer<f32>,
    /// The mean radiance that the sweeps find: of all layers or, with the flux, of some.
    mean: Buffer<f32>,
    /// Rays on their way through layers.
    rays: Buffer<f32>,
}

/// The grids on which light is computed, and how often each is swept before the last sweep.
pub(super) fn levels(grids: &ScatterGrids, resolution: LightGrid) -> Vec<(CellGrid, usize)> {
    match resolution {
        LightGrid::Quarter => vec![(grids.coarse, FEW_SWEEPS)],
        LightGrid::Half | LightGrid::Full => vec![(grids.coarse, SWEEPS), (grids.fine, 0)],
    }
}

/// Bytes of the light field of a grid. Look-ups read a row and a layer beyond it.
pub(super) fn packed_bytes(grid: CellGrid) -> usize {
    let [x, y, _] = grid.dims;
    PACKED * (grid.cells() + x * y + x + 1)
}

/// Bytes of the light field of these grids, and of what it is computed from.
pub(super) fn declared(grids: &ScatterGrids, resolution: LightGrid, tuning: &Tuning) -> Vec<(&'static str, usize)> {
    let levels = levels(grids, resolution);
    let blocks = MEDIUM_PLANES * grids.blocks.iter().product::<usize>();
    let of_level = |(n, &(grid, _)): (usize, &(CellGrid, usize))| Cells::floats(grid, n == 0, tuning).iter().sum();
    let radiance = 2 * RADIANCE * grids.coarse.params().plane(tuning);
    let floats = levels.iter().enumerate().map(of_level).chain([blocks, radiance]);
    let last = levels.last().expect("there is a level").0;
    floats.map(|floats| (CELLS, size_of::<f32>() * floats)).chain([(LIGHT_FIELD, packed_bytes(last))]).collect()
}

impl Cells {
    /// Lengths of the buffers. `iterates`: the first grid.
    fn floats(grid: CellGrid, iterates: bool, tuning: &Tuning) -> [usize; 4] {
        let (params, [_, _, z]) = (grid.params(), grid.dims);
        let plane = params.plane(tuning);
        let last = WITH_FLUX * plane / z * z.min(LAYERS as usize);
        let (medium, mean) = if iterates { (MEDIUM_PLANES, (RADIANCE * plane).max(last)) } else { (1, last) };
        [medium * plane, RADIANCE * plane, mean, ScatterLayers::rays(params, tuning)]
    }
}

impl Scattering<'_> {
    /// Computes the light field of the last of these grids: the first is swept this many times, a second begins with its radiance, and the last
    /// is swept once more, which finds the flux, too. `blocks`: sums of kernels/light/scatter_medium.cl.
    pub fn solve(&mut self, blocks: &Buffer<f32>, levels: &[(CellGrid, usize)], packed: &Buffer<u8>) -> Result<(), Error> {
        let mut coarser = None;
        for &(grid, sweeps) in levels {
            let cells = self.cells(grid, blocks, coarser.as_ref())?;
            let radiance = match coarser {
                Some(coarser) => coarser,
                None => self.iterate(&cells, sweeps, packed)?,
            };
            if levels.last() == Some(&(grid, sweeps)) {
                return self.finish(&cells, packed);
            }
            coarser = Some(radiance);
        }
        Ok(())
    }

    /// Floats of a plane of cells.
    fn plane(&self, grid: CellGrid) -> usize {
        grid.params().plane(self.device.tuning())
    }

    fn radiance(&self, grid: CellGrid) -> Result<Buffer<f32>, Error> {
        Buffer::new(self.device, RADIANCE * self.plane(grid), CELLS)
    }

    /// Cells of blocks, and the light that they scatter with the radiance of a coarser grid.
    fn cells(&mut self, grid: CellGrid, blocks: &Buffer<f32>, coarser: Option<&Buffer<f32>>) -> Result<Cells, Error> {
        let lengths = Cells::floats(grid, coarser.is_none(), self.device.tuning());
        let buffer = |n: usize| Buffer::new(self.device, lengths[n], CELLS);
        let (medium, source, mean, rays) = (buffer(0)?, buffer(1)?, buffer(2)?, buffer(3)?);
        let p = ScatterCellsParams {
            grid: grid.params(),
            blocks: self.grids.blocks.map(|n| n as i32),
            per_cell: grid.per_cell.as_vec3().to_array(),
            edges: (grid.edge / self.grids.fine.edge) as f32,
            coarser: self.grids.coarse.params(),
            per_coarse: (grid.edge / self.grids.coarse.edge) as f32,
            scattering: self.scattering as f32,
            refined: i32::from(coarser.is_some()),
        };
        let radiance = coarser.unwrap_or(&source);
        let arguments = ScatterCellsArguments { blocks, medium: &medium, coarser: radiance, source: &source, p };
        self.kernels.cells.launch(self.device, (), &arguments)?;
        Ok(Cells { grid, medium, source, mean, rays })
    }

    /// The mean radiance after some sweeps from a start value on, and the light that cells scatter with it.
    fn iterate(&mut self, cells: &Cells, sweeps: usize, packed: &Buffer<u8>) -> Result<Buffer<f32>, Error> {
        let (mut radiance, mut older) = (self.radiance(cells.grid)?, self.radiance(cells.grid)?);
        self.scatter(cells, true, [&radiance, &older], (0.0, 0.0))?;
        // Of eigenvalues from 0 to KEPT.
        let (gain, spread) = (2.0 / (2.0 - KEPT), KEPT / (2.0 - KEPT));
        let mut relaxation = 1.0;
        for n in 0..sweeps {
            relaxation = match n {
                0 => 1.0,
                1 => 2.0 / (2.0 - spread * spread),
                _ => 4.0 / (4.0 - spread * spread * relaxation),
            };
            self.sweep(cells, packed)?;
            self.scatter(cells, false, [&radiance, &older], (relaxation, gain))?;
            std::mem::swap(&mut radiance, &mut older);
        }
        Ok(radiance)
    }

    /// Computes the light that cells scatter, from a start value or from the next radiance of an iteration.
    fn scatter(
        &mut self,
        cells: &Cells,
        starts: bool,
        [radiance, older]: [&Buffer<f32>; 2],
        (relaxation, gain): (f64, f64),
    ) -> Result<(), Error> {
        let sky: DVec3 =
            OrdinatePair::all().iter().zip(&self.entering).map(|(pair, both)| (both[0] + both[1]) * pair.weight).sum();
        let p = ScatterSourceParams {
            grid: cells.grid.params(),
            scattering: self.scattering as f32,
            sky: sky.as_vec3().to_array(),
            starts: i32::from(starts),
            relaxation: relaxation as f32,
            gain: gain as f32,
        };
        let Cells { medium, source, mean, .. } = cells;
        let arguments = ScatterSourceArguments { medium, radiance, older, mean, source, p };
        self.kernels.source.launch(self.device, (), &arguments)
    }

    /// The mean radiance along all ordinates.
    fn sweep(&mut self, cells: &Cells, packed: &Buffer<u8>) -> Result<(), Error> {
        self.axes(cells, 0..cells.grid.params().z, false)?;
        for z in [1, -1] {
            for launch in self.layers(cells.grid, z) {
                self.across(cells, false, launch, packed)?;
            }
        }
        Ok(())
    }

    /// The last sweep, which packs the light field with the flux.
    fn finish(&mut self, cells: &Cells, packed: &Buffer<u8>) -> Result<(), Error> {
        for launch in self.layers(cells.grid, 1) {
            self.across(cells, true, launch, packed)?;
        }
        let mut held = 0..0;
        for launch in self.layers(cells.grid, -1) {
            if launch.first % LAYERS == 0 && launch.between == 0 {
                let end = launch.grid.z - launch.first;
                held = (end - LAYERS).max(0)..end;
                self.axes(cells, held.clone(), true)?;
            }
            let launch = ScatterLayersParams { held_from: held.start, held: held.end - held.start, ..launch };
            self.across(cells, true, launch, packed)?;
        }
        Ok(())
    }

    /// The mean radiance along x and y in some layers, and its flux.
    fn axes(&mut self, cells: &Cells, held: Range<i32>, with_flux: bool) -> Result<(), Error> {
        let Cells { medium, source, mean, .. } = cells;
        let (grid, first, layers) = (cells.grid.params(), held.start, held.end - held.start);
        for (step, along_x) in [([0, 1, 0], false), ([1, 0, 0], true)] {
            let [(weight, forward), (_, backward)] = [step, step.map(|n| -n)].map(|step| self.ordinate(step));
            let items = ScatterSweep::work(grid, layers, along_x, self.device.tuning());
            let (flags, entering) = ([along_x, with_flux].map(i32::from), [forward, backward]);
            let p = ScatterSweepParams { grid, items, first, layers, weight, along_x: flags[0], flux: flags[1], entering };
            self.kernels.sweep.launch(self.device, (), &ScatterSweepArguments { medium, source, mean, p })?;
        }
        Ok(())
    }

    /// The launches of a sweep across layers, up (1) or down (-1).
    fn layers(&self, grid: CellGrid, z: i32) -> Vec<ScatterLayersParams> {
        let ordinates = [[0, 0, z], [1, 1, z], [-1, 1, z], [1, -1, z], [-1, -1, z]].map(|step| self.ordinate(step));
        let (axis, diagonal, entering) = (ordinates[0].0, ordinates[1].0, ordinates.map(|(_, radiance)| radiance));
        let launches = ScatterLayers::launches(grid.params(), self.device.tuning());
        launches.map(|launch| ScatterLayersParams { upwards: i32::from(z > 0), axis, diagonal, entering, ..launch }).collect()
    }

    fn across(&mut self, cells: &Cells, is_last: bool, p: ScatterLayersParams, packed: &Buffer<u8>) -> Result<(), Error> {
        let Cells { medium, source, mean, rays, .. } = cells;
        let p = ScatterLayersParams { is_last: i32::from(is_last), ..p };
        self.kernels.layers.launch(self.device, (), &ScatterLayersArguments { medium, source, mean, rays, packed, p })
    }

    /// The weight of the ordinate with these steps, and the radiance that enters along it.
    fn ordinate(&self, step: [i32; 3]) -> (f32, [f32; 3]) {
        let pairs = OrdinatePair::all().into_iter().zip(&self.entering);
        let both = pairs.flat_map(|(pair, entering)| {
            [(pair.step, entering[0]), (pair.step.map(|n| -n), entering[1])].map(|(step, radiance)| (step, pair.weight, radiance))
        });
        let found = both.into_iter().find(|&(other, ..)| other == step);
        let (_, weight, radiance) = found.expect("all steps to neighbours of faces and corners are ordinates");
        (weight as f32, radiance.as_vec3().to_array())
    }
}

#[cfg(test)]
mod tests;
