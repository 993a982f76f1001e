//! The command line: a thin skin over the library.

mod algorithm;
mod bench;
mod blending;
mod check;
mod compare;
mod convert;
mod devices;
mod fields;
mod info;
mod options;
mod paper;
mod parse;
mod render;
mod rotate;
mod scene;
#[cfg(unix)]
mod signals;
mod tune;
mod viewer;

use crate::error::Error;
use clap::{Parser, Subcommand};
use serde::Serialize;
use std::io::IsTerminal;
use std::path::Path;
use std::process::ExitCode;

/// Volume rendering by layered splatting, on any OpenCL device.
#[derive(Parser)]
#[command(name = "layersplat", version, propagate_version = true)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Render a volume to a .png or .npy picture
    Render(render::Arguments),
    /// Render a full turn about the y axis to numbered PNGs
    Rotate(rotate::Arguments),
    /// Tell dimensions, type, range and histogram of a volume
    Info(info::Arguments),
    /// Write a volume to a file of another format, voxels in the type that they have
    Convert(convert::Arguments),
    /// List platforms and devices, with the tuning that would be used
    Devices(devices::Arguments),
    /// Tell how far two pictures differ
    Compare(compare::Arguments),
    /// Time a full turn about the y axis
    Bench(bench::Arguments),
    /// Measure which tuning values this device is fastest with, and print them
    Tune(tune::Arguments),
    /// Repeat the experiments of the paper
    Paper(paper::Arguments),
    /// What other commands start to check a device
    #[command(name = check::child::NAME, hide = true)]
    CheckDevice(check::child::Arguments),
}

/// Runs the command line of this process. Exit code 2 for a bad command line, 1 for anything else that fails.
pub fn main() -> ExitCode {
    log();
    #[cfg(unix)]
    signals::let_files_be_finished();
    let done = match Cli::parse().command {
        Command::Render(arguments) => render::run(&arguments),
        Command::Rotate(arguments) => rotate::run(&arguments),
        Command::Info(arguments) => info::run(&arguments),
        Command::Convert(arguments) => convert::run(&arguments),
        Command::Devices(arguments) => devices::run(&arguments),
        Command::Compare(arguments) => compare::run(&arguments),
        Command::Bench(arguments) => bench::run(&arguments),
        Command::Tune(arguments) => tune::run(&arguments),
        Command::Paper(arguments) => paper::run(&arguments),
        Command::CheckDevice(arguments) => check::child::run(&arguments),
    };
    done.unwrap_or_else(|error| {
        eprintln!("layersplat: {}", fields::with_options(&error));
        ExitCode::from(exit_code(&error))
    })
}

/// Warnings, or what RUST_LOG asks for, to standard error.
fn log() {
    let filter = tracing_subscriber::EnvFilter::try_from_default_env().unwrap_or_else(|_| "warn".into());
    // Colours for those who look at a terminal, unless they would rather have none (no-color.org).
    let unwanted = std::env::var_os("NO_COLOR").is_some_and(|value| !value.is_empty());
    let colors = std::io::stderr().is_terminal() && !unwanted;
    let builder = tracing_subscriber::fmt().with_env_filter(filter).with_writer(std::io::stderr).with_ansi(colors);
    builder.without_time().with_target(false).init();
}

/// 2 where the command line itself is at fault.
fn exit_code(error: &Error) -> u8 {
    match error {
        Error::OutOfRange { .. }
        | Error::UnknownName { .. }
        | Error::Settings { .. }
        | Error::Camera { .. }
        | Error::MemoryBudget { .. } => 2,
        _ => 1,
    }
}

/// Prints a report: as one line of JSON, or as text.
fn report(json: bool, value: &impl Serialize, text: impl FnOnce() -> String) -> Result<(), Error> {
    use std::io::{ErrorKind, Write};
    let line = if json { serde_json::to_string(value).expect("reports are plain data") } else { text() };
    let mut out = std::io::stdout();
    match writeln!(out, "{}", line.trim_end()).and_then(|()| out.flush()) {
        // A reader that went away (`| head`) is no error of ours.
        Err(e) if e.kind() != ErrorKind::BrokenPipe => Err(Error::write(Path::new("standard output"), e)),
        _ => Ok(()),
    }
}
