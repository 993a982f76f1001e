//! Tubes.

use super::spheres::check_radii;
use super::triangles::check_points;
use crate::choice::choices;
use crate::error::Error;
use glam::DVec3;

/// How tubes end.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Ends {
    /// With a disc.
    #[default]
    Flat,
    /// With nothing: one looks into the tube.
    Open,
    /// With half a sphere.
    Round,
}

choices! { Ends, "ends"; Flat = "flat", Open = "open", Round = "round" }

/// Tubes around lines of points. A piece between two points is a cone, whose radius changes linearly; at inner points, what a bend opens between
/// two pieces is filled by the ball of that point. Of each piece, the part inside its neighbours is not drawn, so a translucent tube shows its
/// outside. A line whose points coincide is a ball with round ends, and nothing with others.
#[derive(Clone, Debug, PartialEq)]
pub struct Tubes {
    points: Vec<DVec3>,
    radii: Vec<f64>,
    /// The first point of each line, and the number of points.
    starts: Vec<u32>,
    ends: Ends,
}

impl Tubes {
    /// Tubes around lines. The points of a line follow each other; `lengths` are their numbers.
    ///
    /// # Errors
    /// If there is not one radius per point, the lengths do not sum to the number of points, a point is not finite, or a radius is negative or
    /// not finite.
    pub fn new(points: Vec<DVec3>, radii: Vec<f64>, lengths: &[usize], ends: Ends) -> Result<Self, Error> {
        check_points(&points)?;
        check_radii("tubes", &radii, points.len())?;
        let mut starts = vec![0];
        let mut end = 0usize;
        for length in lengths {
            end = end.saturating_add(*length);
            starts.push(u32::try_from(end).unwrap_or(u32::MAX));
        }
        if end != points.len() || end >= u32::MAX as usize {
            let problem = format!("lines have {end} points, and there are {}", points.len());
            return Err(Error::Surface { name: "tubes".into(), problem });
        }
        Ok(Self { points, radii, starts, ends })
    }

    /// Points in the world, line by line.
    pub fn points(&self) -> &[DVec3] {
        &self.points
    }

    /// A radius per point.
    pub fn radii(&self) -> &[f64] {
        &self.radii
    }

    /// How they end.
    pub fn ends(&self) -> Ends {
        self.ends
    }

    /// The points of each line.
    pub fn lines(&self) -> impl ExactSizeIterator<Item = std::ops::Range<usize>> {
        self.starts.windows(2).map(|pair| pair[0] as usize..pair[1] as usize)
    }
}
