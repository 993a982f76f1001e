//! A million small frames, as in a program that runs for weeks: no resource may grow.
//!
//! Ignored: `cargo test --release --test rendering soak:: -- --ignored --nocapture`. LAYERSPLAT_FRAMES changes the number of frames.

use crate::common::{POINTS, Random, SPLATTED, layered, random_volume, smooth_transfer};
use glam::DVec3;
use layersplat::device::DeviceMemory;
use layersplat::layers::Kernel;
use layersplat::renderer::{PictureFormat, PictureMemory};
use layersplat::settings::{Algorithm, Blend, ClipPlane, Clipping, Evaluation};
use layersplat::{Background, Camera, Device, Frame, Orbit, Projection, Quality, Renderer, Settings, TransferFunction, Viewport};
use opencl3::command_queue::CommandQueue;
use opencl3::context::Context;
use opencl3::device::Device as ClDevice;
use opencl3::memory::{Buffer, CL_MEM_READ_WRITE};
use std::time::Instant;

/// Number of frames between changes of the transfer function.
const FRAMES_PER_TRANSFER: u64 = 25;
/// Allowed growth of the process in bytes, of about 100 MB: the allocator's own.
const SLACK: u64 = 4 << 20;
/// Allowed growth of device buffers in bytes: a later view may have the largest lattice.
const LARGER: u64 = 64 << 10;

fn ways() -> Vec<Settings> {
    let settings = Settings::default();
    let of = |classification, evaluation| Settings {
        algorithm: layersplat::settings::Layered { classification, evaluation, ..layered(settings) }.into(),
        ..settings
    };
    let plane = ClipPlane { point: DVec3::splat(4.0), normal: DVec3::new(1.0, 0.4, 0.2) };
    vec![
        settings,
        Quality::Draft.settings(),
        Settings { clipping: Clipping::default().with_planes([plane]), ..settings },
        of(SPLATTED, layered(settings).evaluation),
        of(POINTS, Evaluation::Direct),
        Settings { blend: Blend::Maximum, ..settings },
        Algorithm::Raycast { kernel: Kernel::Linear, step: 0.8 }.into(),
        Algorithm::Slicing { step: 0.8 }.into(),
        Algorithm::ViewSheets { sheet_distance: 1.0 }.into(),
    ]
}

/// Resident bytes of this process; 0 if unknown.
fn resident() -> u64 {
    let pages = std::fs::read_to_string("/proc/self/statm").ok();
    pages.and_then(|text| text.split(' ').nth(1)?.parse::<u64>().ok()).unwrap_or(0) * 4096
}

/// Resources at a checkpoint: bytes on the device, programs, and references to context and queue, which events hold.
#[derive(Debug, PartialEq)]
struct Held {
    allocated: u64,
    programs: usize,
    context: u32,
    queue: u32,
}

struct Run {
    context: Context,
    queue: CommandQueue,
    device: Device,
    renderer: Renderer,
    floats: PictureMemory,
    bytes: PictureMemory,
    transfers: [TransferFunction; 2],
    ways: Vec<Settings>,
    centre: DVec3,
    diagonal: f64,
}

impl Run {
    fn new() -> Self {
        let context = Context::from_device(&ClDevice::new(crate::common::device().id())).unwrap();
        #[allow(deprecated)] // The replacement needs OpenCL 2.0.
        let queue = CommandQueue::create_default(&context, 0).unwrap();
        let device = Device::from_queue(&queue).unwrap();
        let volume = random_volume([9, 8, 10], DVec3::new(1.0, 0.9, 1.1), 5);
        let transfer = smooth_transfer();
        let transfers = [transfer.clone(), transfer.faded(0.5).unwrap()];
        let picture = || {
            // SAFETY: no host pointer is passed.
            let room = unsafe { Buffer::<u8>::create(&context, CL_MEM_READ_WRITE, 16 * 16 * 16, std::ptr::null_mut()) };
            DeviceMemory::from_buffer(&room.unwrap()).unwrap()
        };
        let floats = PictureMemory::new(&picture(), PictureFormat::Floats);
        let bytes = PictureMemory::new(&picture(), PictureFormat::Rgba8(Background::BLACK));
        let (centre, diagonal) = (volume.grid().centre(), volume.grid().diagonal());
        let renderer = Renderer::new(&device, &volume, &transfers[0]).unwrap();
        Self { context, queue, device, renderer, floats, bytes, transfers, ways: ways(), centre, diagonal }
    }

