//! Caller-owned contexts, queues, buffers and events through the C functions.

mod common;

use common::{FLOATS, HEIGHT, Scene, WIDTH, last_error, made, ok, refused};
use layersplat::opencl3::command_queue::{CommandQueue, enqueue_read_image};
use layersplat::opencl3::context::Context;
use layersplat::opencl3::device::Device as ClDevice;
use layersplat::opencl3::event::{CL_COMPLETE, Event, create_user_event, set_user_event_status};
use layersplat::opencl3::memory::{Buffer, CL_FLOAT, CL_MEM_OBJECT_IMAGE2D, CL_MEM_READ_WRITE, CL_RGBA, ClMem, Image};
use layersplat::opencl3::memory::{cl_image_desc, cl_image_format};
use layersplat::opencl3::types::CL_BLOCKING;
use layersplat_c::*;
use std::ptr::{null, null_mut};

/// An application with its own OpenCL context and queue.
struct Host {
    context: Context,
    queue: CommandQueue,
}

impl Host {
    fn new() -> Self {
        let device = layersplat::Device::open(&layersplat::DeviceChoice::Default).unwrap();
        let context = Context::from_device(&ClDevice::new(device.id())).unwrap();
        #[allow(deprecated)] // The replacement needs OpenCL 2.0.
        let queue = CommandQueue::create_default(&context, 0).unwrap();
        Self { context, queue }
    }

    fn device(&self) -> *mut Device {
        // SAFETY: the handles are alive.
        made(|out| unsafe {
            let (context, id) = (self.context.get().cast(), self.context.default_device().cast());
            layersplat_device_from_queue(context, id, self.queue.get().cast(), out)
        })
    }

    fn buffer<T>(&self, len: usize) -> Buffer<T> {
        // SAFETY: no host pointer is given.
        unsafe { Buffer::create(&self.context, CL_MEM_READ_WRITE, len, null_mut()) }.unwrap()
    }

    fn filled(&self, values: &[u8]) -> Buffer<u8> {
        let mut buffer = self.buffer(values.len());
        // SAFETY: the write blocks, and the values fit.
        unsafe { self.queue.enqueue_write_buffer(&mut buffer, CL_BLOCKING, 0, values, &[]) }.unwrap();
        buffer
    }

    fn read<T: Copy + Default>(&self, buffer: &Buffer<T>, len: usize, after: &Event) -> Vec<T> {
        let mut values = vec![T::default(); len];
        // SAFETY: the read blocks, and there are as many values.
        unsafe { self.queue.enqueue_read_buffer(buffer, CL_BLOCKING, 0, &mut values, &[after.get()]) }.unwrap();
        values
    }
}

/// The event that a call returns.
fn event(call: impl FnOnce(*mut *mut _cl_event) -> Status) -> Event {
    Event::new(made(call).cast())
}

const SIDE: usize = 12;

fn bytes(seed: usize) -> Vec<u8> {
    (0..SIDE * SIDE * SIDE).map(|n| (n * (seed + 7) * 31 % 251) as u8).collect()
}

fn voxels(memory: &Buffer<u8>) -> Voxels {
    Voxels {
        memory: memory.get().cast(),
        voxel_type: VoxelType::Uint8 as i32,
        invalid_voxels: 0,
        first: 0,
        row_pitch: 0,
        slice_pitch: 0,
        grid: layersplat_grid_at_origin(SIDE, SIDE, SIDE, 1.0, 1.0, 1.0),
        smallest: 0.0,
        largest: 255.0,
    }
}

fn onto<T>(memory: &Buffer<T>, format: PixelFormat) -> Picture {
    let format = format as i32;
    Picture { memory: memory.get().cast(), format, transparent: 0, background: [0.0, 0.5, 1.0], first: 0, row_pitch: 0 }
}

fn fire() -> *mut Transfer {
    // SAFETY: all arguments are alive.
    unsafe {
        let unit = made(|out| layersplat_transfer_open(c"fire".as_ptr(), null(), out));
        let transfer = made(|out| layersplat_transfer_stretched(unit, 0.0, 255.0, out));
        layersplat_transfer_free(unit);
        transfer
    }
}

fn camera() -> Camera {
    let grid = layersplat_grid_at_origin(SIDE, SIDE, SIDE, 1.0, 1.0, 1.0);
    let mut camera = common::EMPTY;
    // SAFETY: all arguments are alive.
    ok(unsafe { layersplat_camera_fit_grid(&grid, common::FROM, 0.0, WIDTH, HEIGHT, &mut camera) });
    camera
}

