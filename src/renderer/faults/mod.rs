//! Tests of what goes wrong: at every call in turn, in every way to a picture. It comes back as an error, nothing is lost or left
//! behind, and the next picture is right.
//!
//! LAYERSPLAT_CASE names the ways to look at, by a part of their names: scripts/valgrind-faults has time for a few.

mod cases;
mod host;

use super::Renderer;
use crate::device::{Call, Device};
use crate::error::Error;
use crate::settings::{Algorithm, Settings};
use cases::{Case, Draw, Scene};
use host::Host;
use opencl3::error_codes::{CL_DEVICE_NOT_AVAILABLE, CL_MEM_OBJECT_ALLOCATION_FAILURE, CL_OUT_OF_RESOURCES};

/// Small: it is drawn some thousand times.
const SMALL: &str = "builtin:hydrogen@12x10x14";

/// How a device fails at its n-th call.
struct Failing {
    arm: fn(&Device, u64),
    /// Whether it fails until it recovers.
    lasting: bool,
    /// Whether a frame may go on all the same, by making room.
    gives_way: bool,
    expected: fn(&Error) -> bool,
}

const ALLOCATIONS: Failing = Failing {
    arm: |device, n| device.fail(Call::Allocation, n, CL_MEM_OBJECT_ALLOCATION_FAILURE),
    lasting: false,
    gives_way: true,
    expected: |error| matches!(error, Error::OutOfDeviceMemory { source, .. } if source.0 == CL_MEM_OBJECT_ALLOCATION_FAILURE),
};

const COMMANDS: Failing = Failing {
    arm: |device, n| device.fail(Call::Command, n, CL_OUT_OF_RESOURCES),
    lasting: false,
    gives_way: false,
    expected: |error| matches!(error, Error::OpenCl { source, .. } if source.0 == CL_OUT_OF_RESOURCES),
};

const BUILDS: Failing = Failing {
    arm: |device, n| device.fail(Call::Build, n, CL_OUT_OF_RESOURCES),
    lasting: false,
    gives_way: false,
    expected: |error| matches!(error, Error::Build { log, .. } if log.contains("told to fail")),
};

const LOSSES: Failing = Failing {
    arm: |device, n| device.lose(n, CL_DEVICE_NOT_AVAILABLE),
    lasting: true,
    gives_way: false,
    expected: |error| {
        matches!(error, Error::OpenCl { source, .. } if source.0 == CL_DEVICE_NOT_AVAILABLE)
            || matches!(error, Error::Build { .. })
    },
};

/// What a device holds: bytes and programs.
fn held(device: &Device) -> (u64, usize) {
    (device.allocated_bytes(), device.programs())
}

/// Fails a case at its first call, its second one and so on, until it has none left; and tells how many it had.
fn sweep(host: &Host, device: &Device, case: &Case, failing: &Failing) -> u64 {
    let name = &case.name;
    let outside = held(device);
    let made = || (case.make)(device).unwrap_or_else(|e| panic!("{name}: {e}"));
    let drawn = |draw: &mut Draw| draw().unwrap_or_else(|e| panic!("{name}: {e}"));
    let mut undisturbed = made();
    let expected = drawn(&mut undisturbed);
    assert!(drawn(&mut undisturbed) == expected && expected.iter().any(|&byte| byte != 0), "{name}");
    let kept = held(device);
    drop(undisturbed);
    assert_eq!(held(device), (outside.0, kept.1), "{name}: programs are what stays");
    let references = host.references(None);
    for n in 0.. {
        (failing.arm)(device, n);
        let (draw, error) = match (case.make)(device) {
            Ok(mut draw) => {
                let error = match draw() {
                    Ok(picture) => {
                        assert!(picture == expected, "{name}, call {n}: the picture is another");
                        None
                    }
                    Err(error) => Some(error),
                };
                let lost = failing.lasting && error.is_some();
                assert!(!lost || draw().is_err(), "{name}, call {n}: a lost device draws nothing");
                (Some(draw), error)
            }
            Err(error) => (None, Some(error)),
        };
        if !device.recover() {
            assert!(error.is_none(), "{name}: {error:?}");
            return n;
        }
        match error {
            Some(error) => assert!((failing.expected)(&error), "{name}, call {n}: {error}"),
            None => assert!(failing.gives_way, "{name}: call {n} failed unnoticed"),
        }
        let mut draw = draw.unwrap_or_else(made);
        assert!(drawn(&mut draw) == expected, "{name}, call {n}: the next picture is another");
        assert!(drawn(&mut draw) == expected, "{name}, call {n}: the one after the next is another");
        assert_eq!(held(device), kept, "{name}, call {n}");
        drop(draw);
        assert_eq!(held(device), (outside.0, kept.1), "{name}, call {n}");
        assert_eq!(host.references(Some(references)), references, "{name}, call {n}");
    }
    unreachable!("there are not so many calls")
}

