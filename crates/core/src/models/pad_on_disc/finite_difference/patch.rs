//! The patch where the pad touches the disc, and how it moves over the grid.

use crate::models::pad_on_disc::finite_difference::plate::grid::PlateGrid;
use crate::models::pad_on_disc::finite_difference::plate::motion::PlateMotion;
use crate::models::pad_on_disc::flexible_disc::contact::points::{ANGULAR_POINTS, RADIAL_POINTS};
use crate::numerics::quadrature::gauss_legendre;

/// The points of the patch, each radius with each angle.
#[derive(Debug, Clone)]
pub(crate) struct MovingPatch {
    radii: Vec<PatchRadius>,
    angles: Vec<PatchAngle>,
    /// Where deflections are recorded: at the edge, and a quarter of the way to it.
    edge: PatchRadius,
    inside: PatchRadius,
    /// A_s over h^2.
    #[cfg(test)]
    pub area: f64,
    /// Radius by radius.
    pub points: Vec<PatchPoint>,
}

/// One point of the patch.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PatchPoint {
    /// Share of the patch's area.
    pub weight: f64,
    /// r theta over h.
    pub arc: f64,
}

/// A radius between two rings.
#[derive(Debug, Clone, Copy)]
struct PatchRadius {
    ring: usize,
    /// Of the outer ring.
    share: f64,
    /// r over h.
    radius: f64,
    weight: f64,
}

/// An angle of the patch.
#[derive(Debug, Clone, Copy)]
struct PatchAngle {
    /// In elements, from the middle of the pad.
    elements: f64,
    weight: f64,
}

/// How far the disc has passed under the pad, in elements: whole ones, less full turns, and a part of one.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Passage {
    pub whole: usize,
    pub part: f64,
}

/// A position on a ring, between the nodes e and e + 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct RingPosition {
    column: usize,
    /// Of the node e + 1, the paper's `i/C`.
    share: f64,
}

/// The disc under the points of the patch.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Surface {
    pub deflections: Vec<f64>,
    /// `W_theta / r`.
    pub slopes: Vec<f64>,
}

impl PatchRadius {
    fn new(plate: &PlateGrid, radius: f64, weight: f64) -> Self {
        let position = (radius - plate.inner) / plate.spacing;
        let ring = (position.max(0.0) as usize).min(plate.rings - 1);
        Self { ring, share: position - ring as f64, radius, weight }
    }

    fn rings(&self) -> [(usize, f64); 2] {
        [(self.ring, 1.0 - self.share), (self.ring + 1, self.share)]
    }
}

impl MovingPatch {
    /// `inner` radius over h and `half_angle` of the pad, `per_pad` elements under a pad of a sixth.
    pub fn new(plate: &PlateGrid, inner: f64, half_angle: f64, per_pad: usize) -> Self {
        let (middle, half) = (0.5 * (plate.outer + inner), 0.5 * (plate.outer - inner));
        let radius = |(at, weight): (f64, f64)| {
            let radius = middle + half * at;
            PatchRadius::new(plate, radius, 0.5 * weight * radius / middle)
        };
        let angle =
            |(at, weight): (f64, f64)| PatchAngle { elements: half_angle * at / plate.angle, weight: 0.5 * weight };
        let radii: Vec<_> = gauss_legendre(RADIAL_POINTS.max(per_pad / 2)).into_iter().map(radius).collect();
        let angles: Vec<_> = gauss_legendre(ANGULAR_POINTS.max(per_pad)).into_iter().map(angle).collect();
        let point = |(radius, angle): (&PatchRadius, &PatchAngle)| PatchPoint {
            weight: radius.weight * angle.weight,
            arc: radius.radius * angle.elements * plate.angle,
        };
        let points =
            radii.iter().flat_map(|radius| angles.iter().map(move |angle| (radius, angle))).map(point).collect();
        let on_radius = |radius: f64| PatchRadius::new(plate, radius, 0.0);
        let edge = on_radius(plate.outer);
        let inside = on_radius(plate.inner + 0.25 * (plate.outer - plate.inner));
        Self {
            radii,
            angles,
            edge,
            inside,
            #[cfg(test)]
            area: 4.0 * half_angle * half * middle,
            points,
        }
    }

    /// The node e before an angle, and how far the angle is beyond it, `i/C`.
    fn position_of(plate: &PlateGrid, elements: f64, passage: Passage) -> RingPosition {
        let position = elements - passage.part;
        let before = position.floor();
        let column = (before as i64 - passage.whole as i64).rem_euclid(plate.columns as i64);
        RingPosition { column: column as usize, share: position - before }
    }

    /// Finds where on the grid the angles of the patch are.
    pub fn locate(&self, plate: &PlateGrid, passage: Passage, positions: &mut Vec<RingPosition>) {
        positions.clear();
        positions.extend(self.angles.iter().map(|angle| Self::position_of(plate, angle.elements, passage)));
    }

    /// Reads the disc under the patch.
    pub fn read(&self, plate: &PlateGrid, motion: &PlateMotion, positions: &[RingPosition], surface: &mut Surface) {
        surface.deflections.clear();
        surface.slopes.clear();
        for radius in &self.radii {
            for &RingPosition { column, share } in positions {
                let (mut deflection, mut slope) = (0.0, 0.0);
                for (ring, weight) in radius.rings() {
                    let [before, own, next, after] = plate.four_nodes(motion, ring, column);
                    deflection += weight * (own + share * (next - own));
                    slope += weight * ((1.0 - share) * (next - before) + share * (after - own));
                }
                surface.deflections.push(deflection);
                surface.slopes.push(slope / (2.0 * plate.angle * radius.radius));
            }
        }
    }

    /// Allots the loads of the points, accelerations times the area h^2, to the nodes.
    pub fn allot(
        &self,
        plate: &PlateGrid,
        positions: &[RingPosition],
        loads: &[f64],
        mut push: impl FnMut(usize, usize, f64),
    ) {
        for (radius, loads) in self.radii.iter().zip(loads.chunks_exact(positions.len())) {
            // What is allotted to the clamped rim moves nothing.
            for (ring, weight) in radius.rings().into_iter().filter(|(ring, _)| *ring > 0) {
                let weight = weight / plate.area(ring);
                for (&RingPosition { column, share }, load) in positions.iter().zip(loads) {
                    push(ring, column, weight * (1.0 - share) * load);
                    push(ring, (column + 1) % plate.columns, weight * share * load);
                }
            }
        }
    }

    /// w at the middle of the pad: at the outer edge, and a quarter of the way to it.
    pub fn middle(&self, plate: &PlateGrid, motion: &PlateMotion, passage: Passage) -> (f64, f64) {
        let RingPosition { column, share } = Self::position_of(plate, 0.0, passage);
        let at = |radius: &PatchRadius| {
            let ring = |(ring, weight): (usize, f64)| {
                let [_, own, next, _] = plate.four_nodes(motion, ring, column);
                weight * (own + share * (next - own))
            };
            radius.rings().map(ring).iter().sum()
        };
        (at(&self.edge), at(&self.inside))
    }

    /// Radius over h and angle of every point, for elements of an angle.
    #[cfg(test)]
    pub fn places(&self, element: f64) -> impl Iterator<Item = (f64, f64)> {
        self.radii
            .iter()
            .flat_map(move |radius| self.angles.iter().map(move |angle| (radius.radius, angle.elements * element)))
    }

    /// The average over the patch.
    pub fn average(&self, values: impl Iterator<Item = f64>) -> f64 {
        self.points.iter().zip(values).map(|(point, value)| point.weight * value).sum()
    }
}

#[cfg(test)]
mod tests;
