//! The grid of a frame in which fields with grids of their own are drawn together. It has no voxels: layers and lattices follow it.

use crate::error::Error;
use crate::volume::{Grid, reach, spacing_along};
use glam::DVec3;

/// Finer spacings up to this share of a voxel need no further voxels.
const SLACK: f64 = 0.25;
/// Share by which spacings may differ and still count as equal: those of rotated axes are rounded.
const ROUNDING: f64 = 1e-6;
/// How many voxels beyond its outermost ones a field reaches: the largest radius of kernels that several fields are reconstructed by.
const REACH: f64 = 2.0;

/// The grid of the first field with the smallest spacing, refined along its axes where another field is finer, and extended to the union of all
/// extents. So that field keeps its values at its own voxels.
///
/// # Errors
/// If there would be more than [`Grid::MAX_VOXELS`] voxels.
pub(super) fn common_grid(grids: &[&Grid]) -> Result<Grid, Error> {
    let smallest = |grid: &Grid| grid.spacing().min_element();
    let finest = grids.iter().map(|grid| smallest(grid)).fold(f64::INFINITY, f64::min);
    let base = *grids.iter().find(|grid| smallest(grid) <= finest * (1.0 + ROUNDING)).expect("a scene has a field");
    if grids.iter().all(|grid| *grid == base) {
        return Ok(base.clone());
    }
    let refined: DVec3 = std::array::from_fn::<f64, 3, _>(|axis| {
        let own = base.spacing()[axis];
        let finest =
            grids.iter().map(|grid| spacing_along(grid.world_to_voxel_linear(), base.direction().col(axis))).fold(own, f64::min);
        (own / finest - SLACK).ceil().max(1.0)
    })
    .into();
    let place = |grid: &Grid, voxel| base.world_to_voxel(grid.index_to_world().transform_point3(voxel)) * refined;
    let others = grids.iter().filter(|grid| **grid != base);
    let [lowest, highest] = others
        .map(|grid| reach(grid.dims(), REACH, |voxel| place(grid, voxel)))
        .fold([DVec3::ZERO, last(base) * refined], |[lowest, highest], [from, to]| [lowest.min(from), highest.max(to)]);
    let dims = (highest - lowest + 1.0).to_array().map(|n| n as usize);
    let origin = base.index_to_world().transform_point3(lowest / refined);
    let grid = Grid::oriented(dims, base.spacing() / refined, origin, base.direction())?;
    Ok(if base.has_anatomy() { grid.with_anatomy() } else { grid })
}

fn last(grid: &Grid) -> DVec3 {
    DVec3::from_array(grid.dims().map(|n| n as f64 - 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;
    use glam::DMat3;

    #[test]
    fn equal_grids_are_kept() {
        let grid = Grid::oriented([5, 6, 7], DVec3::new(1.0, 2.0, 3.0), DVec3::ONE, DMat3::IDENTITY).unwrap();
        assert_eq!(common_grid(&[&grid, &grid.clone()]).unwrap(), grid);
    }

    #[test]
    fn the_first_of_equally_fine_fields_has_the_axes() {
        let first = Grid::new([10; 3], DVec3::ONE).unwrap();
        let turned = DMat3::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 0.7);
        let rotated = Grid::oriented([10; 3], DVec3::splat(1.0 - 1e-12), DVec3::ZERO, turned).unwrap();
        assert_eq!(common_grid(&[&first, &rotated]).unwrap().direction(), DMat3::IDENTITY);
    }

    #[test]
    fn a_coarse_field_extends_the_fine_one() {
        let fine = Grid::new([10; 3], DVec3::ONE).unwrap();
        // Voxel 0 at -4: the field is 0 from -12 on.
        let coarse = Grid::oriented([4; 3], DVec3::splat(4.0), DVec3::splat(-4.0), DMat3::IDENTITY).unwrap();
        let common = common_grid(&[&coarse, &fine]).unwrap();
        assert_eq!((common.dims(), common.spacing()), ([29; 3], DVec3::ONE));
        assert!(common.origin().abs_diff_eq(DVec3::splat(-12.0), 1e-9));
    }

    #[test]
    fn layers_are_refined_where_another_field_is_finer() {
        let thick = Grid::new([10, 10, 4], DVec3::new(0.5, 0.5, 5.0)).unwrap();
        let even = Grid::new([8; 3], DVec3::splat(1.0)).unwrap();
        let common = common_grid(&[&thick, &even]).unwrap();
        assert_eq!(common.spacing(), DVec3::new(0.5, 0.5, 1.0));
        // Every fifth layer is one of the thick field.
        let layer = common.world_to_voxel(thick.index_to_world().transform_point3(DVec3::new(0.0, 0.0, 3.0)));
        assert_abs_diff_eq!(layer.z, layer.z.round(), epsilon = 1e-9);
    }

    #[test]
    fn huge_unions_are_refused() {
        let one = Grid::new([2; 3], DVec3::splat(1e-3)).unwrap();
        let far = Grid::oriented([2; 3], DVec3::ONE, DVec3::splat(1e6), DMat3::IDENTITY).unwrap();
        assert!(common_grid(&[&one, &far]).is_err());
    }
}
