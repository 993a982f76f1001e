// Names for the files that are included for each type of voxels: those that values are reconstructed from.
#undef TYPED
#undef ELEMENT
#undef ELEMENT_BYTES
#undef ELEMENT_SIGNED
#undef ELEMENT_VALUE
#undef ELEMENT_VALUES
#define TYPED(name) name
#define ELEMENT VOXEL
#define ELEMENT_BYTES VOXEL_BYTES
#define ELEMENT_SIGNED VOXEL_SIGNED
#define ELEMENT_VALUE VOXEL_VALUE
#define ELEMENT_VALUES VOXEL_VALUES
