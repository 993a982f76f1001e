//! Options for blend modes and clipping.

use super::parse;
use crate::Error;
use crate::settings::{Blend, ClipPlane, Clipping, CropBox, Settings};
use crate::transfer::Value;
use clap::{Args, ValueEnum};

/// Blend mode and ray clip region.
#[derive(Args)]
#[command(next_help_heading = "Blending and clipping")]
pub(super) struct BlendOptions {
    /// How values along a ray combine; maximum, minimum and average ignore opacity, iso shades a surface
    #[arg(long, default_value = "composite", value_name = "MODE")]
    blend: BlendName,
    /// Value of the iso-surface: a number, or a percentile of the voxels such as p95
    #[arg(long, value_parser = parse::value, value_name = "V", allow_hyphen_values = true)]
    iso: Option<Value>,
    /// Show only this box, in voxels from 0; an omitted bound is open
    #[arg(long, value_parser = parse::crop, value_name = "X0:X1,Y0:Y1,Z0:Z1", allow_hyphen_values = true)]
    crop: Option<CropBox>,
    /// Show only the side of a plane to which its normal points; a point and the normal in world units. Repeatable, up to 6
    #[arg(long, value_parser = parse::clip_plane, value_name = "X,Y,Z,NX,NY,NZ", allow_hyphen_values = true)]
    clip: Vec<ClipPlane>,
}

#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
enum BlendName {
    Composite,
    Maximum,
    Minimum,
    Average,
    Iso,
}

impl BlendOptions {
    /// Checks for conflicting options. Does not need the volume.
    pub fn check(&self) -> Result<(), Error> {
        let conflict = |problem: &str| Err(Error::Settings { field: "blend", problem: problem.into() });
        match (self.blend, self.iso) {
            (BlendName::Iso, None) => return conflict("an iso-surface needs a data value: add --iso V"),
            (BlendName::Iso, Some(_)) | (_, None) => {}
            (_, Some(_)) => return conflict("--iso sets the value of an iso-surface: add --blend iso, or omit --iso"),
        }
        if self.clip.len() > Clipping::MAX_PLANES {
            let problem =
                format!("{} clip planes given, at most {} are possible: omit some", self.clip.len(), Clipping::MAX_PLANES);
            return Err(Error::Settings { field: "clipping", problem });
        }
        Ok(())
    }

    /// Applies the options to `settings`. `find` converts a value to a number; percentiles need the volume.
    pub fn apply(&self, settings: Settings, find: impl Fn(Value) -> f64) -> Settings {
        let blend = match self.blend {
            BlendName::Composite => Blend::Composite,
            BlendName::Maximum => Blend::Maximum,
            BlendName::Minimum => Blend::Minimum,
            BlendName::Average => Blend::Average,
            BlendName::Iso => Blend::Iso(self.iso.map_or(f64::NAN, find)),
        };
        let clipping = Clipping { crop: self.crop, ..Clipping::default() }.with_planes(self.clip.iter().copied());
        Settings { blend, clipping, ..settings }
    }
}
