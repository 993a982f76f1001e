// A lattice of rays: a ray keeps its (I, J) in all layers, and crosses layer k at u = c_u + (k - k_c) s_u(I),
// v = c_v + (k - k_c) s_v(J), for crossings (c, s) per column and per row.

// Mirrors `RayLatticeParams` in src/device/launch/params.rs.
typedef struct {
    int width, height;      // of the lattice
    int tiles_u, tiles_v;
    int blocks_u, blocks_v; // of `visible`
    int layer_step;         // +1 or -1
    int culling;            // 0: visit every layer, to test that culling changes nothing
    float centre_layer;     // k_c
    // Point-sampled layers: values between which lies all opacity, and slabs between which lies all that shows any.
    float visible_from, visible_to;
    int first_slab, last_slab;
} RayLatticeParams;
CHECK_SIZE(RayLatticeParams, RAY_LATTICE_PARAMS_BYTES);
