//! Kernel arguments for classification.

use super::super::scene::Scene;
use super::tables::{Integrals, Scale, Table};
use crate::color::reflectance;
use crate::device::launch::structs::ClassificationParams;
use crate::settings::Blend;
use crate::transfer::Extinction;

impl ClassificationParams {
    /// Parameters for a table of this scale and unit of extinction, without limits of visible values.
    fn new(scene: &Scene, scale: Scale, table_unit: f32) -> Self {
        let iso = if let Blend::Iso(value) = scene.settings.blend { Some(value) } else { None };
        let color = |value| {
            let coded = scene.classification.transfer_function().color(value);
            if scene.settings.studio.is_some() { coded.map(reflectance) } else { coded }
        };
        Self {
            table_first: scale.first,
            table_per_value: scale.per_value,
            table_last: scale.last,
            visible: [0, scale.last],
            shown: [f32::NEG_INFINITY, f32::INFINITY],
            table_unit,
            cut: 0,
            linear: i32::from(scene.settings.extinction == Extinction::Linear),
            background_visible: i32::from(scene.background_shows()),
            iso: iso.map_or(0.0, |value| scene.field.stored_value(value) as f32),
            iso_color: iso.map_or([0.0; 3], |value| color(value).map(|c| c as f32)),
            brightness: scene.classification.factor() as f32,
            padding: 0.0,
        }
    }

    /// Parameters of post-classified samples.
    pub(in crate::renderer) fn from_table(scene: &Scene, table: &Table) -> Self {
        Self { visible: table.visible_entries, ..Self::new(scene, table.scale, 1.0) }
    }

    /// Parameters of composited pre-integrated segments.
    pub(in crate::renderer) fn from_integrals(scene: &Scene, integrals: &Integrals) -> Self {
        Self {
            shown: integrals.visible_values,
            cut: i32::from(integrals.cut),
            ..Self::new(scene, integrals.scale, integrals.unit)
        }
    }

    /// Parameters of values that are reduced along segments or compared with the iso-value. Their colours come from the table.
    pub(in crate::renderer) fn from_useful_values(scene: &Scene, table: &Table) -> Self {
        let all = Self::from_table(scene, table);
        Self { shown: scene.field.useful_values(scene.settings.blend).unwrap_or(all.shown), ..all }
    }
}
