//! How a picture is made, and bundles of it.

use super::algorithm::Algorithm;
use super::blend::Blend;
use super::clipping::Clipping;
use crate::error::Error;
use crate::layers::{Axis, Correction, Density, MAX_SAMPLES_PER_VOXEL};
use crate::transfer::Extinction;
use glam::DVec3;
use serde::Serialize;
use std::str::FromStr;

/// Which layer axis is taken.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LayerAxis {
    /// The axis most parallel to the view, in voxel units (the 45° rule).
    #[default]
    Auto,
    /// Always this one; an error where the view leans more than three voxels per layer from it.
    Forced(Axis),
}

/// Where splat sums are evaluated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Evaluation {
    /// On the sheared lattice; where none reaches, per pixel.
    Lattice(Density),
    /// Per screen pixel.
    Direct,
}

/// How samples become colour and opacity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Classification {
    /// Each sample by itself, after interpolation (the paper): samples mix the splat sums of three layers.
    Post(Correction),
    /// The segment between two samples, over all values between theirs. Layers are sampled where rays cross them, this many
    /// times per layer (1 … [`Classification::MAX_POINTS`]).
    Preintegrated {
        /// Samples per layer.
        samples_per_layer: u32,
    },
}

impl Classification {
    /// Most samples per layer of pre-integration.
    pub const MAX_POINTS: u32 = 8;

    /// Samples per layer.
    pub fn samples_per_layer(self) -> u32 {
        match self {
            Classification::Post(correction) => correction.samples_per_layer(),
            Classification::Preintegrated { samples_per_layer } => samples_per_layer,
        }
    }
}

/// Source of the footprints in [`Evaluation::Direct`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Footprints {
    /// Computed for the view.
    #[default]
    Exact,
    /// The nearest of the paper's 856 oriented images of 64² bytes.
    Set,
}

/// Blinn-Phong with one white light, two-sided, from the gradient of the splat sums.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shading {
    /// Share of the colour that needs no light.
    pub ambient: f64,
    /// Share that depends on the angle to the light.
    pub diffuse: f64,
    /// Strength of the white highlight.
    pub specular: f64,
    /// Its exponent, > 0.
    pub power: f64,
    /// Direction to the light in world coordinates; `None`: the light is at the camera.
    pub light: Option<DVec3>,
}

impl Default for Shading {
    fn default() -> Self {
        Self { ambient: 0.2, diffuse: 0.7, specular: 0.3, power: 20.0, light: None }
    }
}

/// Everything that decides how a picture is made, besides volume, transfer function and camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Which renderer. What the others do not have (classification, evaluation, footprints; of all but axis-aligned sheets
    /// the layer axis) they ignore. Default: layered.
    pub algorithm: Algorithm,
    /// Which layer axis is taken. Default: the 45° rule.
    pub layer_axis: LayerAxis,
    /// Where splat sums are evaluated. Default: on a lattice about as fine as the screen.
    pub evaluation: Evaluation,
    /// Footprints of the direct evaluation. Default: exact.
    pub footprints: Footprints,
    /// How samples become colour and opacity. Default: pre-integrated.
    pub classification: Classification,
    /// What becomes of the values along a ray. Default: composited.
    pub blend: Blend,
    /// What of the volume is shown. Default: all.
    pub clipping: Clipping,
    /// Default: exponential, which is exact for homogeneous segments at any spacing.
    pub extinction: Extinction,
    /// Default: on.
    pub shading: Option<Shading>,
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
        Quality::Standard.settings()
    }
}

/// Bundles of settings.
///
/// `draft`, `standard` and `high` are pre-integrated: nearer to the integral than splat sums with sub-layers, in a third
/// of the time (docs/fidelity.md, docs/performance.md).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Quality {
    /// One sample per voxel and layer: the fastest.
    Draft,
    /// [`Density::Relaxed`], one sample per layer: what is best for the time.
    #[default]
    Standard,
    /// [`Density::Fine`], two samples per layer.
    High,
    /// The paper to the letter: per pixel, its footprint set, constant κ.
    Paper,
}

impl Quality {
    /// Classification after interpolation, with the correction that is best for the time of this bundle.
    pub fn splatted(self) -> Classification {
        Classification::Post(match self {
            Quality::Draft | Quality::Paper => Correction::Constant,
            Quality::Standard => Correction::SubLayers(2),
            Quality::High => Correction::SubLayers(4),
        })
    }

