//! Options for quality and shading.

use super::{LightOptions, PlainOptions};
use crate::cli::algorithm::AlgorithmOptions;
use crate::cli::{names, parse};
use crate::image::Background;
use crate::layers::{Correction, Density, GradientEstimator, Kernel};
use crate::settings::{
    Algorithm, Classification, DepthCue, Evaluation, Footprints, GradientOpacity, LayerAxis, Layered, Quality, Settings,
};
use clap::Args;

/// Quality preset, and options that override its choices.
#[derive(Args)]
#[command(next_help_heading = "Quality")]
pub(in crate::cli) struct QualityOptions {
    #[command(flatten)]
    algorithm: AlgorithmOptions,
    /// Quality preset of layered [default: standard]
    #[arg(long, value_name = "NAME", value_parser = names::of::<Quality>())]
    quality: Option<Quality>,
    /// Classify samples (post) or ray segments (preintegrated)
    #[arg(long, value_name = "NAME", value_parser = names::of::<Classification>())]
    classification: Option<Classification>,
    /// Layer-overlap correction; implies --classification post
    #[arg(long, value_name = "NAME", value_parser = names::of::<Correction>())]
    correction: Option<Correction>,
    /// Samples per layer, 1 to 8; with --classification post 1 to 16 [default: by --quality, more where opacity is steep]
    #[arg(long, value_parser = parse::sub_layers, value_name = "N", allow_hyphen_values = true)]
    sublayers: Option<u32>,
    /// Estimation of gradients: central (differences), sobel (smoothed, hides terraces and noise), gaussian:SIGMA (smoothed more, SIGMA 0.3 to
    /// 2 voxels) or own (derivative of the kernel) [default: sobel for layers; central for splats; ray casting: own if the kernel has one]
    #[arg(long, value_name = "NAME")]
    gradient: Option<GradientEstimator>,
    /// Scale opacity by F at gradient magnitude G, interpolated linearly; 5:0,20:1 hides uniform regions, shows boundaries
    #[arg(long, value_parser = parse::gradient_opacity, value_name = "G:F,G:F")]
    gradient_opacity: Option<GradientOpacity>,
    /// Fade colours to the background with their distance: 0 at the front of the volume's (cropped) box, STRENGTH at its back
    #[arg(long, value_parser = parse::number(DepthCue::STRENGTH), value_name = "STRENGTH", allow_hyphen_values = true)]
    depth_cue: Option<f64>,
    /// Sampling lattice: auto, direct (per pixel), or N samples per voxel, 1 to 16
    #[arg(long, value_parser = parse::lattice, value_name = "direct|auto|N", allow_hyphen_values = true)]
    lattice: Option<Evaluation>,
    /// Footprint evaluation: exact, or the paper's set (needs --lattice direct, implies --classification post)
    #[arg(long, value_name = "NAME", value_parser = names::of::<Footprints>())]
    footprints: Option<Footprints>,
    /// Layer axis; auto is the most parallel to the view (45° rule)
    #[arg(long, default_value = "auto", value_parser = names::of::<LayerAxis>(), value_name = "AXIS")]
    layer_axis: LayerAxis,
    #[command(flatten)]
    plain: PlainOptions,
    // Last, since a flattened group's heading also applies to the options behind it.
    #[command(flatten)]
    pub light: LightOptions,
}

/// The colour that shows where nothing covers the background.
fn color_under_picture(background: Option<Background>) -> [f64; 3] {
    match background {
        Some(Background::Color(color)) => color.map(f64::from),
        Some(Background::Transparent) | None => [0.0; 3],
    }
}

impl QualityOptions {
    /// The settings of the quality preset with the options applied. Depth cueing fades colours to the background, or to black if it is
    /// transparent.
    ///
    /// # Errors
    /// [`crate::Error::Settings`] for conflicting options.
    pub fn settings(&self, background: Option<Background>) -> Result<Settings, crate::Error> {
        self.settings_with_light(&self.light, background)
    }

    /// As [`settings`](Self::settings), with other options of light.
    pub fn settings_with_light(&self, light: &LightOptions, background: Option<Background>) -> Result<Settings, crate::Error> {
        let algorithm = self.algorithm.algorithm(self.quality().layered(), self.layer_axis)?;
        self.check_support(algorithm)?;
        let algorithm = match algorithm {
            Algorithm::Layered(own) => self.layered(own)?.into(),
            other => other,
        };
        let settings = self.plain.apply(light.apply(Settings::from(algorithm))?)?;
        Ok(Settings {
            gradient: self.gradient.or(settings.gradient),
            gradient_opacity: self.gradient_opacity,
            depth_cue: self.depth_cue.map(|strength| DepthCue { strength, color: color_under_picture(background) }),
            ..settings
        })
    }

