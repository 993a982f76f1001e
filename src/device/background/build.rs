//! Builds a kernel completely, including the parts that drivers compile at its first launch.

use crate::device::launch::KernelRequest;
use crate::device::program::Programs;
use crate::error::Error;
use opencl3::command_queue::CommandQueue;
use opencl3::kernel::{Kernel, set_kernel_arg};
use opencl3::memory::{Buffer as ClBuffer, CL_MEM_READ_WRITE, ClMem, cl_mem};

/// Bytes of the placeholder for buffer arguments in a launch without work.
const PLACEHOLDER_BYTES: usize = 4096;

/// Builds a kernel and launches it without work. PoCL compiles most of a kernel at its first launch, for each work-group size.
pub(super) fn build(programs: &Programs, launcher: &mut Option<EmptyLauncher>, request: &KernelRequest) -> Result<(), Error> {
    let kernel = programs.kernel(request.file, &request.kernel, &request.defines)?;
    let launcher = match launcher {
        Some(launcher) => launcher,
        empty => empty.insert(EmptyLauncher::new(programs)?),
    };
    launcher.launch(programs, &kernel, request)
}

/// A queue and a placeholder buffer for launches without work.
pub(super) struct EmptyLauncher {
    queue: CommandQueue,
    placeholder: ClBuffer<u8>,
}

impl EmptyLauncher {
    fn new(programs: &Programs) -> Result<Self, Error> {
        #[allow(deprecated)] // The replacement needs OpenCL 2.0.
        let queue = CommandQueue::create_default(&programs.context, 0).map_err(|e| programs.error("clCreateCommandQueue", e))?;
        // SAFETY: no host pointer is given.
        let placeholder =
            unsafe { ClBuffer::create(&programs.context, CL_MEM_READ_WRITE, PLACEHOLDER_BYTES, std::ptr::null_mut()) };
        Ok(Self { queue, placeholder: placeholder.map_err(|e| programs.error("clCreateBuffer", e))? })
    }

    /// Launches a kernel with all values 0. Sizes of 0 leave it no work, and every kernel returns at once in excess work-items.
    fn launch(&self, programs: &Programs, kernel: &Kernel, request: &KernelRequest) -> Result<(), Error> {
        self.set_zero_arguments(kernel, &request.arguments).map_err(|e| programs.error("clSetKernelArg", e))?;
        let group = request.group.min(programs.largest_group(kernel)?);
        let items = KernelRequest::SMALL_GRID;
        let global = if request.wide { (items + 1).next_multiple_of(group) } else { (items / group).max(1) * group };
        // SAFETY: the sizes outlive the call, and every argument is set.
        let event = unsafe { self.queue.enqueue_nd_range_kernel(kernel.get(), 1, std::ptr::null(), &global, &group, &[]) };
        let event = event.map_err(|e| programs.error("clEnqueueNDRangeKernel", e))?;
        event.wait().map_err(|e| programs.error("clWaitForEvents", e))
    }

    /// `sizes`: the bytes of each value, and 0 for each buffer.
    fn set_zero_arguments(&self, kernel: &Kernel, sizes: &[usize]) -> opencl3::Result<()> {
        let placeholder = self.placeholder.get();
        let largest = sizes.iter().copied().max().unwrap_or(0);
        // 16-byte alignment suffices for every argument type.
        let zeros = vec![0u128; largest.div_ceil(size_of::<u128>())];
        for (index, &bytes) in (0..).zip(sizes) {
            let (bytes, value) = match bytes {
                0 => (size_of::<cl_mem>(), (&raw const placeholder).cast()),
                bytes => (bytes, zeros.as_ptr().cast()),
            };
            // SAFETY: `value` points to a live buffer handle or to at least `bytes` zero bytes.
            unsafe { set_kernel_arg(kernel.get(), index, bytes, value) }?;
        }
        Ok(())
    }
}
