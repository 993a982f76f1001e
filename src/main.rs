//! The command `layersplat`.

fn main() -> std::process::ExitCode {
    // SAFETY: nothing has started a thread yet.
    unsafe {
        layersplat::device::pin_cpu_threads();
        layersplat::device::keep_compiled_kernels();
    }
    if let Some(done) = layersplat::device::compile_for_parent() {
        return done;
    }
    layersplat::cli::main()
}
