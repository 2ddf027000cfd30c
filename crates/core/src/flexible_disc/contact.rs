//! The patch where pad and disc touch: its quadrature, and what the pressure does to the disc's modes.
//!
//! The gap (positive where the surfaces press into each other) and the loads that follow from it are averages over the
//! patch `r_a < r < b`, `|theta| < psi`, lengths scaled by h:
//!
//! ```text
//! g = w - y - r theta tan(phi),  g+ = max(g, 0),      <f> = integral of f dA / A_s
//! pressure  <g+>,      on mode k  <psi_k g+>,      of the follower friction on mode k  <psi_k g+ w_theta / r>
//! ```
//!
//! While the whole patch is certainly in contact they come from averages of products of mode shapes, taken once with a few
//! Gauss nodes; where that is not certain, from the pressed region ([`crate::flexible_disc::partial_contact`]), and if that is the whole
//! patch after all, node by node. The sums over whole patches are the same sum in
//! another order. Mode shapes are even (cosine) or odd (sine) in theta, and so is each average: half of the products
//! vanish and are left out.

use crate::flexible_disc::partial_contact::{MOST_HARMONICS, Pressed, PressedNode, PressedRegion, Radius, Visitor};
use crate::flexible_disc::plate_modes::{MOST_DISC_MODES, PlateMode, gauss_legendre};
use crate::parameters::Parameters;

/// Gauss-Legendre points of the patch along the radius and along the angle, at the least.
pub(crate) const RADIAL_POINTS: usize = 4;
pub(crate) const ANGULAR_POINTS: usize = 8;

/// What the rule may miss of a product of three shapes (two and a slope, as in the follower load), relative to the cube of
/// their size. Products of two shapes are better by far. The 4 x 8 points of the preset with five modes miss 5e-6.
const PRODUCT_TOLERANCE: f64 = 1e-5;

/// Points at the most; beyond them the modes are finer than anything that the plate model describes.
const MOST_POINTS: usize = 96;

/// What a partly lifted patch has more, on each piece and between two cuts of the radius: where pieces part and join, the
/// integrand is smooth but no longer a product of shapes.
const FURTHER_POINTS: usize = 4;

/// Points along the radius and along the angle that integrate products of these modes over the patch.
pub(crate) fn sufficient_points(parameters: &Parameters, modes: &[PlateMode]) -> (usize, usize) {
    let inner = parameters.pad.inner_radius / parameters.disc.outer_radius;
    let mean = |points: usize, mode: &PlateMode| {
        let (mut square, mut product) = (0.0, 0.0);
        for (s, weight) in gauss_legendre(points) {
            let r = 0.5 * ((1.0 + inner) + (1.0 - inner) * s);
            let shape = mode.shape(r);
            square += weight * r * shape * shape / (1.0 + inner);
            product += weight * shape * shape * shape / (1.0 + inner);
        }
        (square, product)
    };
    let radial_suffice = |points: usize| {
        modes.iter().all(|mode| {
            let ((_, product), (square, exact)) = (mean(points, mode), mean(2 * points, mode));
            (product - exact).abs() <= PRODUCT_TOLERANCE * square * square.sqrt()
        })
    };
    // The shortest wave of such a product.
    let most_diameters = modes.iter().map(|mode| mode.nodal_diameters).max().unwrap_or(0);
    let phase = 3.0 * f64::from(most_diameters) * parameters.pad.half_angle;
    let angular_suffice = |points: usize| {
        let mean: f64 = gauss_legendre(points).iter().map(|(x, weight)| 0.5 * weight * libm::cos(phase * x)).sum();
        phase == 0.0 || (mean - libm::sin(phase) / phase).abs() <= PRODUCT_TOLERANCE
    };
    let first = |from: usize, suffice: &dyn Fn(usize) -> bool| {
        (from..MOST_POINTS).find(|&points| suffice(points)).unwrap_or(MOST_POINTS)
    };
    // Fewer than two points for a wave length may seem to suffice by chance.
    let waves = (phase / std::f64::consts::PI).ceil() as usize;
    (first(RADIAL_POINTS, &radial_suffice), first(ANGULAR_POINTS.max(2 * waves), &angular_suffice))
}

/// The pad's motion as far as the gap is concerned.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PadPosition {
    /// y.
    pub normal: f64,
    /// tan(phi).
    pub tilt: f64,
}

/// One quadrature point.
#[derive(Debug, Clone)]
struct Node {
    /// Share of the patch's area.
    weight: f64,
    /// r theta.
    arc: f64,
    /// psi_k of every amplitude, even ones first.
    shapes: Vec<f64>,
    /// (1/r) d psi_k / d theta.
    slopes: Vec<f64>,
}

