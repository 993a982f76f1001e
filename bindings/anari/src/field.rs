//! Spatial fields: values on a regular grid.

use crate::arrays::Memory;
use crate::handle::Handle;
use crate::objects::Objects;
use crate::status::Problem;
use crate::types::DataType;
use anari_sys::*;
use layersplat::Error;
use layersplat::glam::{DAffine3, DMat3, DVec3};
use layersplat::settings::CropBox;
use layersplat::volume::{Grid, Rescale, Storage, Volume, VoxelType};
use std::sync::Arc;

/// What the voxels of a field depend on. Two fields with the same key have the same voxels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FieldKey {
    pub field: Handle,
    committed: u64,
    pub array: Handle,
    contents: u64,
}

/// A field as of its last commit. Its memory is that of the array, not a copy.
pub struct Field {
    pub key: FieldKey,
    /// Whether its filter is cubic.
    pub is_cubic: bool,
    memory: Arc<Memory>,
    element: DataType,
    dims: [usize; 3],
    origin: DVec3,
    spacing: DVec3,
}

/// The memory of an array as a library's storage.
struct Voxels(Arc<Memory>);

impl AsRef<[u8]> for Voxels {
    fn as_ref(&self) -> &[u8] {
        (*self.0).as_ref()
    }
}

impl Field {
    /// The field of an object.
    ///
    /// # Errors
    /// If it has no values, or its array is mapped.
    pub fn from_object(objects: &Objects, handle: Handle) -> Result<Self, Problem> {
        let field = objects.known(handle)?;
        let missing = || Problem::argument("the field has no data: commit an array as data");
        let data = field.object(c"data").ok_or_else(missing)?;
        let array = objects.get(data).and_then(|object| object.array()).ok_or_else(missing)?;
        if array.maps > 0 {
            return Err(Problem::operation("the data of the field is mapped: unmap it before a frame"));
        }
        let key = FieldKey { field: handle, committed: field.version, array: data, contents: array.version };
        let vector = |name, otherwise| field.floats::<3>(name).map_or(otherwise, |v| DVec3::from_array(v.map(f64::from)));
        Ok(Self {
            key,
            is_cubic: field.text(c"filter") == Some("cubic"),
            memory: array.memory.clone(),
            element: array.element,
            dims: array.dims,
            origin: vector(c"origin", DVec3::ZERO),
            spacing: vector(c"spacing", DVec3::ONE),
        })
    }

    /// The smallest and largest corner, in the coordinates of the object.
    pub fn bounds(&self) -> [DVec3; 2] {
        let cells = DVec3::from_array(self.dims.map(|n| n as f64 - 1.0));
        [self.origin, self.origin + cells * self.spacing]
    }

    /// The box of the values in voxels. A single layer of values keeps its reach, or nothing of it would be left.
    pub fn crop_box(&self) -> CropBox {
        let ends = self.dims.map(|n| if n > 1 { (0.0, n as f64 - 1.0) } else { (-1.0, 1.0) });
        CropBox { lowest: DVec3::from_array(ends.map(|end| end.0)), highest: DVec3::from_array(ends.map(|end| end.1)) }
    }

    /// Transform from voxels to the world, for one from the object to the world.
    pub fn index_to_world(&self, placement: DAffine3) -> DAffine3 {
        placement * DAffine3::from_mat3_translation(DMat3::from_diagonal(self.spacing), self.origin)
    }

    /// Whether a transform that [`grid`](Self::grid) takes shears the axes of the voxels.
    pub fn is_sheared(&self, placement: DAffine3) -> bool {
        Grid::from_affine(self.dims, self.index_to_world(placement)).is_err()
    }

    /// The grid in the world, for a transform from the object to the world: that of the voxels; if they are sheared, one that covers them.
    ///
    /// # Errors
    /// If the transform is singular, and for numbers that the library does not take.
    pub fn grid(&self, placement: DAffine3) -> Result<Grid, Error> {
        let index_to_world = self.index_to_world(placement);
        Grid::from_affine(self.dims, index_to_world).or_else(|_| Grid::covering(self.dims, index_to_world))
    }

    /// The volume in the world; if it is sheared, with the same spacings without shear. Fixed-point numbers are values from 0 to 1, or −1 to 1.
    ///
    /// # Errors
    /// Those of the grid, and ranges of values that the library does not take.
    pub fn volume(&self, placement: DAffine3) -> Result<Volume<'static>, Error> {
        let index_to_world = self.index_to_world(placement);
        let axes = index_to_world.matrix3;
        let spacing = || DVec3::new(axes.x_axis.length(), axes.y_axis.length(), axes.z_axis.length());
        let grid = Grid::from_affine(self.dims, index_to_world).or_else(|_| Grid::new(self.dims, spacing()))?;
        let (voxel_type, largest) = match self.element {
            ANARI_UFIXED8 => (VoxelType::Uint8, f64::from(u8::MAX)),
            ANARI_UFIXED16 => (VoxelType::Uint16, f64::from(u16::MAX)),
            ANARI_FIXED16 => (VoxelType::Int16, f64::from(i16::MAX)),
            ANARI_FLOAT64 => {
                let doubles = (*self.memory).as_ref().as_chunks::<8>().0;
                let values: Vec<f64> = doubles.iter().map(|&double| f64::from_ne_bytes(double)).collect();
                return Volume::from_wide(NAME, grid, &values);
            }
            _ => (VoxelType::Float32, 1.0),
        };
        let storage = Storage::from_bytes(Voxels(self.memory.clone()), voxel_type);
        let volume = Volume::new(NAME, grid, storage)?;
        Ok(if largest == 1.0 { volume } else { volume.with_rescale(Rescale::new(1.0 / largest, 0.0)?) })
    }
}

/// Name of the volume in the library's messages.
const NAME: &str = "the spatial field";
