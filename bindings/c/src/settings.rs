//! Render settings.

mod light;
#[cfg(test)]
mod tests;

use crate::boundary::{Failure, Out, guard};
use crate::choices::{chosen, chosen_or_default};
use crate::{AlgorithmChoice, BlendChoice, GradientChoice, KernelChoice, LightGridChoice, LookChoice, Status};
use layersplat::settings::{
    self, Algorithm, AlgorithmOptions, AmbientOcclusion, Blend, ClipPlane, Clipping, CropBox, DepthCue, GradientOpacity, Layered,
    Shading, Shadows, Studio,
};
use layersplat::{Kernel, Quality};
use std::mem::offset_of;

/// A directional light. Its angular diameter is in `light_angles`, and its colour in `light_colors` of layersplat_settings.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Light {
    /// Direction towards the light, in world axes unless `lights_in_camera_space` is 1; (0, 0, 0) is a light at the camera.
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
    /// Number of `lights` in use; 0: one light of strength 1 at the camera. With shadows it is beside the camera, where they are visible:
    /// at (-1, 1, 1) in camera space.
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
    /// Specular coefficient, of highlights in the colours of the lights.
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
    /// Shadows of the lights: 1 or 0. They need shading, LAYERSPLAT_BLEND_COMPOSITE or _ISO, and layers or ray casting.
    pub shadows: i32,
    /// Ambient occlusion, which dims the ambient light where little of the surroundings is open: 1 or 0. It needs what shadows need.
    pub ambient_occlusion: i32,
    /// A layersplat_light_grid, for shadows and ambient occlusion.
    pub light_grid: i32,
    /// Axes of the lights' directions. 1: right, up, towards the viewer: the lights move with the camera, and shadows are computed
    /// again for each view. 0: world axes.
    pub lights_in_camera_space: i32,
    /// Share of the shadows, from 0 to 1.
    pub shadow_strength: f64,
    /// Factor of the light in shadows, at most full light, from 1 to 1000. 1 is physically exact, and dark.
    pub shadow_forgiveness: f64,
    /// World distance over which ambient occlusion decreases to 1/e; 0 or infinity: no limit.
    pub ao_reach: f64,
    /// Factor of the share of the sky that reaches a point, at most all of it, from 1 to 1000. 3 shows open surfaces at full light: a point of
    /// an opaque plane sees half of the sky at most.
    pub ao_gain: f64,
    /// Angular diameters of `lights` in degrees, from 0 to 45: how soft the edges of their shadows are.
    pub light_angles: [f64; 4],
    /// Red, green and blue of `lights`, from 0 to 1.
    pub light_colors: [[f64; 3]; 4],
    /// Red, green and blue of the ambient light, from 0 to 1.
    pub ambient_color: [f64; 3],
    /// Gamma of 8-bit pictures, from 0.2 to 5: straight colours are raised to 1/gamma. Floats are unaffected.
    pub gamma: f64,
    /// A layersplat_look. The studio uses the lights: with none, a key light and a rim light beside the camera. It has no use for `ambient`,
    /// `ambient_color`, `diffuse`, `specular` and `power`.
    pub look: i32,
    /// A layersplat_tone of the studio.
    pub tone: i32,
    /// Red, green and blue of the sky above, in linear light, from 0 to 100. Up is upwards in the picture, or, with
    /// `lights` in world axes, along z.
    pub sky_top: [f64; 3],
    /// The same below.
    pub sky_bottom: [f64; 3],
    /// Factor of both, from 0 to 100.
    pub sky_strength: f64,
    /// Factor of the light that scatters again in the studio, from 0 to 1.
    pub scattering: f64,
    /// Exposure of 8-bit pictures of the studio in stops, from -20 to 20.
    pub exposure: f64,
    /// Share of the light that surfaces of the studio reflect as by a mirror, from 0 to 100.
    pub studio_specular: f64,
    /// Specular exponent of the studio, above 0.
    pub studio_power: f64,
}

/// Size in bytes of the first version of the struct, which ends before `shadows`.
const FIRST_VERSION: usize = offset_of!(Settings, shadows);

/// Sizes of all versions of the struct, all of which are accepted. Before fields are appended, the present size becomes a constant here.
const VERSIONS: [usize; 4] =
    [FIRST_VERSION, offset_of!(Settings, light_colors), offset_of!(Settings, look), size_of::<Settings>()];

fn from_quality(quality: Quality) -> Settings {
    let Shading { ambient, diffuse, specular, power, .. } = Shading::default();
    let Shadows { strength, forgiveness } = Shadows::default();
    let Studio { sky, scattering, tone, exposure } = Studio::default();
    Settings {
        size: size_of::<Settings>(),
        quality: quality as i32, // The constants count as the library does.
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
        shadows: 0,
        ambient_occlusion: 0,
        light_grid: LightGridChoice::Full as i32,
        lights_in_camera_space: 0,
        shadow_strength: strength,
        shadow_forgiveness: forgiveness,
        ao_reach: 0.0,
        ao_gain: AmbientOcclusion::default().gain,
        light_angles: [0.0; 4],
        light_colors: [[1.0; 3]; 4],
        ambient_color: [1.0; 3],
        gamma: 1.0,
        look: LookChoice::Plain as i32,
        tone: tone as i32, // The constants count as the library does.
        sky_top: sky.top,
        sky_bottom: sky.bottom,
        sky_strength: sky.strength,
        scattering,
        exposure,
        studio_specular: Studio::SHADING.specular,
        studio_power: Studio::SHADING.power,
    }
}