    /// The preset's settings of layered rendering with the options applied.
    fn layered(&self, own: Layered) -> Result<Layered, crate::Error> {
        let classification = self.classification(own.classification)?;
        let evaluation = match (self.lattice, own.evaluation) {
            (None, own) => own,
            // `auto` keeps the density of presets that adapt it to the view.
            (Some(Evaluation::Lattice(Density::Relaxed)), Evaluation::Lattice(own @ Density::Fine)) => Evaluation::Lattice(own),
            (Some(evaluation), _) => evaluation,
        };
        let footprints = match self.footprints {
            // The footprint set belongs to the paper's direct evaluation and does not apply to a lattice.
            None if self.lattice.is_some() && evaluation != Evaluation::Direct => Footprints::Exact,
            given => given.unwrap_or(own.footprints),
        };
        // Explicit numbers of samples are kept.
        let adapts_to_opacity = self.sublayers.is_none();
        Ok(Layered { classification, evaluation, footprints, adapts_to_opacity, ..own })
    }

    /// The quality preset that was given.
    #[cfg(feature = "viewer")]
    pub fn given_quality(&self) -> Option<Quality> {
        self.quality
    }

    /// The kernel that was given.
    pub fn given_kernel(&self) -> Option<Kernel> {
        self.algorithm.kernel
    }

    /// The quality preset.
    pub fn quality(&self) -> Quality {
        self.quality.unwrap_or_default()
    }

    /// Fails for options that the algorithm does not support.
    fn check_support(&self, algorithm: Algorithm) -> Result<(), crate::Error> {
        if let Algorithm::Layered(_) = algorithm {
            return Ok(());
        }
        algorithm.reject(&[
            ("quality", self.quality.is_some()),
            ("classification", self.classification.is_some()),
            ("correction", self.correction.is_some()),
            ("samples_per_layer", self.sublayers.is_some()),
            ("evaluation", self.lattice.is_some()),
            ("footprints", self.footprints.is_some()),
        ])
    }

    /// The classification. Corrections and the footprint set apply to post-classification only, and imply it.
    fn classification(&self, own: Classification) -> Result<Classification, crate::Error> {
        let conflict = |problem: &str| Err(crate::Error::Settings { field: "correction", problem: problem.into() });
        let given_kernel = self.algorithm.kernel;
        let post = match (self.classification, own) {
            (Some(Classification::Post(_)), _) => true,
            (Some(Classification::Preintegrated { .. }), _) => false,
            (None, own) => {
                let implied = self.correction.is_some() || self.footprints == Some(Footprints::Set);
                implied || matches!(own, Classification::Post(_))
            }
        };
        if !post {
            if self.correction.is_some() {
                return conflict("it does not apply to --classification preintegrated: omit one of them");
            }
            let (kernel, points) = match own {
                Classification::Preintegrated { kernel, samples_per_layer } => (kernel, samples_per_layer),
                Classification::Post(_) => (Kernel::Cubic, 1),
            };
            return Ok(Classification::Preintegrated {
                kernel: given_kernel.unwrap_or(kernel),
                samples_per_layer: self.sublayers.unwrap_or(points),
            });
        }
        if given_kernel.is_some_and(|kernel| kernel != Kernel::Cubic) {
            let problem = "splats use the paper's cubic: omit the kernel, or use --classification preintegrated".into();
            return Err(crate::Error::Settings { field: "kernel", problem });
        }
        Ok(match (self.correction, self.sublayers) {
            (None, None) => match own {
                Classification::Post(_) => own,
                Classification::Preintegrated { .. } => self.quality().splatted(),
            },
            (None | Some(Correction::SubLayers(_)), Some(n)) => Classification::Post(Correction::SubLayers(n)),
            (Some(Correction::SubLayers(_)), None) => Classification::Post(Correction::SubLayers(own.samples_per_layer().max(2))),
            (Some(correction), None) => Classification::Post(correction),
            (Some(_), Some(_)) => {
                return conflict("only --correction sublayers takes a number of sub-layers: omit one of them");
            }
        })
    }
}
