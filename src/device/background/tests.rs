//! Programs built in the background: once, with errors reported, and not after the device is gone.

use crate::device::launch::KernelRequest;
use crate::device::{Call, Device, DeviceChoice};
use crate::error::Error;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc;
use std::time::Duration;

/// Longer than a small build takes on a busy machine.
const PATIENCE: Duration = Duration::from_secs(60);

fn device() -> Device {
    Device::open(&DeviceChoice::Default).expect("the tests need an OpenCL device: scripts/test installs PoCL")
}

/// A small kernel.
fn small() -> KernelRequest {
    let arguments = vec![0, size_of::<f32>(), size_of::<i32>(), size_of::<i32>(), 0, size_of::<u64>()];
    KernelRequest {
        file: "layered/table.cl",
        kernel: "table".into(),
        defines: "-DVW=1".into(),
        group: 64,
        wide: false,
        arguments,
    }
}

/// Builds kernels in the background and waits for the result.
fn build(device: &Device, kernels: Vec<KernelRequest>) -> Result<(), Error> {
    let (sender, receiver) = mpsc::channel();
    device.build_ahead(move || Ok(kernels), move |built| sender.send(built).unwrap());
    receiver.recv_timeout(PATIENCE).expect("a result")
}

#[test]
fn programs_built_ahead_are_not_built_again() {
    let device = device();
    let builds = Arc::new(AtomicUsize::new(0));
    let count = builds.clone();
    device.observe_builds(move |_| {
        count.fetch_add(1, Ordering::Relaxed);
    });
    build(&device, vec![small(), KernelRequest { wide: true, ..small() }, small()]).unwrap();
    build(&device, vec![small()]).unwrap();
    build(&device, Vec::new()).unwrap();
    device.kernel("layered/table.cl", "table", "-DVW=1").unwrap();
    assert_eq!(builds.load(Ordering::Relaxed), 1);
}

#[test]
fn a_failure_is_reported_and_the_other_programs_are_built() {
    let device = device();
    device.fail(Call::Build, 0, opencl3::error_codes::CL_BUILD_PROGRAM_FAILURE);
    let other = KernelRequest { defines: "-DVW=1 -DOTHER".into(), ..small() };
    assert!(matches!(build(&device, vec![small(), other]), Err(Error::Build { .. })));
    device.recover();
    assert_eq!(device.programs(), 1);
    let error = Error::NotBuilt { program: "unknown kernels", problem: "nobody knows them" };
    let (sender, receiver) = mpsc::channel();
    let builds = device.build_ahead(move || Err(error), move |built| sender.send(built).unwrap());
    builds.wait();
    assert!(receiver.recv_timeout(PATIENCE).unwrap().is_err() && builds.is_ready());
}

#[test]
fn a_job_that_panics_fails_and_later_ones_are_done() {
    let device = device();
    let (sender, receiver) = mpsc::channel();
    let builds = device.build_ahead(|| panic!("an expected panic"), move |built| sender.send(built).unwrap());
    assert!(matches!(receiver.recv_timeout(PATIENCE), Ok(Err(Error::NotBuilt { .. }))) && builds.is_ready());
    let panics = Arc::new(AtomicUsize::new(1));
    device.observe_builds(move |_| assert_eq!(panics.swap(0, Ordering::Relaxed), 0, "an expected panic"));
    assert!(matches!(build(&device, vec![small()]), Err(Error::NotBuilt { program: "layered/table.cl", .. })));
    build(&device, vec![small()]).unwrap();
}

#[test]
fn dropping_the_device_abandons_waiting_builds() {
    let device = device();
    let (begin, begun) = mpsc::channel();
    device.observe_builds(move |_| {
        begin.send(()).unwrap();
        // The next build must not begin before the device is dropped.
        std::thread::sleep(Duration::from_millis(300));
    });
    let (sender, receiver) = mpsc::channel();
    let others = (0..50).map(|n| KernelRequest { defines: format!("-DVW=1 -DOTHER={n}"), ..small() });
    let builds = device.build_ahead(move || Ok(others.collect()), move |built| sender.send(built).unwrap());
    begun.recv_timeout(PATIENCE).expect("a build begins");
    drop(device);
    assert!(matches!(receiver.recv_timeout(PATIENCE), Ok(Err(Error::NotBuilt { .. }))));
    builds.wait();
    assert!(begun.try_iter().count() < 10, "builds continue");
}

#[test]
fn the_last_device_may_be_dropped_on_the_build_thread() {
    let device = device();
    let (sender, receiver) = mpsc::channel();
    let last = device.clone();
    device.build_ahead(
        move || Ok(vec![small()]),
        move |_| {
            drop(last);
            sender.send(()).unwrap();
        },
    );
    drop(device);
    receiver.recv_timeout(PATIENCE).expect("a result");
}