/// On queues of both kinds; and asserts that references to the host's context are as before when all is dropped.
fn sweep_all<'a>(hosts: &'a [Host], cases: impl Fn(&'a Host) -> Vec<Case<'a>>, failing: &Failing, least: u64) {
    for host in hosts {
        let [context, _] = host.references(None);
        let device = host.device();
        let only = std::env::var("LAYERSPLAT_CASE").unwrap_or_default();
        for case in cases(host).into_iter().filter(|case| case.name.contains(&only)) {
            let calls = sweep(host, &device, &case, failing);
            eprintln!("{}: {calls}", case.name);
            assert!(calls >= least, "{}: {calls} calls", case.name);
        }
        drop(device);
        assert_eq!(host.references(None)[0], context);
    }
}

fn all<'a>(scene: &'a Scene, large: &'a Scene, host: &'a Host) -> Vec<Case<'a>> {
    let mut cases = cases::frames(scene);
    cases.extend(cases::displayed(scene));
    cases.extend(cases::enqueued(scene, host));
    cases.push(cases::in_parts(scene));
    cases.extend(cases::streamed(large));
    cases
}

/// Volumes that are kept whole, and one that is streamed.
fn scenes() -> [Scene; 2] {
    [SMALL, "builtin:marschner-lobb@72"].map(Scene::of)
}

#[test]
fn every_allocation_may_fail() {
    let ([small, large], host) = (scenes(), [Host::new(false)]);
    sweep_all(&host, |host| all(&small, &large, host), &ALLOCATIONS, 5);
}

#[test]
fn every_command_may_fail() {
    let ([small, large], hosts) = (scenes(), [false, true].map(Host::new));
    sweep_all(&hosts, |host| all(&small, &large, host), &COMMANDS, 4);
}

#[test]
fn a_device_may_be_lost_at_every_call() {
    let ([small, large], hosts) = (scenes(), [false, true].map(Host::new));
    sweep_all(&hosts, |host| all(&small, &large, host), &LOSSES, 10);
}

/// A program that does not compile: the compiler's words come back, and nothing is kept of it.
#[test]
fn every_build_may_fail() {
    let scene = Scene::of(SMALL);
    for case in cases::frames(&scene) {
        // What is built stays: only a new device builds again.
        let host = Host::new(false);
        let device = host.device();
        device.fail(Call::Build, 1, CL_OUT_OF_RESOURCES);
        let mut draw = (case.make)(&device).unwrap();
        let error = draw().expect_err("its second program does not compile");
        assert!(device.recover() && (BUILDS.expected)(&error), "{}: {error}", case.name);
        assert_eq!(device.programs(), 1, "{}: one was built, and the other is not kept", case.name);
        let picture = draw().unwrap();
        assert!((case.make)(&host.device()).unwrap()().unwrap() == picture, "{}", case.name);
    }
}

/// What made tables and occupancy never ran: they are made again.
#[test]
fn what_a_failed_frame_was_to_make_is_not_kept() {
    let scene = Scene::of(SMALL);
    let camera = scene.camera(80.0, None);
    for host in [false, true].map(Host::new) {
        for settings in [Settings::default(), Algorithm::Slicing { step: 0.8 }.into()] {
            let device = host.device();
            let new = || Renderer::new(&device, &scene.volume, &scene.transfer).unwrap();
            let size = crate::viewport::Viewport { width: 21, height: 17 };
            let (expected, _) = new().render(&camera, size, &settings).unwrap();
            let mut renderer = new();
            let picture = host.room(16 * size.pixels());
            let onto = super::PictureMemory::new(
                &crate::device::DeviceMemory::from_buffer(&picture).unwrap(),
                super::PictureFormat::Floats,
            );
            let promise = opencl3::event::Event::new(opencl3::event::create_user_event(host.context.get()).unwrap());
            let failed = renderer.enqueue(&camera, size, &settings, &onto, &[&promise]).unwrap();
            // Enqueued before it is known that the first one fails.
            let after = renderer.enqueue(&camera, size, &settings, &onto, &[]).unwrap();
            opencl3::event::set_user_event_status(promise.get(), -5).unwrap();
            assert!(failed.wait().is_err());
            // Where commands follow one another by events, and so in PoCL, it fails, too; elsewhere it is right: it has made again what the
            // first one was to make.
            if after.wait().is_ok() {
                let found = host.read(&picture, 16 * size.pixels(), &after);
                assert!(found == bytemuck::cast_slice::<_, u8>(expected.pixels()), "{settings:?}");
            }
            assert!(renderer.render(&camera, size, &settings).unwrap().0 == expected, "{settings:?}");
        }
    }
}
