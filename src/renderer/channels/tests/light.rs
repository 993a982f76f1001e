//! Shadows and ambient occlusion of several fields: one light volume, dimmed by the sum of the extinctions.

use super::*;
use crate::settings::{AmbientOcclusion, Light, LightGrid, Lights, Shading, Shadows};

/// A step of a light volume. Sums of floats in another order round to another step in few values, of which a sample sees a share.
const STEP: f32 = 1.0 / 255.0;
/// Share of the numbers of a picture that differ by more than rounding. Measured on PoCL: none, and at most 6e-8.
const ANOTHER_STEP: f64 = 1e-3;
const TOLERANCE: f32 = 1e-5;

fn shadowed() -> Vec<Settings> {
    let light = Light { angle: 4.0, ..Light::towards(DVec3::new(-1.0, 1.2, 0.4)) };
    let shading = Some(Shading { lights: Lights::new(&[light]).unwrap(), ..Shading::default() });
    let shadows = Settings { shading, shadows: Some(Shadows { forgiveness: 1.0, ..Shadows::default() }), ..Settings::default() };
    let hard = Settings { shading: Settings::default().shading, ..shadows };
    let occlusion = Some(AmbientOcclusion { reach: None, gain: 1.0 });
    let gradient_opacity = Some(GradientOpacity::new(&[(0.0, 0.2), (20.0, 1.0)]).unwrap());
    let cast = Algorithm::Raycast { kernel: Kernel::Cubic, step: 0.5 };
    vec![
        shadows,
        Settings { shading: hard.shading.map(|shading| Shading { lights: Lights::BESIDE_CAMERA, ..shading }), ..hard },
        Settings { light_grid: LightGrid::Half, ..shadows },
        Settings { shadows: None, ambient_occlusion: occlusion, light_grid: LightGrid::Quarter, ..shadows },
        Settings { ambient_occlusion: occlusion, extinction: Extinction::Linear, ..shadows },
        Settings { extinction: Extinction::Linear, light_grid: LightGrid::Half, ..shadows },
        Settings { gradient_opacity, ..shadows },
        Settings { gradient_opacity, light_grid: LightGrid::Half, ..shadows },
        Settings { algorithm: cast, ..shadows },
    ]
}

/// Largest difference, and the share of numbers that differ by more than rounding.
fn apart(one: &[Frame], other: &[Frame]) -> (f32, f64) {
    let numbers = |frames: &[Frame]| frames.iter().flat_map(|frame| frame.pixels().as_flattened().to_vec()).collect::<Vec<_>>();
    let (one, other) = (numbers(one), numbers(other));
    let rounded = one.iter().zip(&other).filter(|(a, b)| (**a - **b).abs() <= TOLERANCE).count();
    (difference_of(&one, &other), 1.0 - rounded as f64 / one.len() as f64)
}

