// Names for the files that are included for each type of voxels: those that gradients are estimated from, with SEPARATE_GRADIENTS.
#undef TYPED
#undef ELEMENT
#undef ELEMENT_BYTES
#undef ELEMENT_SIGNED
#undef ELEMENT_VALUE
#undef ELEMENT_VALUES
#define TYPED(name) CAT(gradient_, name)
#define ELEMENT GRADIENT_VOXEL
#define ELEMENT_BYTES GRADIENT_VOXEL_BYTES
#define ELEMENT_SIGNED GRADIENT_VOXEL_SIGNED
#ifdef GRADIENT_UNCHECKED
#define ELEMENT_VALUE CHECKED_VALUE
#define ELEMENT_VALUES CHECKED_VALUES
#else
#define ELEMENT_VALUE PLAIN_VALUE
#define ELEMENT_VALUES PLAIN_VALUE
#endif
