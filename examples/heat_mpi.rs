//! A distributed simulation that renders itself: `mpirun -n 4 cargo run --release --features mpi --example heat_mpi [FOLDER]`, or the
//! built program under mpirun.
//!
//! Heat spreads from a few hot rods through a block with cold faces (dT/dt = 0.1 ΔT, explicit steps). Every rank has a slab of the block
//! along z with two ghost layers on either side: one for the simulation, both for kernels and gradients, so that rendering sends no
//! voxels. Every few steps all ranks render their slabs in place, and rank 0 adds the picture to a film.

use layersplat::distributed::mpi::topology::SimpleCommunicator;
use layersplat::distributed::mpi::traits::*;
use layersplat::distributed::mpi::{self, Threading};
use layersplat::distributed::{Brick, Group, Renderer};
use layersplat::glam::DVec3;
use layersplat::image::{Animation, Background};
use layersplat::volume::{Grid, VoxelBox};
use layersplat::{Camera, Device, DeviceChoice, Orbit, Settings, TransferFunction, Viewport, Volume};
use std::error::Error;
use std::path::PathBuf;
use std::time::{Duration, Instant};

const SIDE: usize = 96;
const LAYER: usize = SIDE * SIDE;
const FRAMES: u32 = 40;
const STEPS_PER_FRAME: usize = 4;
/// Ghost layers on either side.
const GHOSTS: usize = 2;
const BACKGROUND: Background = Background::Color([0.03, 0.04, 0.07]);

/// A rank's layers, and ghost layers of its neighbours.
struct Slab {
    brick: Brick,
    heat: Vec<f32>,
}

impl Slab {
    fn new(rank: usize, ranks: usize) -> Self {
        let (first, end) = (rank * SIDE / ranks, (rank + 1) * SIDE / ranks);
        let (from, to) = (first.saturating_sub(GHOSTS), (end + GHOSTS).min(SIDE));
        let layers = |first, end| VoxelBox { first: [0, 0, first], dims: [SIDE, SIDE, end - first] };
        let brick = Brick { own: layers(first, end), held: layers(from, to) };
        let mut heat = vec![0.0; LAYER * (to - from)];
        for (n, heat) in heat.iter_mut().enumerate() {
            let [x, y, z] = [n % SIDE, n / SIDE % SIDE, from + n / LAYER].map(|i| i as f64 / SIDE as f64 - 0.5);
            let rods = [(x - 0.2).hypot(y), (y + 0.22).hypot(z - 0.1), (x + 0.2).hypot(z + 0.15)];
            let inside = [x, y, z].iter().all(|i| (-0.42..0.41).contains(i));
            if inside && rods.iter().any(|distance| *distance < 0.06) {
                *heat = 1.0;
            }
        }
        Self { brick, heat }
    }

    /// One step of the rank's own layers. The faces of the block stay cold.
    fn step(&mut self) {
        let before = self.heat.clone();
        for z in self.brick.own.first[2].max(1)..self.brick.own.end(2).min(SIDE - 1) {
            for y in 1..SIDE - 1 {
                for x in 1..SIDE - 1 {
                    let at = x + SIDE * y + LAYER * (z - self.brick.held.first[2]);
                    let around = [1, SIDE, LAYER].iter().map(|d| before[at - d] + before[at + d]).sum::<f32>();
                    self.heat[at] += 0.1 * (around - 6.0 * before[at]);
                }
            }
        }
    }

