//! The kernel files, compiled into the binary.

#[cfg(feature = "cli")]
use std::hash::{DefaultHasher, Hash, Hasher};

/// `kernel_files!("folder/file.cl"…)`: names and texts of files in kernels/.
macro_rules! kernel_files {
    ($($name:literal),* $(,)?) => {
        const FILES: &[(&str, &str)] = &[$(($name, include_str!(concat!("../../kernels/", $name)))),*];
    };
}

kernel_files!(
    "layered/beam.cl",
    "layered/channel_lattice.cl",
    "layered/channel_slabs.cl",
    "layered/channel_splat_lattice.cl",
    "layered/channel_splat_perspective.cl",
    "layered/channels.cl",
    "layered/color_lattice.cl",
    "layered/columns.cl",
    "layered/footprint.cl",
    "layered/footprint_set.cl",
    "layered/footprints.cl",
    "layered/patches.cl",
    "layered/phase_slabs.cl",
    "layered/phase_tile.cl",
    "layered/pixel_ray.cl",
    "layered/pixel_tile.cl",
    "layered/point_direct.cl",
    "layered/point_lattice.cl",
    "layered/point_layer.cl",
    "layered/point_sample.cl",
    "layered/point_samples.cl",
    "layered/point_tile.cl",
    "layered/ray_lattice.cl",
    "layered/resampled_rows.cl",
    "layered/sample_tile.cl",
    "layered/splat_direct.cl",
    "layered/splat_gradient.cl",
    "layered/splat_lattice.cl",
    "layered/splat_perspective.cl",
    "layered/splat_samples.cl",
    "layered/splat_stencil.cl",
    "layered/splat_sum.cl",
    "layered/table.cl",
    "layered/tile.cl",
    "layered/tile_rows.cl",
    "layered/visible_cells.cl",
    "layered/visible_group.cl",
    "layered/visible_layers.cl",
    "layered/visible_tile.cl",
    "layered/voxel_spans.cl",
    "light/coarse_transmittance.cl",
    "light/finish_light.cl",
    "light/light_rays.cl",
    "light/light_sweep.cl",
    "light/light_table.cl",
    "light/ray_sample.cl",
    "picture/catmull_rom.cl",
    "picture/crossed_columns.cl",
    "picture/display.cl",
    "picture/own_samples.cl",
    "picture/lines.cl",
    "picture/present.cl",
    "picture/warp.cl",
    "rays/cast_segments.cl",
    "rays/cast_values.cl",
    "rays/channel_raycast.cl",
    "rays/color_raycast.cl",
    "rays/march.cl",
    "rays/marching.cl",
    "rays/preintegrated_table.cl",
    "rays/raycast.cl",
    "rays/slabs.cl",
    "rays/slicing.cl",
    "shared/accumulator.cl",
    "shared/bit_sets.cl",
    "shared/blend_modes.cl",
    "shared/channel.cl",
    "shared/clipping.cl",
    "shared/color_absorption.cl",
    "shared/dimmed_segment.cl",
    "shared/elementary.cl",
    "shared/emission.cl",
    "shared/field.cl",
    "shared/gradient_voxels.cl",
    "shared/integral_nodes.cl",
    "shared/light_volume.cl",
    "shared/point.cl",
    "shared/preintegration.cl",
    "shared/ray_span.cl",
    "shared/reconstruction.cl",
    "shared/sample.cl",
    "shared/scalar_field.cl",
    "shared/screen.cl",
    "shared/segment.cl",
    "shared/shading.cl",
    "shared/span_lighting.cl",
    "shared/stagger.cl",
    "shared/table_entries.cl",
    "shared/tint.cl",
    "shared/value_voxels.cl",
    "shared/vector.cl",
    "shared/volume.cl",
    "shared/voxel_access.cl",
    "shared/voxel_rows.cl",
    "shared/words.cl",
    "sheets/axis_sheets.cl",
    "sheets/scan.cl",
    "sheets/sheet.cl",
    "sheets/sorted_splats.cl",
    "sheets/splat.cl",
    "sheets/splats.cl",
    "sheets/tiled_splats.cl",
    "sheets/view_sheets.cl",
    "slice/slice.cl",
    "volume/color_voxels.cl",
    "volume/label_voxels.cl",
    "volume/min_max_blocks.cl",
    "volume/opacity_range.cl",
    "volume/prefilter.cl",
    "volume/prefilter_columns.cl",
    "volume/prefilter_rows.cl",
    "volume/prepare.cl",
    "volume/resample.cl",
    "volume/shown_slabs.cl",
    "volume/slab_visibility.cl",
    "volume/transpose.cl",
    "volume/value_range.cl",
);

