//! Render settings.

use crate::boundary::{Failure, Out, guard};
use crate::{AlgorithmChoice, BlendChoice, GradientChoice, KernelChoice, QualityChoice, Status};
use layersplat::glam::DVec3;
use layersplat::settings::{
    self, Algorithm, Blend, ClipPlane, Clipping, CropBox, DepthCue, GradientOpacity, Layered, Lights, Shading,
};
use layersplat::{Kernel, Quality};

/// A white directional light.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Light {
    /// World direction towards the light; (0, 0, 0) is a light at the camera.
    pub direction: [f64; 3],
    /// Factor of its diffuse and specular terms, from 0 to 100.
    pub strength: f64,
}

/// A clipping plane in world coordinates. The side that the normal points to is shown.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Plane {
    /// A point of the plane.
    pub point: [f64; 3],
    /// Its normal, of any length but 0.
    pub normal: [f64; 3],
}

/// Render settings. Initialise them with layersplat_settings_default() before changing fields: later versions have more of them.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Size of this struct in bytes in the program's header. layersplat_settings_default() sets it; do not change it.
    pub size: usize,
    /// A layersplat_quality.
    pub quality: i32,
    /// A layersplat_algorithm.
    pub algorithm: i32,
    /// A layersplat_kernel, for layered splatting and ray casting.
    pub kernel: i32,
    /// Layered splatting: 1 splats layers with post-classification, as published; 0 uses the quality's classification.
    pub splatted: i32,
    /// A layersplat_blend.
    pub blend: i32,
    /// Shading: 1 or 0.
    pub lit: i32,
    /// Number of `lights` in use; 0: one light of strength 1 at the camera.
    pub light_count: i32,
    /// Early ray termination, at a transmittance below 1/4096: 1 or 0.
    pub early_termination: i32,
    /// Cropping to the box from crop_lowest to crop_highest: 1 or 0.
    pub cropped: i32,
    /// Number of `planes` in use.
    pub plane_count: i32,
    /// Number of points of `gradient_opacity` in use; 0 disables gradient opacity.
    pub gradient_point_count: i32,
    /// Distance between slices or samples along rays in units of the smallest spacing; between sheets in voxels. 0 is the
    /// algorithm's default.
    pub step: f64,
    /// Iso-value of LAYERSPLAT_BLEND_ISO.
    pub iso_value: f64,
    /// Ambient coefficient.
    pub ambient: f64,
    /// Diffuse coefficient.
    pub diffuse: f64,
    /// Specular coefficient, of a white highlight.
    pub specular: f64,
    /// Specular exponent.
    pub power: f64,
    /// The lights.
    pub lights: [Light; 4],
    /// Thickness in world units at which the given opacities apply; 0 is the smallest spacing.
    pub unit_distance: f64,
    /// Points of the gradient opacity function: gradient magnitude in values per world unit, ascending, and opacity factor.
    pub gradient_opacity: [[f64; 2]; 8],
    /// Lowest corner of the crop box, in voxels.
    pub crop_lowest: [f64; 3],
    /// Highest corner of the crop box, in voxels.
    pub crop_highest: [f64; 3],
    /// Clipping planes. The side behind any of them is hidden.
    pub planes: [Plane; 6],
    /// A layersplat_gradient, for layers and ray casting.
    pub gradient: i32,
    /// Standard deviation of LAYERSPLAT_GRADIENT_GAUSSIAN in voxels of the smallest spacing, 0.3 to 2.
    pub gradient_sigma: f64,
    /// Depth cueing: share of depth_cue_color at the back of the volume's bounding box, from 0 (off) to 1. It rises linearly from 0 at the
    /// front.
    pub depth_cue: f64,
    /// Colour that samples fade to, from 0 to 1: that of the picture's background.
    pub depth_cue_color: [f64; 3],
}

