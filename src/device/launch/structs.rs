//! Structures that kernels take, each written once: here. Their OpenCL definitions come from these and precede every program.

mod scatter;
mod surfaces;

pub(crate) use scatter::{
    ScatterCellsParams, ScatterGrid, ScatterLayersParams, ScatterMediumParams, ScatterSourceParams, ScatterSweepParams,
};
pub(crate) use surfaces::{SurfaceSet, SurfaceView};

use super::cl_type::ClType;
pub(crate) use super::cl_type::Float4;
use super::kernel_struct::{Field, kernel_struct};

kernel_struct! {
    /// Where the voxels of a layer axis lie, and what lies around them. Axes are u, v, a.
    VolumeView {
        /// Distances in voxels. Along u it is 1, except for kernels that take any layout.
        stride as [stride_u, stride_v, stride_a]: i64,
        /// Place of the first voxel that is held, in voxels from the beginning of the buffer.
        first: i64,
        /// Voxels along u, v, a.
        dims as [dims_u, dims_v, dims_a]: i32,
        /// Value of the voxels missing around the volume, less `offset`.
        background: f32,
        /// Subtracted from every voxel, so that float sums are as fine as the data's own range.
        offset: f32,
        /// Number of the first layer that the voxels hold; all that is read is among those that they hold.
        first_a: i32,
    }
}

kernel_struct! {
    /// The voxel values of a field and the scale of its gradients. Axes are u, v, a.
    FieldParams {
        /// Voxel differences to gradients in value ranges per voxel of the smallest spacing, world axes.
        gradient as [gradient_u, gradient_v, gradient_a]: f32,
        /// Weight of each neighbour of a voxel where gradients are smoothed across their direction.
        smoothing as [smoothing_u, smoothing_v, smoothing_a]: f32,
        /// Smallest and largest voxel, less the offset.
        range as [least, largest]: f32,
    }
}

kernel_struct! {
    /// Look-up of values in a transfer table or in its integrals, and which values are visible.
    ClassificationParams {
        /// Value of table entry 0, less the offset.
        table_first: f32,
        /// Entries per unit of value.
        table_per_value: f32,
        /// Index of the last entry.
        table_last: i32,
        /// First and last entry with opacity.
        visible as [first_visible, last_visible]: i32,
        /// Values outside have no opacity, or cannot change a ray.
        shown as [shown_from, shown_to]: f32,
        /// Extinction of one unit in the table.
        table_unit: f32,
        /// Values can lie beyond the table of integrals, where its first and last entries apply.
        cut: i32,
        /// Extinction: 1 = min(1, alpha dt), 0 = 1 - exp(-tau dt).
        linear: i32,
        /// The background has opacity: what lies beside the field's support is masked.
        background_visible: i32,
        /// Value of an iso-surface, less the offset, and its colour.
        iso: f32,
        iso_color as [iso_r, iso_g, iso_b]: f32,
        /// Factor of the colours of reduced values.
        brightness: f32,
        /// Structures with 64-bit fields hold an even number of 32-bit ones.
        padding: f32,
    }
}

kernel_struct! {
    /// Look-up of shadows and ambient occlusion in the bytes of light volumes. Axes are u, v, a.
    LightVolumeParams {
        /// Positions in the volumes of shadows and of the ambient light: voxels times the scale, plus the origin of each.
        shadow_scale as [shadow_scale_u, shadow_scale_v, shadow_scale_a]: f32,
        sky_scale as [sky_scale_u, sky_scale_v, sky_scale_a]: f32,
        /// Of each light: shifted towards the light.
        origins: [[f32; 3]; 4],
        sky_origin as [sky_origin_u, sky_origin_v, sky_origin_a]: f32,
        /// Bytes to the next value.
        shadow_stride as [shadow_stride_u, shadow_stride_v, shadow_stride_a]: i32,
        sky_stride as [sky_stride_u, sky_stride_v, sky_stride_a]: i32,
        /// Largest positions whose cell lies inside.
        shadow_last as [shadow_last_u, shadow_last_v, shadow_last_a]: f32,
        sky_last as [sky_last_u, sky_last_v, sky_last_a]: f32,
        /// Volume of each light, or -1: nothing casts a shadow. Volumes follow each other.
        volumes: [i32; 4],
        /// Bytes of a volume.
        volume_bytes: i32,
        /// First layers of values that the volumes hold: 0, but for parts of a volume.
        first_layers as [shadow_first, sky_first]: f32,
        /// Strength of the shadows.
        strength: f32,
        /// 1: the ambient light is dimmed by a volume.
        sky: i32,
        /// Of scattered light: which of x, y, z are u, v, a, two bits each.
        sky_axes: i32,
        /// Factor of a colour where gradients are too weak for shading: constant part, ambient part, part of each light.
        unshaded: f32,
        unshaded_ambient: f32,
        unshaded_lights: [f32; 4],
        /// Distance from an iso-surface, along its normal, at which light is looked up, in voxels.
        lift as [lift_u, lift_v, lift_a]: f32,
        /// Direction to the eye, unit length: the visible side of an iso-surface.
        eye as [eye_u, eye_v, eye_a]: f32,
        /// In the studio: how many times as far from a surface the light of lights is looked up; 0 in matter.
        shadow_lift: f32,
    }
}

