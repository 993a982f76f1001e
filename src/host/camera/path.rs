//! Smooth camera paths.

use super::{Camera, Orbit, OrbitFrame, Projection};
use crate::error::Error;
use glam::{DMat3, DQuat, DVec3};

/// A camera at a point in time.
///
/// ```
/// use layersplat::camera::Key;
/// use layersplat::{Camera, Orbit, Projection, glam::DVec3};
///
/// let camera = Camera::orbit(DVec3::ZERO, 5.0, Orbit::default(), Projection::Parallel { scale: 1.0 });
/// assert!(Key { time: 0.0, camera, orbit: Some(Orbit::default()) }.camera == camera);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Key {
    /// Time in seconds.
    pub time: f64,
    /// Camera at that time.
    pub camera: Camera,
    /// The orbit of the camera, if any: that of [`Camera::orbit`], or counted in the path's [frame](CameraPath::in_frame). Between such keys
    /// the angles are interpolated, so a path may include full turns.
    pub orbit: Option<Orbit>,
}

/// A smooth path through key cameras.
///
/// Position and direction are continuously differentiable in time. Interpolation never overshoots the keys. Distances, sizes and fields
/// of view are interpolated logarithmically.
///
/// ```
/// use layersplat::camera::{CameraPath, Key};
/// use layersplat::{Camera, Orbit, Projection, glam::DVec3};
///
/// let key = |time, azimuth| {
///     let orbit = Orbit { azimuth, elevation: 20.0, roll: 0.0 };
///     let camera = Camera::orbit(DVec3::ZERO, 5.0, orbit, Projection::Parallel { scale: 1.0 });
///     Key { time, camera, orbit: Some(orbit) }
/// };
/// let path = CameraPath::new(vec![key(0.0, 0.0), key(2.0, 720.0)])?;
/// let half = path.at(0.5);
/// assert!(half.position.distance(key(0.5, 180.0).camera.position) < 1e-12);
/// # Ok::<(), layersplat::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct CameraPath {
    times: Vec<f64>,
    /// Interpolated parameters of each key: focal point, logarithms of distance and size, and orientation.
    numbers: Vec<[f64; NUMBERS]>,
    orbiting: bool,
    parallel: bool,
    /// Frame of the keys' orbits.
    frame: OrbitFrame,
}

/// Three for the focal point, two logarithms, three angles or four of a quaternion.
const NUMBERS: usize = 9;

impl CameraPath {
    /// Creates a path through `keys` that orbits about y.
    ///
    /// # Errors
    /// [`Error::Camera`] if there are no keys, their times are not finite and ascending, a camera is invalid, or parallel and perspective
    /// projections are mixed.
    pub fn new(keys: Vec<Key>) -> Result<Self, Error> {
        let invalid = |problem| Err(Error::Camera { problem });
        let Some(first) = keys.first() else { return invalid("a path needs at least one key") };
        if !keys.iter().all(|key| key.time.is_finite()) || keys.windows(2).any(|pair| pair[0].time >= pair[1].time) {
            return invalid("the times of a path's keys must be finite and ascending");
        }
        let is_parallel = |key: &Key| matches!(key.camera.projection, Projection::Parallel { .. });
        let parallel = is_parallel(first);
        if keys.iter().any(|key| is_parallel(key) != parallel) {
            return invalid("the keys of a path must be all parallel or all perspective");
        }
        let orbiting = keys.iter().all(|key| key.orbit.is_some());
        let mut numbers: Vec<[f64; NUMBERS]> = Vec::with_capacity(keys.len());
        for key in &keys {
            let mut found = numbers_of(key, orbiting)?;
            // A quaternion and its negative are the same rotation: choose the one closer to the previous key.
            let opposite = |last: &[f64; NUMBERS]| (5..NUMBERS).map(|i| last[i] * found[i]).sum::<f64>() < 0.0;
            if !orbiting && numbers.last().is_some_and(opposite) {
                found[5..].iter_mut().for_each(|n| *n = -*n);
            }
            numbers.push(found);
        }
        let frame = OrbitFrame::default();
        Ok(Self { times: keys.iter().map(|key| key.time).collect(), numbers, orbiting, parallel, frame })
    }

    /// Counts the orbits of the keys in `frame`, in which their cameras were made, so that the path orbits about its axis.
    pub fn in_frame(self, frame: OrbitFrame) -> Self {
        Self { frame, ..self }
    }

    /// Times of the first and the last key, in seconds.
    pub fn span(&self) -> (f64, f64) {
        (self.times[0], self.times[self.times.len() - 1])
    }

    /// Cameras at this many times, evenly spaced from the first key to the last.
    pub fn evenly(&self, count: u32) -> Vec<Camera> {
        let ((from, to), last) = (self.span(), f64::from(count.max(2) - 1));
        (0..count).map(|n| self.at(from + (to - from) * f64::from(n) / last)).collect()
    }

