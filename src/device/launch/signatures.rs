//! Compares the declared arguments of each launcher with its kernel.

use super::*;
use crate::device::{DeviceChoice, sources};
use crate::layers::Kernel;
use crate::volume::VoxelType;
use opencl3::kernel::Kernel as ClKernel;
use std::collections::BTreeSet;

/// Compares name and type of each argument. Returns the name of the kernel.
fn compare<K: Launch>(device: &Device, variant: K::Variant) -> &'static str {
    let options = format!("{} -cl-kernel-arg-info", K::defines(device.tuning(), variant));
    let kernel: ClKernel = device.kernel(K::FILE, K::NAME, &options).unwrap();
    let declared = K::Arguments::signature();
    let actual: Vec<(String, String)> = (0..kernel.num_args().unwrap())
        .map(|i| (kernel.get_arg_name(i).unwrap(), kernel.get_arg_type_name(i).unwrap()))
        .collect();
    let expected: Vec<(String, String)> =
        declared.into_iter().map(|(name, kind)| (name, kind.replace("VOXEL", "short"))).collect();
    assert_eq!(actual, expected, "{} in {}", K::NAME, K::FILE);
    K::NAME
}

/// Also checks that the kernel returns at once without work; otherwise it would divide by zero or read out of bounds.
fn compare_and_idle<K: Launch>(device: &Device, variant: K::Variant) -> &'static str {
    let request = KernelRequest::new::<K>(device.tuning(), variant, 0);
    let defines = format!("{} -cl-kernel-arg-info", request.defines);
    let (sender, receiver) = std::sync::mpsc::channel();
    let kernels = vec![KernelRequest { defines, ..request }];
    device.build_ahead(move || Ok(kernels), move |built| sender.send(built).unwrap()).wait();
    receiver.recv().unwrap().unwrap();
    compare::<K>(device, variant)
}

