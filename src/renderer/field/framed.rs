//! A field in frames on another grid: rays are counted in the voxels of the frame, and values come from the field's own voxels.

use super::{Field, FieldKernels, World};
use crate::device::Device;
use crate::device::launch::structs::{FieldPlacement, LightParams};
use crate::error::Error;
use crate::layers::{Axis, AxisFrame};
use crate::volume::Grid;
use glam::{DAffine3, DVec3};

/// Share of a voxel by which voxels of two grids may differ and still count as equal.
const ROUNDING: f64 = 1e-6;

/// Where the voxels of a field lie in a frame.
pub(super) struct Framed {
    /// The field's grid.
    own: Grid,
    /// Voxels of the frame to those of the field.
    to_own: DAffine3,
    /// The voxel of the frame at the field's first one, if both grids have the same axes.
    shift: Option<[i32; 3]>,
}

impl Framed {
    fn new(own: &Grid, frame: &Grid) -> Self {
        let to_own = own.index_to_world().inverse() * frame.index_to_world();
        // Where corners of the frame lie, so that small differences of axes add up over the grid.
        let last = DVec3::from_array(frame.dims().map(|n| n as f64));
        let shift = (-to_own.translation).round();
        let is_shifted = [DVec3::ZERO, last.with_x(0.0), last.with_y(0.0), last.with_z(0.0)]
            .iter()
            .all(|&voxel| to_own.transform_point3(voxel).abs_diff_eq(voxel - shift, ROUNDING * last.max_element()));
        let shift = is_shifted.then(|| shift.to_array().map(|n| n as i32));
        Self { own: own.clone(), to_own, shift }
    }
}

impl Field {
    /// This field in frames on another grid. The voxels stay as they are; opacities keep the unit distance of the own grid.
    pub fn in_frame(&self, frame: &Grid) -> Self {
        let own = self.description.grid();
        let framed = Framed::new(own, frame);
        let description = self.description.on_grid(frame.clone());
        let world = World::new(frame);
        let unit_distance = self.unit_distance * own.spacing().min_element() / world.unit();
        Self { description, world, grid: world.grid(frame), unit_distance, framed: Some(framed.into()), ..self.for_renderer() }
    }

    /// The field at the voxels of the frame, where algorithms need them there; `ends` as for [`resampled`](Self::resampled).
    ///
    /// # Errors
    /// If they do not fit into a buffer of the device.
    pub fn on_frame(&self, kernels: &mut FieldKernels, device: &Device, ends: bool) -> Result<Self, Error> {
        let field = self.resampled(kernels, device, self.own_grid().index_to_world(), self.description.grid(), ends)?;
        Ok(Self { unit_distance: self.unit_distance, ..field })
    }

    /// Whether frames have another grid than the voxels.
    pub fn is_framed(&self) -> bool {
        self.framed.is_some()
    }

    /// The grid of the voxels. Its unit of length is not that of [`grid`](Self::grid).
    pub fn own_grid(&self) -> &Grid {
        self.framed.as_ref().map_or(&self.grid, |framed| &framed.own)
    }

    /// Voxels of the frame among those of the field, if these are others.
    pub fn of_frame(&self) -> Option<DAffine3> {
        self.framed.as_ref().map(|framed| framed.to_own)
    }

    /// The layer axis of the layout that is read in layers along an axis of the frame.
    pub fn own_axis(&self, axis: Axis) -> Axis {
        let is_apart = self.framed.as_ref().is_some_and(|framed| framed.shift.is_none());
        if is_apart { Axis::Z } else { axis }
    }

