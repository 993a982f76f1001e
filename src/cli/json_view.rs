//! Views in JSON, for `--cameras` and `--keys`.

use super::cameras::Cameras;
use super::orientation::Angles;
use crate::camera::{Camera, Orbit, Projection};
use glam::DVec3;
use serde::Deserialize;
use serde_json::{Map, Value};

/// Largest angle. Up to it, visible differences are still resolved.
const MAX_DEGREES: f64 = 1e6;

/// A camera by position or orbit. The command line provides omitted fields.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct View {
    position: Option<[f64; 3]>,
    focal_point: Option<[f64; 3]>,
    view_up: Option<[f64; 3]>,
    azimuth: Option<f64>,
    elevation: Option<f64>,
    roll: Option<f64>,
    center: Option<[f64; 3]>,
    distance: Option<f64>,
    parallel_scale: Option<f64>,
    perspective: Option<f64>,
}

impl View {
    /// Creates a view from the fields of a JSON object.
    ///
    /// # Errors
    /// A description of the problem for unknown, conflicting or invalid fields.
    pub fn from_fields(fields: Map<String, Value>) -> Result<Self, String> {
        let view: View = serde_json::from_value(Value::Object(fields)).map_err(|e| e.to_string())?;
        view.check()?;
        Ok(view)
    }

    fn check(&self) -> Result<(), String> {
        let placed = [
            (self.azimuth.is_some(), "azimuth"),
            (self.elevation.is_some(), "elevation"),
            (self.roll.is_some(), "roll"),
            (self.center.is_some(), "center"),
            (self.distance.is_some(), "distance"),
        ];
        let orbit = placed.iter().find(|(given, _)| *given).map(|(_, name)| name);
        match (self.position, orbit) {
            (Some(_), Some(name)) => return Err(format!("position and {name} conflict: a view has one or the other")),
            (None, _) if self.focal_point.is_some() || self.view_up.is_some() => {
                return Err("focal_point and view_up need a position: add it".into());
            }
            _ => (),
        }
        if self.parallel_scale.is_some() && self.perspective.is_some() {
            return Err("parallel_scale and perspective conflict: a view has one or the other".into());
        }
        for (name, angle) in [("azimuth", self.azimuth), ("elevation", self.elevation), ("roll", self.roll)] {
            if angle.is_some_and(|angle| angle.abs() > MAX_DEGREES) {
                return Err(format!("{name} must be within {MAX_DEGREES} degrees of 0"));
            }
        }
        for (name, value) in [("distance", self.distance), ("parallel_scale", self.parallel_scale)] {
            if value.is_some_and(|value| value <= 0.0) {
                return Err(format!("{name} must be above 0"));
            }
        }
        match self.perspective {
            Some(degrees) if !(degrees > 0.0 && degrees < 180.0) => {
                Err("perspective must be between 0 and 180 degrees, exclusive".into())
            }
            _ => Ok(()),
        }
    }

    /// The orbit in the frame of `cameras`, unless the view has a position. `cameras` provides omitted angles, or `default` all of them.
    pub fn orbit(&self, cameras: &Cameras, default: Orbit) -> Option<Orbit> {
        let angles = Angles { azimuth: self.azimuth, elevation: self.elevation, roll: self.roll };
        self.position.is_none().then(|| angles.or(cameras.angles()).or_all_of(default))
    }

    /// The camera of this view. `cameras` provides omitted values, or `default` all angles.
    pub fn camera(&self, cameras: &Cameras, default: Orbit) -> Result<Camera, String> {
        let mut options = cameras.options().clone();
        match (self.parallel_scale, self.perspective) {
            (Some(scale), _) => (options.parallel_scale, options.perspective) = (Some(scale), None),
            (_, Some(degrees)) => (options.parallel_scale, options.perspective) = (None, Some(degrees)),
            _ => (),
        }
        options.distance = self.distance.or(options.distance).filter(|_| options.perspective.is_some());
        options.center = self.center.map(DVec3::from_array).or(options.center);
        let checked = |camera: Camera| camera.basis().map(|_| camera).map_err(|e| e.to_string());
        if let Some(orbit) = self.orbit(cameras, default) {
            return checked(cameras.with_options(options).still(orbit));
        }
        let focal_point = self.focal_point.map_or_else(|| cameras.centre(), DVec3::from_array);
        let projection = match (options.perspective, options.parallel_scale) {
            (Some(field_of_view), _) => Projection::Perspective { field_of_view },
            (None, Some(scale)) => Projection::Parallel { scale },
            (None, None) => return Err("a view from a position needs parallel_scale or perspective".into()),
        };
        let position = self.position.map_or(focal_point, DVec3::from_array);
        let view_up = self.view_up.map_or(cameras.orientation().frame().up(), DVec3::from_array);
        checked(Camera { position, focal_point, view_up, projection })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn view(text: &str) -> Result<View, String> {
        View::from_fields(serde_json::from_str(text).unwrap())
    }

    #[test]
    fn contradictions_are_named() {
        for (text, word) in [
            (r#"{"position":[1,2,3],"azimuth":3}"#, "azimuth"),
            (r#"{"view_up":[0,1,0]}"#, "position"),
            (r#"{"azimuth":"left"}"#, "invalid type"),
            (r#"{"azimut":3}"#, "azimut"),
            (r#"{"position":[1,2]}"#, "length"),
            (r#"{"parallel_scale":3,"perspective":20}"#, "one or the other"),
            (r#"{"parallel_scale":0}"#, "above 0"),
            (r#"{"perspective":180}"#, "180"),
            (r#"{"roll":-1e308}"#, "roll must be within 1000000 degrees"),
        ] {
            let message = view(text).unwrap_err();
            assert!(message.contains(word), "{text}: {message}");
        }
        assert!(view("{}").is_ok() && view(r#"{"elevation":-20,"perspective":30,"distance":9}"#).is_ok());
    }
}