/// Files that are included for each type of voxels that a program reads.
const FOR_EACH_TYPE: [&str; 5] = [
    "layered/voxel_spans.cl",
    "shared/gradient_voxels.cl",
    "shared/value_voxels.cl",
    "shared/voxel_access.cl",
    "shared/voxel_rows.cl",
];

/// The text of a kernel file with each `#include "folder/file.cl"` replaced by that file, once unless it is one
/// [for each type](FOR_EACH_TYPE). `#line` directives keep line numbers in build logs correct.
pub(super) fn with_includes(file: &'static str) -> String {
    let mut text = String::new();
    append(file, &mut Vec::new(), &mut text);
    text
}

/// Hash of all kernel sources and structure definitions.
#[cfg(feature = "cli")]
pub(crate) fn hash() -> u64 {
    let mut hasher = DefaultHasher::new();
    (FILES, super::launch::structs::typedefs()).hash(&mut hasher);
    hasher.finish()
}

fn append(file: &'static str, included: &mut Vec<&'static str>, text: &mut String) {
    included.push(file);
    text.push_str(&format!("#line 1 \"{file}\"\n"));
    for (number, line) in source_text(file).lines().enumerate() {
        let Some(name) = included_file(line) else {
            text.push_str(line);
            text.push('\n');
            continue;
        };
        if !included.contains(&name) || FOR_EACH_TYPE.contains(&name) {
            append(name, included, text);
        }
        text.push_str(&format!("#line {} \"{file}\"\n", number + 2));
    }
}

fn included_file(line: &'static str) -> Option<&'static str> {
    line.strip_prefix("#include \"")?.strip_suffix('"')
}

fn source_text(file: &str) -> &'static str {
    let found = FILES.iter().find(|(name, _)| *name == file);
    found.unwrap_or_else(|| panic!("kernels/{file} is not listed in sources.rs")).1
}

/// Names of all kernel files.
pub(super) fn files() -> impl Iterator<Item = &'static str> {
    FILES.iter().map(|(name, _)| *name)
}

/// Names of all kernels in all files.
#[cfg(test)]
pub(crate) fn kernel_names() -> std::collections::BTreeSet<&'static str> {
    let all = FILES.iter().flat_map(|(_, text)| text.split("__kernel void ").skip(1));
    all.map(|rest| rest.split('(').next().unwrap()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;
    use std::path::Path;

    #[test]
    fn every_kernel_file_is_compiled_in() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("kernels");
        let mut on_disk = BTreeSet::new();
        for folder in root.read_dir().unwrap() {
            let folder = folder.unwrap();
            for file in folder.path().read_dir().unwrap() {
                let names = [folder.file_name(), file.unwrap().file_name()].map(|name| name.into_string().unwrap());
                on_disk.insert(names.join("/"));
            }
        }
        assert_eq!(on_disk, FILES.iter().map(|(name, _)| name.to_string()).collect());
    }

    #[test]
    fn files_are_included_once_and_before_their_use() {
        let text = with_includes("rays/raycast.cl");
        assert_eq!(text.matches("inline realv absorbed(").count(), 1);
        assert!(text.find("inline realv absorbed(").unwrap() < text.find("__kernel void march(").unwrap());
        assert!(!text.contains("#include"));
    }
}
