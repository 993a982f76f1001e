//! Which method draws what with which blend mode. Refusals, the guide and tests read this table.

use super::{Algorithm, Blend, Classification, Evaluation, Layered, Settings};
use crate::choice::choices;
use crate::error::Error;
use crate::layers::Kernel;

/// A way to make a picture.
///
/// ```
/// use layersplat::settings::{Method, Settings};
///
/// assert_eq!(Method::of(Settings::default().algorithm), Method::Preintegrated);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// Layers on a lattice with pre-integrated classification.
    Preintegrated,
    /// Splatted layers on a lattice.
    Splats,
    /// Layers with pre-integrated classification, sampled by each pixel.
    PreintegratedPixels,
    /// Splatted layers, evaluated by each pixel.
    SplatPixels,
    /// Ray casting.
    Rays,
    /// Pre-integrated slicing.
    Slicing,
    /// Axis-aligned sheets.
    AxisSheets,
    /// Image-aligned sheets.
    ViewSheets,
    /// Depths of a picture, which are found by ray casting.
    Depths,
    /// Slices of the volume. They have no blend mode.
    Slices,
}

choices! {
    Method, "method";
    Preintegrated = "pre-integrated layers",
    Splats = "splatted layers",
    PreintegratedPixels = "pre-integrated layers per pixel",
    SplatPixels = "splatted layers per pixel",
    Rays = "ray casting",
    Slicing = "slicing",
    AxisSheets = "axis-sheets",
    ViewSheets = "view-sheets",
    Depths = "depths",
    Slices = "slices",
}

impl Method {
    /// The method of an algorithm, in views that its lattice covers.
    pub fn of(algorithm: Algorithm) -> Self {
        match algorithm {
            Algorithm::Layered(Layered { evaluation, classification, .. }) => match (evaluation, classification) {
                (Evaluation::Lattice(_), Classification::Preintegrated { .. }) => Self::Preintegrated,
                (Evaluation::Lattice(_), Classification::Post(_)) => Self::Splats,
                (Evaluation::Direct, Classification::Preintegrated { .. }) => Self::PreintegratedPixels,
                (Evaluation::Direct, Classification::Post(_)) => Self::SplatPixels,
            },
            Algorithm::AxisSheets { .. } => Self::AxisSheets,
            Algorithm::ViewSheets { .. } => Self::ViewSheets,
            Algorithm::Slicing { .. } => Self::Slicing,
            Algorithm::Raycast { .. } => Self::Rays,
        }
    }
}

/// What a renderer draws. Programs ask it which settings go with that, so that they need no list of their own.
///
/// ```
/// use layersplat::settings::{Blend, FieldKind, Settings};
///
/// let maximum = Settings { blend: Blend::Maximum, ..Settings::default() };
/// assert!(FieldKind::One.check(&maximum).is_ok() && FieldKind::Colors.check(&maximum).is_err());
/// assert!(FieldKind::Several.check(&Settings::default()).is_ok());
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FieldKind {
    /// The values of one field.
    One,
    /// The values of one field in the colours of labels.
    LabelColors,
    /// Several fields.
    Several,
    /// Several fields, of which some have colours instead of values, or labels.
    Mixed,
    /// Colours.
    Colors,
    /// Labels, which are drawn as colours.
    Labels,
}

choices! {
    FieldKind, "field_kind";
    One = "one field",
    LabelColors = "in the colours of labels",
    Several = "several fields",
    Mixed = "colours or labels among them",
    Colors = "colours",
    Labels = "labels",
}

impl Settings {
    /// Fails for settings with which no surfaces are drawn.
    ///
    /// # Errors
    /// [`Error::Settings`]: splatted layers, and the systems that the paper compares with.
    pub fn check_surfaces(&self) -> Result<(), Error> {
        let (field, problem) = match Method::of(self.algorithm) {
            Method::Splats | Method::SplatPixels => (
                "classification",
                "splatted layers draw no surfaces: choose pre-integrated layers or ray casting, or no surfaces",
            ),
            Method::AxisSheets | Method::ViewSheets | Method::Slicing => {
                ("algorithm", "sheets and slicing draw no surfaces: choose layers or ray casting, or no surfaces")
            }
            _ => return Ok(()),
        };
        Err(Error::Settings { field, problem: problem.into() })
    }
}

/// A setting, and why it does not go with what is drawn.
type Refusal = (&'static str, &'static str);

impl FieldKind {
    /// Fails for settings with which no view is drawn.
    ///
    /// # Errors
    /// [`Error::Settings`], as of the frame.
    pub fn check(self, settings: &Settings) -> Result<(), Error> {
        self.check_method(Method::of(settings.algorithm), settings.blend)?;
        if settings.studio.is_some() && self == Self::LabelColors {
            let problem =
                "the studio draws no colours of labels over one scan: draw the labels beside it, or choose the plain look";
            return Err(Error::Settings { field: "look", problem: problem.into() });
        }
        match (self, settings.algorithm) {
            (Self::Colors | Self::Labels | Self::Mixed, Algorithm::Raycast { kernel: Kernel::Gaussian, .. }) => {
                let problem = "reconstructs single values, which volumes of colours and labels do not have: choose another";
                Err(Error::Settings { field: "kernel", problem: problem.into() })
            }
            _ => Ok(()),
        }
    }

