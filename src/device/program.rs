//! Kernel programs: built with their log at hand, and kept.

use super::launch::structs;
use super::{Device, cache, sources};
use crate::error::Error;
use opencl3::error_codes::ClError;
use opencl3::kernel::Kernel;
use opencl3::program::Program;
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::time::Instant;

/// Built programs by file and `-D` options.
pub(super) type Programs = HashMap<(&'static str, String), Program>;

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

impl Device {
    /// A kernel object of its own; its program is built when first needed, and kept. `options`: further ones, `-D` most of all.
    pub(super) fn kernel(&self, file: &'static str, name: &str, options: &str) -> Result<Kernel, Error> {
        let key = (file, options.to_owned());
        let mut programs = self.shared.programs.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        let program = match programs.entry(key) {
            Entry::Occupied(built) => built.into_mut(),
            Entry::Vacant(place) => place.insert(self.build(file, options)?),
        };
        Kernel::create(program, name).map_err(|e| self.error("clCreateKernel", e))
    }

    /// Kernel files of which nothing was built on this device so far.
    #[cfg(test)]
    pub(crate) fn unbuilt_files(&self) -> Vec<&'static str> {
        let programs = self.shared.programs.lock().unwrap();
        let built: String = programs.keys().map(|(file, _)| sources::with_includes(file)).collect();
        sources::files().filter(|file| !built.contains(&format!("#line 1 \"{file}\""))).collect()
    }

    fn build(&self, file: &'static str, options: &str) -> Result<Program, Error> {
        let text = source(file);
        // A program that does not compile: its log is the compiler's own.
        #[cfg(test)]
        let text = match self.shared.faults.at(super::Call::Build) {
            Ok(()) => text,
            Err(e) => format!("#error told to fail with {e}\n{text}"),
        };
        let options = self::options(options);
        let mut program =
            Program::create_from_source(&self.shared.context, &text).map_err(|e| self.error("clCreateProgramWithSource", e))?;
        let ids = self.shared.context.devices();
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
        let built = || Error::Build { program, device: self.info().name.clone(), source, log };
        cache::unusable_cache(&self.info().platform).unwrap_or_else(built)
    }
}
