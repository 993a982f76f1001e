//! Compares the declared arguments of launchers with their kernels, in builds with debug assertions.

use super::{Argument, Extras, Launch};
use opencl3::kernel::Kernel;

/// Compares name and type of each argument.
///
/// # Panics
/// If they differ: setting the arguments would write other types than the kernel reads.
pub(super) fn compare<K: Launch>(kernel: &Kernel, extras: Extras, defines: &str) {
    let declared = K::Arguments::parameters("", extras).into_iter().map(|parameter| {
        let kind = parameter.kind.replace("VOXEL", voxel_type(&parameter.name, defines));
        (parameter.name, kind)
    });
    let expected: Vec<_> = declared.chain([("first_item".into(), "ulong".into())]).collect();
    let argument =
        |index| Ok::<_, opencl3::error_codes::ClError>((kernel.get_arg_name(index)?, kernel.get_arg_type_name(index)?));
    // Some drivers do not keep what was declared.
    if let Ok(actual) = (0..kernel.num_args().unwrap_or(0)).map(argument).collect::<Result<Vec<_>, _>>() {
        assert_eq!(actual, expected, "{} in {}, {defines}", K::NAME, K::FILE);
    }
}

/// Type of the voxels of an argument: gradients may be estimated from others.
fn voxel_type<'a>(argument: &str, defines: &'a str) -> &'a str {
    let of = |name: &str| defines.split(' ').find_map(|define| define.strip_prefix(name));
    let own = if argument.starts_with("gradient") { of("-DGRADIENT_VOXEL=") } else { None };
    own.or_else(|| of("-DVOXEL=")).unwrap_or("VOXEL")
}

#[cfg(test)]
mod tests {
    use crate::device::sources;
    use crate::{
        Camera, Device, DeviceChoice, OpenOptions, Orbit, Projection, Renderer, Settings, TransferFunction, Viewport, Volume,
    };
    use std::path::Path;

    #[test]
    fn every_kernel_has_a_launcher() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/device/launch");
        let files = [folder.join("layered"), folder].into_iter().flat_map(|folder| folder.read_dir().unwrap());
        let text: String = files.filter_map(|file| std::fs::read_to_string(file.unwrap().path()).ok()).collect();
        for name in sources::kernel_names() {
            assert!(text.contains(&format!(".cl\", {name}, \"")), "no kernel! declares {name}");
        }
    }

    #[test]
    #[should_panic(expected = "(\"first_item\", \"long\")")]
    fn a_launcher_with_other_arguments_is_found() {
        let device = Device::open(&DeviceChoice::Default).unwrap();
        device.edit_sources(|text| text.replace("ulong first_item", "long first_item"));
        let volume = Volume::open("builtin:cube@4", &OpenOptions::default()).unwrap();
        let mut renderer = Renderer::new(&device, &volume, &TransferFunction::automatic(&volume)).unwrap();
        let camera = Camera::orbit(volume.grid().centre(), 1.0, Orbit::default(), Projection::Parallel { scale: 4.0 });
        let _ = renderer.render(&camera, Viewport::new(4, 4).unwrap(), &Settings::default());
    }
}