/// Size in bytes of the first version of the struct, which is this one. Later versions append fields and still accept this size.
const FIRST_VERSION: usize = size_of::<Settings>();

fn from_quality(quality: QualityChoice) -> Settings {
    let Shading { ambient, diffuse, specular, power, .. } = Shading::default();
    Settings {
        size: size_of::<Settings>(),
        quality: quality as i32,
        algorithm: AlgorithmChoice::Layered as i32,
        kernel: KernelChoice::Automatic as i32,
        splatted: 0,
        blend: BlendChoice::Composite as i32,
        lit: 1,
        light_count: 0,
        early_termination: 1,
        cropped: 0,
        plane_count: 0,
        step: 0.0,
        iso_value: 0.0,
        ambient,
        diffuse,
        specular,
        power,
        lights: [Light::default(); 4],
        unit_distance: 0.0,
        gradient_point_count: 0,
        gradient_opacity: [[0.0; 2]; 8],
        crop_lowest: [0.0; 3],
        crop_highest: [0.0; 3],
        planes: [Plane::default(); 6],
        gradient: GradientChoice::Automatic as i32,
        gradient_sigma: 1.0,
        depth_cue: 0.0,
        depth_cue_color: [0.0; 3],
    }
}

/// Default settings of a layersplat_quality: composited, lit from the camera, without clipping. Pass sizeof(layersplat_settings) as
/// `size`: a program compiled with a newer header than this library gets an error.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_settings_default(quality: i32, settings: *mut Settings, size: usize) -> Status {
    guard(|| {
        let quality = QualityChoice::from_number(quality)?;
        check_size(size)?;
        // SAFETY: upheld by the caller: a struct of `size` bytes, which is this version's.
        unsafe { Out::new(settings, "settings") }?.set(from_quality(quality));
        Ok(())
    })
}

fn check_size(size: usize) -> Result<(), Failure> {
    if size == FIRST_VERSION {
        return Ok(());
    }
    Err(Failure::invalid(format!(
        "settings have {size} bytes, and this version of layersplat expects {FIRST_VERSION}: initialise them with \
         layersplat_settings_default(), and use the library that matches the header"
    )))
}

/// Checked settings of a call; null means those of the standard quality.
pub(crate) unsafe fn checked(settings: *const Settings) -> Result<settings::Settings, Failure> {
    if settings.is_null() {
        return Ok(settings::Settings::default());
    }
    // SAFETY: upheld by the caller: the struct begins with its size. Nothing else is read before the size is checked.
    check_size(unsafe { (&raw const (*settings).size).read() })?;
    // SAFETY: upheld by the caller.
    unsafe { *settings }.checked()
}

impl Settings {
    fn checked(&self) -> Result<settings::Settings, Failure> {
        let planes = usize::try_from(self.plane_count).ok().and_then(|count| self.planes.get(..count));
        let Some(planes) = planes else {
            return Err(Failure::invalid(format!("plane_count is {}: expected 0 to {}", self.plane_count, self.planes.len())));
        };
        let plane = |p: &Plane| ClipPlane { point: p.point.into(), normal: p.normal.into() };
        let crop = CropBox { lowest: self.crop_lowest.into(), highest: self.crop_highest.into() };
        let crop = flag("cropped", self.cropped)?.then_some(crop);
        Ok(settings::Settings {
            algorithm: self.algorithm()?,
            blend: match BlendChoice::from_number(self.blend)? {
                BlendChoice::Composite => Blend::Composite,
                BlendChoice::Maximum => Blend::Maximum,
                BlendChoice::Minimum => Blend::Minimum,
                BlendChoice::Average => Blend::Average,
                BlendChoice::Iso => Blend::Iso(self.iso_value),
            },
            clipping: Clipping { crop, ..Clipping::default() }.with_planes(planes.iter().map(plane)),
            shading: self.shading()?,
            gradient: GradientChoice::from_number(self.gradient)?.estimator(self.gradient_sigma),
            gradient_opacity: self.gradient_opacity()?,
            depth_cue: (self.depth_cue != 0.0).then_some(DepthCue { strength: self.depth_cue, color: self.depth_cue_color }),
            early_termination: flag("early_termination", self.early_termination)?,
            unit_distance: (self.unit_distance != 0.0).then_some(self.unit_distance),
            ..settings::Settings::default()
        })
    }