kernel_struct! {
    /// How voxels of labels become extinctions and colours.
    LabelVoxelParams {
        dims as [dims_x, dims_y, dims_z]: i32,
        entry_count: i32,
        /// 1: to what the fields hold, the labels of other layers.
        adds: i32,
        /// 1: opacities differ.
        varied: i32,
        /// Weights of the neighbours of a voxel along each axis, against its own.
        beside as [beside_x, beside_y, beside_z]: f32,
        /// Axis across thick slices.
        thick: i32,
        /// Spacing in smallest spacings.
        across as [across_x, across_y, across_z]: f32,
        /// Farthest distance in a slice that changes shares, in smallest spacings, and in voxels along each axis.
        farthest: f32,
        reach as [reach_x, reach_y, reach_z]: i32,
    }
}

kernel_struct! {
    /// The surfaces of labels (label_surface.cl).
    LabelParams {
        /// Means of opacities up to this show nothing.
        least: f32,
        /// Largest opacity.
        most: f32,
        /// One over the change of a share within which the opacity changes.
        per_share: f32,
    }
}

kernel_struct! {
    /// Where the colours of labels lie (tint.cl).
    TintParams {
        /// Rows of the affine transform from voxels along u, v, a to voxels of the labels along x, y, z.
        to_voxels: [[f32; 4]; 3],
        /// Voxels of the labels along x, y, z.
        dims as [dims_x, dims_y, dims_z]: i32,
        /// Voxels of the labels for which the outer ones go on beyond their grid.
        beyond: f32,
        /// Bytes of a voxel of the labels, 1 or 2.
        bytes: i32,
    }
}

kernel_struct! {
    /// A sweep of rays from a light through the layers of an axis.
    LightSweepParams {
        tiles as [tiles_u, tiles_v]: i32,
        /// Blocks of `visible`.
        blocks as [blocks_u, blocks_v]: i32,
        /// Voxels along u and v, and layers.
        dims as [dims_u, dims_v, layers]: i32,
        /// +1 or -1: in the direction in which the light shines.
        layer_step: i32,
        /// 0: visit everything, to test that culling changes nothing.
        culling: i32,
        centre_layer: f32,
        /// Voxels along u and v from layer to layer, in the direction in which the light shines.
        along as [along_u, along_v]: f32,
        /// Layers from the first up to but excluding the last, numbered in the order in which the light shines: of all, 0 ... n + 2.
        order as [from, to]: i32,
        /// 1: rays continue from their state, else they are not dimmed.
        continues: i32,
        /// Strides of the voxels written, from voxel -1 on, and number of the first layer written.
        stride as [stride_u, stride_v, stride_a]: i32,
        first_stored: i32,
        /// Number of the volume among those of the buffer, and the bytes of one.
        volume: i32,
        volume_bytes: i32,
        /// Where the light goes: 0 to the bytes, 1 to the sums, 2 it is added to the sums.
        sum: i32,
        /// Factor of the light before it is clamped, and the value stored for a light of 1.
        gain: f32,
        steps: f32,
        /// Share of the shadow that is left after half a step from layer to layer: 1 without a limit of reach.
        recovered: f32,
        /// Length of a step from layer to layer, in unit distances of the first field.
        layer_length: f32,
        /// Half a layer, in the length that coarse transmittances are for.
        half_layer: f32,
    }
}

