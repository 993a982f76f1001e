//! Ordinates: the directions along which scattered light is computed.

use super::light_rays::sky_directions;
use glam::DVec3;

/// An ordinate of a grid of cubic cells, and the opposite one. Both join the middles of neighbouring cells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OrdinatePair {
    /// Cells from one to the next, along the ordinate. Along z, if it moves along z at all, it is positive.
    pub step: [i32; 3],
    /// Weight of each of both; those of all pairs sum to ½.
    pub weight: f64,
}

impl OrdinatePair {
    /// The pairs of the directions of [`sky_directions`].
    pub fn all() -> Vec<Self> {
        let cells = |direction: DVec3| (direction / direction.abs().max_element()).to_array().map(|d| d.round() as i32);
        let all = sky_directions().into_iter().map(|(direction, weight)| Self { step: cells(direction), weight });
        all.filter(|&Self { step: [x, y, z], .. }| z > 0 || (z == 0 && x + y > 0)).collect()
    }

    /// Unit vector along the ordinate.
    pub fn direction(&self) -> DVec3 {
        DVec3::from_array(self.step.map(f64::from)).normalize()
    }
}

/// Directions of the quadrature with which radiances around a point are averaged.
const DIRECTIONS: usize = 2000;

/// Radiances that enter along each ordinate and along the opposite one, of a sky that shines with `radiance` from a direction: its means over
/// the directions nearest to each ordinate, scaled so that their mean is that of all directions.
pub fn entering(pairs: &[OrdinatePair], radiance: impl Fn(DVec3) -> DVec3) -> Vec<[DVec3; 2]> {
    let against: Vec<_> = pairs.iter().flat_map(|pair| [-pair.direction(), pair.direction()]).collect();
    let mut sums = vec![(DVec3::ZERO, 0.0); against.len()];
    let mut whole = DVec3::ZERO;
    for direction in sphere(DIRECTIONS) {
        let value = radiance(direction);
        let nearest = (0..against.len()).max_by(|&a, &b| against[a].dot(direction).total_cmp(&against[b].dot(direction)));
        let (sum, count) = &mut sums[nearest.expect("there are ordinates")];
        (*sum, *count, whole) = (*sum + value, *count + 1.0, whole + value / DIRECTIONS as f64);
    }
    let means: Vec<DVec3> = sums.into_iter().map(|(sum, count)| sum / count).collect();
    let found: DVec3 = pairs.iter().zip(means.chunks_exact(2)).map(|(pair, both)| (both[0] + both[1]) * pair.weight).sum();
    let scale = DVec3::from_array([0, 1, 2].map(|c| if found[c] > 0.0 { whole[c] / found[c] } else { 1.0 }));
    means.chunks_exact(2).map(|both| [both[0] * scale, both[1] * scale]).collect()
}

/// Directions spread evenly over the sphere: a Fibonacci lattice.
pub fn sphere(count: usize) -> impl Iterator<Item = DVec3> {
    let golden_angle = std::f64::consts::PI * (3.0 - 5f64.sqrt());
    (0..count).map(move |n| {
        let z = 1.0 - (2 * n + 1) as f64 / count as f64;
        let (sin, cos) = (n as f64 * golden_angle).sin_cos();
        let radius = (1.0 - z * z).sqrt();
        DVec3::new(radius * cos, radius * sin, z)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pairs_have_all_directions() {
        let pairs = OrdinatePair::all();
        assert_eq!(pairs.len(), 7);
        assert!((pairs.iter().map(|pair| pair.weight).sum::<f64>() - 0.5).abs() < 1e-12);
        for (direction, weight) in sky_directions() {
            let is_it = |pair: &&OrdinatePair| pair.direction().dot(direction).abs() > 1.0 - 1e-12;
            assert_eq!(pairs.iter().find(is_it).map(|pair| pair.weight), Some(weight), "{direction}");
        }
    }

    #[test]
    fn the_mean_of_a_sky_is_kept() {
        let pairs = OrdinatePair::all();
        let sky = |d: DVec3| DVec3::new(1.0, 0.5 + 0.5 * d.y, d.z.max(0.0));
        let entering = entering(&pairs, sky);
        let mean: DVec3 = pairs.iter().zip(&entering).map(|(pair, both)| (both[0] + both[1]) * pair.weight).sum();
        // Of the quadrature.
        assert!((mean - DVec3::new(1.0, 0.5, 0.25)).length() < 1e-3, "{mean}");
        let up = pairs.iter().position(|pair| pair.step == [0, 0, 1]).unwrap();
        assert!(entering[up][0].z < 1e-9 && entering[up][1].z > 0.8, "light from above travels down: {entering:?}");
    }
}
