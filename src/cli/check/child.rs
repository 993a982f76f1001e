//! Device checks in a child process. Compilers may crash or hang, which counts as a failed check.

use crate::check::{Family, Verdict};
use crate::device::{Device, DeviceChoice, DeviceInfo};
use crate::error::Error;
use serde::{Deserialize, Serialize};
use std::io::{self, BufRead, BufReader, Read, Write};
use std::process::{Child, Command, ExitCode, Stdio};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread;
use std::time::Duration;

/// Name of the hidden subcommand.
pub(crate) const NAME: &str = "check-device";

/// Time limit per family. The slowest compiler that succeeded took six and a half minutes of processor time.
const TIME_LIMIT: Duration = Duration::from_secs(20 * 60);

/// Result of checking a family.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) enum Outcome {
    Decided(Verdict),
    /// No verdict, for a reason that is not the device's fault.
    Undecided(Family, String),
}

impl Outcome {
    fn family(&self) -> Family {
        match self {
            Outcome::Decided(verdict) => verdict.family,
            Outcome::Undecided(family, _) => *family,
        }
    }
}

/// A message of the child process: one line of JSON on its standard output.
#[derive(Serialize, Deserialize)]
enum Message {
    Started(Family),
    Finished(Outcome),
}

/// Arguments of the child process.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// Index of the device
    index: usize,
    /// Families, as JSON
    families: String,
}

/// The child process: checks the families one by one, with a message before and after each.
pub(crate) fn run(arguments: &Arguments) -> Result<ExitCode, Error> {
    let families: Vec<Family> = serde_json::from_str(&arguments.families).map_err(|e| Error::Settings {
        field: "families",
        problem: format!("not a list of names ({e}); only the command itself starts this process"),
    })?;
    let device = Device::open(&DeviceChoice::Named(arguments.index.to_string()))?;
    for family in families {
        let outcome = |family| match device.check_family(family) {
            Ok(verdict) => Outcome::Decided(verdict),
            Err(error) => Outcome::Undecided(family, error.to_string()),
        };
        // Sending fails if the parent has ended.
        if send(&Message::Started(family)).and_then(|()| send(&Message::Finished(outcome(family)))).is_err() {
            break;
        }
    }
    Ok(ExitCode::SUCCESS)
}

fn send(message: &Message) -> io::Result<()> {
    let mut out = io::stdout().lock();
    writeln!(out, "{}", serde_json::to_string(message)?)?;
    out.flush()
}

/// Checks families of a device in a child process, and in another one if that ends early. Calls `started` for each family.
pub(super) fn check(device: &DeviceInfo, families: &[Family], started: impl FnMut(Family)) -> Vec<Outcome> {
    let command = |families: &[Family]| {
        let mut command = Command::new(std::env::current_exe()?);
        command.args([
            NAME,
            &device.index.expect("the command takes devices from the list").to_string(),
            &serde_json::to_string(families)?,
        ]);
        Ok(command)
    };
    check_with(command, families, TIME_LIMIT, started)
}

/// As [`check`], with any command that prints such messages.
fn check_with(
    command: impl Fn(&[Family]) -> io::Result<Command>,
    families: &[Family],
    time_limit: Duration,
    mut started: impl FnMut(Family),
) -> Vec<Outcome> {
    let mut outcomes: Vec<Outcome> = Vec::new();
    loop {
        let rest: Vec<Family> =
            families.iter().copied().filter(|family| !outcomes.iter().any(|outcome| outcome.family() == *family)).collect();
        if rest.is_empty() {
            return outcomes;
        }
        let more = match command(&rest).and_then(|command| run_child(command, time_limit, &mut started)) {
            Ok(more) => more,
            Err(error) => {
                rest.iter().map(|&family| Outcome::Undecided(family, format!("cannot start a process: {error}"))).collect()
            }
        };
        if more.is_empty() {
            let reason = "the child process ended before the check started";
            outcomes.extend(rest.into_iter().map(|family| Outcome::Undecided(family, reason.into())));
        }
        outcomes.extend(more);
    }
}

/// Runs one child process to its end. A family fails if the process crashes in it or exceeds the time limit.
fn run_child(mut command: Command, time_limit: Duration, started: &mut impl FnMut(Family)) -> io::Result<Vec<Outcome>> {
    let mut child = command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn()?;
    let last_line = last_error_line(&mut child);
    let stdout = child.stdout.take().expect("it is piped");
    let (sender, lines) = mpsc::channel();
    thread::spawn(move || BufReader::new(stdout).lines().map_while(Result::ok).try_for_each(|line| sender.send(line)));
    let mut outcomes = Vec::new();
    let mut running = None;
    let timed_out = loop {
        match lines.recv_timeout(time_limit) {
            Ok(line) => match serde_json::from_str(&line) {
                Ok(Message::Started(family)) => {
                    running = Some(family);
                    started(family);
                }
                Ok(Message::Finished(outcome)) => {
                    running = None;
                    outcomes.push(outcome);
                }
                // Drivers print to standard output too.
                Err(_) => tracing::debug!("{line}"),
            },
            Err(RecvTimeoutError::Disconnected) => break false,
            Err(RecvTimeoutError::Timeout) => break true,
        }
    };
    if timed_out {
        child.kill()?;
    }
    let status = child.wait()?;
    if let Some(family) = running {
        let line = last_line.join().unwrap_or_default();
        let message = if line.is_empty() { String::new() } else { format!(": {line}") };
        outcomes.push(if timed_out {
            let seconds = time_limit.as_secs_f64();
            Outcome::Decided(Verdict::failed(family, format!("its driver did not respond for {seconds} seconds and was stopped")))
        } else if is_external_stop(&status) {
            Outcome::Undecided(family, format!("the process that checked it was stopped ({status})"))
        } else {
            Outcome::Decided(Verdict::failed(family, format!("its driver crashed ({status}){message}")))
        });
    }
    Ok(outcomes)
}

