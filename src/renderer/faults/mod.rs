//! Fault injection: every OpenCL call of every render path fails in turn. The failure is returned as an error, nothing leaks, and
//! the next picture is correct.
//!
//! LAYERSPLAT_CASE selects render paths by a part of their names, for scripts/valgrind-faults, which has time for only a few.

mod cases;
mod host;
mod recovery;

use super::Renderer;
use crate::device::{Call, Device};
use crate::error::Error;
use crate::settings::{Algorithm, Settings};
use cases::{Case, Draw, Scene};
use host::Host;
use opencl3::error_codes::{CL_DEVICE_NOT_AVAILABLE, CL_MEM_OBJECT_ALLOCATION_FAILURE, CL_OUT_OF_RESOURCES};

/// Small, because it is rendered several thousand times.
const SMALL: &str = "builtin:hydrogen@12x10x14";

/// A kind of failure at the n-th call.
struct Failure {
    arm: fn(&Device, u64),
    /// Whether all later calls fail, too, until [`Device::recover`].
    lasting: bool,
    /// Whether a frame may still succeed after dropping cached data.
    may_recover: bool,
    expected: fn(&Error) -> bool,
}

const ALLOCATIONS: Failure = Failure {
    arm: |device, n| device.fail(Call::Allocation, n, CL_MEM_OBJECT_ALLOCATION_FAILURE),
    lasting: false,
    may_recover: true,
    expected: |error| matches!(error, Error::OutOfDeviceMemory { source, .. } if source.0 == CL_MEM_OBJECT_ALLOCATION_FAILURE),
};

const COMMANDS: Failure = Failure {
    arm: |device, n| device.fail(Call::Command, n, CL_OUT_OF_RESOURCES),
    lasting: false,
    may_recover: false,
    expected: |error| matches!(error, Error::OpenCl { source, .. } if source.0 == CL_OUT_OF_RESOURCES),
};

const BUILDS: Failure = Failure {
    arm: |device, n| device.fail(Call::Build, n, CL_OUT_OF_RESOURCES),
    lasting: false,
    may_recover: false,
    expected: |error| matches!(error, Error::Build { log, .. } if log.contains("injected fault")),
};

const LOSSES: Failure = Failure {
    arm: |device, n| device.lose(n, CL_DEVICE_NOT_AVAILABLE),
    lasting: true,
    may_recover: false,
    expected: |error| {
        matches!(error, Error::OpenCl { source, .. } if source.0 == CL_DEVICE_NOT_AVAILABLE)
            || matches!(error, Error::Build { .. })
    },
};

/// Allocated bytes and number of programs of a device.
fn held(device: &Device) -> (u64, usize) {
    (device.allocated_bytes(), device.programs())
}

/// Fails a case at its first call, at its second, and so on until it has no more calls. Returns their number.
fn sweep(host: &Host, device: &Device, case: &Case, failure: &Failure) -> u64 {
    let name = &case.name;
    let outside = held(device);
    let made = || (case.make)(device).unwrap_or_else(|e| panic!("{name}: {e}"));
    let drawn = |draw: &mut Draw| draw().unwrap_or_else(|e| panic!("{name}: {e}"));
    let mut undisturbed = made();
    let expected = drawn(&mut undisturbed);
    assert!(drawn(&mut undisturbed) == expected && expected.iter().any(|&byte| byte != 0), "{name}");
    let kept = held(device);
    drop(undisturbed);
    assert_eq!(held(device), (outside.0, kept.1), "{name}: only programs stay");
    let references = host.references(None);
    for n in 0.. {
        (failure.arm)(device, n);
        let (draw, error) = match (case.make)(device) {
            Ok(mut draw) => {
                let error = match draw() {
                    Ok(picture) => {
                        assert!(picture == expected, "{name}, call {n}: the picture differs");
                        None
                    }
                    Err(error) => Some(error),
                };
                let lost = failure.lasting && error.is_some();
                assert!(!lost || draw().is_err(), "{name}, call {n}: a lost device renders nothing");
                (Some(draw), error)
            }
            Err(error) => (None, Some(error)),
        };
        if !device.recover() {
            assert!(error.is_none(), "{name}: {error:?}");
            return n;
        }
        match error {
            Some(error) => assert!((failure.expected)(&error), "{name}, call {n}: {error}"),
            None => assert!(failure.may_recover, "{name}: call {n} failed unnoticed"),
        }
        let mut draw = draw.unwrap_or_else(made);
        assert!(drawn(&mut draw) == expected, "{name}, call {n}: the next picture differs");
        assert!(drawn(&mut draw) == expected, "{name}, call {n}: the second next picture differs");
        assert_eq!(held(device), kept, "{name}, call {n}");
        drop(draw);
        assert_eq!(held(device), (outside.0, kept.1), "{name}, call {n}");
        assert_eq!(host.references(Some(references)), references, "{name}, call {n}");
    }
    unreachable!("the number of calls is finite")
}

