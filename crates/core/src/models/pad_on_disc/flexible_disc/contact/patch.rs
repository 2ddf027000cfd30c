//! The patch with the shapes of the disc's modes on it, and its loads.

use crate::models::pad_on_disc::flexible_disc::contact::averages::Averages;
use crate::models::pad_on_disc::flexible_disc::contact::loads::ContactLoads;
use crate::models::pad_on_disc::flexible_disc::contact::node::{ContactNode, Node};
use crate::models::pad_on_disc::flexible_disc::contact::position::PadPosition;
use crate::models::pad_on_disc::flexible_disc::contact::pressed_region::integration::{Pressed, PressedNode, Visitor};
use crate::models::pad_on_disc::flexible_disc::contact::pressed_region::line::{MOST_HARMONICS, Radius};
use crate::models::pad_on_disc::flexible_disc::contact::pressed_region::shapes::PressedRegion;
use crate::models::pad_on_disc::flexible_disc::plate_modes::PlateMode;
use crate::models::pad_on_disc::parameters::Parameters;
use crate::numerics::quadrature::gauss_legendre;

/// Unit of the lengths along the disc, `r theta` and those by which slopes are taken, over the outer radius b. It is
/// the thickness of the preset, whose scales are 1 for it: see [`PadPosition::tilt`] and [`ContactLoads::follower`].
pub(crate) const LENGTH_UNIT: f64 = 0.020 / 0.135;

/// Further points for a partly lifted patch, on each piece and between two cuts of the radius: where pieces divide and
/// join, the integrand is smooth but no longer a product of shapes.
const FURTHER_POINTS: usize = 4;

/// The patch with the shapes of the disc's amplitudes on it. It depends on radii, Poisson's ratio and the pad's angle
/// alone: not on the thickness.
#[derive(Debug, Clone)]
pub(crate) struct ContactPatch {
    nodes: Vec<Node>,
    /// Amplitudes with even shapes; they come first.
    pub even: usize,
    /// Amplitudes with odd shapes.
    pub odd: usize,
    pub averages: Averages,
    region: PressedRegion,
}

impl ContactPatch {
    /// `radial` by `angular` Gauss-Legendre points.
    pub fn new(parameters: &Parameters, modes: &[PlateMode], radial: usize, angular: usize) -> Self {
        let (disc, pad) = (&parameters.disc, &parameters.pad);
        let odd_modes: Vec<&PlateMode> = modes.iter().filter(|mode| mode.nodal_diameters > 0).collect();
        let (even, odd) = (modes.len(), odd_modes.len());
        // With b as unit of length; the weights of the radius carry the r of r dr dtheta.
        let inner = pad.inner_radius / disc.outer_radius;
        let mut nodes = Vec::with_capacity(radial * angular);
        for (s, radial_weight) in gauss_legendre(radial) {
            let r = 0.5 * ((1.0 + inner) + (1.0 - inner) * s);
            let shapes: Vec<f64> = modes.iter().map(|mode| mode.shape(r)).collect();
            let odd_shapes: Vec<f64> = odd_modes.iter().map(|mode| mode.shape(r)).collect();
            for (t, angular_weight) in gauss_legendre(angular) {
                let theta = pad.half_angle * t;
                let angle = |mode: &PlateMode| f64::from(mode.nodal_diameters) * theta;
                let n = |mode: &PlateMode| f64::from(mode.nodal_diameters);
                let even_shapes = modes.iter().zip(&shapes).map(|(mode, shape)| shape * libm::cos(angle(mode)));
                let even_slopes =
                    modes.iter().zip(&shapes).map(|(mode, shape)| -n(mode) * shape * libm::sin(angle(mode)) / r);
                let odd = || odd_modes.iter().zip(&odd_shapes);
                let odd_values = odd().map(|(mode, shape)| shape * libm::sin(angle(mode)));
                let odd_slopes = odd().map(|(mode, shape)| n(mode) * shape * libm::cos(angle(mode)) / r);
                nodes.push(Node {
                    // The weights of the rules add up to 2 each; the mean radius is (1 + inner) / 2.
                    weight: radial_weight * angular_weight * r / (2.0 * (1.0 + inner)),
                    arc: r * theta / LENGTH_UNIT,
                    shapes: even_shapes.chain(odd_values).collect(),
                    slopes: even_slopes.chain(odd_slopes).map(|slope| slope * LENGTH_UNIT).collect(),
                });
            }
        }
        let averages = Averages::new(&nodes, even, odd);
        let extent = (inner, LENGTH_UNIT, pad.half_angle);
        let region = PressedRegion::new(modes, extent, radial + FURTHER_POINTS, angular + 1);
        Self { nodes, even, odd, averages, region }
    }

