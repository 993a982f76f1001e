//! A process of its own in which a device is checked: compilers crash, and hang, and that is a verdict too.

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

/// The longest that a family may take: the slowest compiler that got there took six and a half minutes of a processor.
const PATIENCE: Duration = Duration::from_secs(20 * 60);

/// What came of checking a family.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) enum Outcome {
    Decided(Verdict),
    /// With the reason, which is not the device's fault.
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

/// A line that the process says.
#[derive(Serialize, Deserialize)]
enum Said {
    Begun(Family),
    Done(Outcome),
}

/// Arguments of the process.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// Index of the device
    index: usize,
    /// Families, as JSON
    families: String,
}

/// What the process does: checks families one by one, and says before and after what it does.
pub(crate) fn run(arguments: &Arguments) -> Result<ExitCode, Error> {
    let families: Vec<Family> = serde_json::from_str(&arguments.families).map_err(|e| Error::Settings {
        field: "families",
        problem: format!("they are no list of names ({e}); the command starts this process itself"),
    })?;
    let device = Device::open(&DeviceChoice::Named(arguments.index.to_string()))?;
    for family in families {
        let outcome = |family| match device.check_family(family) {
            Ok(verdict) => Outcome::Decided(verdict),
            Err(error) => Outcome::Undecided(family, error.to_string()),
        };
        // Where nobody listens any more, there is nothing to do.
        if say(&Said::Begun(family)).and_then(|()| say(&Said::Done(outcome(family)))).is_err() {
            break;
        }
    }
    Ok(ExitCode::SUCCESS)
}

fn say(said: &Said) -> io::Result<()> {
    let mut out = io::stdout().lock();
    writeln!(out, "{}", serde_json::to_string(said)?)?;
    out.flush()
}

/// Checks families of a device in a process of their own, or in several, where one ends early. Says which begins.
pub(super) fn check(device: &DeviceInfo, families: &[Family], begun: impl FnMut(Family)) -> Vec<Outcome> {
    let command = |families: &[Family]| {
        let mut command = Command::new(std::env::current_exe()?);
        command.args([
            NAME,
            &device.index.expect("the command takes devices from the list").to_string(),
            &serde_json::to_string(families)?,
        ]);
        Ok(command)
    };
    check_by(command, families, PATIENCE, begun)
}

/// The same by any command that says such lines.
fn check_by(
    command: impl Fn(&[Family]) -> io::Result<Command>,
    families: &[Family],
    patience: Duration,
    mut begun: impl FnMut(Family),
) -> Vec<Outcome> {
    let mut outcomes: Vec<Outcome> = Vec::new();
    loop {
        let rest: Vec<Family> =
            families.iter().copied().filter(|family| !outcomes.iter().any(|outcome| outcome.family() == *family)).collect();
        if rest.is_empty() {
            return outcomes;
        }
        let more = match command(&rest).and_then(|command| listen(command, patience, &mut begun)) {
            Ok(more) => more,
            Err(error) => rest.iter().map(|&family| Outcome::Undecided(family, format!("no process: {error}"))).collect(),
        };
        if more.is_empty() {
            let why = "the process that was to check it ended before it began";
            outcomes.extend(rest.into_iter().map(|family| Outcome::Undecided(family, why.into())));
        }
        outcomes.extend(more);
    }
}

/// What one process finds, to its end. That of a family in which it ends early, or says nothing for too long, is a failure.
fn listen(mut command: Command, patience: Duration, begun: &mut impl FnMut(Family)) -> io::Result<Vec<Outcome>> {
    let mut child = command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn()?;
    let last_words = last_words(&mut child);
    let stdout = child.stdout.take().expect("it is piped");
    let (sender, lines) = mpsc::channel();
    thread::spawn(move || BufReader::new(stdout).lines().map_while(Result::ok).try_for_each(|line| sender.send(line)));
    let mut outcomes = Vec::new();
    let mut running = None;
    let silent = loop {
        match lines.recv_timeout(patience) {
            Ok(line) => match serde_json::from_str(&line) {
                Ok(Said::Begun(family)) => {
                    running = Some(family);
                    begun(family);
                }
                Ok(Said::Done(outcome)) => {
                    running = None;
                    outcomes.push(outcome);
                }
                // Drivers talk on standard output too.
                Err(_) => tracing::debug!("{line}"),
            },
            Err(RecvTimeoutError::Disconnected) => break false,
            Err(RecvTimeoutError::Timeout) => break true,
        }
    };
    if silent {
        child.kill()?;
    }
    let status = child.wait()?;
    if let Some(family) = running {
        let words = last_words.join().unwrap_or_default();
        let said = if words.is_empty() { String::new() } else { format!(", with the words \"{words}\"") };
        outcomes.push(if silent {
            let seconds = patience.as_secs_f64();
            Outcome::Decided(Verdict::failed(family, format!("its driver said nothing for {seconds} seconds and was stopped")))
        } else if is_from_outside(&status) {
            Outcome::Undecided(family, format!("the process that checked it was stopped ({status})"))
        } else {
            Outcome::Decided(Verdict::failed(family, format!("its driver crashed ({status}){said}")))
        });
    }
    Ok(outcomes)
}

