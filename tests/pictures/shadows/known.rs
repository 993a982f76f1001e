//! Shadows that are known: of planes and of a sphere, and turns, which must be even.

use super::*;
use layersplat::layers::Rays;

/// Difference of closed forms of planes: their layers are a voxel apart, and light is stored in steps of 1/255.
const PLANE: f64 = 0.03;

/// In front of an opaque plane, seen at the cosine mu from its normal and lit at mu0, the mean light is 1 - F^(-mu0/mu) mu / (mu0 + mu),
/// whatever the extinction (light.md, "The brightness of matter that shadows itself").
#[test]
fn opaque_planes_have_the_light_of_the_closed_form() {
    // Homogeneous, so that there is no gradient: colours are the light alone.
    let dims = [48, 48, 60];
    let volume = Volume::new("block", Grid::new(dims, DVec3::ONE).unwrap(), Voxels::Uint8(vec![200; 48 * 48 * 60])).unwrap();
    let transfer = TransferFunction::new("fog", vec![(0.0, [1.0; 3])], vec![(150.0, 0.0), (190.0, 0.12)]).unwrap();
    let size = viewport(31, 31);
    let camera = scaled(parallel(&volume, size, 0.0, 0.0), 4.0);
    for (to_light, forgiveness) in
        [1.0, 2.0, 4.0, 8.0, 16.0].map(|f| (DVec3::new(0.2, 0.3, 1.0), f)).into_iter().chain([(DVec3::new(0.9, 0.3, 1.0), 4.0)])
    {
        let shading = Shading { ambient: 0.0, diffuse: 1.0, specular: 0.0, lights: one_light(to_light), ..Shading::default() };
        let shadows = Some(Shadows { forgiveness, ..EXACT });
        let settings = Settings { shading: Some(shading), shadows, ..Settings::default() };
        let [r, .., a] = render(&volume, &transfer, &camera, size, &settings).pixels()[15 * 31 + 15].map(f64::from);
        let mu0 = to_light.normalize().z;
        let expected = 1.0 - forgiveness.powf(-mu0) / (mu0 + 1.0);
        assert!((r / a - expected).abs() < PLANE, "F = {forgiveness}: {}, not {expected}", r / a);
    }
    // The sky over the plane: the mean of its transmittance, (1 - mu ln(1 + 1/mu)) / 2, by 14 directions.
    let shading = Shading { ambient: 1.0, diffuse: 0.0, specular: 0.0, ..Shading::default() };
    let occlusion = Some(AmbientOcclusion { gain: 1.0, reach: None });
    let settings = Settings { shading: Some(shading), ambient_occlusion: occlusion, ..Settings::default() };
    let [r, .., a] = render(&volume, &transfer, &camera, size, &settings).pixels()[15 * 31 + 15].map(f64::from);
    let expected = 0.5 * (1.0 - 2f64.ln());
    assert!((r / a - expected).abs() < PLANE, "sky: {}, not {expected}", r / a);
}

