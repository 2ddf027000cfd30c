//! The patch where the pad touches the disc of [`crate::finite_difference::brake`], and how it moves over the grid.

use crate::finite_difference::plate::{PlateGrid, PlateMotion};
use crate::flexible_disc::contact::{ANGULAR_POINTS, RADIAL_POINTS};
use crate::flexible_disc::plate_modes::gauss_legendre;

/// The points of the patch, each radius with each angle.
#[derive(Debug, Clone)]
pub(crate) struct MovingPatch {
    radii: Vec<PatchRadius>,
    angles: Vec<PatchAngle>,
    /// Where deflections are told: the edge, and a quarter of the way to it.
    edge: PatchRadius,
    inside: PatchRadius,
    /// A_s over h^2.
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

/// A place between the nodes e and e + 1 of a ring.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Foothold {
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
        Self { radii, angles, edge, inside, area: 4.0 * half_angle * half * middle, points }
    }

    /// The node e before an angle, and how far the angle is beyond it, `i/C`.
    fn foothold(plate: &PlateGrid, elements: f64, passage: Passage) -> Foothold {
        let position = elements - passage.part;
        let before = position.floor();
        let column = (before as i64 - passage.whole as i64).rem_euclid(plate.columns as i64);
        Foothold { column: column as usize, share: position - before }
    }

    /// Where on the grid the angles of the patch are.
    pub fn stand(&self, plate: &PlateGrid, passage: Passage, footing: &mut Vec<Foothold>) {
        footing.clear();
        footing.extend(self.angles.iter().map(|angle| Self::foothold(plate, angle.elements, passage)));
    }

    /// Reads the disc under the patch.
    pub fn read(&self, plate: &PlateGrid, motion: &PlateMotion, footing: &[Foothold], surface: &mut Surface) {
        surface.deflections.clear();
        surface.slopes.clear();
        for radius in &self.radii {
            for &Foothold { column, share } in footing {
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
        footing: &[Foothold],
        loads: &[f64],
        mut push: impl FnMut(usize, usize, f64),
    ) {
        for (radius, loads) in self.radii.iter().zip(loads.chunks_exact(footing.len())) {
            // What is allotted to the clamped rim moves nothing.
            for (ring, weight) in radius.rings().into_iter().filter(|(ring, _)| *ring > 0) {
                let weight = weight / plate.area(ring);
                for (&Foothold { column, share }, load) in footing.iter().zip(loads) {
                    push(ring, column, weight * (1.0 - share) * load);
                    push(ring, (column + 1) % plate.columns, weight * share * load);
                }
            }
        }
    }

    /// w at the middle of the pad: at the outer edge, and a quarter of the way to it.
    pub fn middle(&self, plate: &PlateGrid, motion: &PlateMotion, passage: Passage) -> (f64, f64) {
        let Foothold { column, share } = Self::foothold(plate, 0.0, passage);
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
mod tests {
    use super::*;

    #[test]
    fn what_is_allotted_is_what_is_read() {
        // The work of loads on any deflection is the same on the grid as at the points.
        let plate = PlateGrid::new(8, 48, (3.2, 6.75), 0.02, 0.3);
        let patch = MovingPatch::new(&plate, 3.3, 0.5, 8);
        let deflection: Vec<f64> = (0..8 * 48).map(|k| libm::sin((7 * k * k) as f64)).collect();
        let loads: Vec<f64> = (0..patch.points.len()).map(|k| libm::cos((5 * k * k) as f64)).collect();
        let motion = plate.at_rest(&deflection);
        for passage in [Passage::default(), Passage { whole: 3, part: 0.7 }, Passage { whole: 45, part: 0.1 }] {
            let (mut footing, mut surface) = (Vec::new(), Surface::default());
            patch.stand(&plate, passage, &mut footing);
            patch.read(&plate, &motion, &footing, &mut surface);
            let at_points: f64 = surface.deflections.iter().zip(&loads).map(|(w, load)| w * load).sum();
            let mut on_grid = 0.0;
            patch.allot(&plate, &footing, &loads, |ring, column, load| {
                on_grid += plate.area(ring) * load * deflection[(ring - 1) * 48 + column];
            });
            assert!((at_points - on_grid).abs() < 1e-13 && at_points.abs() > 0.1, "{at_points} {on_grid}");
        }
    }

    #[test]
    fn the_patch_reads_what_is_there_and_where_it_is() {
        // w = (r - a) (1 + cos(2 (theta + Om t))) seen from the pad, which is linear along the radius.
        let plate = PlateGrid::new(5, 96, (3.2, 6.75), 0.02, 0.3);
        let patch = MovingPatch::new(&plate, 4.5, 0.5, 8);
        let (whole, part) = (90, 0.3);
        let passed = (whole as f64 + part) * plate.angle;
        let node = |ring: usize, column: usize| {
            (plate.radius(ring) - 3.2) * (1.0 + libm::cos(2.0 * (column as f64 * plate.angle + passed)))
        };
        let deflection: Vec<f64> = (1..=5).flat_map(|ring| (0..96).map(move |column| node(ring, column))).collect();
        let motion = plate.at_rest(&deflection);
        let (mut footing, mut surface) = (Vec::new(), Surface::default());
        patch.stand(&plate, Passage { whole, part }, &mut footing);
        patch.read(&plate, &motion, &footing, &mut surface);
        for (((radius, theta), w), slope) in patch.places(plate.angle).zip(&surface.deflections).zip(&surface.slopes) {
            let height = radius - 3.2;
            // Second order in the spacing of 0.065.
            assert!((w - height * (1.0 + libm::cos(2.0 * theta))).abs() < 3e-3 * height, "{radius} {theta}: {w}");
            let exact = -2.0 * height * libm::sin(2.0 * theta) / radius;
            assert!((slope - exact).abs() < 2e-2 * height / radius, "{radius} {theta}: {slope} {exact}");
        }
        let (edge, inside) = patch.middle(&plate, &motion, Passage { whole, part });
        assert!((edge - 2.0 * 3.55).abs() < 0.01 && (inside - 0.5 * 3.55).abs() < 0.01, "{edge} {inside}");
        let total: f64 = patch.points.iter().map(|point| point.weight).sum();
        assert!((total - 1.0).abs() < 1e-14 && (patch.area - 0.5 * (6.75 * 6.75 - 4.5 * 4.5)).abs() < 1e-12, "{total}");
    }
}
