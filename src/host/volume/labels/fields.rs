//! Labels as fields that are drawn together with others.

use super::mask::Layer;
use super::{LabelSurfaces, Labels};
use crate::error::Error;
use crate::volume::Volume;
use std::path::Path;

/// The voxels of labels of one look, as a field: their shares, 0 to 255. The surface lies where the share is one half.
pub struct LabelField {
    /// Shares of the voxels, 0 beyond them.
    pub volume: Volume<'static>,
    /// Name of the label, or of the first of several.
    pub name: String,
    /// Red, green and blue, 0 to 1.
    pub color: [f64; 3],
    /// Opacity, 0 to 1.
    pub opacity: f64,
}

impl LabelField {
    /// The share at the surface.
    pub const SURFACE: f64 = 127.5;
    /// Half the width of the ramp of opacities around it: a quarter of a voxel at a plane along the grid.
    const RAMP: f64 = 16.0;

    /// Opacities of shares.
    pub fn opacities(&self) -> Vec<(f64, f64)> {
        vec![(Self::SURFACE - Self::RAMP, 0.0), (Self::SURFACE + Self::RAMP, self.opacity)]
    }
}

/// Labels of a layer that have one colour and opacity.
struct Look {
    /// Red, green, blue and opacity.
    entry: [f64; 4],
    layer: usize,
    /// Of each entry of the layer's palette, whether it is one of them.
    shown: Vec<bool>,
    /// Name of the first.
    name: String,
    count: usize,
}

impl Labels {
    /// The visible labels as fields, those of one layer, colour and opacity together.
    ///
    /// # Errors
    /// [`Error::Volume`] if there is none, or there would be more than `most`; and if memory is too small.
    pub fn fields(&self, most: usize) -> Result<Vec<LabelField>, Error> {
        let looks = self.looks();
        let (name, count) = (self.name(), looks.len());
        let refuse = |problem: String| Err(Error::volume(Path::new(&name), problem));
        match count {
            0 => return refuse("none of its labels is visible: show some".into()),
            _ if count > most => {
                return refuse(format!(
                    "its labels have {count} colours and opacities, and at most {most} of them are drawn with other fields: choose labels, or \
                     give several one look"
                ));
            }
            _ => {}
        }
        looks.into_iter().map(|look| self.field(look)).collect()
    }

    fn looks(&self) -> Vec<Look> {
        let mut looks: Vec<Look> = Vec::new();
        for (number, layer) in self.layers().iter().enumerate() {
            let (first, palette) = (looks.len(), layer.palette());
            for (n, (&entry, label)) in palette.iter().skip(1).zip(layer.present()).enumerate() {
                if entry[3] <= 0.0 {
                    continue;
                }
                let known = looks[first..].iter().position(|look| look.entry == entry).map(|at| first + at);
                let at = known.unwrap_or_else(|| {
                    let name = label.name.clone().unwrap_or_else(|| format!("label {}", label.id));
                    looks.push(Look { entry, layer: number, shown: vec![false; palette.len()], name, count: 0 });
                    looks.len() - 1
                });
                looks[at].shown[n + 1] = true;
                looks[at].count += 1;
            }
        }
        looks
    }

    fn field(&self, look: Look) -> Result<LabelField, Error> {
        let Look { entry: [r, g, b, opacity], layer, shown, name, count } = look;
        let name = if count > 1 { format!("{name} and {} more", count - 1) } else { name };
        let layer = Layer { indices: self.layers()[layer].indices(None)?, shown };
        let shares = match self.surfaces() {
            LabelSurfaces::Smooth => layer.shares(&name)?,
            LabelSurfaces::Voxels => layer.whole_shares(&name)?,
        };
        let volume = Volume::new(name.clone(), layer.indices.grid().clone(), shares)?.with_background(0.0)?;
        let volume = volume.with_contents(layer.indices.contents().clone());
        Ok(LabelField { volume, name, color: [r, g, b], opacity })
    }
}
