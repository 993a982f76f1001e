// Points and gradients.

#include "shared/vector.cl"

// In voxels along the kernel's axes.
typedef struct {
    realv u, v, a;
} Point;

// In voxel differences along the kernel's axes.
typedef struct {
    realv u, v, a;
} Gradient;
