//! Render settings: common and algorithm-specific options.

mod algorithm;
mod argument;
mod arguments;
mod blend;
mod clipping;
mod depth_cue;
mod described;
mod gradient_opacity;
mod layered;
mod lights;
mod methods;
mod number;
mod quality;
mod shading;
mod shadows;
mod studio;

pub use crate::color::Tone;
pub use algorithm::{Algorithm, AlgorithmOptions};
pub use argument::Argument;
pub use blend::Blend;
pub use clipping::{ClipPlane, Clipping, CropBox};
pub use depth_cue::DepthCue;
pub use described::{Kind, Setting};
pub use gradient_opacity::GradientOpacity;
pub use layered::{Classification, Evaluation, Footprints, LayerAxis, Layered};
#[doc(hidden)]
pub use lights::WHITE;
pub use lights::{Light, LightSpace, Lights};
pub use methods::{FieldKind, Method};
use number::ABOVE_0;
pub use number::Number;
pub use quality::Quality;
pub use shading::Shading;
pub use shadows::{AmbientOcclusion, LightGrid, Shadows};
pub use studio::{Look, Sky, Studio};

use crate::camera::Camera;
use crate::choice::in_words;
use crate::color::{Curve, Exposure};
use crate::error::Error;
use crate::layers::{GradientEstimator, Kernel};
use crate::transfer::Extinction;

/// All render settings besides volume, transfer function and camera.
///
/// ```
/// use layersplat::settings::{Blend, Settings};
/// use layersplat::Quality;
///
/// // Maximum intensity projection in the highest quality.
/// let settings = Settings { blend: Blend::Maximum, ..Quality::High.settings() };
/// assert!(settings.layered().is_some());
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Rendering algorithm and its options. Default: layered.
    pub algorithm: Algorithm,
    /// Blend mode. Default: compositing.
    pub blend: Blend,
    /// Clipping. Default: none.
    pub clipping: Clipping,
    /// Attenuation model. Default: exponential, which is exact for homogeneous segments of any length.
    pub extinction: Extinction,
    /// Shading; `None` disables it. Default: on.
    pub shading: Option<Shading>,
    /// Scattered light in linear colours; `None` for the plain look. Default: none. It needs shading, and compositing.
    pub studio: Option<Studio>,
    /// Shadows of the lights. Default: none. They need shading, and compositing or an iso-surface.
    pub shadows: Option<Shadows>,
    /// Ambient occlusion. Default: none. It needs what shadows need.
    pub ambient_occlusion: Option<AmbientOcclusion>,
    /// Resolution of shadows and ambient occlusion, and of scattered light. Default: full.
    pub light_grid: LightGrid,
    /// Estimation of gradients for shading and gradient opacity. Default: `None`, which is [`GradientEstimator::Sobel`] for layers with
    /// pre-integrated classification, [`GradientEstimator::for_kernel`] for ray casting, and central differences elsewhere. Sheets and
    /// slices support nothing but central differences.
    pub gradient: Option<GradientEstimator>,
    /// Gradient opacity. Default: none.
    pub gradient_opacity: Option<GradientOpacity>,
    /// Depth cueing. Default: none. Ignored where shading is: by the blend modes maximum, minimum and average.
    pub depth_cue: Option<DepthCue>,
    /// Whether tiles stop when all their rays transmit less than 1/4096 of the light. Default: on. The error is below half a step of an
    /// 8-bit picture.
    pub early_termination: bool,
    /// Width of a pixel in heights of a pixel, 1/16 … 16: the viewport is this much wider in the world. Framing and annotations take
    /// pixels as square. Default: 1.
    pub pixel_aspect: f64,
    /// World distance to which the opacities apply. Default: [`Grid::unit`](crate::volume::Grid::unit).
    pub unit_distance: Option<f64>,
    /// Gamma of pictures of 8 and 16 bits, 0.2 … 5: their straight colours are raised to 1/gamma. Pictures of floats are unaffected.
    /// Default: 1.
    pub gamma: f64,
    /// Whether invisible layers are skipped. Does not change any bit of the picture; disabling it serves verification only.
    pub culling: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Algorithm::default().into()
    }
}

impl From<Algorithm> for Settings {
    /// The algorithm with default common settings.
    fn from(algorithm: Algorithm) -> Self {
        Self {
            algorithm,
            blend: Blend::Composite,
            clipping: Clipping::default(),
            extinction: Extinction::Exponential,
            shading: Some(Shading::default()),
            studio: None,
            shadows: None,
            ambient_occlusion: None,
            light_grid: LightGrid::Full,
            gradient: None,
            gradient_opacity: None,
            depth_cue: None,
            early_termination: true,
            pixel_aspect: 1.0,
            unit_distance: None,
            gamma: 1.0,
            culling: true,
        }
    }
}

