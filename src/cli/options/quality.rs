//! How pictures are made.

use crate::cli::algorithm::{AlgorithmOptions, no_meaning};
use crate::cli::parse;
use crate::layers::{Correction, Density, Kernel};
use crate::settings::{
    Algorithm, Classification, Evaluation, Footprints, GradientOpacity, LayerAxis, Layered, Light, Lights, Quality, Settings,
    Shading,
};
use crate::transfer::Extinction;
use clap::{Args, ValueEnum};

/// How the picture is made. Each option overrides the quality's choice.
#[derive(Args)]
#[command(next_help_heading = "Quality")]
pub(in crate::cli) struct QualityOptions {
    #[command(flatten)]
    algorithm: AlgorithmOptions,
    /// draft, standard, high or paper [default: standard; of --algorithm layered]
    #[arg(long)]
    quality: Option<Quality>,
    /// When samples become colours: each after interpolation, or each segment between two as a whole
    #[arg(long)]
    classification: Option<ClassificationName>,
    /// What makes up for kernels that reach into neighbouring layers; implies --classification post
    #[arg(long)]
    correction: Option<CorrectionName>,
    /// Samples per layer: 1 to 8; with --classification post 1 to 16
    #[arg(long, value_parser = parse::sub_layers, value_name = "N", allow_hyphen_values = true)]
    sublayers: Option<u32>,
    /// How opacity becomes attenuation over a distance
    #[arg(long)]
    extinction: Option<ExtinctionName>,
    /// on or off
    #[arg(long, value_parser = parse::switch)]
    shading: Option<bool>,
    /// Direction to a light, in world coordinates, or camera, and its strength (1): white, and on both sides of surfaces; may be given up to
    /// four times [default: camera]
    #[arg(long, value_parser = parse::light, value_name = "X,Y,Z[:S]", allow_hyphen_values = true)]
    light: Vec<Light>,
    /// What is left of the opacity where the field changes by so much, in values per world distance: G:FACTOR,G:FACTOR,…, even between;
    /// "5:0,20:1" hides what lies even and shows where materials meet
    #[arg(long, value_parser = parse::gradient_opacity, value_name = "G:F,G:F")]
    gradient_opacity: Option<GradientOpacity>,
    /// auto, direct (per pixel) or samples per voxel, 1 to 16
    #[arg(long, value_parser = parse::lattice, value_name = "auto|direct|N", allow_hyphen_values = true)]
    lattice: Option<Evaluation>,
    /// Source of the footprints; the set goes with --lattice direct, and implies --classification post
    #[arg(long)]
    footprints: Option<FootprintsName>,
    /// Whether opaque tiles stop: on or off
    #[arg(long, value_parser = parse::switch)]
    early_termination: Option<bool>,
    /// auto (the 45° rule), x, y or z
    #[arg(long, default_value = "auto", value_parser = parse::layer_axis)]
    layer_axis: LayerAxis,
    /// World distance that opacities are for [default: the smallest spacing]
    #[arg(long, value_parser = parse::positive, value_name = "D", allow_hyphen_values = true)]
    unit_distance: Option<f64>,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum ClassificationName {
    Post,
    Preintegrated,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum CorrectionName {
    None,
    Constant,
    Sublayers,
}

#[derive(Clone, Copy, ValueEnum)]
enum ExtinctionName {
    Exponential,
    Linear,
}

#[derive(Clone, Copy, ValueEnum)]
enum FootprintsName {
    Exact,
    Set,
}

impl QualityOptions {
    /// The quality's settings with what was asked for otherwise, or what is contradictory.
    pub fn settings(&self) -> Result<Settings, crate::Error> {
        let algorithm = self.algorithm.algorithm(self.quality().layered(), self.layer_axis)?;
        self.check_meaning(algorithm)?;
        let algorithm = match algorithm {
            Algorithm::Layered(own) => self.layered(own)?.into(),
            other => other,
        };
        let settings = Settings::from(algorithm);
        Ok(Settings {
            unit_distance: self.unit_distance,
            extinction: match self.extinction {
                None => settings.extinction,
                Some(ExtinctionName::Exponential) => Extinction::Exponential,
                Some(ExtinctionName::Linear) => Extinction::Linear,
            },
            shading: self.lit(settings.shading)?,
            gradient_opacity: self.gradient_opacity,
            early_termination: self.early_termination.unwrap_or(settings.early_termination),
            ..settings
        })
    }

    /// The settings' shading with what was asked for otherwise.
    fn lit(&self, own: Option<Shading>) -> Result<Option<Shading>, crate::Error> {
        let shading = self.shading.map_or(own, |on| on.then(Shading::default));
        match shading {
            _ if self.light.is_empty() => Ok(shading),
            Some(shading) => Ok(Some(Shading { lights: Lights::new(&self.light)?, ..shading })),
            None => {
                let problem = "nothing is shaded: leave it out, or switch shading on".into();
                Err(crate::Error::Settings { field: "light", problem })
            }
        }
    }

    /// The quality's choices of layered rendering with what was asked for otherwise.
    fn layered(&self, own: Layered) -> Result<Layered, crate::Error> {
        let classification = self.classification(own.classification)?;
        let evaluation = match (self.lattice, own.evaluation) {
            (None, own) => own,
            // `auto` leaves a quality its own density, unless that is a number or none.
            (Some(Evaluation::Lattice(Density::Relaxed)), Evaluation::Lattice(own @ Density::Fine)) => Evaluation::Lattice(own),
            (Some(evaluation), _) => evaluation,
        };
        let footprints = match self.footprints {
            // The set comes with the paper's direct evaluation; on a lattice it has no meaning.
            None if self.lattice.is_some() && evaluation != Evaluation::Direct => Footprints::Exact,
            None => own.footprints,
            Some(FootprintsName::Exact) => Footprints::Exact,
            Some(FootprintsName::Set) => Footprints::Set,
        };
        Ok(Layered { classification, evaluation, footprints, ..own })
    }

    /// The bundle that the options begin with.
    pub fn quality(&self) -> Quality {
        self.quality.unwrap_or_default()
    }

    /// Refuses options that an algorithm does not have.
    fn check_meaning(&self, algorithm: Algorithm) -> Result<(), crate::Error> {
        if let Algorithm::Layered(_) = algorithm {
            return Ok(());
        }
        let layer_axis = self.layer_axis != LayerAxis::Auto && !matches!(algorithm, Algorithm::AxisSheets { .. });
        let given = [
            (self.quality.is_some(), "quality"),
            (self.classification.is_some(), "classification"),
            (self.correction.is_some(), "correction"),
            (self.sublayers.is_some(), "samples_per_layer"),
            (self.lattice.is_some(), "evaluation"),
            (self.footprints.is_some(), "footprints"),
            (layer_axis, "layer_axis"),
        ];
        no_meaning(algorithm, &given)
    }

    /// Corrections and the footprint set are for classification after interpolation, and imply it.
    fn classification(&self, own: Classification) -> Result<Classification, crate::Error> {
        let conflict = |problem: &str| Err(crate::Error::Settings { field: "correction", problem: problem.into() });
        let asked_kernel = self.algorithm.kernel();
        let post = match (self.classification, own) {
            (Some(ClassificationName::Post), _) => true,
            (Some(ClassificationName::Preintegrated), _) => false,
            (None, own) => {
                let for_post = self.correction.is_some() || matches!(self.footprints, Some(FootprintsName::Set));
                for_post || matches!(own, Classification::Post(_))
            }
        };
        if !post {
            if self.correction.is_some() {
                return conflict("it has no meaning where classification is pre-integrated: leave one of them out");
            }
            let (kernel, points) = match own {
                Classification::Preintegrated { kernel, samples_per_layer } => (kernel, samples_per_layer),
                Classification::Post(_) => (Kernel::Cubic, 1),
            };
            return Ok(Classification::Preintegrated {
                kernel: asked_kernel.unwrap_or(kernel),
                samples_per_layer: self.sublayers.unwrap_or(points),
            });
        }
        if asked_kernel.is_some_and(|kernel| kernel != Kernel::Cubic) {
            let problem = "splats are the paper's cubic: leave it out, or choose --classification preintegrated".into();
            return Err(crate::Error::Settings { field: "kernel", problem });
        }
        Ok(match (self.correction, self.sublayers) {
            (None, None) => match own {
                Classification::Post(_) => own,
                Classification::Preintegrated { .. } => self.quality().splatted(),
            },
            (None | Some(CorrectionName::Sublayers), Some(n)) => Classification::Post(Correction::SubLayers(n)),
            (Some(CorrectionName::Sublayers), None) => {
                Classification::Post(Correction::SubLayers(own.samples_per_layer().max(2)))
            }
            (Some(CorrectionName::None), None) => Classification::Post(Correction::None),
            (Some(CorrectionName::Constant), None) => Classification::Post(Correction::Constant),
            (Some(_), Some(_)) => {
                return conflict("only that by sub-layers takes a number of them: leave one of them out");
            }
        })
    }
}
