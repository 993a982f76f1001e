//! Vectors as colours: the direction is the colour, and the norm makes the opacity.

use super::colors::{ColorOpacity, UploadedColors};
use crate::device::Device;
use crate::error::Error;
use crate::transfer::TransferFunction;
use crate::volume::Volume;
use rayon::prelude::*;
use std::path::Path;

/// Components of a vector.
const COMPONENTS: usize = 3;

impl UploadedColors {
    /// Uploads vectors whose components are volumes on one grid. The colour is (|x|, |y|, |z|) / norm, so opposite directions have the same,
    /// and the opacity, per smallest spacing, is that of the transfer function at the norm, the Euclidean one. Vectors that are 0 or have an
    /// invalid component are transparent.
    ///
    /// # Errors
    /// Unless there are three components on one grid, and for too little memory.
    pub fn from_vectors(device: &Device, components: &[Volume], transfer: &TransferFunction) -> Result<Self, Error> {
        let norms = vector_norms(components)?;
        let color = |n: usize, index: usize| {
            let norm = norms.valid(index).filter(|&norm| norm > 0.0)?;
            Some((components[n].valid(index)?.abs() / norm) as f32)
        };
        let opacity = |index: usize| norms.valid(index).filter(|&norm| norm > 0.0).map(|norm| transfer.opacity(norm) as f32);
        let volume = |value: &(dyn Fn(usize) -> Option<f32> + Sync)| {
            let voxels = (0..norms.grid().voxel_count()).into_par_iter().map(|index| value(index).unwrap_or(0.0));
            Volume::new(norms.name(), norms.grid().clone(), voxels.collect::<Vec<f32>>())
        };
        let colors = (0..COMPONENTS).map(|n| volume(&|index| color(n, index)));
        let all = colors.chain([volume(&opacity)]).collect::<Result<Vec<_>, _>>()?;
        Self::new(device, &all, ColorOpacity::Alpha, transfer)
    }
}

/// The Euclidean norms of vectors whose components are volumes on one grid. Those of vectors with an invalid component are NaN.
///
/// ```
/// use layersplat::renderer::vector_norms;
/// use layersplat::volume::{Grid, Volume};
///
/// let grid = Grid::new([2, 1, 1], [1.0, 1.0, 1.0].into())?;
/// let component = |values: [f32; 2]| Volume::new("flow", grid.clone(), values.to_vec());
/// let norms = vector_norms(&[component([3.0, 0.0])?, component([4.0, 0.0])?, component([0.0, 1.0])?])?;
/// assert_eq!([norms.value(0), norms.value(1)], [5.0, 1.0]);
/// # Ok::<(), layersplat::Error>(())
/// ```
///
/// # Errors
/// Unless there are three components on one grid.
pub fn vector_norms(components: &[Volume]) -> Result<Volume<'static>, Error> {
    if components.len() != COMPONENTS {
        let problem = format!("there are {} components, and vectors have {COMPONENTS}", components.len());
        return Err(Error::Settings { field: "colors", problem });
    }
    let first = &components[0];
    if let Some(other) = components.iter().find(|other| other.grid() != first.grid()) {
        return Err(Error::volume(Path::new(other.name()), format!("its grid is not that of {}", first.name())));
    }
    let norm = |index: usize| {
        let squares = components.iter().map(|component| component.valid(index).map(|value| value * value));
        squares.sum::<Option<f64>>().map_or(f32::NAN, |sum| sum.sqrt() as f32)
    };
    let norms: Vec<f32> = (0..first.grid().voxel_count()).into_par_iter().map(norm).collect();
    Volume::new(first.name(), first.grid().clone(), norms)
}