    /// The settings of the bundle.
    pub fn settings(self) -> Settings {
        let lattice = |density, samples_per_layer| {
            (Evaluation::Lattice(density), Footprints::Exact, Classification::Preintegrated { samples_per_layer })
        };
        let (evaluation, footprints, classification) = match self {
            Quality::Draft => lattice(Density::Fixed(1), 1),
            Quality::Standard => lattice(Density::Relaxed, 1),
            Quality::High => lattice(Density::Fine, 2),
            Quality::Paper => (Evaluation::Direct, Footprints::Set, self.splatted()),
        };
        Settings {
            algorithm: Algorithm::Layered,
            layer_axis: LayerAxis::Auto,
            evaluation,
            footprints,
            classification,
            blend: Blend::Composite,
            clipping: Clipping::default(),
            extinction: Extinction::Exponential,
            shading: Some(Shading::default()),
            early_termination: true,
            unit_distance: None,
            culling: true,
        }
    }
}

impl FromStr for Quality {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        match name {
            "draft" => Ok(Quality::Draft),
            "standard" => Ok(Quality::Standard),
            "high" => Ok(Quality::High),
            "paper" => Ok(Quality::Paper),
            _ => Err(format!("unknown quality '{name}': use draft, standard, high or paper")),
        }
    }
}

impl Settings {
    /// Transmittance at which early termination stops: 72 dB below white.
    pub const OPAQUE: f64 = 1.0 / 4096.0;

    /// Refuses blend modes that an algorithm cannot have.
    fn check_blend(&self) -> Result<(), Error> {
        let problem = match (self.blend, self.algorithm) {
            (Blend::Composite, _) => return Ok(()),
            (_, Algorithm::AxisSheets | Algorithm::ViewSheets { .. }) => {
                "sheets mix voxels with the background around them: only the blend mode composite has a meaning there"
            }
            (Blend::Iso(_), Algorithm::Layered) if matches!(self.classification, Classification::Post(_)) => {
                "splatted layers have no values between samples that could cross an iso-value: choose pre-integrated classification"
            }
            _ => return Ok(()),
        };
        Err(Error::Settings { field: "blend", problem: problem.into() })
    }

    /// Checks every number.
    pub(super) fn check(&self) -> Result<(), Error> {
        let refuse = |name, value: &dyn ToString, expected| Err(Error::OutOfRange { name, value: value.to_string(), expected });
        self.algorithm.check()?;
        self.blend.check()?;
        self.clipping.check()?;
        self.check_blend()?;
        if let Evaluation::Lattice(Density::Fixed(m) | Density::AtLeast(m)) = self.evaluation
            && !(1..=MAX_SAMPLES_PER_VOXEL).contains(&m)
        {
            return refuse("density", &m, "1 to 16 samples per voxel");
        }
        let samples = self.classification.samples_per_layer();
        let (most, expected) = match self.classification {
            Classification::Post(_) => (Correction::MAX_SUB_LAYERS, "1 to 16"),
            Classification::Preintegrated { .. } => (Classification::MAX_POINTS, "1 to 8 where classification is pre-integrated"),
        };
        if !(1..=most).contains(&samples) {
            return refuse("samples_per_layer", &samples, expected);
        }
        if let Some(d) = self.unit_distance.filter(|d| !(d.is_finite() && *d > 0.0)) {
            return refuse("unit_distance", &d, "a finite number above 0");
        }
        if let Some(s) = self.shading {
            let good = [s.ambient, s.diffuse, s.specular].iter().all(|c| (0.0..=100.0).contains(c));
            if !(good && s.power > 0.0 && s.power <= 1e4) {
                let value = format!("{},{},{},{}", s.ambient, s.diffuse, s.specular, s.power);
                return refuse("shading", &value, "ambient, diffuse and specular from 0 to 100, power above 0 and at most 10000");
            }
            if s.light.is_some_and(|l| l.try_normalize().is_none()) {
                return refuse("light", &s.light.unwrap_or_default(), "a finite vector other than 0");
            }
        }
        if self.footprints == Footprints::Set && matches!(self.classification, Classification::Preintegrated { .. }) {
            let problem = "the footprint set is for classification after interpolation: choose that, or exact footprints".into();
            return Err(Error::Settings { field: "classification", problem });
        }
        if self.footprints == Footprints::Set && self.evaluation != Evaluation::Direct {
            let problem = "the footprint set is for the direct evaluation: choose that, or exact footprints".into();
            return Err(Error::Settings { field: "evaluation", problem });
        }
        Ok(())
    }
}
