//! Every launcher's arguments against those of its kernel.

use super::*;
use crate::device::{DeviceChoice, sources};
use crate::layers::Kernel;
use crate::volume::VoxelType;
use opencl3::kernel::Kernel as ClKernel;
use std::collections::BTreeSet;

/// Compares a launcher with its kernel, by name and type of each argument.
fn compare<K: Launch>(device: &Device, variant: K::Variant) -> &'static str {
    let options = format!("{} -cl-kernel-arg-info", K::defines(device.tuning(), variant));
    let kernel: ClKernel = device.kernel(K::FILE, K::NAME, &options).unwrap();
    let declared = K::Arguments::signature();
    let of_kernel: Vec<(String, String)> = (0..kernel.num_args().unwrap())
        .map(|i| (kernel.get_arg_name(i).unwrap(), kernel.get_arg_type_name(i).unwrap()))
        .collect();
    let expected: Vec<(String, String)> =
        declared.iter().map(|(name, of)| (name.to_string(), of.replace("VOXEL", "short"))).collect();
    assert_eq!(of_kernel, expected, "{} in {}", K::NAME, K::FILE);
    K::NAME
}

#[test]
fn launchers_are_their_kernels_signatures() {
    let device = Device::open(&DeviceChoice::Default).unwrap();
    let d = &device;
    let kind = VoxelType::Int16;
    let voxels = VoxelKind { voxel_type: kind, far: false, unchecked: false };
    let far = VoxelKind { far: true, ..voxels };
    let segments = layered::Segments { cut: true, curved: true, dimmed: true, whole: true };
    let rendering = Rendering::EVERYTHING;
    let others = [BlendMode::Maximum, BlendMode::Minimum, BlendMode::Average, BlendMode::Iso { refined: true }];
    for blend in others {
        let rendering = Rendering { blend, ..rendering };
        compare::<layered::PointLattice>(d, (voxels, Kernel::BSpline, segments, rendering));
        compare::<layered::PointSamples>(d, (voxels, Kernel::BSpline, segments, rendering));
        compare::<layered::PointDirect>(d, (voxels, Kernel::Linear, segments, rendering));
        compare::<rays::CastValues>(d, (voxels, Kernel::Linear, rendering));
    }
    let depths = Rendering { depths: true, ..rendering };
    compare::<rays::Raycast>(d, (voxels, Kernel::Cubic, depths));
    compare::<rays::CastValues>(d, (voxels, Kernel::Cubic, Rendering { blend: BlendMode::Iso { refined: false }, ..depths }));
    let compared = [
        compare::<volume::Transpose>(d, voxels),
        compare::<volume::PrefilterRows>(d, voxels),
        compare::<volume::PrefilterColumns>(d, ()),
        compare::<volume::FillMinMaxBlocks>(d, voxels),
        compare::<volume::SlabVisibility>(d, voxels),
        compare::<volume::ShownChunks>(d, voxels),
        compare::<volume::ShownSlabs>(d, voxels),
        compare::<volume::ValueRange>(d, kind),
        compare::<layered::PointLattice>(d, (voxels, Kernel::CatmullRom, segments, rendering)),
        compare::<layered::PointSamples>(d, (voxels, Kernel::CatmullRom, segments, rendering)),
        compare::<layered::PointDirect>(d, (voxels, Kernel::Cubic, segments, rendering)),
        compare::<layered::SplatLattice>(d, (voxels, rendering)),
        compare::<layered::SplatPerspective>(d, (voxels, rendering)),
        compare::<layered::SplatSamples>(d, (voxels, rendering)),
        compare::<layered::SplatDirect>(d, (voxels, true, rendering)),
        compare::<layered::Footprints>(d, ()),
        compare::<layered::FootprintSet>(d, ()),
        compare::<layered::OpacityTable>(d, ()),
        compare::<rays::Raycast>(d, (voxels, Kernel::Gaussian, rendering)),
        compare::<rays::Slicing>(d, (far, true, rendering)),
        compare::<rays::CastSegments>(d, (voxels, Kernel::Cubic, segments, rendering)),
        compare::<rays::CastValues>(
            d,
            (voxels, Kernel::Cubic, Rendering { blend: BlendMode::Iso { refined: false }, ..rendering }),
        ),
        compare::<rays::PreintegratedTable>(d, ()),
        compare::<sheets::Splats>(d, voxels),
        compare::<sheets::Scan>(d, ()),
        compare::<sheets::SortedSplats>(d, true),
        compare::<sheets::TiledSplats>(d, ()),
        compare::<sheets::AxisSheets>(d, rendering),
        compare::<sheets::ViewSheets>(d, (5, true, rendering)),
        compare::<picture::Warp>(d, ()),
        compare::<picture::Present>(d, ()),
    ];
    assert_eq!(BTreeSet::from(compared), sources::kernel_names(), "every kernel is compared");
}