    /// Updates the ghost layers from both neighbours.
    fn exchange(&mut self, world: &SimpleCommunicator) {
        let (rank, last) = (world.rank(), world.size() - 1);
        let Brick { own, held } = self.brick;
        let [below, above] = [own.first[2] - held.first[2], held.end(2) - own.end(2)].map(|layers| layers * LAYER);
        let size = self.heat.len();
        for (to, from) in [(rank - 1, rank + 1), (rank + 1, rank - 1)] {
            let upwards = to > rank;
            let sent = if upwards { size - 2 * above..size - above } else { below..2 * below };
            let sent = if (0..=last).contains(&to) { self.heat[sent].to_vec() } else { Vec::new() };
            mpi::request::scope(|scope| {
                let send = (!sent.is_empty()).then(|| world.process_at_rank(to).immediate_send(scope, &sent[..]));
                if (0..=last).contains(&from) {
                    let into = if upwards { 0..below } else { size - above..size };
                    world.process_at_rank(from).receive_into(&mut self.heat[into]);
                }
                send.into_iter().for_each(|send| {
                    send.wait();
                });
            });
        }
    }

    fn volume(&self, group: &Group, grid: &Grid) -> Result<Volume<'static>, layersplat::Error> {
        group.volume("heat", grid.clone(), self.brick, self.heat.clone())
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    // SAFETY: no thread has been started yet. Each rank of a machine gets its share of the cores.
    unsafe { layersplat::device::pin_cpu_threads() };
    let folder = PathBuf::from(std::env::args().nth(1).unwrap_or_else(|| ".".into()));
    let (universe, _) = mpi::initialize_with_threading(Threading::Serialized).ok_or("MPI could not be initialised")?;
    let world = universe.world();
    let group = Group::new(&world)?;
    if group.size() > SIDE / (2 * GHOSTS) {
        return Err(format!("{} ranks are too many for {SIDE} layers", group.size()).into());
    }
    let grid = Grid::new([SIDE; 3], DVec3::ONE)?;
    let transfer = TransferFunction::new(
        "heat",
        vec![(0.0, [0.1, 0.1, 0.5]), (0.15, [0.8, 0.1, 0.2]), (0.4, [1.0, 0.6, 0.1]), (1.0, [1.0, 1.0, 0.8])],
        vec![(0.0, 0.0), (0.02, 0.0), (0.04, 0.03), (0.12, 0.03), (0.2, 0.15), (0.5, 0.6), (1.0, 0.9)],
    )?;
    let (viewport, device) = (Viewport::new(512, 512)?, Device::open(&DeviceChoice::Default)?);
    let mut slab = Slab::new(group.rank(), group.size());
    let mut renderer = Renderer::new(&group, &device, &slab.volume(&group, &grid)?, &transfer)?;
    // The ranges of the simulation are suitable for rendering, and its voxels change.
    renderer.balance(false);
    let film = || Animation::create(&folder.join("heat.gif"), viewport, FRAMES, 20, BACKGROUND);
    let mut film = if group.leads() { Some(film()?) } else { None };
    let (mut simulating, mut rendering, mut sent) = (Duration::ZERO, Duration::ZERO, 0);
    for n in 0..FRAMES {
        let started = Instant::now();
        for _ in 0..STEPS_PER_FRAME {
            slab.step();
            slab.exchange(&world);
        }
        simulating += started.elapsed();
        let started = Instant::now();
        renderer.set_volume(&slab.volume(&group, &grid)?)?;
        let orbit = Orbit { azimuth: -30.0 + f64::from(n), elevation: 25.0, roll: 0.0 };
        let camera = Camera::fit_parallel(grid.centre(), grid.diagonal() * 0.8, viewport, orbit);
        let (frame, report) = renderer.render(&camera, viewport, &Settings::default())?;
        rendering += started.elapsed();
        sent += report.ranks.iter().map(|rank| rank.exchanged.sent_bytes).sum::<u64>();
        if let (Some(film), Some(frame)) = (&mut film, frame) {
            film.add(&frame)?;
            if n + 1 == FRAMES {
                frame.save(folder.join("heat.png"), Some(BACKGROUND))?;
            }
        }
    }
    if let Some(film) = film {
        film.finish()?;
        let share = rendering.as_secs_f64() / (simulating + rendering).as_secs_f64();
        println!(
            "{FRAMES} frames by {} ranks: {:.0} % of the time for pictures, {sent} bytes of voxels sent for them",
            group.size(),
            100.0 * share
        );
    }
    Ok(())
}
