//! Projection of world points to pixels by plain sines and cosines.

#[derive(Clone, Copy, Debug)]
pub enum Projection {
    /// `scale`: half the picture's height in world units.
    Parallel { scale: f64 },
    /// Vertical field of view, and distance of the eye from the centre.
    Perspective { degrees: f64, distance: f64 },
}

#[derive(Clone, Copy, Debug)]
pub struct View {
    /// Columns and rows.
    pub size: [u32; 2],
    /// World point at the centre of the picture.
    pub centre: [f64; 3],
    /// Azimuth, elevation and roll in degrees.
    pub orbit: [f64; 3],
    pub projection: Projection,
}

impl View {
    /// Column and row of a world point, from the upper left corner of the picture.
    ///
    /// The direction from the centre to the eye is (cosE·sinA, sinE, cosE·cosA). Rotating the world by −A about y and then by E about x moves
    /// the eye to +z; then x points right and y up. A camera that rolls by φ clockwise sees the world rotate the other way.
    pub fn place(&self, point: [f64; 3]) -> [f64; 2] {
        let [azimuth, elevation, roll] = self.orbit.map(f64::to_radians);
        let [x, y, z] = [0, 1, 2].map(|a| point[a] - self.centre[a]);
        let (x, z) = (x * azimuth.cos() - z * azimuth.sin(), x * azimuth.sin() + z * azimuth.cos());
        let (y, z) = (y * elevation.cos() - z * elevation.sin(), y * elevation.sin() + z * elevation.cos());
        let (x, y) = (x * roll.cos() - y * roll.sin(), y * roll.cos() + x * roll.sin());
        let [width, height] = self.size.map(f64::from);
        // World units from the centre of the picture to its upper edge, at this depth.
        let half = match self.projection {
            Projection::Parallel { scale } => scale,
            Projection::Perspective { degrees, distance } => (distance - z) * (degrees.to_radians() / 2.0).tan(),
        };
        let pixels = height / 2.0 / half;
        [width / 2.0 + x * pixels, height / 2.0 - y * pixels]
    }

    /// Positions that common mistakes would give; each must be detected.
    pub fn mistakes(&self, point: [f64; 3]) -> Vec<[f64; 2]> {
        let [width, height] = self.size.map(f64::from);
        let [x, y] = self.place(point);
        let [azimuth, elevation, roll] = self.orbit;
        let orbits = [[-azimuth, elevation, roll], [azimuth, -elevation, roll], [azimuth, elevation, -roll]];
        let turned = orbits.into_iter().filter(|&orbit| orbit != self.orbit).map(|orbit| View { orbit, ..*self }.place(point));
        let (right, down) = (x - width / 2.0, y - height / 2.0);
        let stretched = [width / 2.0 + right * height / width, height / 2.0 + down * width / height];
        // Upside down, mirrored, and transposed.
        let mut mistakes = vec![[x, height - y], [width - x, y], [width / 2.0 + down, height / 2.0 + right]];
        // Aspect ratio on the wrong side, or on both.
        mistakes.extend([[stretched[0], y], [x, stretched[1]], stretched]);
        mistakes.extend(turned);
        if let Projection::Perspective { degrees, .. } = self.projection {
            // Sine of half the angle instead of its tangent.
            let shrunk = 1.0 / (degrees.to_radians() / 2.0).cos();
            mistakes.push([width / 2.0 + right * shrunk, height / 2.0 + down * shrunk]);
        }
        mistakes
    }
}
