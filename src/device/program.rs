//! Kernel programs: built with their log at hand, each once, and kept.

use super::launch::structs;
use super::{Device, DeviceInfo, cache, sources};
use crate::error::Error;
use opencl3::context::Context;
use opencl3::device::Device as ClDevice;
use opencl3::error_codes::ClError;
use opencl3::kernel::Kernel;
use opencl3::program::Program;
use std::collections::HashMap;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::time::Instant;

/// Denormals cost 150 cycles each where specular powers and transmittances underflow; contraction lets a*b+c be one
/// instruction. Neither is allowed to change what NaN and infinity mean.
const OPTIONS: &str = "-cl-std=CL1.2 -cl-denorms-are-zero -cl-mad-enable";

/// Options that every kernel program is compiled with, whatever its own `-D` options are.
#[cfg(feature = "cli")]
pub(crate) fn compiler_options() -> &'static str {
    OPTIONS
}

/// What a compiler is given of a program in a file.
pub(super) fn source(file: &'static str) -> String {
    structs::typedefs() + &sources::with_includes(file)
}

/// And its options, where the program's own are these.
pub(super) fn options(own: &str) -> String {
    format!("{OPTIONS} {own}")
}

/// The programs of a context's device, built when they are first needed.
pub(super) struct Programs {
    pub info: DeviceInfo,
    pub context: Context,
    /// By file and `-D` options. Held only to look up a slot: other programs can be built at the same time.
    slots: Mutex<HashMap<(&'static str, String), Arc<Slot>>>,
    #[cfg(test)]
    pub faults: super::faults::Faults,
    /// Called with the file of each program when its build begins.
    #[cfg(test)]
    observer: Mutex<Option<Observer>>,
}

#[cfg(test)]
type Observer = Arc<dyn Fn(&'static str) + Send + Sync>;

/// A program that is built, or will be.
#[derive(Default)]
struct Slot {
    built: OnceLock<Program>,
    /// Held by the thread that builds it: the others wait for its result.
    building: Mutex<()>,
}

impl Programs {
    pub fn new(info: DeviceInfo, context: Context) -> Self {
        Self {
            info,
            context,
            slots: Mutex::default(),
            #[cfg(test)]
            faults: super::faults::Faults::default(),
            #[cfg(test)]
            observer: Mutex::default(),
        }
    }

    /// A kernel object; its program is built if it is not yet.
    pub fn kernel(&self, file: &'static str, name: &str, options: &str) -> Result<Kernel, Error> {
        let slot = self.slot(file, options);
        let program = match slot.built.get() {
            Some(built) => built,
            None => {
                let _building = slot.building.lock().unwrap_or_else(PoisonError::into_inner);
                match slot.built.get() {
                    Some(built) => built,
                    None => {
                        let built = self.build(file, options)?;
                        slot.built.get_or_init(|| built)
                    }
                }
            }
        };
        Kernel::create(program, name).map_err(|e| self.error("clCreateKernel", e))
    }

    /// Work-items that a group of a kernel can have: of the device's most, what its registers leave.
    pub fn largest_group(&self, kernel: &Kernel) -> Result<usize, Error> {
        let id = self.context.default_device();
        let of_kernel = kernel.get_work_group_size(id).map_err(|e| self.error("clGetKernelWorkGroupInfo", e))?;
        let of_axes = ClDevice::new(id).max_work_item_sizes().map_err(|e| self.error("clGetDeviceInfo", e))?;
        // Some say 0 of a kernel that they have not compiled yet; one work-item always goes.
        Ok(of_axes.first().map_or(of_kernel, |&along_x| of_kernel.min(along_x)).max(1))
    }

    /// How many are built.
    pub fn count(&self) -> usize {
        self.slots.lock().unwrap_or_else(PoisonError::into_inner).values().filter(|slot| slot.built.get().is_some()).count()
    }

    pub fn error(&self, call: &'static str, source: ClError) -> Error {
        Error::OpenCl { call, device: self.info.name.clone(), source }
    }

    fn slot(&self, file: &'static str, options: &str) -> Arc<Slot> {
        let mut slots = self.slots.lock().unwrap_or_else(PoisonError::into_inner);
        slots.entry((file, options.to_owned())).or_default().clone()
    }

    fn build(&self, file: &'static str, options: &str) -> Result<Program, Error> {
        #[cfg(test)]
        self.observe(file);
        let text = source(file);
        // A program that does not compile: its log is the compiler's own.
        #[cfg(test)]
        let text = match self.faults.at(super::Call::Build) {
            Ok(()) => text,
            Err(e) => format!("#error told to fail with {e}\n{text}"),
        };
        let options = self::options(options);
        let mut program =
            Program::create_from_source(&self.context, &text).map_err(|e| self.error("clCreateProgramWithSource", e))?;
        let ids = self.context.devices();
        let started = Instant::now();
        let built = program.build(ids, &options);
        let taken = started.elapsed();
        tracing::debug!("built {file} in {:.0} ms: {options}", taken.as_secs_f64() * 1e3);
        #[cfg(feature = "cli")]
        crate::progress::add_building(taken);
        let log = program.get_build_log(ids[0]).unwrap_or_default();
        if let Err(e) = built {
            return Err(self.not_built(file, e, log));
        }
        let warned = log.contains("warning:");
        if warned {
            tracing::warn!("{file}, {options}: {log}");
        }
        // The tests build every kernel with all that there is.
        #[cfg(test)]
        assert!(!warned, "{file}: {log}");
        Ok(program)
    }

    /// Why a program was not built. PoCL's log does not say that it could not write the result.
    fn not_built(&self, program: &'static str, source: ClError, log: String) -> Error {
        let built = || Error::Build { program, device: self.info.name.clone(), source, log };
        cache::unusable_cache(&self.info.platform).unwrap_or_else(built)
    }
}

impl Device {
    /// A kernel object of its own; its program is built when first needed, and kept. `options`: further ones, `-D` most of all.
    pub(super) fn kernel(&self, file: &'static str, name: &str, options: &str) -> Result<Kernel, Error> {
        self.shared.programs.kernel(file, name, options)
    }
}

#[cfg(test)]
impl Programs {
    fn observe(&self, file: &'static str) {
        let observer = self.observer.lock().unwrap_or_else(PoisonError::into_inner).clone();
        if let Some(observer) = observer {
            observer(file);
        }
    }
}

#[cfg(test)]
impl Device {
    /// Kernel files of which nothing was built on this device so far.
    pub(crate) fn unbuilt_files(&self) -> Vec<&'static str> {
        let slots = self.shared.programs.slots.lock().unwrap();
        let built = slots.iter().filter(|(_, slot)| slot.built.get().is_some());
        let built: String = built.map(|((file, _), _)| sources::with_includes(file)).collect();
        sources::files().filter(|file| !built.contains(&format!("#line 1 \"{file}\""))).collect()
    }

    /// Calls `observer` with the file of each program whose build begins from now on.
    pub(super) fn observe_builds(&self, observer: impl Fn(&'static str) + Send + Sync + 'static) {
        *self.shared.programs.observer.lock().unwrap() = Some(Arc::new(observer));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::device::DeviceChoice;
    use std::sync::Condvar;
    use std::sync::atomic::{AtomicUsize, Ordering};
    use std::time::Duration;

    /// Long enough for another thread to begin its build on a busy machine.
    const PATIENCE: Duration = Duration::from_secs(20);
    /// Kernels of few lines, with no options.
    const SMALL: [(&str, &str); 2] = [("layered/table.cl", "table"), ("volume/shown_slabs.cl", "shown_slabs")];

    fn device() -> Device {
        Device::open(&DeviceChoice::Default).expect("the tests need an OpenCL device: scripts/test installs PoCL")
    }

    fn build_at_once(device: &Device, kernels: [(&'static str, &'static str); 2]) {
        std::thread::scope(|scope| {
            for (file, name) in kernels {
                scope.spawn(move || device.kernel(file, name, "-DVW=1").map(drop).unwrap());
            }
        });
    }

    #[test]
    fn different_programs_are_built_at_the_same_time() {
        let device = device();
        let meeting = Arc::new((Mutex::new(0), Condvar::new()));
        let met = Arc::new(AtomicUsize::new(0));
        let (theirs, count) = (meeting.clone(), met.clone());
        device.observe_builds(move |_| {
            let (building, changed) = &*theirs;
            *building.lock().unwrap() += 1;
            changed.notify_all();
            let (building, waited) =
                changed.wait_timeout_while(building.lock().unwrap(), PATIENCE, |building| *building < 2).unwrap();
            drop(building);
            count.fetch_add(usize::from(!waited.timed_out()), Ordering::Relaxed);
        });
        build_at_once(&device, SMALL);
        assert_eq!(met.load(Ordering::Relaxed), 2, "each build begins while the other one is not over");
        assert_eq!(device.programs(), 2);
    }

    #[test]
    fn a_program_that_two_threads_need_is_built_once() {
        let device = device();
        let builds = Arc::new(AtomicUsize::new(0));
        let count = builds.clone();
        device.observe_builds(move |_| {
            count.fetch_add(1, Ordering::Relaxed);
            // The other thread has time to ask for it, too.
            std::thread::sleep(Duration::from_millis(200));
        });
        build_at_once(&device, [SMALL[0]; 2]);
        assert_eq!((builds.load(Ordering::Relaxed), device.programs()), (1, 1));
    }

    #[test]
    fn a_program_that_failed_is_built_again() {
        let device = device();
        device.fail(crate::device::Call::Build, 0, opencl3::error_codes::CL_BUILD_PROGRAM_FAILURE);
        let [(file, name), _] = SMALL;
        assert!(device.kernel(file, name, "-DVW=1").is_err());
        assert_eq!(device.programs(), 0);
        device.recover();
        device.kernel(file, name, "-DVW=1").unwrap();
        assert_eq!(device.programs(), 1);
    }
}
