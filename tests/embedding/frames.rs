//! Enqueued frames: bit-identical to rendered ones, in any memory, after their wait events.

use crate::common::{CONVERGED, POINTS, SPLATTED, layered, perspective};
use crate::handles::image;
use crate::host::{Host, OUT_OF_ORDER, SIZE, frame, hosts, keep, renderer, scene};
use layersplat::device::DeviceMemory;
use layersplat::layers::Kernel;
use layersplat::renderer::{PictureFormat, PictureMemory};
use layersplat::settings::{Algorithm, Blend, Evaluation, LayerAxis, Layered, LightGrid, Look, Studio};
use layersplat::{Background, Camera, Orbit, Quality, Settings};
use opencl3::event::{CL_COMPLETE, Event};
use opencl3::memory::{CL_FLOAT, CL_RGBA, CL_UNORM_INT8, ClMem, cl_image_format};
use opencl3::types::CL_BLOCKING;

/// All render paths: lattices of either classification, blended lattices, per pixel, ray casting.
fn ways() -> Vec<Settings> {
    let settings = Settings::default();
    let of = |classification, evaluation| Settings {
        algorithm: Layered { classification, evaluation, ..layered(settings) }.into(),
        ..settings
    };
    vec![
        settings,
        Quality::High.settings(),
        of(SPLATTED, layered(settings).evaluation),
        of(POINTS, Evaluation::Direct),
        Settings { blend: Blend::Maximum, ..settings },
        Settings { studio: Some(Studio { exposure: 1.0, ..Studio::default() }), ..settings.with_look(Look::Studio) },
        Settings { algorithm: CONVERGED, light_grid: LightGrid::Quarter, ..settings.with_look(Look::Studio) },
        CONVERGED.into(),
        Algorithm::Slicing { step: 0.8 }.into(),
    ]
}

fn cameras() -> [Camera; 3] {
    let (volume, _, camera) = scene();
    let between_axes = Orbit { azimuth: 45.5, elevation: 0.0, roll: 0.0 };
    let shared = Camera::fit_parallel(volume.grid().centre(), volume.grid().diagonal(), SIZE, between_axes);
    [camera, perspective(&volume, 80.0, 10.0, 30.0), shared]
}

#[test]
fn enqueued_frames_have_the_bits_of_rendered_ones() {
    let (volume, transfer, _) = scene();
    for host in hosts() {
        let mut renderer = renderer(&host.device(), &volume, &transfer);
        for settings in ways() {
            for camera in cameras() {
                let (expected, _) = renderer.render(&camera, SIZE, &settings).unwrap();
                assert!(expected.pixels().iter().any(|p| p[3] > 0.05));
                assert!(host.floats(&mut renderer, &camera, &settings) == expected, "{settings:?}");
                for background in [Background::Transparent, Background::Color([0.2, 0.5, 1.0])] {
                    let (expected, _) = renderer.render_rgba8(&camera, SIZE, &settings, background).unwrap();
                    let picture = host.room::<u8>(4 * SIZE.pixels());
                    let memory = DeviceMemory::from_buffer(&picture).unwrap();
                    let onto = PictureMemory::new(&memory, PictureFormat::Rgba8(background));
                    let event = renderer.enqueue(&camera, SIZE, &settings, &onto, &[]).unwrap();
                    assert_eq!(host.read(&picture, expected.len(), &[&event]), expected, "{settings:?}");
                }
            }
        }
    }
}

/// Rows with gaps and any first pixel; bytes outside the picture stay unchanged.
#[test]
fn pictures_go_where_they_are_wanted() {
    const ROW: usize = 4 * 45;
    const UNTOUCHED: u8 = 0xa5;
    let (volume, transfer, camera) = scene();
    let (host, settings) = (Host::new(0), Settings::default());
    let mut renderer = renderer(&host.device(), &volume, &transfer);
    let background = Background::Color([0.3; 3]);
    let (expected, _) = renderer.render_rgba8(&camera, SIZE, &settings, background).unwrap();
    // Without gaps; starting within a row; and starting so late in a row that the first row continues in the next.
    for (first, pitch) in [(4, ROW + 12), (20, ROW), (ROW, ROW), (ROW + 4, ROW + 12), (5 * ROW + 8, ROW + 4)] {
        let bytes = first + pitch * SIZE.height as usize;
        let picture = host.filled(&vec![UNTOUCHED; bytes]);
        let onto = PictureMemory::new(&DeviceMemory::from_buffer(&picture).unwrap(), PictureFormat::Rgba8(background));
        let onto = onto.with_first(first).with_row_pitch(pitch);
        let event = renderer.enqueue(&camera, SIZE, &settings, &onto, &[]).unwrap();
        let found = host.read(&picture, bytes, &[&event]);
        let mut wanted = vec![UNTOUCHED; bytes];
        for (n, pixels) in expected.chunks(ROW).enumerate() {
            wanted[first + n * pitch..][..ROW].copy_from_slice(pixels);
        }
        assert!(found == wanted, "{first}, {pitch}");
    }
}

