//! Device checks before rendering: once per device, driver, build of the command and kernel family.

pub(super) mod child;
mod verdicts;

use super::compiling;
use super::options::DeviceOptions;
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
use std::time::Duration;
use verdicts::Verdicts;

/// Kernel families that render these views. Views that cannot be rendered are skipped; the renderer reports them later.
pub(super) fn families(
    cameras: &[Camera],
    size: Viewport,
    grid: &Grid,
    settings: &Settings,
    has_surfaces: bool,
) -> BTreeSet<Family> {
    let family = |camera: &Camera| {
        let rays = Rays::new(camera, size, grid).ok()?;
        let plan = Plan::new(&rays, size, grid, settings).ok()?;
        let plan = if has_surfaces { plan.with_surfaces(&rays, size, grid, settings).ok()? } else { plan };
        // Lattices with surfaces have programs of their own.
        Some(Family::from_plan(&plan, settings, rays.is_parallel()))
            .filter(|&family| !(has_surfaces && family == Family::PointLattice))
    };
    cameras.iter().filter_map(family).chain(has_surfaces.then_some(Family::Surfaces)).collect()
}

/// Checks these families unless their verdicts are cached or `--device-unchecked` is given.
///
/// # Errors
/// [`Error::DeviceFailed`] if a family failed its check.
pub(super) fn require(device: &Device, families: &BTreeSet<Family>, options: &DeviceOptions) -> Result<(), Error> {
    if options.device_unchecked {
        return Ok(());
    }
    let cache = Verdicts::new(device.info());
    let (known, unknown): (Vec<_>, Vec<_>) =
        families.iter().map(|&family| (family, cache.read(family))).partition(|(_, v)| v.is_some());
    let mut verdicts: Vec<Verdict> = known.into_iter().filter_map(|(_, verdict)| verdict).collect();
    let unknown: Vec<Family> = unknown.into_iter().map(|(family, _)| family).collect();
    let outcomes = run_checks(device.info(), &cache, &unknown);
    // Rendering would fail for the same reason, and PoCL's compiler would end the process.
    if outcomes.iter().any(|outcome| matches!(outcome, Outcome::Undecided(..)))
        && let Some(error) = unusable_cache(&device.info().platform)
    {
        return Err(error);
    }
    verdicts.extend(decided(outcomes));
    CheckReport::new(device, verdicts).require()
}

/// Checks all families of a device again and ignores cached verdicts. Families that cannot be checked count as failed.
pub(super) fn check_all(device: &DeviceInfo) -> Vec<Verdict> {
    let verdict = |outcome| match outcome {
        Outcome::Decided(verdict) => verdict,
        Outcome::Undecided(family, reason) => Verdict::failed(family, format!("it could not be checked: {reason}")),
    };
    run_checks(device, &Verdicts::new(device), &Family::ALL).into_iter().map(verdict).collect()
}

/// Checks families in a child process, with a progress display, and caches the verdicts.
fn run_checks(device: &DeviceInfo, cache: &Verdicts, families: &[Family]) -> Vec<Outcome> {
    if families.is_empty() {
        return Vec::new();
    }
    let bar = ProgressBar::new_spinner();
    bar.enable_steady_tick(Duration::from_millis(200));
    let what = format!("checking {} (once per driver and version of layersplat)", device.name);
    let check = || child::check(device, families, |family| bar.set_message(format!("{what}: {family}")));
    let outcomes = compiling::while_checking(check);
    bar.finish_and_clear();
    let outcomes = discount_cache_failures(outcomes, || unusable_cache(&device.platform));
    cache.write(outcomes.iter().filter_map(|outcome| match outcome {
        Outcome::Decided(verdict) => Some(verdict),
        Outcome::Undecided(..) => None,
    }));
    outcomes
}

/// Turns failures into undecided outcomes if the kernel cache cannot be written: then the device may not be at fault.
fn discount_cache_failures(outcomes: Vec<Outcome>, unusable: impl FnOnce() -> Option<Error>) -> Vec<Outcome> {
    let failed = |outcome: &Outcome| matches!(outcome, Outcome::Decided(verdict) if !verdict.passed());
    let Some(error) = outcomes.iter().any(failed).then(unusable).flatten() else { return outcomes };
    let undecided = |outcome| match outcome {
        Outcome::Decided(verdict) if !verdict.passed() => Outcome::Undecided(verdict.family, error.to_string()),
        other => other,
    };
    outcomes.into_iter().map(undecided).collect()
}

/// The verdicts among the outcomes. Warns of undecided families; rendering itself will report their cause.
fn decided(outcomes: Vec<Outcome>) -> Vec<Verdict> {
    let verdict = |outcome| match outcome {
        Outcome::Decided(verdict) => Some(verdict),
        Outcome::Undecided(family, reason) => {
            tracing::warn!("{family} could not be checked: {reason}");
            None
        }
    };
    outcomes.into_iter().filter_map(verdict).collect()
}
