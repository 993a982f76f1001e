//! Scenes of the device check.

use super::Family;
use crate::camera::{Camera, Orbit, Projection};
use crate::layers::{Correction, Density, Kernel};
use crate::settings::{
    Algorithm, Blend, Classification, Evaluation, Footprints, Layered, Light, Lights, Look, Settings, Shading, Shadows,
};
use crate::surface::{Ends, Per, Spheres, Surface, Triangles, Tubes};
use crate::transfer::TransferFunction;
use crate::viewport::Viewport;
use crate::volume::{Grid, Volume, Voxels};
use glam::DVec3;

/// Size of all pictures.
pub(super) const SIZE: Viewport = Viewport { width: 28, height: 22 };
/// Number of pictures per family.
pub(super) const VIEWS: usize = 2;
/// Odd and even, all different: 1848 voxels.
const DIMS: [usize; 3] = [14, 11, 12];
/// Half the height of parallel views: two pixels per voxel.
const HALF_HEIGHT: f64 = 5.5;
/// An iso-value half-way up both bumps.
const ISO: f64 = 60.0;

/// Settings and camera of a picture, and its surfaces.
pub(super) struct Picture {
    pub settings: Settings,
    pub camera: Camera,
    pub surfaces: Vec<Surface>,
}

/// Two smooth bumps in empty space, without symmetry and without edges, so that no pixel depends on rounding at an edge.
pub(super) fn volume() -> Volume<'static> {
    let bump = |p: DVec3, centre: DVec3, radius: f64| (1.0 - (p - centre).length_squared() / (radius * radius)).max(0.0).powi(2);
    let [x, y, z] = DIMS;
    let value = |n: usize| {
        let place = [n % x, n / x % y, n / x / y];
        let p = DVec3::from_array(std::array::from_fn(|a| (2 * place[a]) as f64 / (DIMS[a] - 1) as f64 - 1.0));
        let first = bump(p, DVec3::new(-0.15, 0.1, -0.1), 0.9);
        let second = bump(p, DVec3::new(0.45, -0.3, 0.35), 0.6);
        (100.0 * first + 90.0 * second).round() as u8
    };
    let grid = Grid::new(DIMS, DVec3::new(1.0, 0.9, 1.2)).expect("the grid is valid");
    let volume = Volume::new("the check's volume", grid, Voxels::Uint8((0..x * y * z).map(value).collect()));
    volume.and_then(|volume| volume.with_background(0.0)).expect("the volume is valid")
}

/// Different colours for small and large values, a transparent background, no steps.
pub(super) fn transfer() -> TransferFunction {
    let colors = vec![(0.0, [0.1, 0.2, 0.9]), (50.0, [0.2, 0.9, 0.3]), (127.0, [1.0, 0.6, 0.1])];
    let opacities = vec![(0.0, 0.0), (10.0, 0.0), (127.0, 0.4)];
    TransferFunction::new("the check's colours", colors, opacities).expect("the transfer function is valid")
}

/// The two views of a family. The first looks along z, the second along x, with transposed voxels.
pub(super) fn views(family: Family) -> [Picture; VIEWS] {
    let [along_z, along_x] = [view(25.0, 15.0, ROLL), view(105.0, -20.0, ROLL)];
    let lit = settings(family);
    let unlit = Settings { shading: None, ..lit };
    let picture = |settings, camera| Picture { settings, camera, surfaces: Vec::new() };
    match family {
        Family::SplatPerspective => [picture(lit, perspective(along_z, 30.0)), picture(lit, perspective(along_x, 40.0))],
        // From inside the volume, where no lattice covers the view.
        Family::CastSegments => [picture(lit, inside(along_z)), picture(unlit, inside(along_x))],
        // For views along an axis, the nearest footprint of the set is exact.
        Family::FootprintSet => [picture(lit, view(0.0, 0.0, ROLL)), picture(lit, view(90.0, 0.0, ROLL))],
        // Separate programs exist for these unlit, or splatted in a perspective; keep to the lit parallel ones.
        Family::ViewSheets | Family::AxisSheets | Family::SplatLattice => [picture(lit, along_z), picture(lit, along_x)],
        // A light that takes several sweeps, and one that takes one.
        Family::Light => [picture(lit, along_z), picture(with_light(unlit, 0.0), perspective(along_x, 30.0))],
        Family::Studio => [picture(lit, along_z), picture(lit, perspective(along_x, 30.0))],
        // Lattices whose samples are the pixels.
        Family::Surfaces => [view(25.0, 15.0, 0.0), view(105.0, -20.0, 0.0)]
            .map(|camera| Picture { surfaces: surfaces(&camera), ..picture(lit, camera) }),
        // A lattice aligned with pixels, and an interpolated one.
        Family::PointLattice => [picture(lit, view(25.0, 15.0, 0.0)), picture(unlit, perspective(along_x, 30.0))],
        _ => [picture(lit, along_z), picture(unlit, perspective(along_x, 30.0))],
    }
}