#[test]
fn pictures_go_into_images() {
    let (volume, transfer, camera) = scene();
    let (host, settings) = (Host::new(OUT_OF_ORDER), Settings::default());
    let mut renderer = renderer(&host.device(), &volume, &transfer);
    let [columns, rows] = [SIZE.width, SIZE.height].map(|n| n as usize);
    let background = Background::Color([0.1, 0.2, 0.3]);
    let mut drawn = |channels, format| {
        let pixels = cl_image_format { image_channel_order: CL_RGBA, image_channel_data_type: channels };
        let image = image(&host, pixels, columns, rows);
        let onto = PictureMemory::new(&DeviceMemory::from_image(&image).unwrap(), format);
        let event = renderer.enqueue(&camera, SIZE, &settings, &onto, &[]).unwrap();
        let mut bytes = vec![0u8; format.bytes() * SIZE.pixels()];
        let (origin, region) = ([0, 0, 0], [columns, rows, 1]);
        // SAFETY: the read blocks, and the buffer has as many bytes.
        let read = unsafe {
            let wait = [event.get()];
            opencl3::command_queue::enqueue_read_image(
                host.queue.get(),
                image.get(),
                CL_BLOCKING,
                origin.as_ptr(),
                region.as_ptr(),
                0,
                0,
                bytes.as_mut_ptr().cast(),
                1,
                wait.as_ptr(),
            )
        };
        drop(Event::new(read.unwrap()));
        bytes
    };
    let (floats, bytes) = (drawn(CL_FLOAT, PictureFormat::Floats), drawn(CL_UNORM_INT8, PictureFormat::Rgba8(background)));
    let floats: Vec<f32> = floats.as_chunks::<4>().0.iter().map(|b| f32::from_ne_bytes(*b)).collect();
    assert!(frame(&floats) == renderer.render(&camera, SIZE, &settings).unwrap().0);
    assert_eq!(bytes, renderer.render_rgba8(&camera, SIZE, &settings, background).unwrap().0);
}

/// The wait event is not complete yet: the call returns immediately, and the picture follows when it completes.
#[test]
fn a_frame_is_enqueued_and_not_waited_for() {
    let (volume, transfer, camera) = scene();
    for host in hosts() {
        // The host uses another queue meanwhile.
        let own_queue = host.another_queue(0);
        for settings in ways() {
            let mut renderer = renderer(&host.device(), &volume, &transfer);
            renderer.prepare(&camera, SIZE, &settings).unwrap();
            let (expected, _) = renderer.render(&camera, SIZE, &settings).unwrap();
            let picture = host.filled(&vec![-1.0f32; 4 * SIZE.pixels()]);
            let onto = PictureMemory::new(&DeviceMemory::from_buffer(&picture).unwrap(), PictureFormat::Floats);
            let promise = host.promise();
            let first = renderer.enqueue(&camera, SIZE, &settings, &onto, &[&promise]).unwrap();
            let second = renderer.enqueue(&camera, SIZE, &settings, &onto, &[]).unwrap();
            let changed = renderer.volume_changed(&[]).unwrap();
            let third = renderer.enqueue(&camera, SIZE, &settings, &onto, &[&changed]).unwrap();
            let events = [&first, &second, &changed, &third];
            assert!(events.iter().all(|event| event.command_execution_status().unwrap().0 != CL_COMPLETE), "{settings:?}");
            let mut now = vec![0f32; 4 * SIZE.pixels()];
            // SAFETY: the read blocks, and the buffer has as many values.
            unsafe { own_queue.enqueue_read_buffer(&picture, CL_BLOCKING, 0, &mut now, &[]) }.unwrap();
            assert!(now.iter().all(|&x| x == -1.0), "the picture must not start before its wait event");
            keep(&promise);
            third.wait().unwrap();
            assert!(events.iter().all(|event| event.command_execution_status().unwrap().0 == CL_COMPLETE));
            assert!(frame(&host.read(&picture, 4 * SIZE.pixels(), &[])) == expected, "{settings:?}");
        }
    }
}