    fn gradient_opacity(&self) -> Result<Option<GradientOpacity>, Failure> {
        let count = usize::try_from(self.gradient_point_count).ok().filter(|&count| count <= self.gradient_opacity.len());
        let Some(count) = count else {
            let (count, most) = (self.gradient_point_count, self.gradient_opacity.len());
            return Err(Failure::invalid(format!("gradient_point_count is {count}: expected 0 to {most}")));
        };
        let points: Vec<_> = self.gradient_opacity[..count].iter().map(|&[length, factor]| (length, factor)).collect();
        Ok((count > 0).then(|| GradientOpacity::new(&points)).transpose()?)
    }

    fn algorithm(&self) -> Result<Algorithm, Failure> {
        let kernel = KernelChoice::from_number(self.kernel)?.kernel();
        let step = |default: f64| if self.step == 0.0 { default } else { self.step };
        let layer_axis = settings::LayerAxis::Auto;
        let algorithm = AlgorithmChoice::from_number(self.algorithm)?;
        if kernel.is_some() && !matches!(algorithm, AlgorithmChoice::Layered | AlgorithmChoice::Raycast) {
            return Err(Failure::invalid("kernel: this algorithm has a fixed kernel"));
        }
        Ok(match algorithm {
            AlgorithmChoice::Layered => self.layered(kernel)?.into(),
            AlgorithmChoice::AxisSheets => Algorithm::AxisSheets { layer_axis },
            AlgorithmChoice::ViewSheets => Algorithm::ViewSheets { sheet_distance: step(Algorithm::SHEET_DISTANCE) },
            AlgorithmChoice::Slicing => Algorithm::Slicing { step: step(Algorithm::SLICE_DISTANCE) },
            AlgorithmChoice::Raycast => Algorithm::Raycast { kernel: kernel.unwrap_or(Kernel::Linear), step: step(0.5) },
        })
    }

    fn layered(&self, kernel: Option<Kernel>) -> Result<Layered, Failure> {
        let quality = Quality::from(QualityChoice::from_number(self.quality)?);
        let splatted = flag("splatted", self.splatted)? || quality == Quality::Paper;
        let layered = quality.layered();
        Ok(match kernel {
            Some(_) if splatted => return Err(Failure::invalid("kernel: splatted layers always use the paper's cubic kernel")),
            _ if splatted => Layered { classification: quality.splatted(), ..layered },
            Some(kernel) => Layered { classification: layered.classification.with_kernel(kernel), ..layered },
            None => layered,
        })
    }

    fn shading(&self) -> Result<Option<Shading>, Failure> {
        let Self { ambient, diffuse, specular, power, .. } = *self;
        let lights = self.lights()?;
        Ok(flag("lit", self.lit)?.then_some(Shading { ambient, diffuse, specular, power, lights }))
    }

    fn lights(&self) -> Result<Lights, Failure> {
        let Some(lights) = usize::try_from(self.light_count).ok().and_then(|count| self.lights.get(..count)) else {
            return Err(Failure::invalid(format!("light_count is {}: expected 0 to {}", self.light_count, self.lights.len())));
        };
        let light = |light: &Light| settings::Light {
            direction: Some(DVec3::from_array(light.direction)).filter(|&direction| direction != DVec3::ZERO),
            strength: light.strength,
        };
        let lights: Vec<_> = lights.iter().map(light).collect();
        Ok(if lights.is_empty() { Lights::AT_CAMERA } else { Lights::new(&lights)? })
    }
}

