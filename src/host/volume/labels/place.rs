//! Labels at positions.

use super::{Label, LabelLayer, Labels};
use crate::error::Error;
use crate::volume::{Description, Grid};
use glam::DVec3;
use std::path::Path;

/// Voxels on each side of a position among which the nearest visible label is found: those that the cubic kernel weights there.
const REACH: i32 = 2;

impl Labels {
    /// The labels where they colour a scan (`Renderer::set_label_colors`): those of a file that states no
    /// placement, as NumPy arrays, get the placement of a scan of their size.
    ///
    /// # Errors
    /// If no voxel of the labels lies in the scan's box, and for labels of another size without a placement.
    pub fn over(mut self, scan: &Description) -> Result<Self, Error> {
        for layer in &mut self.layers {
            let name = layer.path.file_name().unwrap_or_default().to_string_lossy();
            layer.grid = grid_over(&name, (&layer.grid, layer.contents.states_spacing), scan)?;
        }
        Ok(self)
    }

    /// The labels on other grids.
    ///
    /// # Errors
    /// Those of `place`.
    pub fn placed(mut self, place: impl Fn(&Grid) -> Result<Grid, Error>) -> Result<Self, Error> {
        self.layers.iter_mut().try_for_each(|layer| {
            layer.grid = place(&layer.grid)?;
            Ok::<_, Error>(())
        })?;
        Ok(self)
    }

    /// The label of the voxel nearest to a world position: that of the first layer which has one there. `None` for the background and
    /// beyond the grid.
    ///
    /// ```
    /// use layersplat::glam::DVec3;
    /// use layersplat::volume::{Labels, OpenOptions};
    /// # let folder = tempfile::tempdir().expect("a folder");
    /// # let path = folder.path().join("organs.nrrd");
    /// # let header = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 1\nencoding: raw\n\n";
    /// # std::fs::write(&path, [header.as_bytes(), &[0, 7, 7, 12]].concat()).expect("a file");
    ///
    /// let labels = Labels::open(&path, &OpenOptions::default(), None)?;
    /// let id = |x, y| labels.label_at(DVec3::new(x, y, 0.0)).map(|label| label.id);
    /// assert_eq!([id(0.1, 0.2), id(0.6, 0.2), id(1.4, 1.4), id(1.6, 1.0)], [None, Some(7), Some(12), None]);
    /// # Ok::<(), layersplat::Error>(())
    /// ```
    pub fn label_at(&self, position: DVec3) -> Option<&Label> {
        self.layers().iter().find_map(|layer| layer.label_at(layer.grid().world_to_voxel(position)))
    }

    /// The visible label of the nearest voxel that has one, within two voxels of a world position along each axis. Smooth surfaces of labels
    /// lie beside their voxels, and depths between samples.
    pub fn visible_label_near(&self, position: DVec3) -> Option<&Label> {
        let near = self.layers().iter().filter_map(|layer| layer.visible_label_near(position));
        near.min_by(|(one, _), (other, _)| one.total_cmp(other)).map(|(_, label)| label)
    }
}

impl LabelLayer {
    /// The label of the voxel nearest to a place in voxels.
    fn label_at(&self, place: DVec3) -> Option<&Label> {
        let id = self.id(self.grid().nearest_voxel(place)?);
        self.table().get(id)
    }

    /// The nearest visible label, and the square of its distance in world units.
    fn visible_label_near(&self, position: DVec3) -> Option<(f64, &Label)> {
        let place = self.grid().world_to_voxel(position);
        let first = place.floor() - f64::from(REACH - 1);
        let offsets =
            (0..(2 * REACH).pow(3)).map(|n| [n, n / (2 * REACH), n / (2 * REACH).pow(2)].map(|i| f64::from(i % (2 * REACH))));
        let found = offsets.filter_map(|offset| {
            let voxel = first + DVec3::from_array(offset);
            let label = self.label_at(voxel).filter(|label| label.drawn_opacity() > 0.0)?;
            Some((((voxel - place) * self.grid().spacing()).length_squared(), label))
        });
        found.min_by(|(one, _), (other, _)| one.total_cmp(other))
    }
}

/// The grid of labels over a scan: their own, or that of the scan ([`Labels::over`]). `is_placed`: whether their file states a placement.
///
/// # Errors
/// As [`Labels::over`].
#[doc(hidden)]
pub fn grid_over(name: &str, (own, is_placed): (&Grid, bool), scan: &Description) -> Result<Grid, Error> {
    let wrong = |problem: String| Error::volume(Path::new(name), problem);
    let size = |[x, y, z]: [usize; 3]| format!("{x}x{y}x{z}");
    if own.dims() == scan.grid().dims() && (!is_placed || has_default_placement(own)) {
        return Ok(scan.grid().clone());
    }
    if !is_placed {
        let problem = format!(
            "its labels of {} voxels do not fit {} of {} voxels, and it states no spacing and origin: give labels of that size, or \
             a file that states both, such as NRRD or NIfTI",
            size(own.dims()),
            scan.name(),
            size(scan.grid().dims())
        );
        return Err(wrong(problem));
    }
    let place = |corner: DVec3| own.world_to_voxel(scan.grid().index_to_world().transform_point3(corner));
    let corners = scan.grid().corner_voxels().map(place);
    let lowest = corners.into_iter().reduce(DVec3::min).expect("eight corners");
    let highest = corners.into_iter().reduce(DVec3::max).expect("eight corners");
    let last = DVec3::from_array(own.dims().map(|n| n as f64));
    if lowest.cmpgt(last).any() || highest.cmplt(DVec3::NEG_ONE).any() {
        let [of_labels, of_scan] = [own, scan.grid()].map(Grid::centre);
        let problem = format!(
            "its labels lie outside {}: their centre is at {of_labels}, and that of the volume at {of_scan}; check the placement of both",
            scan.name()
        );
        return Err(wrong(problem));
    }
    Ok(own.clone())
}

/// Whether a grid is that of arrays and files which state none.
fn has_default_placement(grid: &Grid) -> bool {
    Grid::new(grid.dims(), DVec3::ONE).is_ok_and(|default| default.index_to_world() == grid.index_to_world())
}