#[test]
fn what_reads_back_is_refused() {
    let (volume, transfer, camera) = scene();
    let host = Host::new(0);
    let mut renderer = renderer(&host.device(), &volume, &transfer);
    let picture = host.room::<f32>(4 * SIZE.pixels());
    let onto = PictureMemory::new(&DeviceMemory::from_buffer(&picture).unwrap(), PictureFormat::Floats);
    for sheets in [Algorithm::AxisSheets { layer_axis: LayerAxis::Auto }, Algorithm::ViewSheets { sheet_distance: 1.0 }] {
        let error = renderer.enqueue(&camera, SIZE, &sheets.into(), &onto, &[]).map(|_| ()).unwrap_err();
        assert_eq!(error.fields(), ["algorithm"]);
        assert!(error.to_string().contains("use `render`"), "{error}");
    }
    assert!(
        host.floats(&mut renderer, &camera, &Settings::default()).pixels().iter().any(|p| p[3] > 0.05),
        "and the queue goes on"
    );
}

/// A failed wait event fails its frame, but not the next one.
#[test]
fn a_failed_wait_fails_one_frame() {
    let (volume, transfer, camera) = scene();
    for host in hosts() {
        let settings = Settings::default();
        let expected = crate::common::render(&volume, &transfer, &camera, SIZE, &settings);
        // The first frame fills the caches.
        let mut renderer = renderer(&host.device(), &volume, &transfer);
        let picture = host.room::<f32>(4 * SIZE.pixels());
        let onto = PictureMemory::new(&DeviceMemory::from_buffer(&picture).unwrap(), PictureFormat::Floats);
        let promise = host.promise();
        let event = renderer.enqueue(&camera, SIZE, &settings, &onto, &[&promise]).unwrap();
        opencl3::event::set_user_event_status(promise.get(), -5).unwrap();
        assert!(event.wait().is_err());
        assert!(event.command_execution_status().unwrap().0 < 0);
        assert!(host.floats(&mut renderer, &camera, &settings) == expected);
        assert!(renderer.render(&camera, SIZE, &settings).unwrap().0 == expected);
    }
}

/// One renderer per thread on one device: with a common queue, and with one queue each.
#[test]
fn renderers_on_several_threads() {
    let (volume, transfer, _) = scene();
    let settings = Settings::default();
    let expected = cameras().map(|camera| crate::common::render(&volume, &transfer, &camera, SIZE, &settings));
    for host in hosts() {
        let device = host.device();
        std::thread::scope(|scope| {
            for n in 0..4 {
                let (device, host, volume, transfer, expected) = (&device, &host, &volume, &transfer, &expected);
                scope.spawn(move || {
                    let own = host.another_queue(if n % 2 == 0 { 0 } else { OUT_OF_ORDER });
                    let device = if n < 2 { device.clone() } else { device.with_queue(&own).unwrap() };
                    let mut renderer = renderer(&device, volume, transfer);
                    for round in 0..6 {
                        let n = (n + round) % 3;
                        let frame = match round % 2 {
                            0 => host.floats(&mut renderer, &cameras()[n], &settings),
                            _ => renderer.render(&cameras()[n], SIZE, &settings).unwrap().0,
                        };
                        assert!(frame == expected[n]);
                    }
                });
            }
        });
    }
}

/// One renderer builds ray casting with every kernel; others of the device reuse the programs.
#[test]
fn programs_are_shared_by_the_renderers_of_a_device() {
    let (volume, transfer, camera) = scene();
    let device = Host::new(0).device();
    let settings: Settings = Algorithm::Raycast { kernel: Kernel::Linear, step: 0.7 }.into();
    let programs = |device: &layersplat::Device| device.programs();
    renderer(&device, &volume, &transfer).render(&camera, SIZE, &settings).unwrap();
    let built = programs(&device);
    assert!(built > 0);
    renderer(&device.clone(), &volume, &transfer).render(&camera, SIZE, &settings).unwrap();
    assert_eq!(programs(&device), built);
}

/// A queue without profiling has no event times: stages then have those of the clock.
#[test]
fn stages_have_times_on_queues_without_profiling() {
    let (volume, transfer, camera) = scene();
    let own = layersplat::Device::open(&layersplat::DeviceChoice::Default).unwrap();
    // SAFETY: the context is alive as long as the device.
    let context = unsafe { opencl3::context::context::retain_context(own.context()) }
        .map(|()| opencl3::context::Context::new(own.context(), &[own.id()]))
        .unwrap();
    #[allow(deprecated)] // The replacement needs OpenCL 2.0.
    let queue = opencl3::command_queue::CommandQueue::create_default(&context, 0).unwrap();
    let mut renderer = layersplat::Renderer::new(&own.with_queue(&queue).unwrap(), &volume, &transfer).unwrap();
    renderer.measure(true);
    let (_, report) = renderer.render(&camera, SIZE, &Settings::default()).unwrap();
    let stages = report.measured.unwrap().stages;
    assert!(!stages.is_empty() && stages.iter().all(|&(_, ms)| ms > 0.0), "{stages:?}");
}