kernel_struct! {
    /// Lights, and what gradients leave of the opacity. Axes are u, v, a.
    LightParams {
        /// Samples are lit or faded by their depth, or their opacity depends on the gradient.
        shading: i32,
        /// Direction to the first light, unit length.
        direction as [direction_u, direction_v, direction_a]: f32,
        /// Direction half-way between the first light and the eye, unit length.
        half_way as [half_u, half_v, half_a]: f32,
        ambient: f32,
        /// Coefficients of the first light.
        diffuse: f32,
        specular: f32,
        power: f32,
        /// Number of further lights. Each has the direction to it, the direction between it and the eye, its diffuse and its specular.
        more_lights: i32,
        lights: [[f32; 8]; 3],
        /// Red, green and blue, for programs in which lights have colours: of all lights, of the ambient light, and the factor of a
        /// colour where gradients are too weak for shading and no light is dimmed.
        colors: [[f32; 3]; 4],
        ambient_color: [f32; 3],
        unshaded_color: [f32; 3],
        /// Opacity depends on the gradient.
        thinned: i32,
        /// The share of the opacity where there is no gradient, and by how much it rises: (from this length, by this per length, to this
        /// length).
        least_thinned: f32,
        rises: [[f32; 3]; 7],
        /// The share of the background in the colour of a sample at p, in voxels: cue.p + cue_at_origin, from 0 to cue_strength.
        cue as [cue_u, cue_v, cue_a]: f32,
        cue_at_origin: f32,
        /// 0: colours do not depend on the depth.
        cue_strength: f32,
        cue_color as [cue_r, cue_g, cue_b]: f32,
        light_volume: LightVolumeParams,
    }
}

kernel_struct! {
    /// How a ray is sampled. Axes are u, v, a.
    SegmentParams {
        /// Samples per layer: of all inner layers, and of splatted layers of the first and the last.
        samples_per_layer as [inner_slabs, front_slabs, back_slabs]: i32,
        /// World size of a voxel step / (unit distance x samples per layer).
        step as [step_u, step_v, step_a]: f32,
        /// Weights of the lower and the upper end of the segments from a layer to the next.
        ends: [[f32; 2]; 8],
        /// Share of the cubic that lighting follows between the ends of a segment, else even.
        curve: f32,
        /// Transmittance below which a tile is finished; 0: never.
        opaque: f32,
    }
}

kernel_struct! {
    /// All that a sample is classified and lit by.
    SampleParams {
        field: FieldParams,
        classification: ClassificationParams,
        light: LightParams,
        segments: SegmentParams,
    }
}

kernel_struct! {
    /// Where the voxels of a field lie among those of the frame, along the axes (u, v, a) of the frame and of the field's layout.
    FieldPlacement {
        /// `ON_FRAME`, `SHIFTED` or `APART`.
        placed: i32,
        /// 1: rays count between `lowest` and `highest` only.
        has_ends: i32,
        /// Voxels of the frame to those of the field, row by row: (u, v, a, 1).
        to_own: [[f32; 4]; 3],
        /// Where the field ends, in its own voxels.
        lowest: [f32; 3],
        highest: [f32; 3],
        /// Voxels of the frame at the field's first one, if shifted.
        shift as [shift_u, shift_v, shift_a]: i32,
        /// First and last slab of the frame in which the field lies.
        slabs as [first_slab, last_slab]: i32,
        /// Numbers of the field's blocks along u and v.
        blocks as [blocks_u, blocks_v]: i32,
        padding: f32,
    }
}

impl FieldPlacement {
    /// The voxels are those of the frame.
    pub const ON_FRAME: i32 = 0;
    /// They are shifted against those of the frame by whole voxels.
    pub const SHIFTED: i32 = 1;
    /// They lie anywhere.
    pub const APART: i32 = 2;
}

kernel_struct! {
    /// One of several fields that are drawn together.
    ChannelParams {
        view: VolumeView,
        gradient_view: VolumeView,
        sample: SampleParams,
        place: FieldPlacement,
        /// Bytes from a voxel with a colour to the next along u, v, a (voxel_colors.cl), 0 without colours; and these voxels.
        color_stride as [color_stride_u, color_stride_v, color_stride_a]: i32,
        color_dims as [color_dims_u, color_dims_v, color_dims_a]: i32,
        padding: [f32; 2],
    }
}

