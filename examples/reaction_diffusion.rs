//! A simulation on the device and a film of it: `cargo run --release --example reaction_diffusion [FOLDER]`.
//!
//! Reaction and diffusion of two substances (Gray & Scott, 1984) in three dimensions. A kernel of this program computes them in its own
//! buffer, and every few steps layersplat renders that buffer. Voxels never leave the device, and the host never waits: the whole film
//! is enqueued frame by frame, and only finished pictures are read.

use layersplat::device::DeviceMemory;
use layersplat::opencl3::command_queue::{CL_QUEUE_PROFILING_ENABLE, CommandQueue};
use layersplat::opencl3::context::Context;
use layersplat::opencl3::device::Device as ClDevice;
use layersplat::opencl3::event::Event;
use layersplat::opencl3::kernel::{ExecuteKernel, Kernel};
use layersplat::opencl3::memory::{Buffer, CL_MEM_READ_WRITE};
use layersplat::opencl3::program::Program;
use layersplat::opencl3::types::{CL_BLOCKING, CL_NON_BLOCKING};
use layersplat::renderer::{DeviceVoxels, PictureFormat, PictureMemory, UploadedVolume};
use layersplat::volume::{Description, Grid, VoxelType};
use layersplat::{Background, Camera, Device, DeviceChoice, Frame, Orbit, Renderer, Settings, TransferFunction, Viewport};
use std::error::Error;
use std::path::PathBuf;

const SIDE: usize = 96;
const FRAMES: usize = 40;
/// Even, so that the newest state is always in the same buffer.
const STEPS_PER_FRAME: usize = 32;
const BACKGROUND: Background = Background::Color([0.03, 0.04, 0.07]);

/// One explicit step of du/dt = 0.16 Δu − uv² + F (1 − u), dv/dt = 0.08 Δv + uv² − (F + k) v, with periodic boundaries. u and v have
/// separate buffers.
const STEP: &str = "
__kernel void gray_scott(__global const float *u, __global const float *v, __global float *u_next, __global float *v_next, int n) {
    const int x = get_global_id(0), y = get_global_id(1), z = get_global_id(2), id = x + n * (y + n * z);
    const int left = x > 0 ? id - 1 : id + n - 1, right = x < n - 1 ? id + 1 : id - n + 1;
    const int below = y > 0 ? id - n : id + n * (n - 1), above = y < n - 1 ? id + n : id - n * (n - 1);
    const int front = z > 0 ? id - n * n : id + n * n * (n - 1), behind = z < n - 1 ? id + n * n : id - n * n * (n - 1);
    const float a = u[id], b = v[id], reaction = a * b * b;
    const float of_u = u[left] + u[right] + u[below] + u[above] + u[front] + u[behind] - 6.0f * a;
    const float of_v = v[left] + v[right] + v[below] + v[above] + v[front] + v[behind] - 6.0f * b;
    u_next[id] = a + 0.16f * of_u - reaction + 0.030f * (1.0f - a);
    v_next[id] = b + 0.08f * of_v + reaction - (0.030f + 0.060f) * b;
}";

/// u everywhere, and a few grains of v near the centre.
fn seeds() -> (Vec<f32>, Vec<f32>) {
    let (mut u, mut v) = (vec![1.0; SIDE.pow(3)], vec![0.0; SIDE.pow(3)]);
    let mut random = 12345u32;
    let mut next = |below: usize| {
        random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (random >> 8) as usize % below
    };
    for _ in 0..24 {
        let corner = [(); 3].map(|()| SIDE / 4 + next(SIDE / 2));
        for cell in 0..216 {
            let [x, y, z] = [cell % 6, cell / 6 % 6, cell / 36];
            let at = corner[0] + x + SIDE * (corner[1] + y + SIDE * (corner[2] + z));
            (u[at], v[at]) = (0.5, 0.25);
        }
    }
    (u, v)
}

fn transfer() -> Result<TransferFunction, layersplat::Error> {
    let colors = vec![(0.0, [0.1, 0.2, 0.6]), (0.12, [0.1, 0.5, 0.7]), (0.2, [0.95, 0.75, 0.35]), (0.4, [1.0, 0.95, 0.85])];
    TransferFunction::new("v", colors, vec![(0.0, 0.0), (0.08, 0.0), (0.13, 0.25), (0.22, 0.7), (0.4, 0.9)])
}