#[test]
fn launchers_match_their_kernels() {
    let device = Device::open(&DeviceChoice::Default).unwrap();
    let d = &device;
    let kind = VoxelType::Int16;
    let voxels = VoxelKind { voxel_type: kind, far: false, unchecked: false };
    let far = VoxelKind { far: true, ..voxels };
    let segments = layered::Segments { dimmed: true, whole: true };
    let rendering = Rendering { light_volume: true, ..Rendering::EVERYTHING };
    // Voxels of one type: the test cannot tell types of arguments apart that depend on the variant.
    let central = super::Gradients { estimate: super::defines::GradientEstimate::Central, voxels: Some(voxels) };
    let separate = Rendering { gradients: central, ..rendering };
    compare::<layered::PointLattice>(d, (voxels, Kernel::BSpline, segments, separate));
    compare::<layered::PointSamples>(d, (voxels, Kernel::BSpline, segments, separate));
    compare::<layered::PointDirect>(d, (voxels, Kernel::Linear, segments, separate));
    compare::<layered::ChannelLattice>(d, (voxels, Kernel::BSpline, segments, separate, layered::Channels::new(3)));
    compare::<rays::Raycast>(d, (voxels, Kernel::Cubic, separate));
    let others = [BlendMode::Maximum, BlendMode::Minimum, BlendMode::Average, BlendMode::Iso { refined: true }];
    for blend in others {
        let rendering = Rendering { blend, ..rendering };
        compare::<layered::PointLattice>(d, (voxels, Kernel::BSpline, segments, rendering));
        compare::<layered::PointSamples>(d, (voxels, Kernel::BSpline, segments, rendering));
        compare::<layered::ChannelLattice>(d, (voxels, Kernel::BSpline, segments, rendering, layered::Channels::new(8)));
        compare::<layered::PointDirect>(d, (voxels, Kernel::Linear, segments, rendering));
        compare::<rays::CastValues>(d, (voxels, Kernel::Linear, rendering));
    }
    compare::<tinted::Tinted<layered::PointLattice>>(d, (voxels, Kernel::Cubic, segments, separate));
    compare::<tinted::Tinted<layered::PointSamples>>(d, (voxels, Kernel::Cubic, segments, separate));
    compare::<tinted::Tinted<rays::Raycast>>(d, (voxels, Kernel::Cubic, separate));
    compare::<tinted::Tinted<rays::CastSegments>>(d, (voxels, Kernel::Cubic, segments, separate));
    let iso = Rendering { blend: BlendMode::Iso { refined: true }, ..rendering };
    compare::<tinted::Tinted<layered::PointLattice>>(d, (voxels, Kernel::Cubic, segments, iso));
    compare::<tinted::Tinted<rays::CastValues>>(d, (voxels, Kernel::Cubic, iso));
    let depths = Rendering { depths: true, ..rendering };
    compare::<rays::Raycast>(d, (voxels, Kernel::Cubic, depths));
    compare::<rays::CastValues>(d, (voxels, Kernel::Cubic, Rendering { blend: BlendMode::Iso { refined: false }, ..depths }));
    compare::<rays::ChannelRaycast>(d, (voxels, Kernel::Gaussian, depths, layered::Channels::new(8)));
    compare::<rays::ColorRaycast>(d, (voxels, Kernel::Linear, depths));
    let compared = [
        compare_and_idle::<volume::Transpose>(d, voxels),
        compare_and_idle::<volume::PrefilterRows>(d, (voxels, volume::Outside::Mirrored)),
        compare_and_idle::<volume::PrefilterColumns>(d, volume::Outside::Background),
        compare_and_idle::<volume::FillMinMaxBlocks>(d, voxels),
        compare_and_idle::<volume::SlabVisibility>(d, voxels),
        compare_and_idle::<volume::ShownChunks>(d, voxels),
        compare_and_idle::<volume::ShownSlabs>(d, voxels),
        compare_and_idle::<volume::Resample>(d, (voxels, Kernel::CatmullRom)),
        compare_and_idle::<volume::ValueRange>(d, kind),
        compare_and_idle::<layered::PointLattice>(d, (voxels, Kernel::CatmullRom, segments, rendering)),
        compare_and_idle::<layered::PointSamples>(d, (voxels, Kernel::CatmullRom, segments, rendering)),
        compare_and_idle::<layered::ChannelLattice>(
            d,
            (voxels, Kernel::CatmullRom, segments, rendering, layered::Channels::new(2)),
        ),
        compare_and_idle::<layered::ChannelSplatLattice>(d, (voxels, rendering, layered::Channels::new(2))),
        compare_and_idle::<layered::ChannelSplatPerspective>(d, (voxels, rendering, layered::Channels::new(2))),
        compare_and_idle::<layered::PointDirect>(d, (voxels, Kernel::Cubic, segments, rendering)),
        compare_and_idle::<layered::SplatLattice>(d, (voxels, rendering)),
        compare_and_idle::<layered::SplatPerspective>(d, (voxels, rendering)),
        compare_and_idle::<layered::SplatSamples>(d, (voxels, rendering)),
        compare_and_idle::<layered::SplatDirect>(d, (voxels, true, rendering)),
        compare_and_idle::<layered::Footprints>(d, ()),
        compare_and_idle::<layered::FootprintSet>(d, ()),
        compare_and_idle::<layered::OpacityTable>(d, ()),
        compare_and_idle::<rays::Raycast>(d, (voxels, Kernel::Gaussian, rendering)),
        compare_and_idle::<colors::ColorLattice>(d, (voxels, Kernel::Cubic, segments, separate)),
        compare_and_idle::<rays::ColorRaycast>(d, (voxels, Kernel::Cubic, separate)),
        compare_and_idle::<colors::ColorVoxels>(d, voxels),
        compare_and_idle::<colors::LabelVoxels>(d, voxels),
        compare_and_idle::<rays::ChannelRaycast>(d, (voxels, Kernel::Cubic, separate, layered::Channels::new(2))),
        compare_and_idle::<rays::Slicing>(d, (far, rendering)),
        compare_and_idle::<rays::CastSegments>(d, (voxels, Kernel::Cubic, segments, rendering)),
        compare_and_idle::<rays::CastValues>(
            d,
            (voxels, Kernel::Cubic, Rendering { blend: BlendMode::Iso { refined: false }, ..rendering }),
        ),
        compare_and_idle::<rays::PreintegratedTable>(d, ()),
        compare_and_idle::<sheets::Splats>(d, voxels),
        compare_and_idle::<sheets::Scan>(d, ()),
        compare_and_idle::<sheets::SortedSplats>(d, true),
        compare_and_idle::<sheets::TiledSplats>(d, ()),
        compare_and_idle::<sheets::AxisSheets>(d, rendering),
        compare_and_idle::<sheets::ViewSheets>(d, (5, true, rendering)),
        compare_and_idle::<light::LightTable>(d, ()),
        compare_and_idle::<light::LightSweep>(d, (voxels, false, rendering, layered::Channels::new(2))),
        compare_and_idle::<light::LightRays>(d, (voxels, false, rendering, layered::Channels::new(1))),
        compare_and_idle::<light::FinishLight>(d, ()),
        compare_and_idle::<light::CoarseTransmittance>(d, (voxels, rendering, 2, layered::Channels::new(8))),
        compare_and_idle::<slice::Slice>(d, (voxels, Kernel::CatmullRom)),
        compare_and_idle::<picture::Warp>(d, ()),
        compare_and_idle::<picture::Present>(d, ()),
    ];
    assert_eq!(BTreeSet::from(compared), sources::kernel_names(), "every kernel is compared");
}