kernel_struct! {
    /// Volumes of colours that are packed into bytes.
    PackedColorParams {
        dims as [dims_x, dims_y, dims_z]: i32,
        /// Largest extinction, more than 0.
        largest: f32,
    }
}

kernel_struct! {
    /// Opacities of colours.
    ColorVoxelParams {
        count: i64,
        /// Share of a step of the components in full intensity.
        per_step: f32,
        /// 0: alpha; 1: a function of the luminance; 2: of the difference from the background.
        opacity_from: i32,
        background as [background_r, background_g, background_b]: f32,
        /// Entries of that function, from 0 to full intensity.
        opacity_count: i32,
    }
}

kernel_struct! {
    /// Voxels of one grid in another.
    ResampleParams {
        /// Voxels to those of the source, row by row: (x, y, z, 1).
        to_source: [[f32; 4]; 3],
        dims as [dims_x, dims_y, dims_z]: i32,
        /// Range of the values, less the offset.
        range as [least, largest]: f32,
        /// Value at the end of the field, less the offset.
        end: f32,
        /// How many times as far from the background values beyond the end are, at most.
        steepest: f32,
    }
}

kernel_struct! {
    /// Where rays begin and end: in an interval of their parameter, in a box, and on the positive side of planes. Box and planes are in
    /// voxels, along the kernel's axes.
    RayEnds {
        /// First and last ray parameter: of screen pixels, -INFINITY in a parallel view; of lattices, in layers along the rays.
        interval as [start, end]: f32,
        lowest: [f32; 3],
        highest: [f32; 3],
        /// (n, d): n.p + d >= 0 counts.
        planes: [[f32; 4]; 6],
        plane_count: i32,
    }
}

kernel_struct! {
    /// Where the samples of one phase sit in one layer, along one axis: column i lies at base + i + fraction.
    LayerOffset {
        base: i32,
        fraction: f32,
    }
}

kernel_struct! {
    /// The lattice in phases of a parallel view.
    SplatLatticeParams {
        /// Samples per voxel.
        per_voxel as [per_voxel_u, per_voxel_v]: i32,
        /// Lattice extent in voxels.
        columns as [columns_u, columns_v]: i32,
        /// Tiles per phase.
        tiles as [tiles_u, tiles_v]: i32,
        /// Blocks of `visible`.
        blocks as [blocks_u, blocks_v]: i32,
        /// +1 or -1.
        layer_step: i32,
        /// 0: visit every layer, to test that culling changes nothing.
        culling: i32,
        /// First and last layer, of -1 ... n, that are composited here.
        layers as [first_layer, last_layer]: i32,
        /// 1: composites onto what the lattice holds, in its raw state.
        continues: i32,
        /// 1: the result stays in its raw state.
        raw: i32,
        shear as [shear_u, shear_v]: f32,
    }
}

kernel_struct! {
    /// A lattice of rays: a ray keeps its (I, J) in all layers, and crosses layer k at u = c_u(I) + (k - k_c) s_u(I),
    /// v = c_v(J) + (k - k_c) s_v(J), where c and s are affine.
    RayLatticeParams {
        size as [width, height]: i32,
        tiles as [tiles_u, tiles_v]: i32,
        /// Blocks of `visible`.
        blocks as [blocks_u, blocks_v]: i32,
        /// +1 or -1.
        layer_step: i32,
        /// 0: visit every layer, to test that culling changes nothing.
        culling: i32,
        /// k_c.
        centre_layer: f32,
        /// First and last layer, of -1 ... n, that are composited here; of point-sampled layers, slab q between layers q - radius and
        /// q - radius + 1, of 0 ... n + 2 radius - 2.
        layers as [first_layer, last_layer]: i32,
        /// 1: composites onto what the lattice holds, in its raw state.
        continues: i32,
        /// 1: the result stays in its raw state.
        raw: i32,
        /// Of columns and of rows: c of the one in the middle, the difference to that of the next, and the same of s.
        rays: [[f32; 4]; 2],
        /// Samples of column I lie so far behind their rows: first + I per_column, in 2^-32 of a row, whole rows left out.
        stagger as [first_stagger, stagger_per_column]: u32,
        /// How many voxel rows farther than their row staggered columns lie, at most: 1 or 2; 0 where they are not.
        farthest: i32,
        /// Where columns of pixels lean, rays are offset from that in the middle (`rays`) by ratios of numerators along u and v to a depth:
        /// their changes from one column to the next, and from one row to the next.
        u_steps as [u_per_column, u_per_row]: f32,
        v_steps as [v_per_column, v_per_row]: f32,
        depth_steps as [depth_per_column, depth_per_row]: f32,
        /// Factor of the offsets at k_c, and its change per layer.
        spread as [spread_at_centre, spread_per_layer]: f32,
        /// (a, b, c, d): each column of a tile begins (a + b j) / (c + d i) rows below the column before it. The column i and the row j of
        /// the tile are counted from the middle of the lattice.
        drift: [f32; 4],
        /// Rows from where the first tiles begin, without drift, to the first of the lattice.
        lead: i32,
        /// Tiles of a run, and how many runs farther the next one lies in the picture.
        runs as [tiles_per_run, next_run]: i32,
    }
}

