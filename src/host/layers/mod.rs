//! Mathematics of layered volume splatting, in voxel units and `f64`. This module does not use OpenCL.
//!
//! *Voxel units*: voxel (i, j, k) lies at (i, j, k). The **layer axis** a is the axis most parallel to the view; u and v are the other two
//! (see [`AxisFrame`]). A ray crosses layer k at (u, v). Its **shear** (s_u, s_v) = (d_u/d_a, d_v/d_a) is its offset per layer.

mod axis;
mod footprint;
mod footprint_set;
mod gaussian;
mod gradient;
mod kernel;
mod kernel_function;
mod lattice;
mod light_rays;
mod ordinates;
mod prefilter;
mod quadrature;
mod rays;
mod segment;
#[cfg(feature = "paper")]
mod splats;
mod sub_slabs;

pub use axis::{Axis, AxisFrame};
pub use footprint::footprint;
pub use footprint_set::{FOOTPRINT_SET_LEN, FOOTPRINT_SET_SIZE, nearest_in_set, set_direction};
pub use gaussian::{
    GAUSSIAN_OVERSHOOT, GAUSSIAN_RADIUS, gaussian, gaussian_footprint, gaussian_footprint_factor, gaussian_integral,
};
pub use gradient::GradientEstimator;
#[doc(hidden)]
pub use gradient::smoothing;
pub use kernel::Kernel;
pub use kernel_function::{kernel_function, kernel_integral};
pub use lattice::{
    AffineRays, Density, Lattice, LayerOffset, Lines, MAX_LATTICE_SHEAR, MAX_SAMPLES_PER_VOXEL, Phases, PixelRays, Sampling,
    ScreenAxis, Stagger,
};
pub use light_rays::{LightRays, disc_directions, sky_directions};
pub use ordinates::{OrdinatePair, entering, sphere};
pub use prefilter::{PREFILTER_RADIUS, prefilter};
pub use quadrature::{GaussNode, quadrature_nodes};
pub use rays::{Ray, Rays};
pub use segment::{lighting_curve, segment_ends};
#[cfg(feature = "paper")]
pub use splats::{SplatProjection, SplatSlabs};
pub use sub_slabs::{Correction, LayerSlabs, SubSlab};