    /// The camera at `time` in seconds; constant before the first and after the last key.
    pub fn at(&self, time: f64) -> Camera {
        let numbers: [f64; NUMBERS] = std::array::from_fn(|i| self.number(i, time));
        let [x, y, z, distance, size, stand @ ..] = numbers;
        let projection = match self.parallel {
            true => Projection::Parallel { scale: size.exp() },
            false => Projection::Perspective { field_of_view: (size.exp().atan() * 2.0).to_degrees() },
        };
        let (focal_point, distance) = (DVec3::new(x, y, z), distance.exp());
        if self.orbiting {
            let [azimuth, elevation, roll, _] = stand;
            let orbit = self.frame.orbit(Orbit { azimuth, elevation, roll });
            return Camera::orbit(focal_point, distance, orbit, projection);
        }
        let axes = DMat3::from_quat(DQuat::from_array(stand).normalize());
        Camera { position: focal_point + axes.z_axis * distance, focal_point, view_up: axes.y_axis, projection }
    }

    /// One parameter at a time: a cubic Hermite spline.
    fn number(&self, i: usize, time: f64) -> f64 {
        let after = self.times.partition_point(|&t| t <= time);
        if after == 0 || after == self.times.len() {
            return self.numbers[after.saturating_sub(1)][i];
        }
        let (k, step) = (after - 1, self.times[after] - self.times[after - 1]);
        let t = (time - self.times[k]) / step;
        let (from, to) = (self.numbers[k][i], self.numbers[after][i]);
        let (leaving, arriving) = (self.slope(k, i) * step, self.slope(after, i) * step);
        let rest = 1.0 - t;
        let eased = t * t * (3.0 - 2.0 * t);
        from + (to - from) * eased + t * rest * (leaving * rest - arriving * t)
    }

    /// Slope at a key: the time-weighted harmonic mean of the adjacent secants (Fritsch & Butland), or 0 if their signs differ. This
    /// prevents overshoot.
    fn slope(&self, k: usize, i: usize) -> f64 {
        let secant = |k: usize| (self.numbers[k + 1][i] - self.numbers[k][i]) / self.step(k);
        match (k > 0, k + 1 < self.times.len()) {
            (false, false) => 0.0,
            (false, true) => secant(0),
            (true, false) => secant(k - 1),
            (true, true) => {
                let (before, after) = (secant(k - 1), secant(k));
                if before * after <= 0.0 {
                    return 0.0;
                }
                let (h, g) = (self.step(k - 1), self.step(k));
                let (v, w) = (2.0 * g + h, g + 2.0 * h);
                (v + w) / (v / before + w / after)
            }
        }
    }

    fn step(&self, k: usize) -> f64 {
        self.times[k + 1] - self.times[k]
    }
}

fn numbers_of(key: &Key, orbiting: bool) -> Result<[f64; NUMBERS], Error> {
    let basis = key.camera.basis()?;
    let Camera { position, focal_point, projection, .. } = key.camera;
    let size = match projection {
        Projection::Parallel { scale } => scale,
        Projection::Perspective { field_of_view } => (field_of_view.to_radians() / 2.0).tan(),
    };
    let stand = match key.orbit.filter(|_| orbiting) {
        Some(Orbit { azimuth, elevation, roll }) => [azimuth, elevation, roll, 0.0],
        None => DQuat::from_mat3(&DMat3::from_cols(basis.right, basis.up, -basis.forward)).to_array(),
    };
    let [x, y, z] = focal_point.to_array();
    let [a, b, c, d] = stand;
    Ok([x, y, z, position.distance(focal_point).ln(), size.ln(), a, b, c, d])
}

#[cfg(test)]
mod tests {
    use super::super::Up;
    use super::*;

    /// Rounding error of positions and directions after a few dozen operations in f64.
    const ROUNDING: f64 = 1e-9;

    fn key(time: f64, azimuth: f64, scale: f64) -> Key {
        let orbit = Orbit { azimuth, elevation: 25.0, roll: 10.0 };
        let camera = Camera::orbit(DVec3::new(1.0, 2.0, azimuth / 50.0), 3.0 * scale, orbit, Projection::Parallel { scale });
        Key { time, camera, orbit: Some(orbit) }
    }

    fn free(key: Key) -> Key {
        Key { orbit: None, ..key }
    }

    fn scale(camera: Camera) -> f64 {
        let Projection::Parallel { scale } = camera.projection else { panic!("{camera:?}") };
        scale
    }

    /// Distance between the views of two cameras.
    fn apart(a: Camera, b: Camera) -> f64 {
        let (p, q) = (a.basis().unwrap(), b.basis().unwrap());
        let turned = p.up.distance(q.up) + p.forward.distance(q.forward);
        a.position.distance(b.position) + a.focal_point.distance(b.focal_point) + turned
    }