/// Whether a process was ended from outside: by a user, or by the system when out of memory.
#[cfg(unix)]
fn is_external_stop(status: &std::process::ExitStatus) -> bool {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGKILL, SIGTERM};
    use std::os::unix::process::ExitStatusExt;
    let signals = [SIGHUP, SIGINT, SIGKILL, SIGTERM];
    // The command's own signal handler exits with 128 plus the signal number.
    status.signal().is_some_and(|signal| signals.contains(&signal))
        || status.code().is_some_and(|code| signals.contains(&(code - 128)))
}

#[cfg(not(unix))]
fn is_external_stop(_: &std::process::ExitStatus) -> bool {
    false
}

/// Collects the last line of standard error, where compilers print failed assertions.
fn last_error_line(child: &mut Child) -> thread::JoinHandle<String> {
    let mut stderr = child.stderr.take().expect("it is piped");
    thread::spawn(move || {
        let mut bytes = Vec::new();
        let _ = stderr.read_to_end(&mut bytes);
        let text = String::from_utf8_lossy(&bytes);
        let last = text.lines().map(str::trim).rfind(|line| !line.is_empty());
        last.unwrap_or_default().chars().take(300).collect()
    })
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    const FAMILIES: [Family; 3] = [Family::PointLattice, Family::Slicing, Family::Raycast];

    /// Outcomes with a shell script as child process, and the families started. `$0` of the script is the first family's name,
    /// `$1` and `$2` are its messages.
    fn outcomes(script: &str, time_limit: Duration) -> (Vec<Outcome>, Vec<Family>) {
        let mut started = Vec::new();
        let command = |families: &[Family]| {
            let mut command = Command::new("sh");
            let json = |message: &Message| serde_json::to_string(message).unwrap();
            let passed = Verdict { family: families[0], largest_difference: Some(0.0), problem: None };
            let lines = [json(&Message::Started(families[0])), json(&Message::Finished(Outcome::Decided(passed)))];
            command.args(["-c", script, families[0].name()]).args(lines);
            Ok(command)
        };
        let outcomes = check_with(command, &FAMILIES, time_limit, |family| started.push(family));
        (outcomes, started)
    }

    fn problem(outcome: &Outcome) -> &str {
        match outcome {
            Outcome::Decided(verdict) => verdict.problem.as_deref().unwrap_or("none"),
            Outcome::Undecided(_, reason) => reason,
        }
    }

    /// A crash fails the running family only; the others are still checked.
    #[test]
    fn a_crash_is_a_verdict() {
        let script = r#"echo 'the driver greets'; echo "$1"
            [ "$0" = slicing ] && { echo 'LLVM ERROR: did not reach a fixpoint' >&2; ulimit -c 0; kill -ABRT $$; }
            echo "$2""#;
        let (found, started) = outcomes(script, TIME_LIMIT);
        assert_eq!(started, FAMILIES);
        assert_eq!(found.iter().map(Outcome::family).collect::<Vec<_>>(), FAMILIES);
        assert_eq!((problem(&found[0]), problem(&found[2])), ("none", "none"));
        for word in ["crashed", "signal: 6", "did not reach a fixpoint"] {
            assert!(problem(&found[1]).contains(word), "{found:?}");
        }
        assert!(matches!(&found[1], Outcome::Decided(verdict) if !verdict.passed()));
    }

    #[test]
    fn a_time_out_is_a_verdict() {
        let script = r#"echo "$1"; [ "$0" = raycast ] && exec sleep 60; echo "$2""#;
        let (found, _) = outcomes(script, Duration::from_millis(700));
        assert!(problem(&found[2]).contains("did not respond") && problem(&found[0]) == "none", "{found:?}");
    }

    /// Processes that are stopped from outside, or never start a check, give no verdict; and the check ends.
    #[test]
    fn external_stops_are_no_verdict() {
        for script in [r#"echo "$1"; kill -KILL $$"#, r#"echo "$1"; exit 143"#, "exit 1"] {
            let (found, _) = outcomes(script, TIME_LIMIT);
            assert_eq!(found.len(), FAMILIES.len(), "{script}");
            assert!(found.iter().all(|outcome| matches!(outcome, Outcome::Undecided(..))), "{script}: {found:?}");
        }
    }
}