/// Calls return while frames wait for events, and the pictures match those of blocking calls.
#[test]
fn frames_of_voxels_in_place_are_enqueued() {
    let host = Host::new();
    let (device, transfer, camera) = (host.device(), fire(), camera());
    let (before, after) = (bytes(1), bytes(2));
    let (mut memory, picture) = (host.filled(&before), host.buffer::<u8>(FLOATS));
    let onto = onto(&picture, PixelFormat::Rgba8);
    // SAFETY: all arguments are alive.
    unsafe {
        let renderer = made(|out| layersplat_renderer_in_place(device, &voxels(&memory), transfer, out));
        ok(layersplat_renderer_prepare(renderer, &camera, WIDTH, HEIGHT, null()));
        let drawn = |voxels_now: &[u8], wait: &[*mut _cl_event]| {
            let count = wait.len() as u32;
            let first = event(|out| {
                layersplat_renderer_enqueue(renderer, &camera, WIDTH, HEIGHT, null(), &onto, count, wait.as_ptr(), out)
            });
            if let Some(&gate) = wait.first() {
                assert_ne!(first.command_execution_status().unwrap().0, CL_COMPLETE, "it waits");
                set_user_event_status(gate.cast(), 0).unwrap();
            }
            let found = host.read(&picture, FLOATS, &first);
            // Reference: a blocking call with a buffer that never changes.
            let same = host.filled(voxels_now);
            let other = made(|out| layersplat_renderer_in_place(device, &voxels(&same), transfer, out));
            let (mut expected, blue) = (vec![0u8; FLOATS], [0.0, 0.5, 1.0f32]);
            let pixels = expected.as_mut_ptr();
            ok(layersplat_render_rgba8(other, &camera, WIDTH, HEIGHT, null(), blue.as_ptr(), pixels, FLOATS));
            layersplat_renderer_free(other);
            assert!(found == expected);
            found
        };
        let gate = Event::new(create_user_event(host.context.get()).unwrap());
        let old = drawn(&before, &[gate.get().cast()]);
        host.queue.enqueue_write_buffer(&mut memory, CL_BLOCKING, 0, &after, &[]).unwrap();
        let changed = event(|out| layersplat_renderer_volume_changed(renderer, 0, null(), out));
        assert!(drawn(&after, &[]) != old);
        changed.wait().unwrap();
        // The event is optional.
        ok(layersplat_renderer_enqueue(renderer, &camera, WIDTH, HEIGHT, null(), &onto, 0, null(), null_mut()));
        let sheets = Settings { algorithm: AlgorithmChoice::AxisSheets as i32, ..common::settings(1) };
        let mut none = null_mut();
        let status = layersplat_renderer_enqueue(renderer, &camera, WIDTH, HEIGHT, &sheets, &onto, 0, null(), &mut none);
        refused(status, Status::InvalidArgument);
        assert!(none.is_null());
        host.queue.finish().unwrap();
        layersplat_renderer_free(renderer);
        layersplat_transfer_free(transfer);
        layersplat_device_free(device);
    }
}

#[test]
fn the_range_is_found_on_the_device() {
    let (host, transfer) = (Host::new(), fire());
    let device = host.device();
    let memory = host.filled(&bytes(1).iter().map(|v| v / 2 + 9).collect::<Vec<_>>());
    let mut found = Voxels { smallest: 0.0, largest: 0.0, invalid_voxels: 1, ..voxels(&memory) };
    // SAFETY: all arguments are alive.
    unsafe {
        ok(layersplat_voxels_find_range(device, &mut found, 0, null()));
        assert_eq!((found.smallest, found.largest, found.invalid_voxels), (9.0, 134.0, 0));
        let mut renderer = null_mut();
        let mut wrong = |voxels: Voxels, status| {
            let message = refused(layersplat_renderer_in_place(device, &voxels, transfer, &mut renderer), status);
            assert!(renderer.is_null());
            message
        };
        assert!(wrong(Voxels { first: 1, ..found }, Status::Unsuitable).contains("end at"));
        assert!(wrong(Voxels { row_pitch: SIDE, ..found }, Status::InvalidArgument).contains("both"));
        assert!(wrong(Voxels { memory: null_mut(), ..found }, Status::Unsuitable).contains("null"));
        wrong(Voxels { smallest: 2.0, largest: 1.0, ..found }, Status::InvalidArgument);
        wrong(Voxels { invalid_voxels: 3, ..found }, Status::InvalidArgument);
        wrong(Voxels { memory: Host::new().filled(&bytes(1)).get().cast(), ..found }, Status::Unsuitable);
        layersplat_transfer_free(transfer);
        layersplat_device_free(device);
    }
}

