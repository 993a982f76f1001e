//! The `layersplat` command.

fn main() -> std::process::ExitCode {
    // SAFETY: no other thread runs yet, so environment variables may be set.
    unsafe {
        layersplat::device::pin_cpu_threads();
        layersplat::device::keep_compiled_kernels();
    }
    if let Some(code) = layersplat::device::compile_for_parent() {
        return code;
    }
    layersplat::cli::main()
}
