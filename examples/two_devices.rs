//! A rotation rendered by two devices: `cargo run --release --example two_devices [FRAMES]`.
//!
//! The CPU is partitioned into sub-devices of one core. First one of them renders a whole rotation; then two of them render half of it each,
//! with separate threads, contexts and queues. (PoCL's devices `pthread` and `basic` would share the same cores.)

use layersplat::opencl3::command_queue::CommandQueue;
use layersplat::opencl3::context::Context;
use layersplat::opencl3::device::{CL_DEVICE_PARTITION_EQUALLY, Device as ClDevice};
use layersplat::{
    Background, Camera, Device, DeviceChoice, OpenOptions, Orbit, Renderer, Settings, TransferFunction, Viewport, Volume,
};
use std::error::Error;
use std::ops::Range;
use std::time::{Duration, Instant};

const ROUNDS: usize = 5;

/// A renderer with a separate context and queue.
fn renderer(device: &ClDevice, volume: &Volume, transfer: &TransferFunction) -> Result<Renderer, Box<dyn Error>> {
    let context = Context::from_device(device)?;
    #[allow(deprecated)] // The replacement requires OpenCL 2.0.
    let queue = CommandQueue::create_default(&context, 0)?;
    Ok(Renderer::new(&Device::from_queue(&queue)?, volume, transfer)?)
}

/// Renders frames of the rotation, one after the other.
fn rotate(renderer: &mut Renderer, frames: Range<usize>, of: usize) -> Result<Vec<Vec<u8>>, layersplat::Error> {
    let viewport = Viewport::new(512, 512)?;
    let (centre, diagonal) = (renderer.grid().centre(), renderer.grid().diagonal());
    frames
        .map(|n| {
            let orbit = Orbit { azimuth: 360.0 * n as f64 / of as f64, elevation: 15.0, roll: 0.0 };
            let camera = Camera::fit_parallel(centre, diagonal, viewport, orbit);
            Ok(renderer.render_rgba8(&camera, viewport, &Settings::default(), Background::Transparent)?.0)
        })
        .collect()
}

fn median(mut times: Vec<Duration>) -> Duration {
    times.sort();
    times[times.len() / 2]
}

fn main() -> Result<(), Box<dyn Error>> {
    let frames = std::env::args().nth(1).map_or(Ok(36), |n| n.parse())?;
    let volume = Volume::open("builtin:hydrogen@128", &OpenOptions::default())?;
    let transfer = TransferFunction::automatic(&volume);
    let whole =
        ClDevice::new(Device::open(&DeviceChoice::Named("cpu".into())).or_else(|_| Device::open(&DeviceChoice::Default))?.id());
    // Dropping the handles releases the sub-devices.
    let cores = whole.create_sub_devices(&[CL_DEVICE_PARTITION_EQUALLY, 1, 0])?;
    let parts: Vec<ClDevice> = cores.iter().map(|core| ClDevice::new(core.id())).collect();
    let [one, other, ..] = &parts[..] else { return Err("this device has a single core: there is nothing to share".into()) };
    let [mut one, mut other] = [renderer(one, &volume, &transfer)?, renderer(other, &volume, &transfer)?];
    // Builds kernels and layouts, before timing.
    rotate(&mut one, 0..frames, frames)?;
    rotate(&mut other, 0..frames, frames)?;

    let [mut alone, mut together] = [Vec::new(), Vec::new()];
    for _ in 0..ROUNDS {
        let started = Instant::now();
        let by_one = rotate(&mut one, 0..frames, frames)?;
        alone.push(started.elapsed());
        let started = Instant::now();
        let by_both = std::thread::scope(|scope| {
            let first = scope.spawn(|| rotate(&mut one, 0..frames / 2, frames));
            let second = rotate(&mut other, frames / 2..frames, frames)?;
            let mut all = first.join().expect("rendering does not panic")?;
            all.extend(second);
            Ok::<_, layersplat::Error>(all)
        })?;
        together.push(started.elapsed());
        assert!(by_one == by_both, "both must render the same pictures");
    }
    let [alone, together] = [alone, together].map(|times| median(times).as_secs_f64());
    println!(
        "{frames} frames by one core: {alone:.2} s; by two devices of a core each: {together:.2} s, {:.2} times as fast",
        alone / together
    );
    Ok(())
}