fn flag(name: &str, number: i32) -> Result<bool, Failure> {
    match number {
        0 => Ok(false),
        1 => Ok(true),
        _ => Err(Failure::invalid(format!("{name} is {number}: expected 0 or 1"))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(change: impl FnOnce(&mut Settings)) -> String {
        let mut settings = from_quality(QualityChoice::Standard);
        change(&mut settings);
        settings.checked().unwrap_err().message
    }

    #[test]
    fn defaults_are_those_of_the_library() {
        let all = [QualityChoice::Draft, QualityChoice::Standard, QualityChoice::High, QualityChoice::Paper];
        for quality in all {
            assert_eq!(from_quality(quality).checked().unwrap(), Quality::from(quality).settings());
        }
        // SAFETY: null is accepted.
        assert_eq!(unsafe { checked(std::ptr::null()) }.unwrap(), settings::Settings::default());
    }

    #[test]
    fn fields_reach_the_library() {
        let standard = from_quality(QualityChoice::Standard);
        let slicing = Settings { algorithm: AlgorithmChoice::Slicing as i32, step: 0.7, lit: 0, ..standard };
        let expected = settings::Settings { shading: None, ..Algorithm::Slicing { step: 0.7 }.into() };
        assert_eq!(slicing.checked().unwrap(), expected);
        let plane = Plane { point: [1.0; 3], normal: [0.0, 0.0, 2.0] };
        let cut = Settings { plane_count: 1, planes: [plane; 6], blend: BlendChoice::Iso as i32, iso_value: 3.0, ..standard };
        let cut = cut.checked().unwrap();
        assert_eq!((cut.clipping.planes.iter().flatten().count(), cut.blend), (1, Blend::Iso(3.0)));
        let splatted = Settings { splatted: 1, ..standard }.checked().unwrap();
        assert_eq!(splatted.layered().unwrap().classification, Quality::Standard.splatted());
        let side = Light { direction: [1.0, 0.0, 0.0], strength: 0.5 };
        let lit =
            Settings { light_count: 2, lights: [side, Light { strength: 2.0, ..Light::default() }, side, side], ..standard };
        let lights = lit.checked().unwrap().shading.unwrap().lights;
        let expected = [
            settings::Light { strength: 0.5, ..settings::Light::towards(DVec3::X) },
            settings::Light { direction: None, strength: 2.0 },
        ];
        assert_eq!(lights.as_slice(), expected);
        let kernel = Settings { kernel: KernelChoice::CatmullRom as i32, ..standard }.checked().unwrap();
        assert_eq!(
            kernel.layered().unwrap().classification,
            Quality::Standard.layered().classification.with_kernel(Kernel::CatmullRom)
        );
    }

    #[test]
    fn invalid_numbers_are_rejected() {
        assert_eq!(refused(|s| s.quality = 9), "9 is not a valid quality");
        assert_eq!(refused(|s| s.algorithm = -1), "-1 is not a valid algorithm");
        assert_eq!(refused(|s| s.blend = 5), "5 is not a valid blend mode");
        assert!(refused(|s| s.lit = 2).contains("lit is 2"));
        assert!(refused(|s| s.plane_count = 7).contains("0 to 6"));
        assert!(refused(|s| s.plane_count = -1).contains("-1"));
        assert!(refused(|s| s.light_count = 5).contains("0 to 4"));
        assert!(refused(|s| (s.light_count, s.lights[0].strength) = (1, -1.0)).contains("0 to 100"));
        let sheets = |s: &mut Settings| (s.kernel, s.algorithm) = (1, AlgorithmChoice::ViewSheets as i32);
        assert!(refused(sheets).contains("has a fixed kernel"));
        let wrong = Settings { size: 8, ..from_quality(QualityChoice::Draft) };
        // SAFETY: it is alive.
        assert!(unsafe { checked(&wrong) }.unwrap_err().message.contains("8 bytes"));
    }
}
