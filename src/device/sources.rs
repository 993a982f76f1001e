//! The kernel files, compiled into the binary.

#[cfg(feature = "cli")]
use std::hash::{DefaultHasher, Hash, Hasher};

/// Names and texts of all files in kernels/ (build.rs).
const FILES: &[(&str, &str)] = include!(concat!(env!("OUT_DIR"), "/kernel_files.rs"));

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
    found.unwrap_or_else(|| panic!("there is no kernels/{file}")).1
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

    #[test]
    fn files_are_included_once_and_before_their_use() {
        let text = with_includes("rays/raycast.cl");
        assert_eq!(text.matches("inline realv absorbed(").count(), 1);
        assert!(text.find("inline realv absorbed(").unwrap() < text.find("__kernel void march(").unwrap());
        assert!(!text.contains("#include"));
    }
}
