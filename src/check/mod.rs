//! Whether a device draws what it should: small pictures through every kernel family, beside stored figures.
//!
//! Compilers for OpenCL fail in many ways: they refuse, they crash, and some draw a wrong picture without a word. [`Device::check`] tells.

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

/// What a check found of one family.
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
    /// What was checked.
    pub family: Family,
    /// Largest difference of any channel, 0 … 1, from what is right; `None` where a picture is missing or has what is no number.
    pub largest_difference: Option<f64>,
    /// What is wrong, of a family that fails.
    pub problem: Option<String>,
}

impl Verdict {
    /// Of a family whose pictures differ so much.
    fn of(family: Family, largest_difference: f64) -> Self {
        let [off, allowed] = [largest_difference, TOLERANCE].map(|d| d * 255.0);
        let problem = if off.is_finite() {
            (off > allowed).then(|| format!("the picture is wrong: off by {off:.1} of 255 steps, where {allowed:.1} are allowed"))
        } else {
            Some("the picture is wrong: it has what is no number".into())
        };
        Self { family, largest_difference: Some(largest_difference).filter(|d| d.is_finite()), problem }
    }

    /// Of a family that drew nothing.
    pub fn failed(family: Family, problem: impl Into<String>) -> Self {
        Self { family, largest_difference: None, problem: Some(problem.into()) }
    }

    /// Whether it draws what it should.
    pub fn passed(&self) -> bool {
        self.problem.is_none()
    }
}

/// What a check found of a device.
///
/// ```
/// use layersplat::check::{CheckReport, Family, Verdict};
/// use layersplat::{Device, DeviceChoice};
///
/// let device = Device::open(&DeviceChoice::Default)?;
/// let report = CheckReport::new(&device, vec![Verdict::failed(Family::Slicing, "does not compile")]);
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
    /// Gathers verdicts on a device.
    pub fn new(device: &Device, verdicts: Vec<Verdict>) -> Self {
        Self { device: device.info().name.clone(), verdicts }
    }

    /// Whether every family passed.
    pub fn passed(&self) -> bool {
        self.verdicts.iter().all(Verdict::passed)
    }

    /// Refuses a device that failed.
    ///
    /// # Errors
    /// [`Error::DeviceFailed`] names the families that failed, with what is wrong with each.
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
    /// Draws small pictures through every kernel family and compares them with what is right. A driver that crashes takes the process with
    /// it; the command `layersplat devices --check` has a process of its own for that.
    ///
    /// # Errors
    /// What says nothing about the device: no memory, or nowhere to put kernels. A device that does not build a program, does not run it or
    /// draws a wrong picture is no error here: the report says so, and [`CheckReport::require`] makes it one.
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

    /// The same of one family.
    ///
    /// # Errors
    /// As of [`check`](Self::check).
    pub fn check_family(&self, family: Family) -> Result<Verdict, Error> {
        match self.largest_difference(family) {
            Ok(largest) => Ok(Verdict::of(family, largest)),
            Err(error @ (Error::Build { .. } | Error::OpenCl { .. })) => Ok(Verdict::failed(family, error.to_string())),
            Err(other) => Err(other),
        }
    }

    /// Draws the family's pictures, as floats and displayed.
    fn largest_difference(&self, family: Family) -> Result<f64, Error> {
        let mut renderer = Renderer::new(self, &pictures::volume(), &pictures::transfer())?;
        let mut largest: f64 = 0.0;
        for (n, Picture { settings, camera }) in pictures::of(family).into_iter().enumerate() {
            let expected = figures::expected(family, n);
            let (frame, _) = renderer.render(&camera, SIZE, &settings)?;
            let (shown, _) = renderer.render_rgba8(&camera, SIZE, &settings, figures::BACKGROUND)?;
            let differences = [figures::difference(&frame, &expected), figures::displayed_difference(&shown, &expected)];
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

    /// Draws nothing: tests/embedding compares what it finds.
    const FINDS_A_RANGE: &str = "volume/value_range.cl";

    /// Other families know no schedules.
    fn is_lattice(family: Family) -> bool {
        matches!(
            family,
            Family::PointLattice
                | Family::Spline
                | Family::PointValues
                | Family::PointSurface
                | Family::SplatLattice
                | Family::SplatPerspective
        )
    }

    /// No kernel that draws goes unchecked.
    #[test]
    fn every_kernel_file_is_built() {
        let device =
            Device::open(&crate::DeviceChoice::Default).expect("the tests need an OpenCL device: scripts/test installs PoCL");
        assert!(!device.unbuilt_files().is_empty());
        // Each kind of device has one of the schedules.
        for lattice_schedule in [LatticeSchedule::Tiles, LatticeSchedule::Samples] {
            let device = device.with_tuning(Tuning { lattice_schedule, ..*device.tuning() }).unwrap();
            for family in
                Family::ALL.into_iter().filter(|&family| lattice_schedule == LatticeSchedule::Tiles || is_lattice(family))
            {
                let verdict = device.check_family(family).unwrap();
                assert!(verdict.passed(), "{lattice_schedule:?}: {verdict:?}");
            }
        }
        assert_eq!(device.unbuilt_files(), [FINDS_A_RANGE]);
    }

    /// What a first picture waits for: one program prepares volumes, one draws lattices whether or not they are staggered and values lie beyond the
    /// table, and one warps them, to floats and to bytes.
    #[test]
    fn a_first_picture_takes_three_programs() {
        let device = Device::open(&crate::DeviceChoice::Default).unwrap();
        let device = device.with_tuning(Tuning { lattice_schedule: LatticeSchedule::Tiles, ..*device.tuning() }).unwrap();
        assert!(device.check_family(Family::PointLattice).unwrap().passed());
        assert_eq!(device.programs(), 3);
        let narrow = crate::TransferFunction::new("narrow", vec![(50.0, [1.0; 3])], vec![(50.0, 0.1), (60.0, 0.3)]).unwrap();
        for transfer in [pictures::transfer(), narrow] {
            let mut renderer = Renderer::new(&device, &pictures::volume(), &transfer).unwrap();
            for family in [Family::PointLattice, Family::Spline, Family::PointValues] {
                for Picture { camera, .. } in pictures::of(family) {
                    let settings = pictures::of(Family::PointLattice)[0].settings;
                    renderer.render_rgba8(&camera, SIZE, &settings, figures::BACKGROUND).unwrap();
                }
            }
        }
        assert_eq!(device.programs(), 3);
    }

    #[test]
    fn verdicts_and_what_becomes_of_them() {
        let right = Verdict::of(Family::Spline, TOLERANCE);
        assert!(right.passed());
        let report = |verdicts| CheckReport { device: "it".into(), verdicts };
        assert!(report(vec![right.clone()]).require().is_ok());
        for wrong in [TOLERANCE * 1.01, 1.0, f64::INFINITY, f64::NAN] {
            let verdict = Verdict::of(Family::Slicing, wrong);
            assert!(!verdict.passed(), "{wrong}");
            // What is infinite is no JSON.
            let text = serde_json::to_string(&verdict).unwrap();
            assert_eq!(serde_json::from_str::<Verdict>(&text).unwrap(), verdict);
            let message = report(vec![right.clone(), verdict]).require().unwrap_err().to_string();
            assert!(message.contains("slicing: the picture is wrong") && !message.contains("spline"), "{message}");
        }
    }
}
