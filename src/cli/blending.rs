//! Options for blend modes and clipping.

use super::options::TransferOptions;
use super::{names, parse};
use crate::Error;
use crate::settings::{Blend, ClipPlane, Clipping, CropBox, Settings};
use crate::transfer::Value;
use crate::volume::{LevelLattice, Volume};
use clap::Args;
use glam::DVec3;

/// Blend mode and ray clip region.
#[derive(Args)]
#[command(next_help_heading = "Blending and clipping")]
pub(super) struct BlendOptions {
    /// How values along a ray combine; maximum, minimum and average ignore opacity, iso shades a surface [default: composite; with --iso: iso]
    #[arg(long, value_name = "MODE", value_parser = names::of::<Blend>())]
    blend: Option<Blend>,
    /// Maximum intensity projection: --blend maximum
    #[arg(long, conflicts_with_all = ["minip", "blend"])]
    mip: bool,
    /// Minimum intensity projection: --blend minimum
    #[arg(long, conflicts_with = "blend")]
    minip: bool,
    /// Show the surface at this value: a number, or a percentile of the voxels such as p95
    #[arg(long, value_parser = parse::value, value_name = "V", allow_hyphen_values = true)]
    iso: Option<Value>,
    /// Colour of the surface: white, grey, #rrggbb or R,G,B [default: ivory, or that of --transfer at the value]
    #[arg(long, value_parser = parse::color, value_name = "COLOR")]
    iso_color: Option<[f64; 3]>,
    /// Show only this box, in voxels from 0, of the finest level; an omitted bound is open
    #[arg(long, value_parser = parse::crop, value_name = "X0:X1,Y0:Y1,Z0:Z1", allow_hyphen_values = true)]
    crop: Option<CropBox>,
    /// Show only the side of a plane to which its normal points; a point and the normal in world units. Repeatable, up to 6
    #[arg(long, value_parser = parse::clip_plane, value_name = "X,Y,Z,NX,NY,NZ", allow_hyphen_values = true)]
    clip: Vec<ClipPlane>,
}

/// Default colour of iso-surfaces. Bright enough for print, and dim enough that highlights are not burnt out.
const IVORY: [f64; 3] = [0.90, 0.86, 0.76];

impl BlendOptions {
    /// Checks for conflicting options. Does not need the volume.
    pub fn check(&self) -> Result<(), Error> {
        let conflict = |problem: &str| Err(Error::Settings { field: "blend", problem: problem.into() });
        match (self.mode(), self.iso) {
            (Blend::Iso(_), None) => return conflict("an iso-surface needs a data value: add --iso V"),
            (Blend::Iso(_), Some(_)) => {}
            (_, Some(_)) => return conflict("--iso sets the value of an iso-surface: omit --iso, or the other blend mode"),
            (_, None) if self.iso_color.is_some() => {
                return conflict("--iso-color is the colour of an iso-surface: add --iso V, or omit it");
            }
            (_, None) => {}
        }
        if self.clip.len() > Clipping::MAX_PLANES {
            let problem =
                format!("{} clip planes given, at most {} are possible: omit some", self.clip.len(), Clipping::MAX_PLANES);
            return Err(Error::Settings { field: "clipping", problem });
        }
        Ok(())
    }

    /// The crop box, which is in voxels of the finest level, in those of a volume.
    pub fn crop_of(&self, volume: &Volume) -> Option<CropBox> {
        let LevelLattice { first, step } = volume.lattice();
        let voxel = |place: DVec3| (place - first) / step;
        self.crop.map(|CropBox { lowest, highest }| CropBox { lowest: voxel(lowest), highest: voxel(highest) })
    }

    /// The blend mode without the value of its surface.
    fn mode(&self) -> Blend {
        match (self.blend, self.iso) {
            (Some(mode), _) => mode,
            _ if self.mip => Blend::Maximum,
            _ if self.minip => Blend::Minimum,
            (None, Some(_)) => Blend::Iso(f64::NAN),
            (None, None) => Blend::Composite,
        }
    }

    /// The colour of an iso-surface that no transfer function colours.
    ///
    /// # Errors
    /// [`Error::Settings`] if both give a colour.
    pub fn surface_color(&self, transfer: &TransferOptions) -> Result<Option<[f64; 3]>, Error> {
        match (self.iso_color, transfer.is_given()) {
            (Some(_), true) => {
                let problem = "--iso-color and the transfer function both colour the surface: omit one of them".into();
                Err(Error::Settings { field: "blend", problem })
            }
            (None, false) if matches!(self.mode(), Blend::Iso(_)) => Ok(Some(IVORY)),
            (color, _) => Ok(color),
        }
    }

    /// Applies the options to `settings`. `find` converts a value to a number; percentiles need the volume.
    pub fn apply(&self, settings: Settings, find: impl Fn(Value) -> f64) -> Settings {
        let blend = self.mode().at(self.iso.map_or(f64::NAN, find));
        let clipping = Clipping { crop: self.crop, ..Clipping::default() }.with_planes(self.clip.iter().copied());
        Settings { blend, clipping, ..settings }
    }
}