/// A node in contact, with what is known there.
pub(crate) struct ContactNode<'a> {
    /// Share of the patch's area.
    pub weight: f64,
    /// g.
    pub gap: f64,
    /// w_theta / r.
    pub slope: f64,
    /// r theta.
    pub arc: f64,
    /// psi_k of every amplitude.
    pub shapes: &'a [f64],
    /// (1/r) d psi_k / d theta.
    pub slopes: &'a [f64],
}

/// The patch with the shapes of the disc's amplitudes on it.
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

/// Averages over the patch of products of mode shapes; even amplitudes are `i`, odd ones `j`.
#[derive(Debug, Clone)]
pub(crate) struct Averages {
    /// `<psi_i>`.
    pub shape: Vec<f64>,
    /// `<psi_j r theta>`.
    pub arc_shape: Vec<f64>,
    /// `<psi_i psi_i'>`, `even` by `even`.
    pub even_even: Vec<f64>,
    /// `<psi_j psi_j'>`, `odd` by `odd`.
    pub odd_odd: Vec<f64>,
    /// For each even amplitude the factors of its follower load: of the products `a_i a_j` (`even` by `odd`), of `-y a_j`,
    /// and of `-tan(phi) a_i`.
    pub even_follower: Vec<Vec<f64>>,
    /// For each odd amplitude: of `a_i a_i'` and `a_j a_j'` (second index not below the first), of `-y a_i`, and of
    /// `-tan(phi) a_j`.
    pub odd_follower: Vec<Vec<f64>>,
    /// Largest `|psi_k|` and `|r theta|` on the nodes.
    pub largest_shape: Vec<f64>,
    pub largest_arc: f64,
}

/// Amplitudes at the most: a cosine and a sine for every mode.
pub(crate) const MOST_AMPLITUDES: usize = 2 * MOST_DISC_MODES;

/// The loads of the contact, before they are multiplied by stiffness and friction.
#[derive(Debug, Clone)]
pub(crate) struct ContactLoads {
    /// `<g+>`.
    pub pressure: f64,
    /// `<psi_k g+>`.
    pub on_modes: [f64; MOST_AMPLITUDES],
    /// `<psi_k g+ w_theta / r>`.
    pub follower: [f64; MOST_AMPLITUDES],
}

impl ContactLoads {
    pub fn zero() -> Self {
        Self { pressure: 0.0, on_modes: [0.0; MOST_AMPLITUDES], follower: [0.0; MOST_AMPLITUDES] }
    }
}

impl ContactPatch {
    /// `radial` by `angular` Gauss-Legendre points.
    pub fn new(parameters: &Parameters, modes: &[PlateMode], radial: usize, angular: usize) -> Self {
        let (disc, pad) = (&parameters.disc, &parameters.pad);
        let odd_modes: Vec<&PlateMode> = modes.iter().filter(|mode| mode.nodal_diameters > 0).collect();
        let (even, odd) = (modes.len(), odd_modes.len());
        // With b as unit of length; the weights of the radius carry the r of r dr dtheta.
        let inner = pad.inner_radius / disc.outer_radius;
        let thickness = disc.thickness / disc.outer_radius;
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
                    arc: r * theta / thickness,
                    shapes: even_shapes.chain(odd_values).collect(),
                    // Slopes are by lengths over h as well.
                    slopes: even_slopes.chain(odd_slopes).map(|slope| slope * thickness).collect(),
                });
            }
        }
        let averages = Averages::new(&nodes, even, odd);
        let extent = (inner, thickness, pad.half_angle);
        let region = PressedRegion::new(modes, extent, radial + FURTHER_POINTS, angular + 1);
        Self { nodes, even, odd, averages, region }
    }

    /// Whether no node can have lifted off, by a bound that costs less than the nodes. False says nothing.
    pub fn is_surely_whole(&self, pad: PadPosition, amplitudes: &[f64]) -> bool {
        let averages = &self.averages;
        let mut margin = -pad.normal - averages.largest_arc * pad.tilt.abs();
        for (amplitude, largest) in amplitudes.iter().zip(&averages.largest_shape) {
            margin -= largest * amplitude.abs();
        }
        margin > 0.0
    }

    /// The loads where part of the patch may have lifted off.
    pub fn loads_of_pressed_part(&self, pad: PadPosition, amplitudes: &[f64], loads: &mut ContactLoads) {
        loads.pressure = 0.0;
        loads.on_modes.fill(0.0);
        loads.follower.fill(0.0);
        let mut sums = LineSums::new(self, loads);
        if self.region.visit(pad, amplitudes, &mut sums) == Pressed::Whole {
            self.loads_by_node(pad, amplitudes, loads);
        }
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
        let (a, b) = amplitudes.split_at(self.even);
        loads.pressure = -pad.normal;
        for (shape, a) in averages.shape.iter().zip(a) {
            loads.pressure += shape * a;
        }
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

impl Node {
    fn gap_and_slope(&self, pad: PadPosition, amplitudes: &[f64]) -> (f64, f64) {
        let (mut gap, mut slope) = (-pad.normal - self.arc * pad.tilt, 0.0);
        for ((amplitude, shape), shape_slope) in amplitudes.iter().zip(&self.shapes).zip(&self.slopes) {
            gap += amplitude * shape;
            slope += amplitude * shape_slope;
        }
        (gap, slope)
    }
}

/// Sums the loads of a line by harmonics before the radial shapes come in.
struct LineSums<'a> {
    patch: &'a ContactPatch,
    loads: &'a mut ContactLoads,
    /// For cosine and sine of every harmonic: the load, and the follower load.
    harmonics: [[f64; 4]; MOST_HARMONICS],
}

