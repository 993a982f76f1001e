//! Options of blend modes and of clipping.

use super::parse;
use crate::Error;
use crate::settings::{Blend, ClipPlane, Clipping, CropBox, Settings};
use clap::{Args, ValueEnum};

/// What becomes of the values along a ray, and of what part of it.
#[derive(Args)]
#[command(next_help_heading = "Blending and clipping")]
pub(super) struct BlendOptions {
    /// What becomes of the values along a ray: maximum, minimum and average are shown in the transfer function's colours, opaque, without
    /// its opacity; iso is a shaded surface
    #[arg(long, default_value = "composite")]
    blend: BlendName,
    /// Data value of the surface of --blend iso
    #[arg(long, value_parser = parse::finite, value_name = "V", allow_hyphen_values = true)]
    iso: Option<f64>,
    /// Show only this box, in voxels: the first voxel is at 0, and what is left out goes on to the end
    #[arg(long, value_parser = parse::crop, value_name = "X0:X1,Y0:Y1,Z0:Z1", allow_hyphen_values = true)]
    crop: Option<CropBox>,
    /// Show only the side of a plane that its normal points to: a point and the normal, in world units; up to six times
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
    /// The settings with what was asked for.
    pub fn apply(&self, settings: Settings) -> Result<Settings, Error> {
        let conflict = |problem: &str| Err(Error::Settings { field: "blend", problem: problem.into() });
        let blend = match (self.blend, self.iso) {
            (BlendName::Iso, Some(value)) => Blend::Iso(value),
            (BlendName::Iso, None) => return conflict("an iso-surface needs its data value: add --iso V"),
            (_, Some(_)) => return conflict("--iso is the value of an iso-surface: add --blend iso, or leave it out"),
            (BlendName::Composite, None) => Blend::Composite,
            (BlendName::Maximum, None) => Blend::Maximum,
            (BlendName::Minimum, None) => Blend::Minimum,
            (BlendName::Average, None) => Blend::Average,
        };
        if self.clip.len() > Clipping::MAX_PLANES {
            let problem =
                format!("there are {} clip planes, more than {}: leave some out", self.clip.len(), Clipping::MAX_PLANES);
            return Err(Error::Settings { field: "clipping", problem });
        }
        let clipping = Clipping { crop: self.crop, ..Clipping::default() }.with_planes(self.clip.iter().copied());
        Ok(Settings { blend, clipping, ..settings })
    }
}