fn difference_of(one: &[f32], other: &[f32]) -> f32 {
    one.iter().zip(other).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

#[test]
fn two_halves_cast_the_shadow_of_the_whole() {
    let device = Device::shared();
    let (volume, [channel, _]) = scene(&device);
    let cameras = cameras(&volume);
    let mut renderer = Renderer::from_channels(std::slice::from_ref(&channel)).unwrap();
    let set = |renderer: &mut Renderer, factors: &[f64]| {
        let parts: Vec<_> = factors.iter().map(|&factor| channel.clone().with_factor(factor).unwrap()).collect();
        renderer.set_channels(&parts).unwrap();
    };
    for settings in shadowed() {
        set(&mut renderer, &[1.0]);
        let whole = pictures(&mut renderer, &cameras, &settings);
        let without = Settings { shadows: None, ambient_occlusion: None, ..settings };
        let shade = difference(&whole, &pictures(&mut renderer, &cameras, &without));
        assert!(shade > 2.0 * STEP, "{shade} with {settings:?}");
        set(&mut renderer, &[0.5, 0.5]);
        let halves = pictures(&mut renderer, &cameras, &settings);
        let (most, share) = apart(&whole, &halves);
        println!("{most:e}, {share:e} with {:?}, {:?}", settings.light_grid, settings.extinction);
        assert!(most <= STEP && share <= ANOTHER_STEP, "{most:e}, {share:e} with {settings:?}");
        // A missing half would be noticed.
        set(&mut renderer, &[0.25, 0.25]);
        let (_, share) = apart(&halves, &pictures(&mut renderer, &cameras, &settings));
        assert!(share > 5.0 * ANOTHER_STEP, "{share:e}");
    }
}

/// A field that is seen through casts a shadow on the other, in any order; a hidden one does not.
#[test]
fn each_field_shades_the_others() {
    let device = Device::shared();
    let (volume, [one, other]) = scene(&device);
    let cameras = cameras(&volume);
    for settings in shadowed() {
        let draw = |channels: &[Channel]| pictures(&mut Renderer::from_channels(channels).unwrap(), &cameras, &settings);
        let both = draw(&[one.clone(), other.clone()]);
        let (most, share) = apart(&both, &draw(&[other.clone(), one.clone()]));
        println!("{most:e}, {share:e} with {:?}, {:?}", settings.light_grid, settings.extinction);
        assert!(most <= STEP && share <= ANOTHER_STEP, "{most:e}, {share:e} with {settings:?}");
        let hidden = one.clone().with_visibility(false);
        assert!(draw(&[hidden.clone(), other.clone()]) == draw(std::slice::from_ref(&other)), "{settings:?}");
        assert!(draw(&[other.clone(), hidden]) == draw(std::slice::from_ref(&other)), "{settings:?}");
        let culled = Settings { culling: false, ..settings };
        let mut renderer = Renderer::from_channels(&[one.clone(), other.clone()]).unwrap();
        assert!(both == pictures(&mut renderer, &cameras, &culled), "{settings:?}");
    }
}

/// Light is swept again if any field changes, and only then.
#[test]
fn light_is_kept_until_a_field_changes() {
    let device = Device::shared();
    let (volume, [one, other]) = scene(&device);
    let [settings, ..] = &shadowed()[..] else { unreachable!() };
    let mut renderer = Renderer::from_channels(&[one.clone(), other.clone()]).unwrap();
    let made = |channels: &[Channel], renderer: &mut Renderer| {
        renderer.set_channels(channels).unwrap();
        pictures(renderer, &cameras(&volume), settings);
        renderer.engine.light_volumes_made()
    };
    assert_eq!(made(&[one.clone(), other.clone()], &mut renderer), 1);
    assert_eq!(made(&[one.clone(), other.clone()], &mut renderer), 1);
    assert_eq!(made(&[one.clone(), other.clone().with_factor(2.0).unwrap()], &mut renderer), 2);
    assert_eq!(made(&[one.clone().with_factor(2.0).unwrap(), other.clone()], &mut renderer), 3);
    let thin = other.with_gradient_opacity(GradientOpacity::new(&[(0.0, 0.2), (20.0, 1.0)]).unwrap());
    assert_eq!(made(&[one, thin], &mut renderer), 4);
}

/// Of several surfaces each casts a shadow.
#[test]
fn surfaces_cast_shadows_on_each_other() {
    let device = Device::shared();
    let (volume, [channel, _]) = scene(&device);
    let cameras = cameras(&volume);
    let (lo, hi) = volume.range();
    let [inner, outer] = [0.7, 0.3].map(|share| lo + share * (hi - lo));
    let [settings, ..] = &shadowed()[..] else { unreachable!() };
    let settings = Settings { blend: Blend::Iso(outer), ..*settings };
    let mut renderer = Renderer::from_channels(std::slice::from_ref(&channel)).unwrap();
    let alone = pictures(&mut renderer, &cameras, &settings);
    // A surface inside another one casts its shadow there.
    renderer.set_channels(&[channel.clone().with_iso(inner), channel.clone()]).unwrap();
    assert!(difference(&pictures(&mut renderer, &cameras, &settings), &alone) <= STEP);
    renderer.set_channels(&[channel.clone().with_iso(inner), channel.with_visibility(false)]).unwrap();
    assert!(difference(&pictures(&mut renderer, &cameras, &settings), &alone) > 0.1);
}