impl<'a> LineSums<'a> {
    fn new(patch: &'a ContactPatch, loads: &'a mut ContactLoads) -> Self {
        Self { patch, loads, harmonics: [[0.0; 4]; MOST_HARMONICS] }
    }
}

impl Visitor for LineSums<'_> {
    fn node(&mut self, node: &PressedNode<'_>, _: &Radius) {
        let share = node.weight * node.gap;
        let follower = share * node.slope;
        self.loads.pressure += share;
        for (sums, (cosine, sine)) in self.harmonics.iter_mut().zip(node.waves) {
            sums[0] += share * cosine;
            sums[1] += share * sine;
            sums[2] += follower * cosine;
            sums[3] += follower * sine;
        }
    }

    fn end_of_line(&mut self, radius: &Radius) {
        let region = &self.patch.region;
        let evens = region.harmonics.iter().zip(&radius.shapes);
        for ((n, shape), k) in evens.zip(0..) {
            self.loads.on_modes[k] += shape * self.harmonics[*n][0];
            self.loads.follower[k] += shape * self.harmonics[*n][2];
        }
        for (&mode, k) in region.odd_modes.iter().zip(self.patch.even..) {
            let (shape, sums) = (radius.shapes[mode], &self.harmonics[region.harmonics[mode]]);
            self.loads.on_modes[k] += shape * sums[1];
            self.loads.follower[k] += shape * sums[3];
        }
        self.harmonics = [[0.0; 4]; MOST_HARMONICS];
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
            n * radius.shapes[mode] * derivative * region.thickness / radius.r
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

impl Averages {
    fn new(nodes: &[Node], even: usize, odd: usize) -> Self {
        let average = |value: &dyn Fn(&Node) -> f64| nodes.iter().map(|node| node.weight * value(node)).sum::<f64>();
        let (evens, odds) = (0..even, even..even + odd);
        let products = |range: std::ops::Range<usize>| -> Vec<f64> {
            let pairs = range.clone().flat_map(|k| range.clone().map(move |l| (k, l)));
            pairs.map(|(k, l)| average(&|node| node.shapes[k] * node.shapes[l])).collect()
        };
        // Of `a_l a_m`, from both orders of g and w_theta; of the square of one amplitude once.
        let quadratic = |k: usize, l: usize, m: usize| {
            let once = average(&|node| node.shapes[k] * node.shapes[l] * node.slopes[m]);
            let other = average(&|node| node.shapes[k] * node.shapes[m] * node.slopes[l]);
            if l == m { once } else { once + other }
        };
        let by_normal = |k: usize, m: usize| average(&|node| node.shapes[k] * node.slopes[m]);
        let by_tilt = |k: usize, m: usize| average(&|node| node.shapes[k] * node.arc * node.slopes[m]);
        let even_follower = |k: usize| -> Vec<f64> {
            let mixed = evens.clone().flat_map(|i| odds.clone().map(move |j| (i, j)));
            let mixed = mixed.map(|(i, j)| quadratic(k, i, j));
            mixed.chain(odds.clone().map(|j| by_normal(k, j))).chain(evens.clone().map(|i| by_tilt(k, i))).collect()
        };
        let odd_follower = |k: usize| -> Vec<f64> {
            let pairs = |range: std::ops::Range<usize>| {
                let end = range.end;
                range.flat_map(move |l| (l..end).map(move |m| (l, m)))
            };
            let same = pairs(evens.clone()).chain(pairs(odds.clone())).map(|(l, m)| quadratic(k, l, m));
            same.chain(evens.clone().map(|i| by_normal(k, i))).chain(odds.clone().map(|j| by_tilt(k, j))).collect()
        };
        let largest = |value: &dyn Fn(&Node) -> f64| nodes.iter().map(|node| value(node).abs()).fold(0.0, f64::max);
        Self {
            shape: evens.clone().map(|i| average(&|node| node.shapes[i])).collect(),
            arc_shape: odds.clone().map(|j| average(&|node| node.shapes[j] * node.arc)).collect(),
            even_even: products(evens.clone()),
            odd_odd: products(odds.clone()),
            even_follower: evens.clone().map(even_follower).collect(),
            odd_follower: odds.clone().map(odd_follower).collect(),
            largest_shape: (0..even + odd).map(|k| largest(&|node| node.shapes[k])).collect(),
            largest_arc: largest(&|node| node.arc),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rigid_disc::pad_on_disc::{PadOnDisc, uniform_draws};

    fn patch(radial: usize, angular: usize) -> ContactPatch {
        let brake = PadOnDisc::preset_with(&[]);
        let plate = brake.annular_plate();
        let modes: Vec<PlateMode> = (0..5).flat_map(|n| plate.modes(n, 1).unwrap()).collect();
        ContactPatch::new(brake.parameters(), &modes, radial, angular)
    }

    /// Amplitudes of either sign and of the size that a limit cycle has, from a simple generator.
    fn amplitudes(seed: u64, scale: f64) -> Vec<f64> {
        let mut draw = uniform_draws(seed);
        (0..9).map(|_| scale * (draw() - 0.5)).collect()
    }

    #[test]
    fn the_fast_path_gives_the_numbers_of_the_nodes() {
        let patch = patch(RADIAL_POINTS, ANGULAR_POINTS);
        for seed in 1..200 {
            let amplitudes = amplitudes(seed, 2e-3);
            let pad = PadPosition { normal: -0.046, tilt: 1e-3 * (seed as f64 / 100.0 - 1.0) };
            assert!(patch.is_surely_whole(pad, &amplitudes));
            let [mut whole, mut by_node] = [ContactLoads::zero(), ContactLoads::zero()];
            patch.loads_of_whole_patch(pad, &amplitudes, &mut whole);
            patch.loads_by_node(pad, &amplitudes, &mut by_node);
            assert!((whole.pressure / by_node.pressure - 1.0).abs() < 1e-14);
            for k in 0..9 {
                // Relative to the loads on the strongest mode; single averages may nearly vanish.
                assert!((whole.on_modes[k] - by_node.on_modes[k]).abs() < 1e-15, "{k}");
                assert!((whole.follower[k] - by_node.follower[k]).abs() < 1e-17, "{k}");
            }
            assert!(by_node.follower.iter().any(|load| load.abs() > 1e-6), "the follower load is there to be compared");
        }
    }

    #[test]
    fn the_bound_never_claims_contact_that_is_lost() {
        let patch = patch(RADIAL_POINTS, ANGULAR_POINTS);
        let (mut claimed, mut lost) = (0, 0);
        for seed in 1..3000 {
            let amplitudes = amplitudes(seed, 0.005);
            let pad = PadPosition { normal: -0.02, tilt: 2e-3 * ((seed % 7) as f64 / 3.0 - 1.0) };
            let whole = patch.contact_share(pad, &amplitudes) > 1.0 - 1e-12;
            let sure = patch.is_surely_whole(pad, &amplitudes);
            assert!(whole || !sure);
            claimed += u32::from(sure);
            lost += u32::from(!whole);
        }
        assert!(claimed > 20 && lost > 20, "{claimed} {lost}: both must occur for the test to mean something");
    }

    #[test]
    fn twice_the_nodes_change_nothing_while_the_patch_is_whole() {
        let (coarse, fine) = (patch(RADIAL_POINTS, ANGULAR_POINTS), patch(2 * RADIAL_POINTS, 2 * ANGULAR_POINTS));
        for seed in 1..50 {
            let amplitudes = amplitudes(seed, 2e-3);
            let pad = PadPosition { normal: -0.046, tilt: 1e-3 };
            let [mut a, mut b] = [ContactLoads::zero(), ContactLoads::zero()];
            coarse.loads_by_node(pad, &amplitudes, &mut a);
            fine.loads_by_node(pad, &amplitudes, &mut b);
            assert!((a.pressure / b.pressure - 1.0).abs() < 1e-8);
            for k in 0..9 {
                assert!((a.on_modes[k] - b.on_modes[k]).abs() < 1e-8, "{k} {} {}", a.on_modes[k], b.on_modes[k]);
                assert!((a.follower[k] - b.follower[k]).abs() < 1e-9, "{k} {} {}", a.follower[k], b.follower[k]);
            }
        }
    }

    #[test]
    fn the_weights_are_shares_of_the_area() {
        let patch = patch(RADIAL_POINTS, ANGULAR_POINTS);
        let total: f64 = patch.nodes.iter().map(|node| node.weight).sum();
        assert!((total - 1.0).abs() < 1e-14, "{total}");
        assert_eq!(patch.contact_share(PadPosition { normal: 1.0, tilt: 0.0 }, &[0.0; 9]), 0.0);
    }
}