    fn frame(&mut self, n: u64, random: &mut Random) {
        if n.is_multiple_of(FRAMES_PER_TRANSFER) {
            self.renderer.set_transfer_function(&self.transfers[(n / FRAMES_PER_TRANSFER % 2) as usize]);
        }
        let settings = self.ways[(random.next() % self.ways.len() as u64) as usize];
        let [azimuth, elevation, roll] = [(); 3].map(|()| random.unit() * 360.0);
        let projection = match random.next() % 3 {
            0 => Projection::Perspective { field_of_view: 30.0 },
            _ => Projection::Parallel { scale: self.diagonal / 2.0 },
        };
        let camera = Camera::orbit(self.centre, 2.0 * self.diagonal, Orbit { azimuth, elevation, roll }, projection);
        let size = Viewport { width: 4 + (random.next() % 12) as u32, height: 4 + (random.next() % 12) as u32 };
        let sheets = matches!(settings.algorithm, Algorithm::ViewSheets { .. });
        match random.next() % 4 {
            0 => drop(self.renderer.render(&camera, size, &settings).unwrap()),
            1 => drop(self.renderer.render_rgba8(&camera, size, &settings, Background::BLACK).unwrap()),
            _ if sheets => drop(self.renderer.render(&camera, size, &settings).unwrap()),
            2 => drop(self.renderer.enqueue(&camera, size, &settings, &self.floats, &[]).unwrap()),
            _ => self.renderer.enqueue(&camera, size, &settings, &self.bytes, &[]).unwrap().wait().unwrap(),
        }
    }

    /// Checkpoint: the same pictures each time, with every render path, and the resources held.
    fn stop(&mut self) -> (Vec<Frame>, Held) {
        self.renderer.set_transfer_function(&self.transfers[1]);
        self.renderer.set_transfer_function(&self.transfers[0]);
        let size = Viewport { width: 15, height: 15 };
        let camera = Camera::fit_parallel(self.centre, self.diagonal, size, Orbit { azimuth: 20.0, elevation: 10.0, roll: 0.0 });
        let frames = self.ways.clone().iter().map(|way| self.renderer.render(&camera, size, way).unwrap().0).collect();
        self.queue.finish().unwrap();
        // PoCL's threads release a command shortly after it completes.
        std::thread::sleep(std::time::Duration::from_millis(200));
        let held = Held {
            allocated: self.device.allocated_bytes(),
            programs: self.device.programs(),
            context: self.context.reference_count().unwrap(),
            queue: self.queue.reference_count().unwrap(),
        };
        (frames, held)
    }
}

#[test]
#[ignore = "a million frames take an hour"]
fn nothing_grows() {
    let count: u64 = std::env::var("LAYERSPLAT_FRAMES").map_or(1_000_000, |n| n.parse().unwrap());
    let mut run = Run::new();
    let mut random = Random(15);
    // By then programs are built, buffers have their largest size, and the allocator is warm.
    let warm = (count / 10).max(500);
    let began = Instant::now();
    (0..warm).for_each(|n| run.frame(n, &mut random));
    let (expected, before) = run.stop();
    let at_start = resident();
    eprintln!("after {warm} frames: {at_start} bytes resident, {before:?}, {:.0} s", began.elapsed().as_secs_f64());
    for n in warm..count.max(2 * warm) {
        run.frame(n, &mut random);
        if n.is_multiple_of(warm) {
            eprintln!("after {n} frames: {} bytes resident, {:.0} s", resident(), began.elapsed().as_secs_f64());
        }
    }
    let (frames, after) = run.stop();
    let at_end = resident();
    eprintln!("after {} frames: {at_end} bytes resident, {after:?}, {:.0} s", count.max(2 * warm), began.elapsed().as_secs_f64());
    assert!(frames == expected, "the pictures must not change");
    assert!(after.allocated <= before.allocated + LARGER, "{} bytes more on the device", after.allocated - before.allocated);
    assert_eq!(Held { allocated: before.allocated, ..after }, before);
    assert!(at_end <= at_start + SLACK, "{} bytes more", at_end - at_start);
}