/// Settings of a family, with shading.
fn settings(family: Family) -> Settings {
    let points = |kernel, samples_per_layer| Layered {
        classification: Classification::Preintegrated { kernel, samples_per_layer },
        evaluation: Evaluation::Lattice(Density::Relaxed),
        ..Layered::default()
    };
    let splats = |evaluation, footprints| Layered {
        classification: Classification::Post(Correction::SubLayers(2)),
        evaluation,
        footprints,
        ..Layered::default()
    };
    let (algorithm, blend): (Algorithm, Blend) = match family {
        Family::PointLattice | Family::Light | Family::Studio => (points(Kernel::Cubic, 1).into(), Blend::Composite),
        // 8 samples per layer, in steps of 1/32 if rays are cast, like the reference integral.
        Family::CastSegments | Family::Surfaces => (points(Kernel::Cubic, 8).into(), Blend::Composite),
        Family::Spline => (points(Kernel::BSpline, 2).into(), Blend::Composite),
        Family::PointValues => (points(Kernel::Cubic, 1).into(), Blend::Maximum),
        Family::PointSurface => (points(Kernel::Cubic, 1).into(), Blend::Iso(ISO)),
        Family::PointPixels => (Layered { evaluation: Evaluation::Direct, ..points(Kernel::Cubic, 1) }.into(), Blend::Composite),
        Family::SplatLattice | Family::SplatPerspective => {
            (splats(Evaluation::Lattice(Density::Relaxed), Footprints::Exact).into(), Blend::Composite)
        }
        Family::SplatPixels => (splats(Evaluation::Direct, Footprints::Exact).into(), Blend::Composite),
        Family::FootprintSet => (splats(Evaluation::Direct, Footprints::Set).into(), Blend::Composite),
        Family::Raycast => (Algorithm::Raycast { kernel: Kernel::Linear, step: 0.5 }, Blend::Composite),
        Family::CastValues => (Algorithm::Raycast { kernel: Kernel::Linear, step: 0.5 }, Blend::Maximum),
        Family::CastSurface => (Algorithm::Raycast { kernel: Kernel::Linear, step: 0.5 }, Blend::Iso(ISO)),
        Family::Slicing => (Algorithm::Slicing { step: 1.0 }, Blend::Composite),
        Family::AxisSheets => (Algorithm::AxisSheets { layer_axis: Default::default() }, Blend::Composite),
        Family::ViewSheets => (Algorithm::ViewSheets { sheet_distance: 1.0 }, Blend::Composite),
    };
    let lit = Settings { algorithm, blend, shading: Some(Shading::default()), early_termination: false, ..Settings::default() };
    match family {
        Family::Light => with_light(lit, 8.0),
        Family::Studio => in_studio(lit),
        _ => lit,
    }
}

