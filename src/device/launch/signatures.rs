//! Compares the declared arguments of each launcher with its kernel: `kernel!` makes a test of each.

pub(super) use super::*;
use crate::device::{DeviceChoice, sources};
pub(super) use crate::layers::Kernel;
use crate::volume::VoxelType;
use std::path::Path;

/// Voxels of one type: the tests cannot tell types of arguments apart that depend on the variant.
pub(super) const VOXELS: VoxelKind = VoxelKind { voxel_type: VoxelType::Int16, far: false, unchecked: false };
pub(super) const SEGMENTS: layered::Segments = layered::Segments { dimmed: true, whole: true };
pub(super) const LIT: Rendering = Rendering { light_volume: true, ..Rendering::EVERYTHING };
/// Gradients from voxels of their own.
pub(super) const SEPARATE: Rendering =
    Rendering { gradients: Gradients { estimate: defines::GradientEstimate::Central, voxels: Some(VOXELS) }, ..LIT };
pub(super) const DEPTHS: Rendering = Rendering { depths: true, ..LIT };
pub(super) const SURFACES: Rendering = Rendering { blend: BlendMode::Iso { refined: true }, ..LIT };
/// All that do not composite.
pub(super) const OTHER_BLENDS: [Rendering; 4] = [
    Rendering { blend: BlendMode::Maximum, ..LIT },
    Rendering { blend: BlendMode::Minimum, ..LIT },
    Rendering { blend: BlendMode::Average, ..LIT },
    SURFACES,
];

/// Compares name and type of each argument, for variants without and with the colours of labels. Also checks that the kernel of the first
/// variant returns at once without work; otherwise it would divide by zero or read out of bounds.
pub(super) fn compare<K: Launch>(plain: &[K::Variant], tinted: &[K::Variant]) {
    let device = Device::open(&DeviceChoice::Default).unwrap();
    let request = KernelRequest::new::<K>(device.tuning(), (plain[0], false), 0);
    let kernels = vec![KernelRequest { defines: with_names(&request.defines), ..request }];
    let (sender, receiver) = std::sync::mpsc::channel();
    device.build_ahead(move || Ok(kernels), move |built| sender.send(built).unwrap()).wait();
    receiver.recv().unwrap().unwrap();
    plain.iter().for_each(|&variant| compare_one::<K>(&device, (variant, false)));
    tinted.iter().for_each(|&variant| compare_one::<K>(&device, (variant, true)));
}

fn compare_one<K: Launch>(device: &Device, permutation: Permutation<K>) {
    let defines = Launcher::<K>::defines(device.tuning(), permutation);
    let kernel = device.kernel(K::FILE, K::NAME, &with_names(&defines)).unwrap();
    let declared = K::Arguments::parameters("", permutation.1).into_iter().map(|p| (p.name, p.kind.replace("VOXEL", "short")));
    let expected: Vec<_> = declared.chain([("first_item".into(), "ulong".into())]).collect();
    let actual: Vec<_> = (0..kernel.num_args().unwrap())
        .map(|i| (kernel.get_arg_name(i).unwrap(), kernel.get_arg_type_name(i).unwrap()))
        .collect();
    assert_eq!(actual, expected, "{} in {}", K::NAME, K::FILE);
}

fn with_names(defines: &str) -> String {
    format!("{defines} -cl-kernel-arg-info")
}

#[test]
fn every_kernel_has_a_launcher() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/device/launch");
    let files = [folder.join("layered"), folder].into_iter().flat_map(|folder| folder.read_dir().unwrap());
    let text: String = files.filter_map(|file| std::fs::read_to_string(file.unwrap().path()).ok()).collect();
    for name in sources::kernel_names() {
        assert!(text.contains(&format!(".cl\", {name}, \"")), "no kernel! declares {name}");
    }
}