    /// Whether no node can have lifted off, by a bound that costs less than the nodes. False decides nothing.
    pub fn is_surely_whole(&self, pad: PadPosition, amplitudes: &[f64]) -> bool {
        self.averages.least_gap(-pad.normal, pad.tilt, amplitudes) > 0.0
    }

    /// The loads where part of the patch may have lifted off.
    pub fn loads_of_pressed_part(&self, pad: PadPosition, amplitudes: &[f64], loads: &mut ContactLoads) {
        self.clear(loads);
        let mut sums = LineSums::new(self, loads);
        if self.region.visit(pad, amplitudes, &mut sums) == Pressed::Whole {
            self.loads_by_node(pad, amplitudes, loads);
        }
    }

    fn clear(&self, loads: &mut ContactLoads) {
        let amplitudes = self.even + self.odd;
        loads.pressure = 0.0;
        loads.on_modes[..amplitudes].fill(0.0);
        loads.follower[..amplitudes].fill(0.0);
    }

    /// The loads node by node, all of which are in contact.
    fn loads_by_node(&self, pad: PadPosition, amplitudes: &[f64], loads: &mut ContactLoads) {
        for node in &self.nodes {
            let (gap, slope) = node.gap_and_slope(pad, amplitudes);
            let share = node.weight * gap;
            loads.pressure += share;
            for (k, shape) in node.shapes.iter().enumerate() {
                loads.on_modes[k] += share * shape;
                loads.follower[k] += share * shape * slope;
            }
        }
    }

    /// The loads while the whole patch is in contact.
    pub fn loads_of_whole_patch(&self, pad: PadPosition, amplitudes: &[f64], loads: &mut ContactLoads) {
        let averages = &self.averages;
        if !averages.has_products() {
            self.clear(loads);
            return self.loads_by_node(pad, amplitudes, loads);
        }
        let (a, b) = amplitudes.split_at(self.even);
        loads.pressure = averages.mean_gap(-pad.normal, amplitudes);
        for i in 0..self.even {
            let mut sum = -pad.normal * averages.shape[i];
            for (product, a) in averages.even_even[i * self.even..].iter().zip(a) {
                sum += product * a;
            }
            loads.on_modes[i] = sum;
            let mut factors = averages.even_follower[i].iter();
            let mut sum = 0.0;
            for a in a {
                for (b, factor) in b.iter().zip(&mut factors) {
                    sum += factor * (a * b);
                }
            }
            for (b, factor) in b.iter().zip(&mut factors) {
                sum += factor * (-pad.normal * b);
            }
            for (a, factor) in a.iter().zip(&mut factors) {
                sum += factor * (-pad.tilt * a);
            }
            loads.follower[i] = sum;
        }
        for j in 0..self.odd {
            let mut sum = -pad.tilt * averages.arc_shape[j];
            for (product, b) in averages.odd_odd[j * self.odd..].iter().zip(b) {
                sum += product * b;
            }
            loads.on_modes[self.even + j] = sum;
            let mut factors = averages.odd_follower[j].iter();
            let mut sum = 0.0;
            for amplitudes in [a, b] {
                for (first, amplitude) in amplitudes.iter().enumerate() {
                    for (other, factor) in amplitudes[first..].iter().zip(&mut factors) {
                        sum += factor * (amplitude * other);
                    }
                }
            }
            for (a, factor) in a.iter().zip(&mut factors) {
                sum += factor * (-pad.normal * a);
            }
            for (b, factor) in b.iter().zip(&mut factors) {
                sum += factor * (-pad.tilt * b);
            }
            loads.follower[self.even + j] = sum;
        }
    }

