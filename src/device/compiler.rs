//! Another process that compiles kernels for this one, where compiling in this process would hold up frames.
//!
//! PoCL compiles most of a kernel when it is first started, under a lock that every start of any kernel takes: frames wait for kernels that
//! another thread compiles. What another process compiles is in PoCL's folder of compiled kernels, and is only loaded here.

use super::ahead;
use super::launch::KernelRequest;
use super::{Device, DeviceChoice, DeviceInfo, sources};
use crate::error::Error;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::io::{self, BufRead, BufReader, Write};
use std::process::{Child, ChildStdin, ChildStdout, Command, ExitCode, Stdio};
use std::sync::{Mutex, PoisonError};

/// Names the device for which a process compiles kernels, as JSON.
const VARIABLE: &str = "LAYERSPLAT_COMPILES_FOR";
/// What the process says of a kernel that is compiled.
const DONE: &str = "done";

/// The device of both processes.
#[derive(Serialize, Deserialize, PartialEq)]
struct Named {
    platform: String,
    name: String,
}

impl Named {
    fn new(info: &DeviceInfo) -> Self {
        Self { platform: info.platform.clone(), name: info.name.clone() }
    }
}

/// A kernel, on its way to the other process.
#[derive(Serialize, Deserialize)]
struct Message {
    file: String,
    kernel: String,
    defines: String,
    group: usize,
    wide: bool,
    arguments: Vec<usize>,
}

/// A process that compiles kernels, and how to talk to it. It is ended when this is dropped.
pub(super) struct Compiler {
    process: Mutex<Child>,
    pipes: Mutex<(ChildStdin, BufReader<ChildStdout>)>,
}

impl Compiler {
    /// Starts a process by a command whose program calls [`compile_for_parent`].
    pub fn start(mut command: Command, info: &DeviceInfo) -> io::Result<Self> {
        command.env(VARIABLE, serde_json::to_string(&Named::new(info))?);
        let mut process = command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::null()).spawn()?;
        let pipes = process.stdin.take().zip(process.stdout.take()).ok_or(io::ErrorKind::BrokenPipe)?;
        Ok(Self { process: Mutex::new(process), pipes: Mutex::new((pipes.0, BufReader::new(pipes.1))) })
    }

    /// Lets it compile a kernel, and waits for that.
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

    /// Ends the process: what waits for its answer gets an error.
    pub fn end(&self) {
        let mut process = self.process.lock().unwrap_or_else(PoisonError::into_inner);
        // It may have ended by itself.
        let _ = process.kill();
        let _ = process.wait();
    }
}

impl Drop for Compiler {
    fn drop(&mut self) {
        self.end();
    }
}

/// In a process that was started to compile kernels for another one ([`Device::compile_by`]), does that until the other one has enough;
/// returns `None` at once in any other. To be called first in `main`.
///
/// ```
/// fn main() -> std::process::ExitCode {
///     if let Some(done) = layersplat::device::compile_for_parent() {
///         return done;
///     }
///     // What the program does.
///     std::process::ExitCode::SUCCESS
/// }
/// ```
pub fn compile_for_parent() -> Option<ExitCode> {
    let named = std::env::var(VARIABLE).ok()?;
    Some(match serve(&named) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            // Nothing else tells the other process why.
            let _ = writeln!(io::stdout(), "{error}");
            ExitCode::FAILURE
        }
    })
}

fn serve(named: &str) -> Result<(), Error> {
    let not_understood =
        |what: &str| Error::Settings { field: VARIABLE, problem: format!("{what} is no request of this version") };
    let named: Named = serde_json::from_str(named).map_err(|_| not_understood(named))?;
    let found = Device::list()?.into_iter().find(|info| Named::new(info) == named);
    let index = found.and_then(|info| info.index).ok_or_else(|| not_understood(&named.name))?;
    let device = Device::open(&DeviceChoice::Named(index.to_string()))?;
    let mut idle = None;
    for line in io::stdin().lock().lines() {
        let Ok(line) = line else { break };
        let answer = match serde_json::from_str(&line).ok().and_then(request) {
            Some(request) => ahead::build(&device.shared.programs, &mut idle, &request),
            None => Err(not_understood(&line)),
        };
        let answer = answer.map_or_else(|error| error.to_string().replace('\n', " "), |()| DONE.into());
        let mut out = io::stdout().lock();
        // Where nobody listens any more, there is nothing to do.
        if writeln!(out, "{answer}").and_then(|()| out.flush()).is_err() {
            break;
        }
    }
    Ok(())
}

/// The request that a message is of, where there is such a kernel file.
fn request(message: Message) -> Option<KernelRequest> {
    let Message { file, kernel, defines, group, wide, arguments } = message;
    let file = sources::files().find(|known| *known == file)?;
    Some(KernelRequest { file, kernel: Cow::Owned(kernel), defines, group, wide, arguments })
}
