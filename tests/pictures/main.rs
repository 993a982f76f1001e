//! Pictures are right: closed forms, the device against the f64 reference, symmetries.

mod algorithms;
mod appearance;
mod background;
mod blending;
mod clipping;
mod closed_forms;
#[path = "../common/mod.rs"]
mod common;
mod depth_cue;
mod depths;
mod device_vs_reference;
mod extremes;
mod first_pictures;
mod footprints;
mod gradient_opacity;
mod gradients;
mod lights;
mod pixel_aspect;
mod pixel_rays;
mod placement;
mod refusals;
mod shadows;
mod slices;
mod surfaces;
mod symmetries;
mod terraces;
#[path = "../gl/told.rs"]
mod told;
mod voxels;
