//! Device check: renders small pictures with every kernel family and compares them with stored ones.
//!
//! OpenCL compilers fail in many ways: they reject kernels, crash, or silently produce wrong pictures. [`Device::check`] detects this.

mod family;
mod figures;
mod pictures;
#[cfg(test)]
mod programs;
#[cfg(test)]
mod truth;

pub use family::Family;
pub use figures::TOLERANCE;

use crate::device::Device;
use crate::error::Error;
use crate::renderer::Renderer;
use pictures::{Picture, SIZE};
use serde::{Deserialize, Serialize};

/// Result of the check of one family.
///
/// ```
/// use layersplat::check::Family;
/// use layersplat::{Device, DeviceChoice};
///
/// let verdict = Device::open(&DeviceChoice::Default)?.check_family(Family::PointLattice)?;
/// assert!(verdict.passed() && verdict.problem.is_none());
/// # Ok::<(), layersplat::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Verdict {
    /// Checked family.
    pub family: Family,
    /// Largest difference of any channel from the expected picture, 0 … 1; `None` if a picture is missing or contains NaN.
    pub largest_difference: Option<f64>,
    /// Description of the failure; `None` if the family passed.
    pub problem: Option<String>,
}

impl Verdict {
    /// Verdict for a family with this largest difference.
    fn new(family: Family, largest_difference: f64) -> Self {
        let [off, allowed] = [largest_difference, TOLERANCE].map(|d| d * 255.0);
        let problem = if off.is_finite() {
            (off > allowed)
                .then(|| format!("the picture is wrong: off by {off:.1} of 255 steps, more than the allowed {allowed:.1}"))
        } else {
            Some("the picture is wrong: it contains NaN".into())
        };
        Self { family, largest_difference: Some(largest_difference).filter(|d| d.is_finite()), problem }
    }

    /// Verdict for a family that could not be rendered.
    pub fn failed(family: Family, problem: impl Into<String>) -> Self {
        Self { family, largest_difference: None, problem: Some(problem.into()) }
    }

    /// Whether the family renders correctly.
    pub fn passed(&self) -> bool {
        self.problem.is_none()
    }
}

/// Result of the check of a device.
///
/// ```
/// use layersplat::check::{CheckReport, Family, Verdict};
/// use layersplat::{Device, DeviceChoice};
///
/// let device = Device::open(&DeviceChoice::Default)?;
/// let report = CheckReport::new(&device, vec![Verdict::failed(Family::Raycast, "does not compile")]);
/// assert!(!report.passed());
/// println!("{}", report.require().expect_err("it failed"));
/// # Ok::<(), layersplat::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct CheckReport {
    /// Name of the device.
    pub device: String,
    /// One verdict per family.
    pub verdicts: Vec<Verdict>,
}

impl CheckReport {
    /// Collects verdicts on a device.
    pub fn new(device: &Device, verdicts: Vec<Verdict>) -> Self {
        Self { device: device.info().name.clone(), verdicts }
    }

    /// Whether every family passed.
    pub fn passed(&self) -> bool {
        self.verdicts.iter().all(Verdict::passed)
    }

    /// Returns an error for a device that failed.
    ///
    /// # Errors
    /// [`Error::DeviceFailed`], which names the families that failed and their problems.
    pub fn require(&self) -> Result<(), Error> {
        let failures = self.verdicts.iter().filter_map(|v| v.problem.as_ref().map(|problem| format!("{}: {problem}", v.family)));
        let failures: Vec<String> = failures.collect();
        if failures.is_empty() {
            return Ok(());
        }
        Err(Error::DeviceFailed { device: self.device.clone(), failures: failures.join("; ") })
    }
}

impl Device {
    /// Renders small pictures with every kernel family and compares them with expected ones.
    ///
    /// A driver that crashes takes the process with it; the command `layersplat devices --check` runs the check in a separate process.
    ///
    /// # Errors
    /// If the check cannot run for reasons other than the device: lack of memory, or an unwritable kernel cache. Failed builds, failed kernels
    /// and wrong pictures are not errors: the report contains them, and [`CheckReport::require`] converts them to an error.
    ///
    /// ```no_run
    /// # fn main() -> Result<(), layersplat::Error> {
    /// let device = layersplat::Device::open(&layersplat::DeviceChoice::Default)?;
    /// device.check()?.require()?;
    /// # Ok(())
    /// # }
    /// ```
    pub fn check(&self) -> Result<CheckReport, Error> {
        let verdicts = Family::ALL.into_iter().map(|family| self.check_family(family)).collect::<Result<_, _>>()?;
        Ok(CheckReport::new(self, verdicts))
    }

    /// Checks one family.
    ///
    /// # Errors
    /// As [`check`](Self::check).
    pub fn check_family(&self, family: Family) -> Result<Verdict, Error> {
        match self.largest_difference(family) {
            Ok(largest) => Ok(Verdict::new(family, largest)),
            Err(error @ (Error::Build { .. } | Error::OpenCl { .. })) => Ok(Verdict::failed(family, error.to_string())),
            Err(other) => Err(other),
        }
    }