impl From<Layered> for Settings {
    /// Layered rendering with default common settings.
    fn from(layered: Layered) -> Self {
        Algorithm::Layered(layered).into()
    }
}

impl Settings {
    /// Transmittance at which early ray termination stops: 72 dB below white.
    pub const OPAQUE: f64 = 1.0 / 4096.0;

    /// Range of [`Settings::pixel_aspect`].
    pub const PIXEL_ASPECT: Number = Number::new("pixel_aspect", 1.0 / 16.0, 16.0, "a ratio of width to height from 1/16 to 16");
    /// Range of [`Settings::unit_distance`].
    pub const UNIT_DISTANCE: Number = Number::new("unit_distance", ABOVE_0, f64::MAX, "a finite number above 0");

    /// Range of [`Settings::gamma`].
    pub const GAMMA: Number = Number::new("gamma", 0.2, 5.0, "a gamma from 0.2 to 5");

    /// Options of layered rendering; `None` for other algorithms.
    pub fn layered(&self) -> Option<Layered> {
        match self.algorithm {
            Algorithm::Layered(layered) => Some(layered),
            _ => None,
        }
    }

    /// Whether samples are lit, which needs gradients. Samples that only fade with their depth are lit by an ambient light of 1.
    #[doc(hidden)]
    pub fn looks_at_gradients(&self) -> bool {
        self.shading.is_some() || self.gradient_opacity.is_some() || self.fading().is_some()
    }

    /// These settings with the defaults of a look: the studio has lights of its own.
    pub fn with_look(self, look: Look) -> Self {
        match look {
            Look::Plain => Self { studio: None, shading: Some(Shading::default()), ..self },
            Look::Studio => Self { studio: Some(Studio::default()), shading: Some(Studio::SHADING), ..self },
        }
    }

    /// The settings whose lights and sky stay in the world where `camera` sees them.
    ///
    /// # Errors
    /// If the camera is invalid.
    pub fn with_light_in_world(mut self, camera: &Camera) -> Result<Self, Error> {
        if let Some(shading) = &mut self.shading {
            shading.lights = shading.lights.in_world(camera)?;
        }
        if let Some(studio) = &mut self.studio {
            studio.sky = studio.sky.in_world(camera)?;
        }
        Ok(self)
    }

    /// How colours of the picture become those of 8 and 16 bits.
    pub fn curve(&self) -> Curve {
        let linear = self.studio.map(|studio| Exposure { stops: studio.exposure, tone: studio.tone });
        Curve { linear, gamma: self.gamma }
    }

    /// The look.
    pub fn look(&self) -> Look {
        self.studio.map_or(Look::Plain, |_| Look::Studio)
    }

    /// Whether light volumes are needed: by shadows, ambient occlusion or the studio.
    #[doc(hidden)]
    pub fn sweeps_light(&self) -> bool {
        self.shadows.is_some() || self.ambient_occlusion.is_some() || self.studio.is_some()
    }

    /// The resolution at which light is swept and looked up. Surfaces have full resolution: a coarse volume would lose thin ones.
    #[doc(hidden)]
    pub fn swept_grid(&self) -> LightGrid {
        if self.blend == Blend::Composite { self.light_grid } else { LightGrid::Full }
    }

    /// The depth cueing, unless its strength is 0.
    #[doc(hidden)]
    pub fn fading(&self) -> Option<DepthCue> {
        self.depth_cue.filter(|cue| cue.strength > 0.0)
    }

    /// The estimator of gradients: the chosen one, or the default of the algorithm.
    ///
    /// The Sobel operator hides the terraces and the noise of scans, and takes about as long as central differences. Ray casting renders
    /// references, so its default is the gradient that fits the kernel most closely.
    pub fn gradient_estimator(&self) -> GradientEstimator {
        self.gradient.unwrap_or(match self.algorithm {
            Algorithm::Layered(Layered { classification: Classification::Preintegrated { .. }, .. }) => GradientEstimator::Sobel,
            Algorithm::Raycast { kernel, .. } => GradientEstimator::for_kernel(kernel),
            _ => GradientEstimator::Central,
        })
    }

    /// The estimator of gradients, if the frame needs gradients.
    #[doc(hidden)]
    pub fn needed_gradient(&self) -> Option<GradientEstimator> {
        let is_needed = self.looks_at_gradients() && !self.blend.gathers_values();
        is_needed.then(|| self.gradient_estimator())
    }

