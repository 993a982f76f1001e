//! Kernel programs: sources compiled into the binary, built with their log at hand.

use super::Device;
use super::launch::params;
use crate::error::Error;
use opencl3::kernel::Kernel;
use opencl3::program::Program;
use std::collections::HashMap;
use std::collections::hash_map::Entry;

/// Built programs by files and `-D` options.
pub(super) type Programs = HashMap<(&'static [&'static str], String), Program>;

/// A kernel file with the shared files it needs.
pub(super) struct Source {
    /// Name of the file, and of the kernel in it.
    pub name: &'static str,
    /// Files in order, the last one holding the kernel.
    pub files: &'static [&'static str],
}

/// `source!("name", "shared"…)`: kernels/name.cl after vector.cl and the shared files.
macro_rules! source {
    ($name:literal $(, $shared:literal)*) => {
        $crate::device::program::Source {
            name: $name,
            files: &[
                include_str!("../../../kernels/vector.cl"),
                $(include_str!(concat!("../../../kernels/", $shared, ".cl")),)*
                include_str!(concat!("../../../kernels/", $name, ".cl")),
            ],
        }
    };
}
pub(super) use source;

/// Denormals cost 150 cycles each where specular powers and transmittances underflow; contraction lets a*b+c be one
/// instruction. Neither is allowed to change what NaN and infinity mean.
const OPTIONS: &str = "-cl-std=CL1.2 -cl-denorms-are-zero -cl-mad-enable";

impl Device {
    /// A kernel of its own; its program is built when first needed, and kept. `defines` are further `-D` options.
    pub(super) fn kernel(&self, source: &Source, defines: &str) -> Result<Kernel, Error> {
        let key = (source.files, defines.to_owned());
        let mut programs = self.inner.programs.borrow_mut();
        let program = match programs.entry(key) {
            Entry::Occupied(built) => built.into_mut(),
            Entry::Vacant(place) => place.insert(self.build(source, defines)?),
        };
        Kernel::create(program, source.name).map_err(|e| self.error("clCreateKernel", e))
    }

    fn build(&self, source: &Source, defines: &str) -> Result<Program, Error> {
        let text = source.files.concat();
        let options = format!("{OPTIONS} {} {defines}", params::size_defines());
        let mut program =
            Program::create_from_source(&self.inner.context, &text).map_err(|e| self.error("clCreateProgramWithSource", e))?;
        let ids = self.inner.context.devices();
        match program.build(ids, &options) {
            Ok(()) => Ok(program),
            Err(e) => Err(Error::Build {
                program: source.name,
                device: self.info().name.clone(),
                source: e,
                log: program.get_build_log(ids[0]).unwrap_or_default(),
            }),
        }
    }
}