/// Sweeps all cases on all hosts, and asserts that the reference count of each host's context is unchanged at the end.
fn sweep_all<'a>(hosts: &'a [Host], cases: impl Fn(&'a Host) -> Vec<Case<'a>>, failure: &Failure, least: u64) {
    for host in hosts {
        let [context, _] = host.references(None);
        let device = host.device();
        let only = std::env::var("LAYERSPLAT_CASE").unwrap_or_default();
        for case in cases(host).into_iter().filter(|case| case.name.contains(&only)) {
            let calls = sweep(host, &device, &case, failure);
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
    cases.push(cases::sliced(scene));
    cases.extend(cases::streamed(large));
    cases
}

/// A volume that is held as a whole, and one that is streamed.
fn scenes() -> [Scene; 2] {
    [SMALL, "builtin:marschner-lobb@72"].map(Scene::new)
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

/// A program that does not compile: the compiler's log is returned, and nothing of the program is kept.
#[test]
fn every_build_may_fail() {
    let scene = Scene::new(SMALL);
    for case in cases::frames(&scene) {
        // Programs are cached per device, so only a new device builds again.
        let host = Host::new(false);
        let device = host.device();
        device.fail(Call::Build, 1, CL_OUT_OF_RESOURCES);
        let mut draw = (case.make)(&device).unwrap();
        let error = draw().expect_err("its second program does not compile");
        assert!(device.recover() && (BUILDS.expected)(&error), "{}: {error}", case.name);
        assert_eq!(device.programs(), 1, "{}: only the program that was built is kept", case.name);
        let picture = draw().unwrap();
        assert!((case.make)(&host.device()).unwrap()().unwrap() == picture, "{}", case.name);
    }
}

/// If the kernels that make tables and occupancy never ran, these are made again.
#[test]
fn what_a_failed_frame_was_to_make_is_not_kept() {
    let scene = Scene::new(SMALL);
    let camera = scene.camera(80.0, None);
    for host in [false, true].map(Host::new) {
        for settings in [Settings::default(), Algorithm::Slicing { step: 0.8 }.into()] {
            let device = host.device();
            let new = || Renderer::new(&device, &scene.volume, &scene.transfer).unwrap();
            let size = crate::viewport::Viewport { width: 21, height: 17 };
            let (expected, _) = new().render(&camera, size, &settings).unwrap();
            let mut renderer = new();
            let picture = host.buffer(16 * size.pixels());
            let onto = super::PictureMemory::new(
                &crate::device::DeviceMemory::from_buffer(&picture).unwrap(),
                super::PictureFormat::Floats,
            );
            let user_event = opencl3::event::Event::new(opencl3::event::create_user_event(host.context.get()).unwrap());
            let failed = renderer.enqueue(&camera, size, &settings, &onto, &[&user_event]).unwrap();
            // Enqueued before the failure of the first frame is known.
            let after = renderer.enqueue(&camera, size, &settings, &onto, &[]).unwrap();
            opencl3::event::set_user_event_status(user_event.get(), -5).unwrap();
            assert!(failed.wait().is_err());
            // If commands are ordered by events, as on PoCL, this frame fails, too. Otherwise it is correct, because it has made
            // again what the first frame failed to make.
            if after.wait().is_ok() {
                let found = host.read(&picture, 16 * size.pixels(), &after);
                assert!(found == bytemuck::cast_slice::<_, u8>(expected.pixels()), "{settings:?}");
            }
            assert!(renderer.render(&camera, size, &settings).unwrap().0 == expected, "{settings:?}");
        }
    }
}