/// Whether somebody else ended a process: a user, or a system without memory.
#[cfg(unix)]
fn is_from_outside(status: &std::process::ExitStatus) -> bool {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGKILL, SIGTERM};
    use std::os::unix::process::ExitStatusExt;
    let ends = [SIGHUP, SIGINT, SIGKILL, SIGTERM];
    // The command itself turns these signals into such exit codes.
    status.signal().is_some_and(|signal| ends.contains(&signal)) || status.code().is_some_and(|code| ends.contains(&(code - 128)))
}

#[cfg(not(unix))]
fn is_from_outside(_: &std::process::ExitStatus) -> bool {
    false
}

/// The last line on standard error, once it ends: assertions of compilers stand there.
fn last_words(child: &mut Child) -> thread::JoinHandle<String> {
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

    /// What comes of a script that is told the families, the first of them by name; with the families that began.
    fn outcomes(script: &str, patience: Duration) -> (Vec<Outcome>, Vec<Family>) {
        let mut begun = Vec::new();
        let command = |families: &[Family]| {
            let mut command = Command::new("sh");
            let said = |said: &Said| serde_json::to_string(said).unwrap();
            let right = Verdict { family: families[0], largest_difference: Some(0.0), problem: None };
            let lines = [said(&Said::Begun(families[0])), said(&Said::Done(Outcome::Decided(right)))];
            command.args(["-c", script, families[0].name()]).args(lines);
            Ok(command)
        };
        let outcomes = check_by(command, &FAMILIES, patience, |family| begun.push(family));
        (outcomes, begun)
    }

    fn problem(outcome: &Outcome) -> &str {
        match outcome {
            Outcome::Decided(verdict) => verdict.problem.as_deref().unwrap_or("none"),
            Outcome::Undecided(_, why) => why,
        }
    }

    /// A crash is that of the family that was running; the others are checked all the same.
    #[test]
    fn a_crash_is_a_verdict() {
        let script = r#"echo 'the driver greets'; echo "$1"
            [ "$0" = slicing ] && { echo 'LLVM ERROR: did not reach a fixpoint' >&2; ulimit -c 0; kill -ABRT $$; }
            echo "$2""#;
        let (found, begun) = outcomes(script, PATIENCE);
        assert_eq!(begun, FAMILIES);
        assert_eq!(found.iter().map(Outcome::family).collect::<Vec<_>>(), FAMILIES);
        assert_eq!((problem(&found[0]), problem(&found[2])), ("none", "none"));
        for word in ["crashed", "signal: 6", "did not reach a fixpoint"] {
            assert!(problem(&found[1]).contains(word), "{found:?}");
        }
        assert!(matches!(&found[1], Outcome::Decided(verdict) if !verdict.passed()));
    }

    #[test]
    fn silence_is_a_verdict() {
        let script = r#"echo "$1"; [ "$0" = raycast ] && exec sleep 60; echo "$2""#;
        let (found, _) = outcomes(script, Duration::from_millis(700));
        assert!(problem(&found[2]).contains("said nothing") && problem(&found[0]) == "none", "{found:?}");
    }

    /// What somebody else did, or what never began, says nothing about a device; and it ends.
    #[test]
    fn what_the_device_is_not_guilty_of_is_none() {
        for script in [r#"echo "$1"; kill -KILL $$"#, r#"echo "$1"; exit 143"#, "exit 1"] {
            let (found, _) = outcomes(script, PATIENCE);
            assert_eq!(found.len(), FAMILIES.len(), "{script}");
            assert!(found.iter().all(|outcome| matches!(outcome, Outcome::Undecided(..))), "{script}: {found:?}");
        }
    }
}