#[test]
fn caller_objects_are_released() {
    let host = Host::new();
    let (memory, picture) = (host.filled(&bytes(3)), host.buffer::<f32>(FLOATS));
    let references = || {
        host.queue.finish().unwrap();
        let counts = [host.context.reference_count(), memory.reference_count(), picture.reference_count()];
        counts.map(Result::unwrap)
    };
    let (before, transfer, camera) = (references(), fire(), camera());
    let onto = onto(&picture, PixelFormat::Floats);
    // SAFETY: all arguments are alive.
    unsafe {
        let device = host.device();
        assert_eq!(layersplat_device_context(device), host.context.get().cast());
        assert_eq!(layersplat_device_queue(device), host.queue.get().cast());
        let renderer = made(|out| layersplat_renderer_in_place(device, &voxels(&memory), transfer, out));
        layersplat_device_free(device);
        let (mut sizes, mut count) = ([0; 8], 0);
        ok(layersplat_renderer_scratch_sizes(renderer, &camera, WIDTH, HEIGHT, null(), &onto, null_mut(), 0, &mut count));
        assert!((1..8).contains(&count));
        let first = sizes.as_mut_ptr();
        let small =
            layersplat_renderer_scratch_sizes(renderer, &camera, WIDTH, HEIGHT, null(), &onto, first, count - 1, &mut count);
        if count > 1 {
            refused(small, Status::TooSmall);
        }
        ok(layersplat_renderer_scratch_sizes(renderer, &camera, WIDTH, HEIGHT, null(), &onto, first, 8, &mut count));
        let scratch: Vec<Buffer<u8>> = sizes[..count].iter().map(|&bytes| host.buffer(bytes)).collect();
        let raw: Vec<*mut _cl_mem> = scratch.iter().map(|buffer| buffer.get().cast()).collect();
        ok(layersplat_renderer_set_scratch(renderer, raw.as_ptr(), count));
        let retained = scratch.iter().map(|buffer| buffer.reference_count().unwrap());
        assert!(retained.into_iter().all(|count| count > 1));
        let drawn = event(|out| layersplat_renderer_enqueue(renderer, &camera, WIDTH, HEIGHT, null(), &onto, 0, null(), out));
        assert!(host.read(&picture, FLOATS, &drawn).chunks(4).any(|p| p[3] > 0.1));
        drop(drawn);
        let used = references();
        assert!(used[0] > before[0] && used[1] > before[1], "{used:?}");
        layersplat_renderer_free(renderer);
        layersplat_transfer_free(transfer);
        assert!(scratch.iter().all(|buffer| buffer.reference_count().unwrap() == 1));
    }
    assert_eq!(references(), before);
}

#[test]
fn pictures_go_into_images() {
    let (host, transfer, camera) = (Host::new(), fire(), camera());
    let memory = host.filled(&bytes(4));
    let size = [WIDTH as usize, HEIGHT as usize, 1];
    let format = cl_image_format { image_channel_order: CL_RGBA, image_channel_data_type: CL_FLOAT };
    let kind = cl_image_desc { image_type: CL_MEM_OBJECT_IMAGE2D, image_width: size[0], image_height: size[1], ..no_image() };
    let (mut drawn, mut expected) = (vec![-1f32; FLOATS], vec![0f32; FLOATS]);
    // SAFETY: all arguments are alive; the read blocks, and there are as many floats.
    unsafe {
        let image = Image::create(&host.context, CL_MEM_READ_WRITE, &format, &kind, null_mut()).unwrap();
        let (floats, device) = (PixelFormat::Floats as i32, host.device());
        let onto = Picture { memory: image.get().cast(), format: floats, ..onto(&memory, PixelFormat::Floats) };
        let renderer = made(|out| layersplat_renderer_in_place(device, &voxels(&memory), transfer, out));
        let done = event(|out| layersplat_renderer_enqueue(renderer, &camera, WIDTH, HEIGHT, null(), &onto, 0, null(), out));
        let (queue, wait, to) = (host.queue.get(), done.get(), drawn.as_mut_ptr().cast());
        let read = enqueue_read_image(queue, image.get(), CL_BLOCKING, [0; 3].as_ptr(), size.as_ptr(), 0, 0, to, 1, &wait);
        drop(Event::new(read.unwrap()));
        ok(layersplat_render_floats(renderer, &camera, WIDTH, HEIGHT, null(), expected.as_mut_ptr(), FLOATS));
        layersplat_renderer_free(renderer);
        layersplat_transfer_free(transfer);
        layersplat_device_free(device);
    }
    assert!(drawn == expected);
}

fn no_image() -> cl_image_desc {
    cl_image_desc {
        image_type: 0,
        image_width: 0,
        image_height: 0,
        image_depth: 0,
        image_array_size: 0,
        image_row_pitch: 0,
        image_slice_pitch: 0,
        num_mip_levels: 0,
        num_samples: 0,
        buffer: null_mut(),
    }
}

#[test]
fn handles_of_another_context_are_rejected() {
    let (host, other) = (Host::new(), Host::new());
    let scene = Scene::new();
    let picture = other.buffer::<f32>(FLOATS);
    let mut device = null_mut();
    // SAFETY: all arguments are alive.
    unsafe {
        let queue = host.queue.get().cast();
        let status = layersplat_device_from_queue(other.context.get().cast(), null_mut(), queue, &mut device);
        assert!(refused(status, Status::Unsuitable).contains("another context"));
        assert!(device.is_null());
        let onto = onto(&picture, PixelFormat::Floats);
        let (view, none) = (&raw const scene.camera, null_mut());
        let status = layersplat_renderer_enqueue(scene.renderer, view, WIDTH, HEIGHT, null(), &onto, 0, null(), none);
        assert!(refused(status, Status::Unsuitable).contains("another context"), "{}", last_error());
    }
}