    /// Checks ranges and combinations.
    #[doc(hidden)]
    pub fn check(&self) -> Result<(), Error> {
        self.algorithm.check()?;
        self.blend.check()?;
        FieldKind::One.check(self)?;
        self.check_gradient()?;
        if self.gradient_opacity.is_some() && self.blend != Blend::Composite {
            let problem = "only the blend mode composite supports gradient opacity: omit it".into();
            return Err(Error::Settings { field: "gradient_opacity", problem });
        }
        self.clipping.check()?;
        self.shading.map_or(Ok(()), |shading| shading.check())?;
        self.depth_cue.map_or(Ok(()), |cue| cue.check())?;
        self.check_light()?;
        Self::PIXEL_ASPECT.check(self.pixel_aspect)?;
        Self::GAMMA.check(self.gamma)?;
        self.unit_distance.map_or(Ok(()), |distance| Self::UNIT_DISTANCE.check(distance))
    }

    /// Rejects gradient estimators that the algorithm or the kernel does not support.
    fn check_gradient(&self) -> Result<(), Error> {
        let Some(gradient) = self.gradient else { return Ok(()) };
        gradient.check().map_err(|problem| Error::Settings { field: "gradient", problem })?;
        let kernel = match self.algorithm {
            Algorithm::Layered(Layered { classification: Classification::Preintegrated { kernel, .. }, .. }) => Some(kernel),
            Algorithm::Layered(_) => Some(Kernel::Cubic),
            Algorithm::Raycast { kernel, .. } => Some(kernel),
            _ => None,
        };
        let problem = match kernel {
            Some(kernel) if gradient.supports(kernel) => return Ok(()),
            Some(kernel) => {
                let known = GradientEstimator::ALL.into_iter().filter(|estimator| estimator.supports(kernel));
                let known = in_words(known.map(GradientEstimator::name));
                format!("gradients of the {} kernel cannot be estimated by {gradient}: choose {known}", kernel.name())
            }
            None if gradient == GradientEstimator::Central => return Ok(()),
            None => "sheets and slices have central differences: choose central, or omit it".into(),
        };
        Err(Error::Settings { field: "gradient", problem })
    }

    /// Checks shadows and ambient occlusion, and rejects them where nothing is lit or light is not swept.
    fn check_light(&self) -> Result<(), Error> {
        self.shadows.map_or(Ok(()), |shadows| shadows.check())?;
        self.ambient_occlusion.map_or(Ok(()), |occlusion| occlusion.check())?;
        self.check_studio()?;
        let field = match (self.studio, self.shadows, self.ambient_occlusion) {
            (None, None, None) => return Ok(()),
            (Some(_), ..) => "look",
            (None, Some(_), _) => "shadows",
            (None, None, Some(_)) => "ambient_occlusion",
        };
        let problem = match self.algorithm {
            _ if self.shading.is_none() => "shading is off: omit it, or enable shading",
            _ if self.blend.gathers_values() => "maximum, minimum and average are not lit: omit it, or choose another blend mode",
            Algorithm::AxisSheets { .. } | Algorithm::ViewSheets { .. } | Algorithm::Slicing { .. } => {
                "sheets and slices have no shadows: omit it, or choose layers or ray casting"
            }
            Algorithm::Layered(_) | Algorithm::Raycast { .. } => return Ok(()),
        };
        Err(Error::Settings { field, problem: problem.into() })
    }

    /// Checks the studio, and rejects what it replaces or does not draw.
    fn check_studio(&self) -> Result<(), Error> {
        let Some(studio) = self.studio else { return Ok(()) };
        studio.check()?;
        let refuse = |field, problem: &str| Err(Error::Settings { field, problem: problem.into() });
        if self.shadows.is_some() {
            return refuse("shadows", "the studio has shadows of its own: omit it, or choose the plain look");
        }
        if self.ambient_occlusion.is_some() {
            return refuse("ambient_occlusion", "the sky of the studio is occluded already: omit it, or choose the plain look");
        }
        if self.extinction == Extinction::Linear {
            return refuse(
                "extinction",
                "light scatters in matter whose extinction is exponential: omit it, or choose the plain look",
            );
        }
        if self.blend.gathers_values() {
            return refuse("look", "maximum, minimum and average are not lit: choose another blend mode, or the plain look");
        }
        match self.algorithm {
            Algorithm::Layered(Layered { classification: Classification::Post(_), .. }) => {
                refuse("look", "splatted layers have no linear colours: choose pre-integrated classification, or the plain look")
            }
            _ => Ok(()),
        }
    }
}
