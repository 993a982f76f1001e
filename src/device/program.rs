//! Kernel programs: each is built once and kept; errors include the build log.

use super::launch::structs;
use super::{Device, DeviceInfo, cache, sources};
use crate::error::Error;
use crate::progress::count_build;
use opencl3::context::Context;
use opencl3::device::Device as ClDevice;
use opencl3::error_codes::ClError;
use opencl3::kernel::Kernel;
use opencl3::program::Program;
use std::collections::HashMap;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::time::Instant;

/// Each denormal costs 150 cycles when specular powers and transmittances underflow. Contraction makes a*b+c one instruction. No
/// option may change the meaning of NaN and infinity. With debug assertions, launchers compare the arguments of kernels with their own.
const OPTIONS: &str = if cfg!(debug_assertions) {
    "-cl-std=CL1.2 -cl-denorms-are-zero -cl-mad-enable -cl-kernel-arg-info"
} else {
    "-cl-std=CL1.2 -cl-denorms-are-zero -cl-mad-enable"
};

/// Options common to all kernel programs, without their `-D` options.
#[cfg(feature = "cli")]
pub(crate) fn compiler_options() -> &'static str {
    OPTIONS
}

/// Clang warns of functions with vectors that are wider than the registers, since their calling convention depends on the processor.
/// All functions of a program are compiled for the same processor.
const WARNINGS: &str = "#ifdef __has_warning
#if __has_warning(\"-Wpsabi\")
#pragma clang diagnostic ignored \"-Wpsabi\"
#endif
#endif
";

/// Complete source text of the program in a kernel file.
pub(super) fn source(file: &'static str) -> String {
    WARNINGS.to_owned() + &structs::typedefs() + &sources::with_includes(file)
}

/// All compiler options of a program, given its `-D` options.
pub(super) fn options(own: &str) -> String {
    format!("{OPTIONS} {own}")
}

/// The programs of a device in a context, built on first use.
pub(super) struct Programs {
    pub info: DeviceInfo,
    pub context: Context,
    /// By file and `-D` options. Locked only to look up a slot, so that programs can be built concurrently.
    slots: Mutex<HashMap<(&'static str, String), Arc<Slot>>>,
    #[cfg(test)]
    pub faults: super::faults::Faults,
    /// Called with the file of each program whose build begins.
    #[cfg(test)]
    observer: Mutex<Option<Observer>>,
    /// Edits the text of each program.
    #[cfg(test)]
    editor: Mutex<Option<Editor>>,
}

#[cfg(test)]
type Observer = Arc<dyn Fn(&'static str) + Send + Sync>;
#[cfg(test)]
type Editor = Arc<dyn Fn(String) -> String + Send + Sync>;

/// A program, built or not.
#[derive(Default)]
struct Slot {
    built: OnceLock<Program>,
    /// Locked by the thread that builds the program, while others wait for its result.
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
            #[cfg(test)]
            editor: Mutex::default(),
        }
    }

    /// Creates a kernel object, and builds its program if necessary.
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

    /// Maximum work-group size of a kernel: the device limit, reduced by the kernel's register use.
    pub fn largest_group(&self, kernel: &Kernel) -> Result<usize, Error> {
        let id = self.context.default_device();
        let kernel_limit = kernel.get_work_group_size(id).map_err(|e| self.error("clGetKernelWorkGroupInfo", e))?;
        let axis_limits = ClDevice::new(id).max_work_item_sizes().map_err(|e| self.error("clGetDeviceInfo", e))?;
        // Some drivers return 0 for a kernel that they have not compiled yet; one work-item is always possible.
        Ok(axis_limits.first().map_or(kernel_limit, |&along_x| kernel_limit.min(along_x)).max(1))
    }

    /// Number of built programs.
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
        #[cfg(test)]
        let text = self.edited(text);
        // An injected fault makes the program invalid, so that the log is a real one.
        #[cfg(test)]
        let text = match self.faults.at(super::Call::Build) {
            Ok(()) => text,
            Err(e) => format!("#error injected fault {e}\n{text}"),
        };
        let options = self::options(options);
        let mut program =
            Program::create_from_source(&self.context, &text).map_err(|e| self.error("clCreateProgramWithSource", e))?;
        let ids = self.context.devices();
        let started = Instant::now();
        let built = count_build(|| program.build(ids, &options));
        tracing::debug!("built {file} in {:.0} ms: {options}", started.elapsed().as_secs_f64() * 1e3);
        let log = program.get_build_log(ids[0]).unwrap_or_default();
        if let Err(e) = built {
            return Err(self.build_error(file, e, log));
        }
        let has_warnings = log.contains("warning:");
        if has_warnings {
            tracing::warn!("{file}, {options}: {log}");
        }
        // Tests build every kernel with all its options.
        #[cfg(test)]
        assert!(!has_warnings, "{file}: {log}");
        Ok(program)
    }

    /// The error for a failed build. PoCL's log does not mention an unwritable cache folder, so that is checked here.
    fn build_error(&self, program: &'static str, source: ClError, log: String) -> Error {
        let error = || Error::Build { program, device: self.info.name.clone(), source, log };
        cache::unusable_cache(&self.info.platform).unwrap_or_else(error)
    }
}

impl Device {
    /// Creates a new kernel object; its program is built on first use and kept. `options`: its `-D` options.
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

    fn edited(&self, text: String) -> String {
        let editor = self.editor.lock().unwrap_or_else(PoisonError::into_inner).clone();
        editor.map_or(text.clone(), |edit| edit(text))
    }
}

#[cfg(test)]
impl Device {
    /// Kernel files that are not part of any program built on this device so far.
    pub(crate) fn unbuilt_files(&self) -> Vec<&'static str> {
        let slots = self.shared.programs.slots.lock().unwrap();
        let built = slots.iter().filter(|(_, slot)| slot.built.get().is_some());
        let built: String = built.map(|((file, _), _)| sources::with_includes(file)).collect();
        sources::files().filter(|file| !built.contains(&format!("#line 1 \"{file}\""))).collect()
    }

    /// Passes the text of each program through `edit` before it is built.
    pub(crate) fn edit_sources(&self, edit: impl Fn(String) -> String + Send + Sync + 'static) {
        *self.shared.programs.editor.lock().unwrap() = Some(Arc::new(edit));
    }

    /// Calls `observer` with the file of each program, when its build begins.
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

    /// Time for another thread to begin its build on a busy machine.
    const PATIENCE: Duration = Duration::from_secs(20);
    /// Small kernels that need no options.
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
    fn different_programs_are_built_concurrently() {
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
        assert_eq!(met.load(Ordering::Relaxed), 2, "each build begins before the other one ends");
        assert_eq!(device.programs(), 2);
    }

    #[test]
    fn a_program_that_two_threads_need_is_built_once() {
        let device = device();
        let builds = Arc::new(AtomicUsize::new(0));
        let count = builds.clone();
        device.observe_builds(move |_| {
            count.fetch_add(1, Ordering::Relaxed);
            // Time for the other thread to request the program, too.
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
