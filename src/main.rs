//! The command `layersplat`.

fn main() -> std::process::ExitCode {
    layersplat::cli::main()
}
