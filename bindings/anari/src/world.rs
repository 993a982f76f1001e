//! Worlds: which volumes and lights there are, and where.

use crate::field::Field;
use crate::handle::Handle;
use crate::light;
use crate::objects::{Object, Objects};
use crate::status::Problem;
use crate::volume::{DrawnVolume, handles};
use layersplat::glam::{DAffine3, DMat4, DVec3};
use layersplat::renderer::Channel;
use layersplat::settings::{Light, Lights};

/// An object and the transform of its instance.
struct Placed {
    handle: Handle,
    placement: DAffine3,
    /// Its index in the array that contains it.
    index: u32,
}

/// The objects of one kind in a world: of the world itself, then of its instances.
fn placed(objects: &Objects, world: &Object, kind: &std::ffi::CStr) -> Vec<Placed> {
    let listed = |container: &Object, placement: DAffine3| {
        let listed = container.object(kind).map(|array| handles(objects, array)).unwrap_or_default();
        let known =
            |(index, handle): (usize, Handle)| objects.get(handle).map(|_| Placed { handle, placement, index: index as u32 });
        listed.into_iter().enumerate().filter_map(known).collect::<Vec<_>>()
    };
    let mut all = listed(world, DAffine3::IDENTITY);
    let instances = world.object(c"instance").map(|array| handles(objects, array)).unwrap_or_default();
    for instance in instances.into_iter().filter_map(|handle| objects.get(handle)) {
        if let Some(group) = instance.object(c"group").and_then(|group| objects.get(group)) {
            all.extend(listed(group, transform(instance)));
        }
    }
    all
}

/// The transform of an instance. The last row of its matrix is ignored.
fn transform(instance: &Object) -> DAffine3 {
    instance
        .floats::<16>(c"transform")
        .map_or(DAffine3::IDENTITY, |columns| DAffine3::from_mat4(DMat4::from_cols_array(&columns.map(f64::from))))
}

/// The volumes that are drawn together: the first visible ones that can be. Others are named as problems.
pub fn shown(objects: &Objects, world: &Object, problems: &mut Vec<Problem>) -> Vec<DrawnVolume> {
    let surfaces = placed(objects, world, c"surface").len();
    if surfaces > 0 {
        problems.push(Problem::argument(format!("{surfaces} surfaces are not drawn: this device draws volumes only")));
    }
    let is_visible = |placed: &Placed| {
        objects.get(placed.handle).is_some_and(|volume| volume.class.is_supported() && volume.is_set(c"visible"))
    };
    let mut all = Vec::new();
    let mut names = Vec::new();
    for volume in placed(objects, world, c"volume").into_iter().filter(is_visible) {
        match DrawnVolume::from_object(objects, volume.handle, volume.placement, volume.index) {
            Ok(shown) => {
                all.push(shown);
                names.push(name(objects, volume.handle));
            }
            Err(problem) => problems.push(problem),
        }
    }
    if all.len() > Channel::MOST {
        let drawn = names[..Channel::MOST].join(", ");
        let text = format!("{} volumes are visible: only the first {} are drawn, {drawn}", all.len(), Channel::MOST);
        problems.push(Problem::argument(text));
        all.truncate(Channel::MOST);
    }
    all
}

/// Name of an object for messages.
fn name(objects: &Objects, handle: Handle) -> String {
    match objects.get(handle).and_then(|object| object.text(c"name")) {
        Some(name) => format!("'{name}'"),
        None => format!("{:#x}", handle.0),
    }
}

/// The lights of a world.
pub fn lights(objects: &Objects, world: &Object, problems: &mut Vec<Problem>) -> Option<Lights> {
    let mut lights: Vec<Light> = Vec::new();
    for light in placed(objects, world, c"light") {
        let Some(object) = objects.get(light.handle).filter(|object| object.class.is_supported()) else { continue };
        match light::directional(object, light.placement.matrix3) {
            Ok(light) => lights.push(light),
            Err(problem) => problems.push(problem),
        }
    }
    light::strongest(lights, problems)
}

/// Smallest and largest corner of the volumes of a world or a group; `None` without any.
fn volume_bounds(objects: &Objects, container: &Object) -> Option<[DVec3; 2]> {
    let mut bounds: Option<[DVec3; 2]> = None;
    for volume in placed(objects, container, c"volume") {
        let field = objects.get(volume.handle).and_then(|object| object.object(c"value"));
        let Some(field) = field.and_then(|field| Field::from_object(objects, field).ok()) else { continue };
        let [low, high] = field.bounds();
        for corner in 0..8 {
            let at = |bit: usize, low: f64, high: f64| if corner >> bit & 1 == 0 { low } else { high };
            let corner = DVec3::new(at(0, low.x, high.x), at(1, low.y, high.y), at(2, low.z, high.z));
            let corner = volume.placement.transform_point3(corner);
            bounds = Some(bounds.map_or([corner; 2], |[low, high]| [low.min(corner), high.max(corner)]));
        }
    }
    bounds
}

/// Bounds of a world, a group or an instance, in its own outer coordinates.
pub fn bounds(objects: &Objects, object: &Object) -> Option<[DVec3; 2]> {
    let Some(group) = object.object(c"group") else { return volume_bounds(objects, object) };
    let [low, high] = volume_bounds(objects, objects.get(group)?)?;
    let placement = transform(object);
    // The box of the transformed box: half its size by the absolute values of the matrix.
    let centre = placement.transform_point3((low + high) / 2.0);
    let half = placement.matrix3.abs() * ((high - low) / 2.0);
    Some([centre - half, centre + half])
}
