//! The command `layersplat`.

fn main() -> std::process::ExitCode {
    // SAFETY: nothing has started a thread yet.
    unsafe { layersplat::device::pin_cpu_threads() };
    layersplat::cli::main()
}
