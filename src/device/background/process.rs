//! A child process that compiles kernels for this one, if compiling in this process would delay frames.
//!
//! PoCL compiles most of a kernel at its first launch, under a lock that every kernel launch takes. Frames thus wait for kernels
//! that another thread compiles. The child process writes to PoCL's cache of compiled kernels, and this process only loads the
//! results.

use super::build::build;
use crate::device::launch::KernelRequest;
use crate::device::{Device, DeviceChoice, DeviceInfo, sources};
use crate::error::Error;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::io::{self, BufRead, BufReader, Write};
use std::process::{Child, ChildStdin, ChildStdout, Command, ExitCode, Stdio};
use std::sync::{Mutex, PoisonError};

/// Environment variable with the device to compile for, as JSON.
const VARIABLE: &str = "LAYERSPLAT_COMPILES_FOR";
/// The child's answer when a kernel is compiled.
const DONE: &str = "done";

/// Identifies the device in both processes.
#[derive(Serialize, Deserialize, PartialEq)]
struct DeviceName {
    platform: String,
    name: String,
}

impl DeviceName {
    fn new(info: &DeviceInfo) -> Self {
        Self { platform: info.platform.clone(), name: info.name.clone() }
    }
}

/// A [`KernelRequest`] as sent to the child process.
#[derive(Serialize, Deserialize)]
struct Message {
    file: String,
    kernel: String,
    defines: String,
    group: usize,
    wide: bool,
    arguments: Vec<usize>,
}

/// A child process that compiles kernels, and its pipes. Dropping this ends the process.
pub(super) struct CompilerProcess {
    process: Mutex<Child>,
    pipes: Mutex<(ChildStdin, BufReader<ChildStdout>)>,
}

impl CompilerProcess {
    /// Starts a process whose program calls [`compile_for_parent`].
    pub fn start(mut command: Command, info: &DeviceInfo) -> io::Result<Self> {
        command.env(VARIABLE, serde_json::to_string(&DeviceName::new(info))?);
        let mut process = command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::null()).spawn()?;
        let pipes = process.stdin.take().zip(process.stdout.take()).ok_or(io::ErrorKind::BrokenPipe)?;
        Ok(Self { process: Mutex::new(process), pipes: Mutex::new((pipes.0, BufReader::new(pipes.1))) })
    }

    /// Lets the process compile a kernel, and waits for its answer.
    pub fn compile(&self, request: &KernelRequest) -> io::Result<()> {
        let KernelRequest { file, kernel, defines, group, wide, arguments } = request.clone();
        let message = Message { file: file.into(), kernel: kernel.into(), defines, group, wide, arguments };
        let mut pipes = self.pipes.lock().unwrap_or_else(PoisonError::into_inner);
        let (to, from) = &mut *pipes;
        writeln!(to, "{}", serde_json::to_string(&message)?)?;
        to.flush()?;
        let mut answer = String::new();
        from.read_line(&mut answer)?;
        if answer.trim() == DONE { Ok(()) } else { Err(io::Error::other(answer)) }
    }

    /// Ends the process. A pending [`compile`](Self::compile) returns an error.
    pub fn end(&self) {
        let mut process = self.process.lock().unwrap_or_else(PoisonError::into_inner);
        // Fails if the process has already ended.
        let _ = process.kill();
        let _ = process.wait();
    }
}

impl Drop for CompilerProcess {
    fn drop(&mut self) {
        self.end();
    }
}

/// Compiles kernels for the parent process ([`Device::set_compiler_command`]) until the parent closes the pipe, and returns the
/// exit code. In a process that was not started for this, returns `None` at once. Call it first in `main`.
///
/// ```
/// fn main() -> std::process::ExitCode {
///     if let Some(exit_code) = layersplat::device::compile_for_parent() {
///         return exit_code;
///     }
///     // The program itself.
///     std::process::ExitCode::SUCCESS
/// }
/// ```
pub fn compile_for_parent() -> Option<ExitCode> {
    let device = std::env::var(VARIABLE).ok()?;
    Some(match serve(&device) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            // The parent logs this as the answer to its first request.
            let _ = writeln!(io::stdout(), "{error}");
            ExitCode::FAILURE
        }
    })
}

fn serve(device: &str) -> Result<(), Error> {
    let invalid = |what: &str| Error::Settings { field: VARIABLE, problem: format!("{what} is not a request of this version") };
    let wanted: DeviceName = serde_json::from_str(device).map_err(|_| invalid(device))?;
    let found = Device::list()?.into_iter().find(|info| DeviceName::new(info) == wanted);
    let index = found.and_then(|info| info.index).ok_or_else(|| invalid(&wanted.name))?;
    let device = Device::open(&DeviceChoice::Named(index.to_string()))?;
    let mut launcher = None;
    for line in io::stdin().lock().lines() {
        let Ok(line) = line else { break };
        let answer = match serde_json::from_str(&line).ok().and_then(request) {
            Some(request) => build(&device.shared.programs, &mut launcher, &request),
            None => Err(invalid(&line)),
        };
        let answer = answer.map_or_else(|error| error.to_string().replace('\n', " "), |()| DONE.into());
        let mut out = io::stdout().lock();
        // The parent has closed the pipe.
        if writeln!(out, "{answer}").and_then(|()| out.flush()).is_err() {
            break;
        }
    }
    Ok(())
}

/// The request in a message; `None` if there is no such kernel file.
fn request(message: Message) -> Option<KernelRequest> {
    let Message { file, kernel, defines, group, wide, arguments } = message;
    let file = sources::files().find(|known| *known == file)?;
    Some(KernelRequest { file, kernel: Cow::Owned(kernel), defines, group, wide, arguments })
}
