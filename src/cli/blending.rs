//! Options of blend modes and of clipping.

use super::parse;
use crate::Error;
use crate::settings::{Blend, ClipPlane, Clipping, CropBox, Settings};
use crate::transfer::Value;
use clap::{Args, ValueEnum};

/// What becomes of the values along a ray, and of what part of it.
#[derive(Args)]
#[command(next_help_heading = "Blending and clipping")]
pub(super) struct BlendOptions {
    /// What becomes of the values along a ray: maximum, minimum and average are shown in the transfer function's colours, opaque, without
    /// its opacity; iso is a shaded surface
    #[arg(long, default_value = "composite")]
    blend: BlendName,
    /// Data value of the surface of --blend iso: a number, or a percentile of the voxels, as p95
    #[arg(long, value_parser = parse::value, value_name = "V", allow_hyphen_values = true)]
    iso: Option<Value>,
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
    /// Refuses what is contradictory, for which no volume need be read.
    pub fn check(&self) -> Result<(), Error> {
        let conflict = |problem: &str| Err(Error::Settings { field: "blend", problem: problem.into() });
        match (self.blend, self.iso) {
            (BlendName::Iso, None) => return conflict("an iso-surface needs its data value: add --iso V"),
            (BlendName::Iso, Some(_)) | (_, None) => {}
            (_, Some(_)) => return conflict("--iso is the value of an iso-surface: add --blend iso, or leave it out"),
        }
        if self.clip.len() > Clipping::MAX_PLANES {
            let problem =
                format!("there are {} clip planes, more than {}: leave some out", self.clip.len(), Clipping::MAX_PLANES);
            return Err(Error::Settings { field: "clipping", problem });
        }
        Ok(())
    }

    /// The settings with what was asked for, once checked.
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