    /// Calls `visit` with every node in contact.
    pub fn for_each_contact(&self, pad: PadPosition, amplitudes: &[f64], mut visit: impl FnMut(&ContactNode<'_>)) {
        let surely_whole = self.is_surely_whole(pad, amplitudes);
        let mut nodes = AllShapes { patch: self, visit: &mut visit, shapes: Vec::new(), slopes: Vec::new() };
        if surely_whole || self.region.visit(pad, amplitudes, &mut nodes) == Pressed::Whole {
            for node in &self.nodes {
                let (gap, slope) = node.gap_and_slope(pad, amplitudes);
                let Node { weight, arc, .. } = *node;
                visit(&ContactNode { weight, gap, slope, arc, shapes: &node.shapes, slopes: &node.slopes });
            }
        }
    }

    /// The share of the patch that is in contact.
    pub fn contact_share(&self, pad: PadPosition, amplitudes: &[f64]) -> f64 {
        let mut share = 0.0;
        self.for_each_contact(pad, amplitudes, |node| share += node.weight);
        share
    }
}

/// Sums the loads of a line by harmonics before the radial shapes come in.
struct LineSums<'a> {
    patch: &'a ContactPatch,
    loads: &'a mut ContactLoads,
    harmonics: [HarmonicLoads; MOST_HARMONICS],
}

/// Load and follower load on the cosine and the sine of one harmonic.
#[derive(Debug, Clone, Copy, Default)]
struct HarmonicLoads {
    cosine: f64,
    sine: f64,
    follower_cosine: f64,
    follower_sine: f64,
}

impl<'a> LineSums<'a> {
    fn new(patch: &'a ContactPatch, loads: &'a mut ContactLoads) -> Self {
        Self { patch, loads, harmonics: [HarmonicLoads::default(); MOST_HARMONICS] }
    }
}

impl Visitor for LineSums<'_> {
    fn node(&mut self, node: &PressedNode<'_>, _: &Radius) {
        let share = node.weight * node.gap;
        let follower = share * node.slope;
        self.loads.pressure += share;
        for (sums, (cosine, sine)) in self.harmonics.iter_mut().zip(node.waves) {
            sums.cosine += share * cosine;
            sums.sine += share * sine;
            sums.follower_cosine += follower * cosine;
            sums.follower_sine += follower * sine;
        }
    }

    fn end_of_line(&mut self, radius: &Radius) {
        let region = &self.patch.region;
        let evens = region.harmonics.iter().zip(&radius.shapes);
        for ((n, shape), k) in evens.zip(0..) {
            self.loads.on_modes[k] += shape * self.harmonics[*n].cosine;
            self.loads.follower[k] += shape * self.harmonics[*n].follower_cosine;
        }
        for (&mode, k) in region.odd_modes.iter().zip(self.patch.even..) {
            let (shape, sums) = (radius.shapes[mode], &self.harmonics[region.harmonics[mode]]);
            self.loads.on_modes[k] += shape * sums.sine;
            self.loads.follower[k] += shape * sums.follower_sine;
        }
        self.harmonics[..region.harmonic_count].fill(HarmonicLoads::default());
    }
}

/// Hands on every node with the shapes of all amplitudes.
struct AllShapes<'a, F> {
    patch: &'a ContactPatch,
    visit: &'a mut F,
    shapes: Vec<f64>,
    slopes: Vec<f64>,
}

impl<F: FnMut(&ContactNode<'_>)> Visitor for AllShapes<'_, F> {
    fn node(&mut self, node: &PressedNode<'_>, radius: &Radius) {
        let region = &self.patch.region;
        self.shapes.clear();
        self.slopes.clear();
        let by_angle = |mode: usize, derivative: f64| {
            let n = region.harmonics[mode] as f64;
            n * radius.shapes[mode] * derivative * region.length_unit / radius.r
        };
        for (mode, &n) in region.harmonics.iter().enumerate() {
            let (cosine, sine) = node.waves[n];
            self.shapes.push(radius.shapes[mode] * cosine);
            self.slopes.push(by_angle(mode, -sine));
        }
        for &mode in &region.odd_modes {
            let (cosine, sine) = node.waves[region.harmonics[mode]];
            self.shapes.push(radius.shapes[mode] * sine);
            self.slopes.push(by_angle(mode, cosine));
        }
        let PressedNode { weight, gap, slope, arc, .. } = *node;
        (self.visit)(&ContactNode { weight, gap, slope, arc, shapes: &self.shapes, slopes: &self.slopes });
    }

    fn end_of_line(&mut self, _: &Radius) {}
}

#[cfg(test)]
mod tests;