/// On a plane that is tilted against the layers, contour rings would show: the spread of the light over it (0.9 % in truth).
#[test]
fn tilted_planes_have_no_rings() {
    /// Measured: 1.1 %. Without pre-integrated segments along the rays: 4.0 %.
    const MOST: f64 = 0.015;
    let normal = DVec3::new(0.09, 0.05, 1.0).normalize();
    let distance = |p: DVec3| (p - DVec3::splat(47.5)).dot(normal);
    let place = |n: usize| DVec3::new((n % 96) as f64, (n / 96 % 96) as f64, (n / 9216) as f64);
    let voxels = (0..96usize.pow(3)).map(|n| (128.0 - 64.0 * distance(place(n))).clamp(0.0, 255.0).round() as u8).collect();
    let volume = Volume::new("plane", Grid::new([96; 3], DVec3::ONE).unwrap(), Voxels::Uint8(voxels)).unwrap();
    let points = vec![(90.0, 0.0), (200.0, 0.8), (255.0, 0.95)];
    let transfer = TransferFunction::new("plane", vec![(0.0, [1.0; 3])], points).unwrap();
    let size = viewport(200, 200);
    let camera = scaled(parallel(&volume, size, 0.0, 0.0), 30.0);
    let spread = |light_grid: LightGrid| {
        let shading = Shading {
            ambient: 0.0,
            diffuse: 1.0,
            specular: 0.0,
            lights: one_light(DVec3::new(-1.0, 1.0, 1.0)),
            ..Shading::default()
        };
        let settings = Settings { shading: Some(shading), shadows: Some(EXACT), light_grid, ..Settings::default() };
        let frame = render(&volume, &transfer, &camera, size, &settings);
        let light: Vec<f64> = frame.pixels().iter().filter(|p| p[3] > 0.99).map(|p| f64::from(p[0] / p[3])).collect();
        assert!(light.len() > 30_000, "{} opaque pixels", light.len());
        let mean = light.iter().sum::<f64>() / light.len() as f64;
        (light.iter().map(|t| (t - mean).powi(2)).sum::<f64>() / light.len() as f64).sqrt() / mean
    };
    let [full, half] = [LightGrid::Full, LightGrid::Half].map(spread);
    println!("spread of the light on a tilted plane: full {:.1} %, half {:.1} %", 100.0 * full, 100.0 * half);
    assert!(full < MOST, "{full}");
    assert!(half > full, "half resolution is noticed");
}

/// Frames change evenly while the view, or the light, turns through 45 degrees, where the axis of sweeps changes.
#[test]
fn turns_through_45_degrees_are_even() {
    /// Largest change near 45 degrees, in medians of the changes beside it. Measured: 1.1.
    const MOST_OF_VIEW: f64 = 1.5;
    /// Measured: 1.4. Where rays meet the middle layer in places that change with the direction: 2.2.
    const MOST_OF_LIGHT: f64 = 1.5;
    let (volume, transfer) = blobs();
    let size = viewport(96, 90);
    let shadowed = Settings { shadows: Some(EXACT), ..Settings::default() };
    let studio = Settings::default().with_look(Look::Studio).with_light_in_world(&parallel(&volume, size, 20.0, 10.0)).unwrap();
    let frame = |settings: Settings, view: f64, light: f64| {
        let camera = parallel(&volume, size, view, 10.0);
        let (sin, cos) = light.to_radians().sin_cos();
        render(&volume, &transfer, &camera, size, &shaded(settings, &[Light::towards(DVec3::new(sin, 0.3, cos))]))
    };
    let changes = |picture: &dyn Fn(f64) -> layersplat::Frame| -> Vec<f64> {
        let frames: Vec<_> = (0..=40).map(|n| picture(35.0 + 0.5 * f64::from(n))).collect();
        let change = |pair: &[layersplat::Frame]| {
            let squares =
                pair[0].pixels().iter().flatten().zip(pair[1].pixels().iter().flatten()).map(|(a, b)| f64::from(a - b).powi(2));
            (squares.sum::<f64>() / pair[0].pixels().len() as f64).sqrt()
        };
        frames.windows(2).map(change).collect()
    };
    let of_view = |settings| changes(&|degrees| frame(settings, degrees, 20.0));
    let of_light = |settings| changes(&|degrees| frame(settings, 20.0, degrees));
    for (name, most, changes) in [
        ("view", MOST_OF_VIEW, of_view(shadowed)),
        ("light", MOST_OF_LIGHT, of_light(shadowed)),
        ("view of the studio", MOST_OF_VIEW, of_view(studio)),
        ("light of the studio", MOST_OF_LIGHT, of_light(studio)),
    ] {
        let mut beside: Vec<f64> = changes[..10].iter().chain(&changes[30..]).copied().collect();
        beside.sort_by(f64::total_cmp);
        let largest = changes[14..26].iter().copied().fold(0.0, f64::max) / beside[beside.len() / 2];
        println!("turning the {name}: the largest change is {largest:.2} of the usual one");
        assert!(largest < most, "{name}: {largest}");
    }
}

