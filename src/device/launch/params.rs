//! Structures shared with the kernels. Sizes are checked at compile time on both sides: here by `shared_struct!`, in
//! the kernels by `CHECK_SIZE` against the `-D` options of [`size_defines`].

/// `float4`.
#[repr(C, align(16))]
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Float4(pub [f32; 4]);

macro_rules! shared_struct {
    ($(#[$doc:meta])* $name:ident, $define:ident, $bytes:literal { $($field:ident: $type:ty),* $(,)? }) => {
        $(#[$doc])*
        #[repr(C)]
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub(crate) struct $name { $(pub $field: $type),* }
        const _: () = assert!(size_of::<$name>() == $bytes);
        const $define: usize = $bytes;
    };
}

shared_struct! {
    /// See `VolumeView` in kernels/volume.cl.
    VolumeView, VOLUME_VIEW_BYTES, 48 {
        stride: [i64; 3],
        dims: [i32; 3],
        background: f32,
        offset: f32,
        padding: u32,
    }
}

shared_struct! {
    /// See `SampleParams` in kernels/shading.cl.
    SampleParams, SAMPLE_PARAMS_BYTES, 184 {
        table_first: f32,
        table_per_value: f32,
        table_last: i32,
        visible: [i32; 2],
        linear: i32,
        samples_per_layer: [i32; 3],
        background_visible: i32,
        opaque: f32,
        shading: i32,
        gradient: [f32; 3],
        light: [f32; 3],
        half_way: [f32; 3],
        ambient: f32,
        diffuse: f32,
        specular: f32,
        power: f32,
        step: [f32; 3],
        table_unit: f32,
        ends: [[f32; 2]; 8],
        curve: f32,
    }
}

shared_struct! {
    /// See `LayerOffset` in kernels/footprint.cl.
    LayerOffset, LAYER_OFFSET_BYTES, 8 {
        base: i32,
        fraction: f32,
    }
}

shared_struct! {
    /// See `LatticeParams` in kernels/lattice.cl.
    LatticeParams, LATTICE_PARAMS_BYTES, 48 {
        samples_per_voxel: [i32; 2],
        columns: [i32; 2],
        tiles: [i32; 2],
        blocks: [i32; 2],
        layer_step: i32,
        culling: i32,
        shear: [f32; 2],
    }
}

shared_struct! {
    /// See `RayLatticeParams` in kernels/ray_lattice.cl.
    RayLatticeParams, RAY_LATTICE_PARAMS_BYTES, 52 {
        size: [i32; 2],
        tiles: [i32; 2],
        blocks: [i32; 2],
        layer_step: i32,
        culling: i32,
        centre_layer: f32,
        visible: [f32; 2],
        slabs: [i32; 2],
    }
}

shared_struct! {
    /// See `DirectParams` in kernels/direct.cl.
    DirectParams, DIRECT_PARAMS_BYTES, 232 {
        stride: [i64; 4],
        origin: [[f32; 4]; 3],
        direction: [[f32; 4]; 3],
        start: f32,
        spacing: [f32; 3],
        gradient: [f32; 3],
        light: [f32; 3],
        half_way: [f32; 3],
        dims: [i32; 3],
        blocks: [[i32; 2]; 3],
        axis: i32,
        culling: i32,
        background: f32,
        offset: f32,
    }
}

shared_struct! {
    /// See `WarpParams` in kernels/warp.cl.
    WarpParams, WARP_PARAMS_BYTES, 80 {
        from_screen: [f32; 9],
        lattice: [i32; 2],
        frame: [i32; 2],
        forward: f32,
        tile: [i32; 2],
        counts: i32,
        filter: i32,
        share: f32,
        added: i32,
    }
}

shared_struct! {
    /// See `ScreenParams` in kernels/screen.cl.
    ScreenParams, SCREEN_PARAMS_BYTES, 128 {
        origin: [[f32; 4]; 3],
        direction: [[f32; 4]; 3],
        start: f32,
        step: [f32; 3],
        size: [i32; 2],
        tiles: [i32; 2],
    }
}

shared_struct! {
    /// See `MarchParams` in kernels/marching.cl.
    MarchParams, MARCH_PARAMS_BYTES, 44 {
        blocks: [i32; 2],
        culling: i32,
        length: f32,
        slice_step: f32,
        thin: i32,
        table_first: f32,
        table_per_value: f32,
        table_size: i32,
        visible: [f32; 2],
    }
}

shared_struct! {
    /// See `SplatParams` in kernels/splat.cl.
    SplatParams, SPLAT_PARAMS_BYTES, 116 {
        to_screen: [[f32; 4]; 3],
        along: [f32; 4],
        footprint: [f32; 3],
        half_size: [f32; 2],
        nearest: f32,
        least_w: f32,
        nearest_sheet: f32,
        sheet_distance: f32,
        sheets: [i32; 2],
        backwards: i32,
        background: f32,
    }
}

/// `-D` options that tell the kernels the sizes of the structures.
pub(crate) fn size_defines() -> String {
    [
        ("VOLUME_VIEW_BYTES", VOLUME_VIEW_BYTES),
        ("SAMPLE_PARAMS_BYTES", SAMPLE_PARAMS_BYTES),
        ("LAYER_OFFSET_BYTES", LAYER_OFFSET_BYTES),
        ("LATTICE_PARAMS_BYTES", LATTICE_PARAMS_BYTES),
        ("RAY_LATTICE_PARAMS_BYTES", RAY_LATTICE_PARAMS_BYTES),
        ("DIRECT_PARAMS_BYTES", DIRECT_PARAMS_BYTES),
        ("WARP_PARAMS_BYTES", WARP_PARAMS_BYTES),
        ("SCREEN_PARAMS_BYTES", SCREEN_PARAMS_BYTES),
        ("MARCH_PARAMS_BYTES", MARCH_PARAMS_BYTES),
        ("SPLAT_PARAMS_BYTES", SPLAT_PARAMS_BYTES),
    ]
    .map(|(name, bytes)| format!("-D{name}={bytes}"))
    .join(" ")
}