    /// Kernel argument for layers along the axis of `frame`. `ends`: where the field ends, in its own voxels; `blocks`: its numbers along
    /// the axes of its layout; `radius`: of the kernel.
    pub fn placement(&self, frame: AxisFrame, ends: Option<(DVec3, DVec3)>, blocks: [i32; 2], radius: i32) -> FieldPlacement {
        let own_frame = self.own_axis(frame.layer_axis()).frame();
        let narrow = |own: DVec3| own_frame.local(own).as_vec3().to_array();
        let (lowest, highest) = ends.unwrap_or_default();
        let placement = FieldPlacement {
            placed: FieldPlacement::ON_FRAME,
            has_ends: i32::from(ends.is_some()),
            to_own: [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]],
            lowest: narrow(lowest),
            highest: narrow(highest),
            shift: [0; 3],
            slabs: [i32::MIN, i32::MAX],
            blocks,
            padding: 0.0,
        };
        let Some(framed) = &self.framed else { return placement };
        let row = |i: usize| {
            let row = framed.to_own.matrix3.row(i);
            frame.local(row).extend(framed.to_own.translation[i]).as_vec4().to_array()
        };
        let to_own = [own_frame.u, own_frame.v, own_frame.a].map(row);
        let radius = f64::from(radius);
        match framed.shift {
            Some(shift) => {
                let first = shift[frame.a];
                let slabs = [first, first + framed.own.dims()[frame.a] as i32 + 2 * radius as i32 - 2];
                FieldPlacement {
                    placed: FieldPlacement::SHIFTED,
                    to_own,
                    shift: [frame.u, frame.v, frame.a].map(|i| shift[i]),
                    slabs,
                    ..placement
                }
            }
            None => {
                let [lowest, highest] = framed.layers_reached(frame, radius);
                // Slab q lies between the planes q - radius and q - radius + 1.
                let slabs = [(lowest.floor() + radius) as i32, (highest.ceil() + radius) as i32 - 1];
                FieldPlacement { placed: FieldPlacement::APART, to_own, slabs, ..placement }
            }
        }
    }
}

impl Framed {
    /// Layers of the frame between which the field lies, with the support of a kernel of this radius.
    fn layers_reached(&self, frame: AxisFrame, radius: f64) -> [f64; 2] {
        let to_frame = self.to_own.inverse();
        let dims = self.own.dims();
        let corner = |n: usize, i: usize| if n >> i & 1 == 0 { -radius } else { dims[i] as f64 - 1.0 + radius };
        let layers = (0..8).map(|n| to_frame.transform_point3(DVec3::new(corner(n, 0), corner(n, 1), corner(n, 2)))[frame.a]);
        layers.fold([f64::INFINITY, f64::NEG_INFINITY], |[lowest, highest], a| [lowest.min(a), highest.max(a)])
    }
}

impl FieldPlacement {
    /// The lighting of points that are counted in the voxels of a shifted field, from that of points in the frame.
    pub fn lighting(&self, mut light: LightParams) -> LightParams {
        if self.placed != Self::SHIFTED {
            return light;
        }
        for (i, shift) in self.shift.into_iter().enumerate() {
            let shift = shift as f32;
            light.cue_at_origin += shift * light.cue[i];
            let volume = &mut light.light_volume;
            volume.origins.iter_mut().for_each(|origin| origin[i] += shift * volume.shadow_scale[i]);
            volume.sky_origin[i] += shift * volume.sky_scale[i];
        }
        light
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DMat3;

    #[test]
    fn whole_voxels_are_a_shift() {
        let spacing = DVec3::new(0.3, 0.7, 1.1);
        let turned = DMat3::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 0.7);
        let frame = Grid::oriented([40, 30, 20], spacing, DVec3::new(5.0, -3.0, 2.0), turned).unwrap();
        let origin = frame.index_to_world().transform_point3(DVec3::new(4.0, -7.0, 11.0));
        let own = Grid::oriented([8; 3], spacing, origin, turned).unwrap();
        assert_eq!(Framed::new(&own, &frame).shift, Some([4, -7, 11]));
        let half = Grid::oriented([8; 3], spacing, frame.index_to_world().transform_point3(DVec3::new(4.5, -7.0, 11.0)), turned)
            .unwrap();
        assert_eq!(Framed::new(&half, &frame).shift, None);
        let longer = Grid::oriented([8; 3], spacing * 1.001, origin, turned).unwrap();
        assert_eq!(Framed::new(&longer, &frame).shift, None);
    }
}