    /// Renders the pictures of the family as floats and displayed, and returns the largest difference.
    fn largest_difference(&self, family: Family) -> Result<f64, Error> {
        let mut renderer = Renderer::new(self, &pictures::volume(), &pictures::transfer())?;
        let mut largest: f64 = 0.0;
        for (n, Picture { settings, camera, surfaces }) in pictures::views(family).into_iter().enumerate() {
            let expected = figures::expected(family, n);
            renderer.set_surfaces(&surfaces)?;
            let (frame, _) = renderer.render(&camera, SIZE, &settings)?;
            let (shown, _) = renderer.render_rgba8(&camera, SIZE, &settings, figures::BACKGROUND)?;
            let differences =
                [figures::difference(&frame, &expected), figures::displayed_difference(&shown, &expected, settings.curve())];
            tracing::debug!("{family} {n}: off by {differences:?}");
            largest = differences.into_iter().fold(largest, f64::max);
        }
        Ok(largest)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::device::{LatticeSchedule, Tuning};

    /// These kernels render nothing for a frame of one field at full resolution; tests/shadows, tests/slices and tests/embedding check their
    /// results, and tests/channels and tests/colors those of several fields and of colours.
    const NOT_CHECKED: [&str; 23] = [
        "layered/channel_apart.cl",
        "layered/channel_lattice.cl",
        "layered/channels.cl",
        "layered/color_lattice.cl",
        "layered/color_segment.cl",
        "layered/label_segment.cl",
        "light/coarse_transmittance.cl",
        "light/light_table.cl",
        "rays/channel_raycast.cl",
        "rays/color_raycast.cl",
        "shared/color_absorption.cl",
        "shared/label_surface.cl",
        "slice/slice.cl",
        "surfaces/count_fragments.cl",
        "surfaces/sort_cells.cl",
        "volume/color_voxels.cl",
        "volume/label_at.cl",
        "volume/label_moments.cl",
        "volume/label_runs.cl",
        "volume/label_voxels.cl",
        "volume/pack_colors.cl",
        "volume/resample.cl",
        "volume/value_range.cl",
    ];

    /// Other families have no schedules.
    fn is_lattice(family: Family) -> bool {
        matches!(
            family,
            Family::PointLattice
                | Family::Spline
                | Family::PointValues
                | Family::PointSurface
                | Family::SplatLattice
                | Family::SplatPerspective
                | Family::Light
                | Family::Studio
                | Family::Surfaces
        )
    }

    /// Every rendering kernel is checked.
    #[test]
    fn every_kernel_file_is_built() {
        let device =
            Device::open(&crate::DeviceChoice::Default).expect("the tests need an OpenCL device: scripts/test installs PoCL");
        assert!(!device.unbuilt_files().is_empty());
        // Schedules differ between kinds of devices.
        for lattice_schedule in [LatticeSchedule::Tiles, LatticeSchedule::Samples] {
            let device = device.with_tuning(Tuning { lattice_schedule, ..*device.tuning() }).unwrap();
            for family in
                Family::ALL.into_iter().filter(|&family| lattice_schedule == LatticeSchedule::Tiles || is_lattice(family))
            {
                let verdict = device.check_family(family).unwrap();
                assert!(verdict.passed(), "{lattice_schedule:?}: {verdict:?}");
            }
        }
        assert_eq!(device.unbuilt_files(), NOT_CHECKED);
    }

    /// The programs of a first picture: one prepares volumes, one draws lattices, staggered or not, and one warps them, to floats and to bytes.
    #[test]
    fn a_first_picture_takes_three_programs() {
        let device = Device::open(&crate::DeviceChoice::Default).unwrap();
        let device = device.with_tuning(Tuning { lattice_schedule: LatticeSchedule::Tiles, ..*device.tuning() }).unwrap();
        assert!(device.check_family(Family::PointLattice).unwrap().passed());
        assert_eq!(device.programs(), 3);
        let mut renderer = Renderer::new(&device, &pictures::volume(), &pictures::transfer()).unwrap();
        for Picture { camera, settings, .. } in pictures::views(Family::PointLattice) {
            renderer.render_rgba8(&camera, SIZE, &settings, figures::BACKGROUND).unwrap();
            renderer.render(&camera, SIZE, &settings).unwrap();
        }
        assert_eq!(device.programs(), 3);
    }

    #[test]
    fn verdicts_and_what_becomes_of_them() {
        let right = Verdict::new(Family::Spline, TOLERANCE);
        assert!(right.passed());
        let report = |verdicts| CheckReport { device: "it".into(), verdicts };
        assert!(report(vec![right.clone()]).require().is_ok());
        for wrong in [TOLERANCE * 1.01, 1.0, f64::INFINITY, f64::NAN] {
            let verdict = Verdict::new(Family::Slicing, wrong);
            assert!(!verdict.passed(), "{wrong}");
            // JSON cannot represent infinity.
            let text = serde_json::to_string(&verdict).unwrap();
            assert_eq!(serde_json::from_str::<Verdict>(&text).unwrap(), verdict);
            let message = report(vec![right.clone(), verdict]).require().unwrap_err().to_string();
            assert!(message.contains("slicing: the picture is wrong") && !message.contains("spline"), "{message}");
        }
    }
}