    #[test]
    fn keys_are_met_and_nothing_goes_beyond_them() {
        let keys = vec![key(0.0, 0.0, 1.0), key(1.0, 30.0, 4.0), key(1.5, 30.0, 4.0), key(4.0, -90.0, 2.0)];
        for keys in [keys.clone(), keys.into_iter().map(free).collect()] {
            let path = CameraPath::new(keys.clone()).unwrap();
            assert_eq!(path.span(), (0.0, 4.0));
            for key in &keys {
                assert!(apart(path.at(key.time), key.camera) < ROUNDING, "{}", key.time);
                assert!((scale(path.at(key.time)) - scale(key.camera)).abs() < ROUNDING);
            }
            for n in 0..=400 {
                let scale = scale(path.at(f64::from(n) / 100.0));
                assert!((1.0 - ROUNDING..=4.0 + ROUNDING).contains(&scale), "{n}: {scale}");
            }
            // Constant between equal keys, before the first and after the last.
            assert!(apart(path.at(1.25), keys[1].camera) < ROUNDING);
            assert!(apart(path.at(-1.0), keys[0].camera) < ROUNDING && apart(path.at(9.0), keys[3].camera) < ROUNDING);
        }
    }

    /// At steps of 1/1000, no step is much longer than the previous one: no jumps in speed, at keys included.
    #[test]
    fn motion_is_smooth() {
        let keys = vec![key(0.0, 0.0, 1.0), key(1.0, 50.0, 2.0), key(3.0, 90.0, 2.5), key(4.0, 170.0, 1.0)];
        for keys in [keys.clone(), keys.into_iter().map(free).collect()] {
            let path = CameraPath::new(keys).unwrap();
            let steps: Vec<f64> =
                (1..4000).map(|n| apart(path.at(f64::from(n) / 1e3), path.at(f64::from(n - 1) / 1e3)) * 1e3).collect();
            let largest = steps.iter().copied().fold(0.0, f64::max);
            for (n, pair) in steps.windows(2).enumerate() {
                assert!((pair[1] - pair[0]).abs() < 0.02 * largest, "at {n} thousandths: {pair:?} of {largest}");
            }
        }
    }

    #[test]
    fn two_keys_are_joined_evenly_by_factors() {
        let path = CameraPath::new(vec![key(0.0, 0.0, 1.0), key(2.0, 720.0, 16.0)]).unwrap();
        assert!((scale(path.at(0.5)) - 2.0).abs() < ROUNDING);
        let expected = key(0.5, 180.0, 2.0).camera;
        assert!(apart(path.at(0.5), expected) < ROUNDING);
        let eye = |time, field_of_view| Key {
            time,
            camera: Camera { projection: Projection::Perspective { field_of_view }, ..key(0.0, 0.0, 1.0).camera },
            orbit: None,
        };
        let Projection::Perspective { field_of_view } =
            CameraPath::new(vec![eye(0.0, 10.0), eye(1.0, 90.0)]).unwrap().at(0.5).projection
        else {
            panic!()
        };
        assert!(((field_of_view / 2.0).to_radians().tan().powi(2) - 5f64.to_radians().tan()).abs() < ROUNDING);
        assert!(CameraPath::new(vec![eye(0.0, 10.0), key(1.0, 0.0, 1.0)]).is_err());
    }

    /// Between keys with z up, the eye stays at the height of both.
    #[test]
    fn paths_orbit_about_the_axis_of_their_frame() {
        let frame = OrbitFrame::about(Up::Z);
        let keys = [0.0, 90.0].map(|azimuth| {
            let orbit = Orbit { azimuth, elevation: 25.0, roll: 0.0 };
            let camera = Camera::orbit(DVec3::ZERO, 3.0, frame.orbit(orbit), Projection::Parallel { scale: 1.0 });
            Key { time: azimuth, camera, orbit: Some(orbit) }
        });
        let path = CameraPath::new(keys.to_vec()).unwrap().in_frame(frame);
        for (time, key) in [(0.0, keys[0]), (90.0, keys[1])] {
            assert!(apart(path.at(time), key.camera) < ROUNDING, "{time}");
        }
        let height = 3.0 * 25f64.to_radians().sin();
        assert!((0..=90).all(|time| (path.at(time.into()).position.z - height).abs() < ROUNDING));
        // Without the frame, the path leaves its keys.
        assert!(apart(CameraPath::new(keys.to_vec()).unwrap().at(0.0), keys[0].camera) > 0.1);
    }

    #[test]
    fn paths_that_are_none() {
        assert!(CameraPath::new(Vec::new()).is_err());
        assert!(CameraPath::new(vec![key(1.0, 0.0, 1.0), key(1.0, 10.0, 1.0)]).is_err());
        assert!(CameraPath::new(vec![key(f64::NAN, 0.0, 1.0)]).is_err());
        assert!(
            CameraPath::new(vec![Key {
                camera: Camera { view_up: DVec3::ZERO, ..key(0.0, 0.0, 1.0).camera },
                ..key(0.0, 0.0, 1.0)
            }])
            .is_err()
        );
        assert!(apart(CameraPath::new(vec![key(1.0, 0.0, 1.0)]).unwrap().at(7.0), key(1.0, 0.0, 1.0).camera) < ROUNDING);
    }
}