kernel_struct! {
    /// The rays of screen pixels where each may have its own layer axis. Axes are x, y, z.
    DirectParams {
        /// A point of a ray: origin\[0\] + x origin\[1\] + y origin\[2\], in voxels.
        origin: [[f32; 4]; 3],
        direction: [[f32; 4]; 3],
        /// Blocks of `visible_*` along u and v.
        blocks: [[i32; 2]; 3],
        /// Layer axis of all rays, or -1: each ray's own.
        axis: i32,
        culling: i32,
        size as [width, height]: i32,
    }
}

kernel_struct! {
    /// The warp of a lattice to the screen.
    WarpParams {
        /// Pixel coordinates (x, y, 1) to lattice positions (I w, J w, w), row by row; sample centres at whole numbers.
        from_screen: [f32; 9],
        /// Size of the lattice.
        lattice as [width, height]: i32,
        /// Size of the frame.
        frame as [columns, rows]: i32,
        /// Sign of w in front of the eye.
        forward: f32,
        /// Samples of a tile.
        tile as [tile_columns, tile_rows]: i32,
        /// Rows by which tiles may begin before their place, where columns of pixels lean.
        tile_lead: i32,
        /// Places per pixel and axis: more than 1 where a pixel covers more than a voxel.
        filter: i32,
        /// Rows of pixels cross the lattice's lines of one u (1), or of one v (2); 0 where they run too close along both.
        lines: i32,
        /// These lines are upright: each is seen in one column of the screen.
        upright: i32,
        /// One of these lines is in the middle of each column of pixels.
        on_pixels: i32,
        /// There is a sample in the middle of each pixel, with this stagger.
        for_each_pixel: i32,
        /// There is a sample on each column of the lattice wherever the middle of a row (1) or of a column (2) of pixels crosses it.
        crossed_along: i32,
        stagger as [first_stagger, stagger_per_column]: u32,
        /// Weight of this lattice in a picture in floats.
        share: f32,
        /// 1: the picture is added to the frame, which holds other lattices.
        added: i32,
        /// The picture is the one in 8 bits, and no frame of floats.
        displayed: i32,
    }
}

kernel_struct! {
    /// The rays of screen pixels and their tiles. Axes are u, v, a of the voxels' layout.
    ScreenParams {
        /// A point of a ray: origin\[0\] + x origin\[1\] + y origin\[2\], in voxels.
        origin: [[f32; 4]; 3],
        direction: [[f32; 4]; 3],
        /// World size of a voxel step, in unit distances.
        step: [f32; 3],
        size as [width, height]: i32,
        tiles as [tiles_u, tiles_v]: i32,
    }
}

kernel_struct! {
    /// How rays are marched.
    MarchParams {
        /// Blocks of `visible`.
        blocks as [blocks_u, blocks_v]: i32,
        /// 0: visit everything, to test that culling changes nothing.
        culling: i32,
        /// Length of a step of ray casting, in unit distances.
        length: f32,
        /// Ray parameter from one slice to the next.
        slice_step: f32,
        /// Slabs between slices are no thicker than a cell: the cells of their ends tell what they can show.
        thin: i32,
        /// Value of entry 0 of the table over two values, less the offset.
        table_first: f32,
        table_per_value: f32,
        /// Entries per value.
        table_size: i32,
        /// Values can lie beyond the table.
        cut: i32,
        /// Values between which lies all opacity.
        visible as [visible_from, visible_to]: f32,
    }
}