    /// Fails for a method that does not draw this with a blend mode.
    ///
    /// # Errors
    /// [`Error::Settings`], as of the frame.
    pub fn check_method(self, method: Method, blend: Blend) -> Result<(), Error> {
        match self.refusal(method, blend) {
            Some((field, problem)) => Err(Error::Settings { field, problem: problem.into() }),
            None => Ok(()),
        }
    }

    /// The table: why a method does not draw this with a blend mode.
    fn refusal(self, method: Method, blend: Blend) -> Option<Refusal> {
        use Blend::{Average, Composite, Iso, Maximum, Minimum};
        use FieldKind::{Colors, LabelColors, Labels, Mixed, One, Several};
        use Method::*;
        let refusal = match (self, method, blend) {
            // These exist for nothing that is drawn.
            (_, AxisSheets | ViewSheets, Maximum | Minimum | Average | Iso(_)) => {
                ("blend", "sheets mix voxels with the surrounding background: only the blend mode composite is supported")
            }
            (_, Splats | SplatPixels, Iso(_)) => (
                "blend",
                "splatted layers have no values between samples, which iso-surfaces require: choose pre-integrated classification",
            ),
            (_, Depths, Maximum | Minimum | Average) => ("blend", "depths exist only for the blend modes composite and iso"),
            (One, ..) => return None,

            (LabelColors, Slices, _) => ("label_colors", "slices do not show them: omit them"),
            (LabelColors, _, Maximum | Minimum | Average) => {
                ("blend", "reduces values, which have no colours of labels: omit one of both")
            }
            (LabelColors, Preintegrated | Rays | Depths, Composite | Iso(_)) => return None,
            (LabelColors, PreintegratedPixels | SplatPixels, _) => {
                ("label_colors", "layers per pixel do not show them: omit them, or choose layers on a lattice or ray casting")
            }
            (LabelColors, Splats, _) => {
                ("label_colors", "splatted layers do not show them: omit them, or choose pre-integrated layers or ray casting")
            }
            (LabelColors, Slicing | AxisSheets | ViewSheets, _) => {
                ("label_colors", "this algorithm does not show them: omit them, or choose pre-integrated layers or ray casting")
            }

            (Several | Mixed, Slices, _) => ("channels", "slices show one channel: show one alone"),
            (Mixed, _, Maximum | Minimum | Average) => {
                ("blend", "takes values, and colours and labels have none: hide them, or draw the composited picture")
            }
            (Mixed, Preintegrated | Rays | Depths, Composite) => return None,
            (Mixed, Preintegrated | Rays | Depths, Iso(_)) => {
                ("blend", "draws surfaces at a value, and colours have none: hide them, or draw the composited picture")
            }
            (Mixed, Splats, _) => {
                ("classification", "splats values, and colours and labels among the fields have none: omit it, or hide them")
            }

            (Several, Preintegrated | Splats, _) | (Several, Rays | Depths, Composite) => return None,
            (Several, Rays, _) => (
                "channels",
                "rays of this blend mode show one channel: show one alone, or choose layers, and a view that their lattice covers",
            ),
            (Several, Depths, _) => ("channels", "depths of surfaces are those of one channel: show one alone"),
            (Several | Mixed, PreintegratedPixels | SplatPixels, _) => {
                ("channels", "layers per pixel show one channel: show one alone, or choose layers on a lattice or ray casting")
            }
            (Several | Mixed, Slicing | AxisSheets | ViewSheets, _) => {
                ("channels", "this algorithm shows one channel: choose pre-integrated layers or ray casting")
            }

            (Colors | Labels, Slices, _) => ("channels", "slices show single values, which colours and labels do not have"),
            (Colors, _, Maximum | Minimum | Average | Iso(_)) => {
                ("blend", "reduces single values, which volumes of colours do not have: omit it, or choose one channel")
            }
            (Labels, _, Maximum | Minimum | Average | Iso(_)) => {
                ("blend", "reduces single values, which volumes of labels do not have: omit it")
            }
            (Colors | Labels, Preintegrated | Rays | Depths, Composite) => return None,
            (Colors | Labels, PreintegratedPixels | SplatPixels, Composite) => {
                ("evaluation", "layers per pixel show single values: choose layers on a lattice or ray casting")
            }
            (Colors | Labels, Splats, Composite) => {
                ("classification", "splats single values, which volumes of colours and labels do not have: omit it")
            }
            (Colors | Labels, Slicing | AxisSheets | ViewSheets, Composite) => {
                ("algorithm", "classifies single values, which volumes of colours and labels do not have: omit it")
            }
        };
        Some(refusal)
    }
}
