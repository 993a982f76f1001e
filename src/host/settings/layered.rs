//! Settings of layered rendering: sampling, classification and evaluation of layers.

use super::Quality;
use crate::choice::{Choice, choices};
use crate::error::Error;
use crate::layers::{Axis, Correction, Density, Kernel, MAX_SAMPLES_PER_VOXEL};

/// Selection of the layer axis.
///
/// ```
/// use layersplat::Axis;
/// use layersplat::settings::{Algorithm, LayerAxis, Settings};
///
/// let algorithm = Algorithm::default().along(LayerAxis::Forced(Axis::X));
/// let settings = Settings { algorithm, ..Settings::default() };
/// assert_eq!(settings.layered().map(|layered| layered.layer_axis), Some(LayerAxis::Forced(Axis::X)));
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LayerAxis {
    /// The axis most parallel to the view in voxel units (the 45° rule).
    #[default]
    Auto,
    /// A fixed axis. An error if the view deviates from it by more than three voxels per layer.
    Forced(Axis),
}

impl Choice for LayerAxis {
    const FIELD: &'static str = "layer_axis";
    const ALL: &'static [Self] = &[Self::Auto, Self::Forced(Axis::X), Self::Forced(Axis::Y), Self::Forced(Axis::Z)];

    fn name(self) -> &'static str {
        match self {
            LayerAxis::Auto => "auto",
            LayerAxis::Forced(axis) => ["x", "y", "z"][axis.index()],
        }
    }
}

/// Evaluation of layer samples.
///
/// ```
/// use layersplat::Quality;
/// use layersplat::settings::{Evaluation, Layered, Settings};
///
/// // No lattice: each pixel samples the layers itself.
/// let per_pixel = Layered { evaluation: Evaluation::Direct, ..Quality::Standard.layered() };
/// let settings = Settings::from(per_pixel);
/// assert_eq!(settings.layered(), Some(per_pixel));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Evaluation {
    /// On the sheared lattice; per pixel where no lattice covers the view.
    Lattice(Density),
    /// Per screen pixel (the paper).
    Direct,
}

/// Classification of samples.
///
/// ```
/// use layersplat::settings::Classification;
/// use layersplat::{Kernel, Quality};
///
/// let Classification::Preintegrated { kernel, .. } = Quality::High.layered().classification else { panic!() };
/// assert_eq!(kernel, Kernel::BSpline);
/// assert!(matches!(Quality::Paper.layered().classification, Classification::Post(_)));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Classification {
    /// Each sample after interpolation (the paper). Samples combine the splat sums of three layers.
    Post(Correction),
    /// The segment between two samples, over all values in between. Layers are sampled where rays cross them, `samples_per_layer` times
    /// per layer (1 … [`Classification::MAX_POINTS`]).
    Preintegrated {
        /// Reconstruction kernel, one of [`Kernel::OF_LAYERS`].
        kernel: Kernel,
        /// Samples per layer.
        samples_per_layer: u32,
    },
}

choices! {
    Classification, "classification";
    Post(Correction::SubLayers(2)) = "post",
    Preintegrated { kernel: Kernel::Cubic, samples_per_layer: 1 } = "preintegrated",
}

impl Classification {
    /// Largest number of samples per layer with pre-integration.
    pub const MAX_POINTS: u32 = 8;

    /// Sets the kernel of pre-integrated classification; splats always use the paper's cubic.
    pub fn with_kernel(self, kernel: Kernel) -> Self {
        match self {
            Classification::Post(_) => self,
            Classification::Preintegrated { samples_per_layer, .. } => {
                Classification::Preintegrated { kernel, samples_per_layer }
            }
        }
    }

    /// Samples per layer.
    pub fn samples_per_layer(self) -> u32 {
        match self {
            Classification::Post(correction) => correction.samples_per_layer(),
            Classification::Preintegrated { samples_per_layer, .. } => samples_per_layer,
        }
    }
}

/// Source of the footprints for [`Evaluation::Direct`].
///
/// ```
/// use layersplat::settings::{Footprints, Layered, Settings};
///
/// let paper = layersplat::Quality::Paper.layered();
/// let settings = Settings::from(Layered { footprints: Footprints::Set, ..paper });
/// assert_eq!(settings.layered().map(|layered| layered.footprints), Some(Footprints::Set));
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Footprints {
    /// Computed for each view.
    #[default]
    Exact,
    /// The nearest of the paper's 856 oriented images of 64² bytes (§3.2).
    Set,
}

choices! { Footprints, "footprints"; Exact = "exact", Set = "set" }

/// Settings of layered rendering.
///
/// ```
/// use layersplat::Density;
/// use layersplat::settings::{Evaluation, Layered, Settings};
///
/// let layered = Layered { evaluation: Evaluation::Lattice(Density::Fine), ..Layered::default() };
/// let settings = Settings::from(layered);
/// assert_eq!(settings.layered(), Some(layered));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layered {
    /// Layer axis. Default: the 45° rule.
    pub layer_axis: LayerAxis,
    /// Evaluation of samples. Default: on a lattice about as fine as the screen.
    pub evaluation: Evaluation,
    /// Classification of samples. Default: pre-integrated.
    pub classification: Classification,
    /// Footprints for direct evaluation of splatted layers. Default: exact. The set is an error in other modes.
    pub footprints: Footprints,
    /// Whether [`Density::Relaxed`] and [`Density::Fine`] become denser where the transfer function is
    /// [steep](crate::TransferFunction::steepness): up to [`Density::Screen`], and more samples per layer. Default: yes. It applies to
    /// pre-integrated compositing.
    pub adapts_to_opacity: bool,
}

impl Default for Layered {
    fn default() -> Self {
        Quality::Standard.layered()
    }
}

impl Layered {
    /// Checks ranges and combinations.
    pub(super) fn check(&self) -> Result<(), Error> {
        let refuse = |name, value: &dyn ToString, expected| Err(Error::OutOfRange { name, value: value.to_string(), expected });
        if let Evaluation::Lattice(Density::Fixed(m) | Density::AtLeast(m)) = self.evaluation
            && !(1..=MAX_SAMPLES_PER_VOXEL).contains(&m)
        {
            return refuse("density", &m, "1 to 16 samples per voxel");
        }
        let samples = self.classification.samples_per_layer();
        let (most, expected) = match self.classification {
            Classification::Post(_) => (Correction::MAX_SUB_LAYERS, "1 to 16"),
            Classification::Preintegrated { .. } => (Classification::MAX_POINTS, "1 to 8 with pre-integrated classification"),
        };
        if !(1..=most).contains(&samples) {
            return refuse("samples_per_layer", &samples, expected);
        }
        if let Classification::Preintegrated { kernel, .. } = self.classification
            && !Kernel::OF_LAYERS.contains(&kernel)
        {
            let problem = format!(
                "layers cannot be sampled with the {} kernel, because its weights do not sum to one: choose \
                                   another kernel",
                kernel.name()
            );
            return Err(Error::Settings { field: "kernel", problem });
        }
        if self.footprints == Footprints::Set && matches!(self.classification, Classification::Preintegrated { .. }) {
            let problem =
                "the footprint set requires classification after interpolation: choose that, or exact footprints".into();
            return Err(Error::Settings { field: "classification", problem });
        }
        if self.footprints == Footprints::Set && self.evaluation != Evaluation::Direct {
            let problem = "the footprint set requires direct evaluation: choose that, or exact footprints".into();
            return Err(Error::Settings { field: "evaluation", problem });
        }
        Ok(())
    }
}
