//! The energy that scattering cells take of lights.

use super::*;

/// Share of the light that cells absorb too much or too little: steps of 1/255 of what a voxel loses. Measured: 1.6 %.
const OF_ENERGY: f64 = 0.03;

/// The same in dense matter, whose extinction is not linear between voxels. Measured: 10 %.
const OF_DENSE: f64 = 0.11;

/// A volume with these shares of a dense value.
fn shares(dims: [usize; 3], share: impl Fn(DVec3) -> f64) -> Volume<'static> {
    let [x, y, _] = dims;
    let place = |n: usize| DVec3::new((n % x) as f64, (n / x % y) as f64, (n / (x * y)) as f64);
    let voxels = (0..dims.iter().product()).map(|n| (200.0 * share(place(n)).clamp(0.0, 1.0)).round() as u8).collect();
    Volume::new("dense", Grid::new(dims, DVec3::ONE).unwrap(), Voxels::Uint8(voxels)).unwrap()
}

/// What cells absorb of a light is what it loses on its way through the volume. With the light at the middles of voxels, the first sheet absorbs
/// 5 % too much.
#[test]
fn cells_absorb_what_lights_lose() {
    let (dims, middle) = ([40, 36, 44], DVec3::new(19.0, 17.0, 21.0));
    // The light leaves through faces where nothing absorbs.
    let inside = |p: DVec3| 14.0 - (p - middle).abs().max_element();
    let sheet = |normal: DVec3, thickness: f64| {
        shares(dims, |p| (0.5 + 0.5 * thickness - (p - middle).dot(normal.normalize()).abs()).min(inside(p)))
    };
    let noise = |p: DVec3| 1.5 * (p * DVec3::new(1.1, 1.7, 1.3)).sin().element_product();
    let all = &[DVec3::Z, -DVec3::X, DVec3::new(0.3, -0.5, 1.0)][..];
    let (along, flat, bent) = (&all[..2], &[0.3, 0.9, 0.99][..], &[0.3, 0.9][..]);
    for (name, volume, lights, opacities) in [
        ("sheet along z", sheet(DVec3::Z, 1.0), along, flat),
        ("thin sheet along x", sheet(DVec3::X, 0.3), along, flat),
        ("ball", shares(dims, |p| 12.5 - (p - middle).length()), all, bent),
        ("tilted sheet", sheet(DVec3::new(1.0, 2.0, 3.0), 1.5), all, bent),
        ("noise", shares(dims, |p| noise(p).min(inside(p))), along, bent),
    ] {
        for (&opacity, &to_light) in opacities.iter().flat_map(|opacity| lights.iter().map(move |light| (opacity, light))) {
            let transfer = TransferFunction::new("ramp", vec![(0.0, [1.0; 3])], vec![(0.0, 0.0), (200.0, opacity)]).unwrap();
            let own = Settings::default().with_look(Look::Studio);
            let shading = own.shading.map(|own| Shading { lights: Lights::new(&[Light::towards(to_light)]).unwrap(), ..own });
            let settings = Settings { shading, ..own };
            let found = absorbed(&volume, &transfer, &settings) / lost(&light_of(&volume, &transfer, &settings), dims, to_light);
            println!("{name}, opacity {opacity}, light from {to_light}: {found:.3}");
            let allowed = if opacity > 0.5 && opacities == bent { OF_DENSE } else { OF_ENERGY };
            assert!((found - 1.0).abs() < allowed, "{name}, opacity {opacity}, light from {to_light}: {found}");
        }
    }
}

/// The power that a light loses in a volume: what is missing behind its faces.
fn lost(light: &Light3, dims: [usize; 3], to_light: DVec3) -> f64 {
    let towards = to_light.normalize();
    let behind = |axis: usize| {
        let [i, j] = [(axis + 1) % 3, (axis + 2) % 3];
        let at = |n: usize| {
            let mut voxel = [if towards[axis] > 0.0 { -1 } else { dims[axis] as i64 }; 3];
            (voxel[i], voxel[j]) = ((n % (dims[i] + 2)) as i64 - 1, (n / (dims[i] + 2)) as i64 - 1);
            // Faces meet at their edges.
            let weight = |i: usize| if voxel[i] == -1 || voxel[i] == dims[i] as i64 { 0.5 } else { 1.0 };
            weight(i) * weight(j) * (1.0 - light.at(voxel))
        };
        towards[axis].abs() * (0..(dims[i] + 2) * (dims[j] + 2)).map(at).sum::<f64>()
    };
    std::f64::consts::PI * (0..3).map(behind).sum::<f64>()
}

/// The power that cells absorb of the red of lights.
fn absorbed(volume: &Volume, transfer: &TransferFunction, settings: &Settings) -> f64 {
    let (device, grid) = (Device::shared(), volume.grid());
    let camera = Camera::fit_parallel(grid.centre(), grid.diagonal(), SIZE, Orbit { azimuth: 33.0, elevation: 5.0, roll: 0.0 });
    let mut renderer = Renderer::new(&device, volume, transfer).unwrap();
    let planned = renderer.planned(&camera, SIZE, settings).unwrap();
    let (grids, buffer) = renderer.engine.lit_blocks(&planned.rays, SIZE, &planned.settings).unwrap();
    let mut blocks = vec![0.0; buffer.len()];
    buffer.read(&device, &mut blocks).unwrap();
    let (count, of_block) = (grids.blocks.iter().product::<usize>(), grids.per_block.iter().product::<usize>());
    // Light arrives from all sides on the mean.
    let per_edge = 4.0 * std::f64::consts::PI * of_block as f64 / grids.fine.edge;
    blocks[4 * count..5 * count].iter().map(|&scattered: &f32| f64::from(scattered) * per_edge).sum()
}
