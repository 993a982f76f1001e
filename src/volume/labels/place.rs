//! Labels at positions.

use super::{Label, LabelLayer, Labels};
use glam::DVec3;

/// Voxels on each side of a position among which the nearest visible label is found: those that the cubic kernel weights there.
const REACH: i32 = 2;

impl Labels {
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
    /// reach that far beyond their voxels.
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