/// Default settings of a layersplat_quality: composited, lit from the camera, without clipping. Pass sizeof(layersplat_settings) as
/// `size`: a program compiled with an older header gets the fields of that header, and one with a newer header than this library an error.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn layersplat_settings_default(quality: i32, settings: *mut Settings, size: usize) -> Status {
    guard(|| {
        let quality = chosen(quality)?;
        check_size(size)?;
        // SAFETY: upheld by the caller: a struct of `size` bytes, which is that of a version.
        unsafe { Out::new(settings, "settings") }?.set_first(Settings { size, ..from_quality(quality) }, size);
        Ok(())
    })
}

fn check_size(size: usize) -> Result<(), Failure> {
    if VERSIONS.contains(&size) {
        return Ok(());
    }
    Err(Failure::invalid(format!(
        "settings have {size} bytes, and this version of layersplat expects {}: initialise them with \
         layersplat_settings_default(), and use the library that matches the header",
        VERSIONS.map(|size| size.to_string()).join(" or ")
    )))
}

/// Checked settings of a call; null means those of the standard quality.
pub(crate) unsafe fn checked(settings: *const Settings) -> Result<settings::Settings, Failure> {
    if settings.is_null() {
        return Ok(settings::Settings::default());
    }
    // SAFETY: upheld by the caller: the struct begins with its size. Nothing else is read before the size is checked.
    let size = unsafe { (&raw const (*settings).size).read() };
    check_size(size)?;
    // Fields that an older version lacks keep their defaults, which no quality changes.
    let mut complete = from_quality(Quality::Standard);
    // SAFETY: upheld by the caller: the struct has `size` bytes, which is at most the size of this version.
    unsafe { settings.cast::<u8>().copy_to_nonoverlapping((&raw mut complete).cast(), size) };
    complete.checked()
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
            blend: chosen::<Blend>(self.blend)?.at(self.iso_value),
            clipping: Clipping { crop, ..Clipping::default() }.with_planes(planes.iter().map(plane)),
            shading: self.shading()?,
            studio: self.studio()?,
            shadows: self.shadows()?,
            ambient_occlusion: self.ambient_occlusion()?,
            light_grid: chosen(self.light_grid)?,
            gradient: GradientChoice::from_number(self.gradient)?.estimator(self.gradient_sigma),
            gradient_opacity: self.gradient_opacity()?,
            depth_cue: (self.depth_cue != 0.0).then_some(DepthCue { strength: self.depth_cue, color: self.depth_cue_color }),
            early_termination: flag("early_termination", self.early_termination)?,
            unit_distance: (self.unit_distance != 0.0).then_some(self.unit_distance),
            gamma: self.gamma,
            ..settings::Settings::default()
        })
    }

    fn gradient_opacity(&self) -> Result<Option<GradientOpacity>, Failure> {
        gradient_points(self.gradient_point_count, &self.gradient_opacity)
    }

    fn algorithm(&self) -> Result<Algorithm, Failure> {
        let kernel = chosen_or_default(self.kernel)?;
        let step = Some(self.step).filter(|&step| step != 0.0);
        let algorithm: Algorithm = chosen(self.algorithm)?;
        let options = match algorithm {
            Algorithm::Layered(_) => return Ok(self.layered(kernel)?.into()),
            // These have no step.
            Algorithm::AxisSheets { .. } => AlgorithmOptions { kernel, ..Default::default() },
            Algorithm::ViewSheets { .. } => AlgorithmOptions { kernel, sheet_distance: step, ..Default::default() },
            _ => AlgorithmOptions { kernel, step, ..Default::default() },
        };
        Ok(algorithm.with(options)?)
    }

    fn layered(&self, kernel: Option<Kernel>) -> Result<Layered, Failure> {
        let quality: Quality = chosen(self.quality)?;
        let splatted = flag("splatted", self.splatted)? || quality == Quality::Paper;
        let layered = quality.layered();
        Ok(match kernel {
            Some(_) if splatted => return Err(Failure::invalid("kernel: splatted layers always use the paper's cubic kernel")),
            _ if splatted => Layered { classification: quality.splatted(), ..layered },
            Some(kernel) => Layered { classification: layered.classification.with_kernel(kernel), ..layered },
            None => layered,
        })
    }
}

/// The gradient opacity of the points in use, if there are any.
pub(crate) fn gradient_points(count: i32, points: &[[f64; 2]]) -> Result<Option<GradientOpacity>, Failure> {
    let Some(used) = usize::try_from(count).ok().and_then(|count| points.get(..count)) else {
        return Err(Failure::invalid(format!("gradient_point_count is {count}: expected 0 to {}", points.len())));
    };
    let points: Vec<_> = used.iter().map(|&[length, factor]| (length, factor)).collect();
    Ok((!points.is_empty()).then(|| GradientOpacity::new(&points)).transpose()?)
}

pub(crate) fn flag(name: &str, number: i32) -> Result<bool, Failure> {
    match number {
        0 => Ok(false),
        1 => Ok(true),
        _ => Err(Failure::invalid(format!("{name} is {number}: expected 0 or 1"))),
    }
}