/// A sphere does not shadow the half that is lit, and casts a round shadow on the plane below.
#[test]
fn iso_surfaces_do_not_shadow_themselves() {
    let dims = [64, 64, 64];
    let (centre, radius) = (DVec3::new(32.0, 34.0, 32.0), 11.0);
    let place = |n: usize| DVec3::new((n % 64) as f64, (n / 64 % 64) as f64, (n / 4096) as f64);
    let distance = |p: DVec3| (p.distance(centre) - radius).min(p.y - 8.0);
    let voxels =
        (0..dims.iter().product()).map(|n| (128.0 - 40.0 * distance(place(n))).clamp(0.0, 255.0).round() as u8).collect();
    let volume = Volume::new("sphere", Grid::new(dims, DVec3::ONE).unwrap(), Voxels::Uint8(voxels)).unwrap();
    let transfer = TransferFunction::new("white", vec![(0.0, [1.0; 3])], vec![(0.0, 1.0)]).unwrap();
    let to_light = DVec3::new(0.6, 1.0, 0.5).normalize();
    let size = viewport(128, 128);
    for (azimuth, elevation) in [(40.0, 35.0), (-60.0, 50.0)] {
        let camera = parallel(&volume, size, azimuth, elevation);
        let shading = Shading { ambient: 0.0, diffuse: 1.0, specular: 0.0, lights: one_light(to_light), ..Shading::default() };
        let settings = Settings { blend: Blend::Iso(128.0), shading: Some(shading), shadows: Some(EXACT), ..Settings::default() };
        let lit = render(&volume, &transfer, &camera, size, &Settings { shadows: None, ..settings });
        let shadowed = render(&volume, &transfer, &camera, size, &settings);
        let rays = Rays::new(&camera, size, volume.grid()).unwrap();
        let (mut on_lit_half, mut in_shadow, mut beside_shadow) = (0, 0, 0);
        for n in 0..size.pixels() {
            let ray = rays.at((n % 128) as f64 + 0.5, (n / 128) as f64 + 0.5);
            let (all, reaching) = (f64::from(lit.pixels()[n][0]), f64::from(shadowed.pixels()[n][0]));
            let direction = ray.direction.normalize();
            let nearest = (centre - ray.origin).dot(direction);
            let beside = (ray.origin + direction * nearest - centre).length();
            if beside < radius - 1.0 {
                let hit = ray.origin + direction * (nearest - (radius * radius - beside * beside).sqrt());
                if (hit - centre).dot(to_light) > 1.0 {
                    on_lit_half += 1;
                    assert!(reaching >= 0.98 * all, "a lit point of the sphere, {hit}, has {reaching} of {all}");
                }
            } else if beside > radius + 2.0 && direction.y < 0.0 {
                let hit = ray.origin + direction * ((8.0 - ray.origin.y) / direction.y);
                if hit.x < 2.0 || hit.x > 61.0 || hit.z < 2.0 || hit.z > 61.0 {
                    continue;
                }
                let towards = hit - centre;
                let from_axis = (towards - to_light * towards.dot(to_light)).length();
                if from_axis < radius - 2.5 {
                    in_shadow += 1;
                    assert!(reaching < 0.02 * all, "{hit} lies in the shadow, but has {reaching} of {all}");
                } else if from_axis > radius + 2.5 {
                    beside_shadow += 1;
                    assert!(reaching > 0.98 * all, "{hit} lies beside the shadow, but has {reaching} of {all}");
                }
            }
        }
        assert!(on_lit_half > 300 && in_shadow > 50 && beside_shadow > 300, "{on_lit_half}, {in_shadow}, {beside_shadow}");
    }
}