kernel_struct! {
    /// What a slice shows.
    SliceParams {
        /// 0: values, 1: a window of grey, 2: colours of the transfer table.
        shows: i32,
        /// Value shown black, less the offset, and shades per unit of value from there to white.
        black: f32,
        per_value: f32,
        /// Thickness of the layer whose opacity colours have, in unit distances.
        thickness: f32,
    }
}

#[cfg(feature = "paper")]
kernel_struct! {
    /// The projection of splats, and the sheets that they can reach.
    SplatParams {
        /// Rows times (u, v, a, 1): pixel coordinates times w, and w.
        to_screen: [[f32; 4]; 3],
        /// The same for the depth, in voxels.
        along: [f32; 4],
        /// Pixel offsets to voxels across the view, for w = 1: (f0 dx + f1 dy, f2 dy).
        footprint: [f32; 3],
        /// Half the size of a footprint in pixels, for w = 1.
        half_size as [half_width, half_height]: f32,
        /// Splats with a smaller depth are left out.
        nearest: f32,
        /// Splats of less w are left out, too.
        least_w: f32,
        /// Sheets of less depth are left out.
        nearest_sheet: f32,
        /// Distance between sheets in voxels.
        sheet_distance: f32,
        /// The sheets that any splat can reach. Buckets count from the first.
        sheets as [first_sheet, last_sheet]: i32,
        /// Axis-aligned sheets: voxels are met in the reverse of their order.
        backwards: i32,
        /// Value around the volume, less the offset.
        background: f32,
    }
}

#[cfg(feature = "paper")]
kernel_struct! {
    /// A splat on the screen.
    Splat {
        /// Pixel coordinates.
        place as [x, y]: f32,
        /// Scale.
        w: f32,
        /// Where it begins, in sheets from the first. For axis-aligned sheets, its layer.
        reach: f32,
        /// (Value less background, gradient). For axis-aligned sheets, (r, g, b, 1) times extinction.
        content: Float4,
    }
}

impl WarpParams {
    /// Of no lattice.
    pub const NONE: Self = Self {
        from_screen: [0.0; 9],
        lattice: [0; 2],
        frame: [0; 2],
        forward: 1.0,
        tile: [1; 2],
        tile_lead: 0,
        filter: 1,
        lines: 0,
        upright: 0,
        on_pixels: 0,
        for_each_pixel: 0,
        crossed_along: 0,
        stagger: [0; 2],
        share: 1.0,
        added: 0,
        displayed: 0,
    };
}

/// The definitions of all structures in OpenCL C.
pub(in crate::device) fn typedefs() -> String {
    [
        VolumeView::typedef(),
        FieldParams::typedef(),
        ClassificationParams::typedef(),
        LightVolumeParams::typedef(),
        LabelVoxelParams::typedef(),
        LabelParams::typedef(),
        TintParams::typedef(),
        LightSweepParams::typedef(),
        ScatterGrid::typedef(),
        ScatterMediumParams::typedef(),
        ScatterCellsParams::typedef(),
        ScatterSourceParams::typedef(),
        ScatterSweepParams::typedef(),
        ScatterLayersParams::typedef(),
        LightParams::typedef(),
        SegmentParams::typedef(),
        SampleParams::typedef(),
        FieldPlacement::typedef(),
        ChannelParams::typedef(),
        ColorVoxelParams::typedef(),
        PackedColorParams::typedef(),
        ResampleParams::typedef(),
        RayEnds::typedef(),
        LayerOffset::typedef(),
        SplatLatticeParams::typedef(),
        RayLatticeParams::typedef(),
        DirectParams::typedef(),
        WarpParams::typedef(),
        ScreenParams::typedef(),
        MarchParams::typedef(),
        SliceParams::typedef(),
        SurfaceView::typedef(),
        SurfaceSet::typedef(),
        #[cfg(feature = "paper")]
        SplatParams::typedef(),
        #[cfg(feature = "paper")]
        Splat::typedef(),
    ]
    .concat()
}
