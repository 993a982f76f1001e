//! OpenCL objects of the caller are retained while they are used, and released afterwards.

use crate::host::{Host, OUT_OF_ORDER, SIZE, hosts, renderer, scene};
use layersplat::device::DeviceMemory;
use layersplat::renderer::{DeviceVoxels, PictureFormat, PictureMemory, UploadedVolume};
use layersplat::volume::VoxelType;
use layersplat::{Device, Renderer, Settings};
use opencl3::memory::{CL_FLOAT, CL_MEM_OBJECT_IMAGE2D, CL_RGBA, CL_UNORM_INT16, cl_image_desc, cl_image_format};
use opencl3::memory::{CL_MEM_READ_ONLY, CL_MEM_READ_WRITE, CL_MEM_WRITE_ONLY, ClMem, Image};
use std::time::Duration;

/// Reference counts of a context and of a queue.
fn references(host: &Host) -> [u32; 2] {
    [host.context.reference_count().unwrap(), host.queue.reference_count().unwrap()]
}

/// Whether reference counts are those of before. PoCL keeps events of a queue for reuse, which count as one reference in total.
fn are_restored([context, queue]: [u32; 2], before: [u32; 2]) -> bool {
    context == before[0] && queue <= before[1] + 1
}

/// Reference counts as soon as they are restored, or at the latest after a few seconds. PoCL's threads release a command shortly
/// after they report it as complete.
fn settled_references(host: &Host, before: [u32; 2]) -> [u32; 2] {
    for _ in 0..500 {
        host.queue.finish().unwrap();
        if are_restored(references(host), before) {
            break;
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    references(host)
}

#[test]
fn reference_counts_are_as_before_when_all_is_dropped() {
    for host in hosts() {
        let (volume, transfer, camera) = scene();
        let voxels = host.filled(&vec![7u8; 21 * 18 * 24]);
        let picture = host.room::<f32>(4 * SIZE.pixels());
        let before = references(&host);
        let of_memory = || [voxels.reference_count().unwrap(), picture.reference_count().unwrap()];
        let memory_before = of_memory();
        let mut after = Vec::new();
        for _ in 0..3 {
            let device = host.device();
            assert!(references(&host).iter().zip(before).all(|(now, before)| *now > before), "objects in use must be retained");
            renderer(&device, &volume, &transfer).render(&camera, SIZE, &Settings::default()).unwrap();
            let memory = DeviceMemory::from_buffer(&voxels).unwrap();
            let placed = DeviceVoxels::new(&memory, VoxelType::Uint8);
            let description = placed.describe(&device, "foreign", volume.grid().clone(), &[]).unwrap();
            let foreign = UploadedVolume::in_place(&device, &description, &placed).unwrap();
            let mut renderer = Renderer::from_uploaded(&foreign, &transfer).unwrap();
            let onto = PictureMemory::new(&DeviceMemory::from_buffer(&picture).unwrap(), PictureFormat::Floats);
            let event = renderer.enqueue(&camera, SIZE, &Settings::default(), &onto, &[]).unwrap();
            assert!(of_memory().iter().zip(memory_before).all(|(now, before)| *now > before));
            event.wait().unwrap();
            drop((device, renderer, foreign, memory, placed, onto, event));
            after.push(settled_references(&host, before));
            assert_eq!(of_memory(), memory_before);
        }
        assert!(after.iter().all(|&counts| are_restored(counts, before)), "{before:?}, {after:?}");
    }
}

/// The renderer remains usable after its creator has dropped all handles.
#[test]
fn what_was_handed_over_lives_as_long_as_it_is_used() {
    let (volume, transfer, camera) = scene();
    let expected = crate::common::render(&volume, &transfer, &camera, SIZE, &Settings::default());
    let mut renderer = {
        let host = Host::new(0);
        renderer(&host.device(), &volume, &transfer)
    };
    assert!(renderer.render(&camera, SIZE, &Settings::default()).unwrap().0 == expected);
}

#[test]
fn raw_handles_must_belong_together() {
    let (host, other) = (Host::new(0), Host::new(0));
    let device = host.device();
    let of = |context, device, queue| {
        // SAFETY: all handles are valid.
        unsafe { Device::from_handles(context, device, queue) }.map(|_| ()).map_err(|e| e.to_string())
    };
    assert_eq!(of(host.context.get(), device.id(), host.queue.get()), Ok(()));
    assert!(of(other.context.get(), device.id(), host.queue.get()).unwrap_err().contains("another context"));
    assert!(of(host.context.get(), std::ptr::null_mut(), host.queue.get()).unwrap_err().contains("another device"));
    assert!(of(host.context.get(), device.id(), std::ptr::null_mut()).unwrap_err().contains("the caller's queue"));
    assert!(device.with_queue(&other.queue).is_err());
    let second = host.another_queue(OUT_OF_ORDER);
    assert_eq!(device.with_queue(&second).unwrap().queue(), second.get());
}

#[test]
fn memory_that_cannot_be_used_is_refused_with_the_reason() {
    let (host, other) = (Host::new(0), Host::new(0));
    let device = host.device();
    let (volume, transfer, camera) = scene();
    let mut renderer = renderer(&device, &volume, &transfer);
    let bytes = 16 * SIZE.pixels();
    let buffer = |host: &Host, flags| {
        // SAFETY: no host pointer is passed.
        unsafe { opencl3::memory::Buffer::<u8>::create(&host.context, flags, bytes, std::ptr::null_mut()) }.unwrap()
    };
    let mut refused = |onto: &PictureMemory| {
        renderer.enqueue(&camera, SIZE, &Settings::default(), onto, &[]).map(|_| ()).unwrap_err().to_string()
    };
    let of = |buffer| PictureMemory::new(&DeviceMemory::from_buffer(buffer).unwrap(), PictureFormat::Floats);
    let (foreign, read_only) = (buffer(&other, CL_MEM_READ_WRITE), buffer(&host, CL_MEM_READ_ONLY));
    let own = buffer(&host, CL_MEM_READ_WRITE);
    assert!(refused(&of(&foreign)).contains("another context"));
    assert!(refused(&of(&read_only)).contains("READ_ONLY"));
    assert!(refused(&of(&own).with_first(16)).contains(&format!("ends at byte {}", bytes + 16)));
    assert!(refused(&of(&own).with_row_pitch(16)).contains("rows 16 bytes apart"));
    let format = cl_image_format { image_channel_order: CL_RGBA, image_channel_data_type: CL_FLOAT };
    let small = image(&host, format, 8, 8);
    let onto = |format| PictureMemory::new(&DeviceMemory::from_image(&small).unwrap(), format);
    assert!(refused(&onto(PictureFormat::Floats)).contains("8x8"));
    assert!(refused(&onto(PictureFormat::Rgba8(layersplat::Background::Transparent))).contains("Floats"));
    let odd = image(&host, cl_image_format { image_channel_data_type: CL_UNORM_INT16, ..format }, 8, 8);
    assert!(DeviceMemory::from_image(&odd).unwrap_err().to_string().contains("CL_UNORM_INT8"));

    let write_only = DeviceMemory::from_buffer(&buffer(&host, CL_MEM_WRITE_ONLY)).unwrap();
    let own = DeviceMemory::from_buffer(&own).unwrap();
    let describe = |voxels: DeviceVoxels| voxels.describe(&device, "v", volume.grid().clone(), &[]).unwrap_err().to_string();
    assert!(describe(DeviceVoxels::new(&write_only, VoxelType::Uint8)).contains("WRITE_ONLY"));
    assert!(describe(DeviceVoxels::new(&own, VoxelType::Float32)).contains("end at"));
    assert!(describe(DeviceVoxels::new(&own, VoxelType::Uint16).with_first(3)).contains("multiples of the voxel size 2"));
    assert!(describe(DeviceVoxels::new(&own, VoxelType::Uint8).with_pitches(20, 400)).contains("overlap"));
    assert!(describe(DeviceVoxels::new(&own, VoxelType::Uint8).with_pitches(21, 300)).contains("overlap"));
    assert!(describe(DeviceVoxels::new(&own, VoxelType::Uint8).with_pitches(1 << 40, 1 << 60)).contains("end at"));
}

/// An image of the host.
pub fn image(host: &Host, format: cl_image_format, width: usize, height: usize) -> Image {
    let description = cl_image_desc {
        image_type: CL_MEM_OBJECT_IMAGE2D,
        image_width: width,
        image_height: height,
        image_depth: 1,
        image_array_size: 1,
        image_row_pitch: 0,
        image_slice_pitch: 0,
        num_mip_levels: 0,
        num_samples: 0,
        buffer: std::ptr::null_mut(),
    };
    // SAFETY: no host pointer is passed.
    unsafe { Image::create(&host.context, CL_MEM_READ_WRITE, &format, &description, std::ptr::null_mut()) }.unwrap()
}
