//! How a picture is made: what each way of rendering has of its own, and what all share.

mod algorithm;
mod blend;
mod clipping;
mod gradient_opacity;
mod layered;
mod lights;
mod quality;
mod shading;

pub use algorithm::Algorithm;
pub use blend::Blend;
pub use clipping::{ClipPlane, Clipping, CropBox};
pub use gradient_opacity::GradientOpacity;
pub use layered::{Classification, Evaluation, Footprints, LayerAxis, Layered};
pub use lights::{Light, Lights};
pub use quality::Quality;
pub use shading::Shading;

use crate::error::Error;
use crate::transfer::Extinction;

/// Everything that decides how a picture is made, besides volume, transfer function and camera.
///
/// ```
/// use layersplat::settings::{Blend, Settings};
/// use layersplat::Quality;
///
/// // The maximum along rays, in the finest quality.
/// let settings = Settings { blend: Blend::Maximum, ..Quality::High.settings() };
/// assert!(settings.layered().is_some());
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Which renderer, with its own choices. Default: layered.
    pub algorithm: Algorithm,
    /// What becomes of the values along a ray. Default: composited.
    pub blend: Blend,
    /// What of the volume is shown. Default: all.
    pub clipping: Clipping,
    /// Default: exponential, which is exact for homogeneous segments at any spacing.
    pub extinction: Extinction,
    /// Default: on.
    pub shading: Option<Shading>,
    /// What gradients leave of the extinction. Default: all.
    pub gradient_opacity: Option<GradientOpacity>,
    /// Whether tiles stop where less than 1/4096 of the light passes. Default: on; it costs less than half a step of an
    /// 8-bit picture.
    pub early_termination: bool,
    /// World distance that the opacities are for. Default: the smallest spacing.
    pub unit_distance: Option<f64>,
    /// Whether layers that can show nothing are skipped. It never changes a bit of the picture; off only to prove it.
    pub culling: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Algorithm::default().into()
    }
}

impl From<Algorithm> for Settings {
    /// The defaults of everything else.
    fn from(algorithm: Algorithm) -> Self {
        Self {
            algorithm,
            blend: Blend::Composite,
            clipping: Clipping::default(),
            extinction: Extinction::Exponential,
            shading: Some(Shading::default()),
            gradient_opacity: None,
            early_termination: true,
            unit_distance: None,
            culling: true,
        }
    }
}

impl From<Layered> for Settings {
    /// The defaults of everything else.
    fn from(layered: Layered) -> Self {
        Algorithm::Layered(layered).into()
    }
}

impl Settings {
    /// Transmittance at which early termination stops: 72 dB below white.
    pub const OPAQUE: f64 = 1.0 / 4096.0;

    /// The choices of layered rendering; `None` of other algorithms.
    pub fn layered(&self) -> Option<Layered> {
        match self.algorithm {
            Algorithm::Layered(layered) => Some(layered),
            _ => None,
        }
    }

    /// Whether gradients are looked at where values are composited.
    pub(crate) fn looks_at_gradients(&self) -> bool {
        self.shading.is_some() || self.gradient_opacity.is_some()
    }

    /// Checks every number, and what goes together.
    pub(crate) fn check(&self) -> Result<(), Error> {
        self.algorithm.check()?;
        self.blend.check()?;
        self.check_blend()?;
        if self.gradient_opacity.is_some() && self.blend != Blend::Composite {
            let problem = "only the blend mode composite has opacities along rays: leave it out".into();
            return Err(Error::Settings { field: "gradient_opacity", problem });
        }
        self.clipping.check()?;
        self.shading.map_or(Ok(()), |shading| shading.check())?;
        match self.unit_distance {
            Some(d) if !(d.is_finite() && d > 0.0) => {
                Err(Error::OutOfRange { name: "unit_distance", value: d.to_string(), expected: "a finite number above 0" })
            }
            _ => Ok(()),
        }
    }

    /// Refuses blend modes that an algorithm cannot have.
    fn check_blend(&self) -> Result<(), Error> {
        let problem = match (self.blend, self.algorithm) {
            (Blend::Composite, _) => return Ok(()),
            (_, Algorithm::AxisSheets { .. } | Algorithm::ViewSheets { .. }) => {
                "sheets mix voxels with the background around them: only the blend mode composite has a meaning there"
            }
            (Blend::Iso(_), Algorithm::Layered(Layered { classification: Classification::Post(_), .. })) => {
                "splatted layers have no values between samples that could cross an iso-value: choose pre-integrated classification"
            }
            _ => return Ok(()),
        };
        Err(Error::Settings { field: "blend", problem: problem.into() })
    }
}
