//! Devices are checked before they draw: once for each device, driver and build of the command, and each family of kernels.

pub(super) mod child;
mod verdicts;

use super::options::DeviceOptions;
use super::progress;
use crate::camera::Camera;
use crate::check::{CheckReport, Family, Verdict};
use crate::device::{Device, DeviceInfo, unusable_cache};
use crate::error::Error;
use crate::layers::Rays;
use crate::renderer::Plan;
use crate::settings::Settings;
use crate::viewport::Viewport;
use crate::volume::Grid;
use child::Outcome;
use indicatif::ProgressBar;
use std::collections::BTreeSet;
use std::time::{Duration, Instant};
use verdicts::Verdicts;

/// A check that takes longer has compiled kernels.
const WORTH_TELLING: Duration = Duration::from_secs(1);

/// Families that draw these views. What cannot be drawn has none: the renderer says why.
pub(super) fn families(cameras: &[Camera], size: Viewport, grid: &Grid, settings: &Settings) -> BTreeSet<Family> {
    let family = |camera: &Camera| {
        let rays = Rays::new(camera, size, grid).ok()?;
        Some(Family::from_plan(&Plan::new(&rays, size, grid, settings).ok()?, settings, rays.is_parallel()))
    };
    cameras.iter().filter_map(family).collect()
}

/// Refuses a device that does not draw these families as it should, unless it is to be used unchecked.
pub(super) fn require(device: &Device, families: &BTreeSet<Family>, options: &DeviceOptions) -> Result<(), Error> {
    if options.device_unchecked {
        return Ok(());
    }
    let kept = Verdicts::of(device.info());
    let (known, unknown): (Vec<_>, Vec<_>) =
        families.iter().map(|&family| (family, kept.read(family))).partition(|(_, v)| v.is_some());
    let mut verdicts: Vec<Verdict> = known.into_iter().filter_map(|(_, verdict)| verdict).collect();
    let unknown: Vec<Family> = unknown.into_iter().map(|(family, _)| family).collect();
    let outcomes = checked(device.info(), &kept, &unknown);
    // The picture would fail for the same reason, and PoCL's compiler ends the process then.
    if outcomes.iter().any(|outcome| matches!(outcome, Outcome::Undecided(..)))
        && let Some(error) = unusable_cache(&device.info().platform)
    {
        return Err(error);
    }
    verdicts.extend(decided(outcomes));
    CheckReport::new(device, verdicts).require()
}

/// Checks a device anew, whatever was known: all families. What could not be checked has not passed.
pub(super) fn check_all(device: &DeviceInfo) -> Vec<Verdict> {
    let verdict = |outcome| match outcome {
        Outcome::Decided(verdict) => verdict,
        Outcome::Undecided(family, why) => Verdict::failed(family, format!("it could not be checked: {why}")),
    };
    checked(device, &Verdicts::of(device), &Family::ALL).into_iter().map(verdict).collect()
}

/// Checks these families in a process of their own, shows that on a terminal, and keeps the verdicts.
fn checked(device: &DeviceInfo, kept: &Verdicts, families: &[Family]) -> Vec<Outcome> {
    if families.is_empty() {
        return Vec::new();
    }
    let bar = ProgressBar::new_spinner();
    bar.enable_steady_tick(Duration::from_millis(200));
    let what = format!("checking {} (once for its driver and this version)", device.name);
    let begun = Instant::now();
    let outcomes = child::check(device, families, |family| bar.set_message(format!("{what}: {family}")));
    bar.finish_and_clear();
    // The pictures themselves take milliseconds.
    if begun.elapsed() >= WORTH_TELLING {
        progress::say_compiled(begun.elapsed());
    }
    let outcomes = without_room(outcomes, || unusable_cache(&device.platform));
    kept.keep(outcomes.iter().filter_map(|outcome| match outcome {
        Outcome::Decided(verdict) => Some(verdict),
        Outcome::Undecided(..) => None,
    }));
    outcomes
}

/// A family that fails while the kernel cache cannot be written says nothing about the device.
fn without_room(outcomes: Vec<Outcome>, unusable: impl FnOnce() -> Option<Error>) -> Vec<Outcome> {
    let failed = |outcome: &Outcome| matches!(outcome, Outcome::Decided(verdict) if !verdict.passed());
    let Some(error) = outcomes.iter().any(failed).then(unusable).flatten() else { return outcomes };
    let undecided = |outcome| match outcome {
        Outcome::Decided(verdict) if !verdict.passed() => Outcome::Undecided(verdict.family, error.to_string()),
        other => other,
    };
    outcomes.into_iter().map(undecided).collect()
}

/// The verdicts among outcomes. Where there is none, it is not the device that is at fault: what is, the picture itself will meet too.
fn decided(outcomes: Vec<Outcome>) -> Vec<Verdict> {
    let verdict = |outcome| match outcome {
        Outcome::Decided(verdict) => Some(verdict),
        Outcome::Undecided(family, why) => {
            tracing::warn!("{family} could not be checked: {why}");
            None
        }
    };
    outcomes.into_iter().filter_map(verdict).collect()
}