/// Surfaces through the volume of such a view: translucent triangles, a sphere before an opaque tube. They cover the whole picture, so that no pixel
/// depends on rounding at an edge.
fn surfaces(camera: &Camera) -> Vec<Surface> {
    let basis = camera.basis().expect("the camera is valid");
    let place =
        |right: f64, up: f64, behind: f64| camera.focal_point + right * basis.right + up * basis.up + behind * basis.forward;
    let corners = vec![place(-30.0, -30.0, -8.0), place(30.0, -30.0, 6.0), place(30.0, 30.0, 5.0), place(-30.0, 30.0, -9.0)];
    let triangles = Triangles::new(corners, vec![[0, 1, 2], [0, 2, 3]]).expect("the triangles are valid");
    let colors = vec![[0.9, 0.3, 0.1, 0.4], [0.1, 0.9, 0.3, 0.6], [0.2, 0.3, 0.9, 0.4], [0.9, 0.9, 0.2, 0.2]];
    let triangles = Surface::new("triangles", triangles).with_colors(Per::Point(colors)).expect("each point has a colour");
    let sphere = Spheres::new(vec![place(0.0, 0.0, 10.0)], vec![11.0]).expect("the sphere is valid");
    let tube = vec![place(-40.0, 0.0, 13.0), place(40.0, 3.0, 13.0)];
    let tube = Tubes::new(tube, vec![11.0; 2], &[2], Ends::Open).expect("the tube is valid");
    let (mut sphere, mut tube) = (Surface::new("sphere", sphere), Surface::new("tube", tube));
    (sphere.color, sphere.opacity, tube.color) = ([0.2, 0.7, 0.9], 0.3, [0.8, 0.6, 0.5]);
    vec![triangles, sphere, tube]
}

/// The studio with a sky and lights of the world.
fn in_studio(settings: Settings) -> Settings {
    let settings = settings.with_look(Look::Studio).with_light_in_world(&view(25.0, 15.0, 0.0));
    settings.expect("the camera is valid")
}

/// Adds the shadow of a light of this angular diameter in degrees. Light volumes interpolate between few voxels here: at full strength one
/// pixel is off by 2.5 steps of 255, and the check allows 2.
fn with_light(settings: Settings, angle: f64) -> Settings {
    let light = Light { angle, ..Light::towards(DVec3::new(-0.8, 1.0, 0.7)) };
    let shading = Shading { lights: Lights::new(&[light]).expect("the light is valid"), ..Shading::default() };
    Settings { shading: Some(shading), shadows: Some(Shadows { strength: 0.3, forgiveness: 1.0 }), ..settings }
}

/// Roll of most views: no lattice axis is aligned with pixels.
const ROLL: f64 = 10.0;

/// A parallel view of the whole volume.
fn view(azimuth: f64, elevation: f64, roll: f64) -> Camera {
    let orbit = Orbit { azimuth, elevation, roll };
    let centre = volume().grid().centre();
    Camera::orbit(centre, 4.0 * HALF_HEIGHT, orbit, Projection::Parallel { scale: HALF_HEIGHT })
}

/// Changes a view to a perspective with a vertical field of view in degrees.
fn perspective(camera: Camera, field_of_view: f64) -> Camera {
    let distance = HALF_HEIGHT / (field_of_view / 2.0).to_radians().tan();
    let to_eye = (camera.position - camera.focal_point).normalize();
    Camera { position: camera.focal_point + to_eye * distance, projection: Projection::Perspective { field_of_view }, ..camera }
}

/// Moves a view inside the volume.
fn inside(camera: Camera) -> Camera {
    let to_eye = (camera.position - camera.focal_point).normalize();
    Camera {
        position: camera.focal_point + to_eye * (0.8 * HALF_HEIGHT),
        projection: Projection::Perspective { field_of_view: 100.0 },
        ..camera
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layers::{Axis, Rays};
    use crate::renderer::Plan;

    #[test]
    fn every_picture_is_drawn_by_its_family() {
        let volume = volume();
        for family in Family::ALL {
            for (n, Picture { settings, camera, surfaces }) in views(family).into_iter().enumerate() {
                let rays = Rays::new(&camera, SIZE, volume.grid()).unwrap();
                let plan = Plan::new(&rays, SIZE, volume.grid(), &settings).unwrap();
                let has_surfaces = family == Family::Surfaces;
                let plan = if has_surfaces { plan.with_surfaces(&rays, SIZE, volume.grid(), &settings).unwrap() } else { plan };
                let drawing = if has_surfaces { Family::PointLattice } else { family };
                assert_eq!(Family::from_plan(&plan, &settings, rays.is_parallel()), drawing, "{n}: {plan}");
                assert_eq!(surfaces.is_empty(), !has_surfaces, "{family}");
                if let (Family::PointLattice, Plan::Lattice(lattice, _)) = (family, &plan) {
                    assert_eq!(lattice.has_pixels_samples() && lattice.stagger.per_column != 0, n == 0);
                }
                let axis = Axis::most_parallel(rays.central_direction());
                assert_eq!(axis, [Axis::Z, Axis::X][n], "{family} {n}");
            }
        }
    }
}