fn main() -> Result<(), Box<dyn Error>> {
    let folder = PathBuf::from(std::env::args().nth(1).unwrap_or_else(|| "reaction_diffusion".into()));
    std::fs::create_dir_all(&folder)?;
    // This program's own OpenCL context, on the device that layersplat would choose.
    let context = Context::from_device(&ClDevice::new(Device::open(&DeviceChoice::Default)?.id()))?;
    #[allow(deprecated)] // The replacement requires OpenCL 2.0.
    let queue = CommandQueue::create_default(&context, CL_QUEUE_PROFILING_ENABLE)?;
    let program = Program::create_and_build_from_source(&context, STEP, "")?;
    let kernel = Kernel::create(&program, "gray_scott")?;
    let room = || {
        // SAFETY: no host pointer is passed.
        unsafe { Buffer::<f32>::create(&context, CL_MEM_READ_WRITE, SIDE.pow(3), std::ptr::null_mut()) }
    };
    let (mut u, mut v, u_next, v_next) = (room()?, room()?, room()?, room()?);
    let (at_first_u, at_first_v) = seeds();
    // SAFETY: the writes block, and the values fit.
    unsafe {
        queue.enqueue_write_buffer(&mut u, CL_BLOCKING, 0, &at_first_u, &[])?;
        queue.enqueue_write_buffer(&mut v, CL_BLOCKING, 0, &at_first_v, &[])?;
    }

    // layersplat uses this queue, and the buffer in place.
    let device = Device::from_queue(&queue)?;
    let grid = Grid::new([SIDE; 3], layersplat::glam::DVec3::ONE)?;
    let description = Description::new("v", grid.clone(), VoxelType::Float32, (0.0, 0.45))?;
    let voxels = DeviceVoxels::new(&DeviceMemory::from_buffer(&v)?, VoxelType::Float32);
    let mut renderer = Renderer::from_uploaded(&UploadedVolume::in_place(&device, &description, &voxels)?, &transfer()?)?;
    let viewport = Viewport::new(512, 512)?;
    let settings = Settings::default();
    let camera = |frame: usize| {
        let orbit = Orbit { azimuth: 20.0 + 2.5 * frame as f64, elevation: 22.0, roll: 0.0 };
        Camera::fit_parallel(grid.centre(), 0.85 * grid.diagonal(), viewport, orbit)
    };
    renderer.prepare(&camera(0), viewport, &settings)?;

    // SAFETY: no host pointer is passed.
    let film =
        unsafe { Buffer::<u8>::create(&context, CL_MEM_READ_WRITE, FRAMES * 4 * viewport.pixels(), std::ptr::null_mut()) }?;
    let onto = PictureMemory::new(&DeviceMemory::from_buffer(&film)?, PictureFormat::Rgba8(BACKGROUND));
    let mut events: Vec<[Event; 3]> = Vec::new();
    let started = std::time::Instant::now();
    for frame in 0..FRAMES {
        let step = |first: [&Buffer<f32>; 2], second: [&Buffer<f32>; 2]| {
            let mut step = ExecuteKernel::new(&kernel);
            // SAFETY: number and types of the arguments match the kernel.
            unsafe {
                step.set_arg(first[0]).set_arg(first[1]).set_arg(second[0]).set_arg(second[1]).set_arg(&(SIDE as i32));
                step.set_global_work_sizes(&[SIDE; 3]).set_local_work_sizes(&[SIDE, 1, 1]).enqueue_nd_range(&queue)
            }
        };
        let first = step([&u, &v], [&u_next, &v_next])?;
        for n in 1..STEPS_PER_FRAME - 1 {
            if n % 2 == 0 {
                step([&u, &v], [&u_next, &v_next])?
            } else {
                step([&u_next, &v_next], [&u, &v])?
            };
        }
        let simulated = step([&u_next, &v_next], [&u, &v])?;
        let changed = renderer.volume_changed(&[&simulated])?;
        let onto = onto.clone().with_first(frame * 4 * viewport.pixels());
        let drawn = renderer.enqueue(&camera(frame), viewport, &settings, &onto, &[&changed])?;
        events.push([first, simulated, drawn]);
    }
    let enqueued = started.elapsed();

    let mut picture = vec![0u8; 4 * viewport.pixels()];
    for (frame, [_, _, drawn]) in events.iter().enumerate() {
        // SAFETY: the program waits for the read, and the buffer has as many bytes.
        unsafe { queue.enqueue_read_buffer(&film, CL_NON_BLOCKING, frame * picture.len(), &mut picture, &[drawn.get()]) }?
            .wait()?;
        let pixels = picture.as_chunks::<4>().0.iter().map(|p| p.map(|c| f32::from(c) / 255.0)).collect();
        Frame::new(viewport, pixels).save(folder.join(format!("{frame:03}.png")), None)?;
    }
    let all = started.elapsed();
    let milliseconds = |from: u64, to: u64| (to - from) as f64 * 1e-6;
    let [mut simulating, mut rendering] = [0.0; 2];
    for [first, simulated, drawn] in &events {
        simulating += milliseconds(first.profiling_command_start()?, simulated.profiling_command_end()?);
        rendering += milliseconds(simulated.profiling_command_end()?, drawn.profiling_command_end()?);
    }
    println!("{FRAMES} frames of {}x{} in {}", viewport.width, viewport.height, folder.display());
    println!("enqueued in {:.2} s, all read and written after {:.2} s", enqueued.as_secs_f64(), all.as_secs_f64());
    println!(
        "{:.1} ms a frame for {STEPS_PER_FRAME} steps of {SIDE}^3 cells, {:.1} ms for its picture: rendering takes {:.0} %",
        simulating / FRAMES as f64,
        rendering / FRAMES as f64,
        100.0 * rendering / (simulating + rendering)
    );
    Ok(())
}
