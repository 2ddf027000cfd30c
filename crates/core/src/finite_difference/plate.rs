//! The disc as a polar grid: central differences of the annular plate, clamped at r = a and free at r = b.
//!
//! Rings of nodes lie at `r_i = a + i dr`, i = 1 .. `rings`, the last of them on the edge; each has `columns` nodes,
//! evenly spaced by `dtheta`. Lengths are scaled by h. With `d` for the second difference along a ring, over
//! `dtheta^2`, two passes of
//!
//! ```text
//! (nabla^2 f)_i = [ r_+ (f_i+1 - f_i) - r_- (f_i - f_i-1) ] / (r_i dr^2) + d f_i / r_i^2,      r_+- = r_i +- dr / 2
//! ```
//!
//! give nabla^4 w. Beyond the rims lie ghost nodes of w and of `L = nabla^2 w`. Clamped (the paper's 3.1), `w_0 = 0`
//! and `w_-1 = w_1`. At the free edge the slope is the mean of the slopes on both sides, and the ghosts follow from
//! bending moment (3.2) and shear force (3.3):
//!
//! ```text
//! f_r = [ r_+ (f_+ - f) + r_- (f - f_-) ] / (2 b dr)
//! L - (1 - nu) (w_r / b + d w / b^2) = 0,      L_r + (1 - nu) d (w_r - w / b) / b^2 = 0
//! ```
//!
//! Weighting the slopes with `r_+-` costs nothing in order, and it makes the operator symmetric under the areas of the
//! nodes, `r_i dr dtheta` and half of that on the edge: its squared frequencies are real. All ghosts are eliminated
//! beforehand, which leaves thirteen points around each node.

use nalgebra::{DMatrix, DVector, SymmetricEigen};

use crate::numerics::eigenvalues::EigenvalueError;

/// Nodes repeated on either side of a ring, so that stencils need not wrap around.
const HALO: usize = 2;

/// Rings of zeros inside and outside of the plate, so that stencils need not end.
const MARGIN: usize = 2;

/// A number for each power of the second difference along a ring: `c[0] + c[1] d + c[2] d^2`.
type AlongRing = [f64; 3];

/// `(1/h) nabla^4` for the nodes of one ring: factors of the rings from two inside to two outside of it.
type RingOperator = [AlongRing; 5];

/// The plate on its grid.
#[derive(Debug, Clone)]
pub(crate) struct PlateGrid {
    /// Rings that move, `1 ..= rings`; the last is the edge.
    pub rings: usize,
    /// Nodes along each of them, even.
    pub columns: usize,
    /// a / h.
    pub inner: f64,
    /// b / h.
    pub outer: f64,
    /// dr.
    pub spacing: f64,
    /// dtheta.
    pub angle: f64,
    operators: Vec<RingOperator>,
}

/// Deflections and speeds of the nodes.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct PlateMotion {
    /// w, ring by ring with halo and margin.
    deflections: Vec<f64>,
    /// W_t in the disc's frame, half a step behind.
    speeds: Vec<f64>,
}

/// What explicit steps of a certain length multiply with.
#[derive(Debug, Clone)]
pub(crate) struct ExplicitStep {
    length: f64,
    /// The share of the speed that damping leaves, and the speed that one unit of force brings.
    keep: f64,
    gain: f64,
    /// `eta1 Om / (2 dtheta)` times the gain.
    drag: f64,
    stencils: Vec<Stencil>,
}

/// The thirteen factors for the nodes of one ring, those that are equal once.
#[derive(Debug, Clone, Copy)]
struct Stencil {
    own: [f64; 3],
    inside: [f64; 2],
    outside: [f64; 2],
    far_inside: f64,
    far_outside: f64,
}

fn sum(a: AlongRing, b: AlongRing) -> AlongRing {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

fn scaled(factor: f64, a: AlongRing) -> AlongRing {
    a.map(|a| factor * a)
}

fn difference(a: AlongRing, b: AlongRing) -> AlongRing {
    sum(a, scaled(-1.0, b))
}

/// The second difference along the ring. What it is applied to contains at most the first power.
fn along(a: AlongRing) -> AlongRing {
    debug_assert_eq!(a[2], 0.0);
    [0.0, a[0], a[1]]
}

impl PlateGrid {
    /// `inner` and `outer` radius and `thickness` as the equations have them: radii over h, h in m.
    pub fn new(rings: usize, columns: usize, radii: (f64, f64), thickness: f64, poissons_ratio: f64) -> Self {
        let (inner, outer) = radii;
        let mut grid = Self {
            rings,
            columns,
            inner,
            outer,
            spacing: (outer - inner) / rings as f64,
            angle: std::f64::consts::TAU / columns as f64,
            operators: vec![[[0.0; 3]; 5]; rings],
        };
        for moved in 1..=rings {
            let result = grid.biharmonic_of_ring(moved, poissons_ratio);
            let rings_around = grid.operators.iter_mut().zip(&result[1..]).zip(1..);
            for ((operator, felt), ring) in rings_around.filter(|(_, ring)| moved.abs_diff(*ring) <= 2) {
                operator[moved + 2 - ring] = scaled(1.0 / thickness, *felt);
            }
        }
        grid
    }

    /// r of a ring over h.
    pub fn radius(&self, ring: usize) -> f64 {
        self.inner + ring as f64 * self.spacing
    }

    /// Area that belongs to a node of a ring, over h^2.
    pub fn area(&self, ring: usize) -> f64 {
        let whole = self.radius(ring) * self.spacing * self.angle;
        if ring == self.rings { 0.5 * whole } else { whole }
    }

    /// nabla^4 of a deflection that is 1 on one ring and 0 on all others, on every ring; the rim comes first, with 0.
    fn biharmonic_of_ring(&self, moved: usize, poissons_ratio: f64) -> Vec<AlongRing> {
        let (edge, dr, b) = (self.rings, self.spacing, self.outer);
        let free = 1.0 - poissons_ratio;
        let outside = |ring: usize| self.radius(ring) + 0.5 * dr;
        let inside = |ring: usize| self.radius(ring) - 0.5 * dr;
        let laplacian = |f: &[AlongRing], ring: usize| {
            let flows = difference(
                scaled(outside(ring), difference(f[ring + 1], f[ring])),
                scaled(inside(ring), difference(f[ring], f[ring - 1])),
            );
            let r = self.radius(ring);
            sum(scaled(1.0 / (r * dr * dr), flows), scaled(1.0 / (r * r), along(f[ring])))
        };
        let mut w = vec![[0.0; 3]; edge + 1];
        w[moved] = [1.0, 0.0, 0.0];
        let mut l = vec![scaled(2.0 / (dr * dr), w[1])];
        l.extend((1..edge).map(|ring| laplacian(&w, ring)));
        // The bending moment gives r_+ (w_+ - w), and with it the edge's own L and slope; b w_r below.
        let flow_in = scaled(inside(edge), difference(w[edge], w[edge - 1]));
        let (of_laplacian, of_slope) = (1.0 / (b * dr * dr), free / (2.0 * b * b * dr));
        let bent = scaled(poissons_ratio / (b * b), along(w[edge]));
        let flow_out =
            scaled(1.0 / (of_laplacian - of_slope), difference(scaled(of_laplacian + of_slope, flow_in), bent));
        let slope = scaled(0.5 / dr, sum(flow_out, flow_in));
        l.push(scaled(free / (b * b), sum(slope, along(w[edge]))));
        // The shear force gives r_+ (L_+ - L).
        let shear = scaled(-free / (b * b), along(difference(slope, w[edge])));
        let flow_in = scaled(inside(edge), difference(l[edge], l[edge - 1]));
        let flow_out = difference(scaled(2.0 * dr, shear), flow_in);
        let mut result = vec![[0.0; 3]];
        result.extend((1..edge).map(|ring| laplacian(&l, ring)));
        result.push(sum(scaled(of_laplacian, difference(flow_out, flow_in)), scaled(1.0 / (b * b), along(l[edge]))));
        result
    }

    /// `-d` for motions with `nodal_diameters`.
    fn wave_number_squared(&self, nodal_diameters: usize) -> f64 {
        let root = 2.0 / self.angle * libm::sin(0.5 * nodal_diameters as f64 * self.angle);
        root * root
    }

    /// `(1/h) nabla^4` for deflections with `nodal_diameters`, ring by ring.
    fn radial_operator(&self, nodal_diameters: usize) -> DMatrix<f64> {
        let d = -self.wave_number_squared(nodal_diameters);
        let mut matrix = DMatrix::zeros(self.rings, self.rings);
        for (row, operator) in self.operators.iter().enumerate() {
            for (offset, [constant, first, second]) in operator.iter().enumerate() {
                if let Some(column) = (row + offset).checked_sub(2).filter(|column| *column < self.rings) {
                    matrix[(row, column)] = constant + d * (first + d * second);
                }
            }
        }
        matrix
    }

    /// The squared frequencies of all motions with `nodal_diameters`, in ascending order.
    pub fn squared_frequencies(&self, nodal_diameters: usize) -> Result<Vec<f64>, EigenvalueError> {
        let mut matrix = self.radial_operator(nodal_diameters);
        for row in 0..self.rings {
            for column in 0..self.rings {
                matrix[(row, column)] *= (self.area(row + 1) / self.area(column + 1)).sqrt();
            }
        }
        let symmetric = (&matrix + matrix.transpose()) * 0.5;
        let sweeps = 1000 * self.rings;
        let eigen =
            SymmetricEigen::try_new(symmetric, f64::EPSILON, sweeps).ok_or(EigenvalueError::NotConverged { sweeps })?;
        let mut values: Vec<f64> = eigen.eigenvalues.iter().copied().collect();
        values.sort_by(f64::total_cmp);
        Ok(values)
    }

    /// No squared frequency is above this (Gershgorin's circles).
    pub fn largest_squared_frequency(&self) -> f64 {
        let row = |ring: usize| {
            let Stencil { own, inside, outside, far_inside, far_outside } = self.stencil(ring, 1.0);
            let double = |next: f64| 2.0 * next.abs();
            let beside = [inside, outside].map(|[middle, next]| middle.abs() + double(next));
            own[0].abs()
                + double(own[1])
                + double(own[2])
                + beside[0]
                + beside[1]
                + far_inside.abs()
                + far_outside.abs()
        };
        (1..=self.rings).map(row).fold(0.0, f64::max)
    }

    fn stencil(&self, ring: usize, factor: f64) -> Stencil {
        let first = factor / (self.angle * self.angle);
        let second = first / (self.angle * self.angle);
        let middle = |c: &AlongRing| factor * c[0] - 2.0 * first * c[1] + 6.0 * second * c[2];
        let next = |c: &AlongRing| first * c[1] - 4.0 * second * c[2];
        let [far_inside, inside, own, outside, far_outside] = &self.operators[ring - 1];
        Stencil {
            own: [middle(own), next(own), second * own[2]],
            inside: [middle(inside), next(inside)],
            outside: [middle(outside), next(outside)],
            far_inside: middle(far_inside),
            far_outside: middle(far_outside),
        }
    }

    /// The deflection that stands still in a frame in which the disc turns with `spin`,
    /// `(1/h) nabla^4 w + spin^2 w_theta_theta = load`; ring by ring, like the load. `None` at speeds at which a wave
    /// of the disc stands still without any load.
    pub fn steady_deflection(&self, spin: f64, load: &[f64]) -> Option<Vec<f64>> {
        let columns = self.columns;
        let cosines: Vec<f64> = (0..columns).map(|j| libm::cos(j as f64 * self.angle)).collect();
        let quarter_behind = |j: usize| libm::sin(j as f64 * self.angle);
        let sines: Vec<f64> = (0..columns).map(quarter_behind).collect();
        let mut deflection = vec![0.0; self.rings * columns];
        // Fourier's series of the load, ring by ring; the plate couples the rings of each term.
        for n in 0..=columns / 2 {
            let mut matrix = self.radial_operator(n);
            let softening = spin * spin * self.wave_number_squared(n);
            for ring in 0..self.rings {
                matrix[(ring, ring)] -= softening;
            }
            let factors = matrix.lu();
            let twice = if n == 0 || n == columns / 2 { 1.0 } else { 2.0 };
            for shape in [&cosines, &sines] {
                let term = |ring: usize, _| {
                    let ring = &load[ring * columns..(ring + 1) * columns];
                    let sum: f64 = ring.iter().enumerate().map(|(j, load)| load * shape[j * n % columns]).sum();
                    twice / columns as f64 * sum
                };
                let amplitudes = factors.solve(&DVector::from_fn(self.rings, term))?;
                for (ring, amplitude) in deflection.chunks_exact_mut(columns).zip(amplitudes.iter()) {
                    for (j, w) in ring.iter_mut().enumerate() {
                        *w += amplitude * shape[j * n % columns];
                    }
                }
            }
        }
        Some(deflection)
    }

    fn stride(&self) -> usize {
        self.columns + 2 * HALO
    }

    /// Where a ring, 1 to the edge, begins among the deflections, less its halo.
    fn begin(&self, ring: usize) -> usize {
        (ring - 1 + MARGIN) * self.stride()
    }

    /// The plate at rest with `deflection` (ring by ring).
    pub fn at_rest(&self, deflection: &[f64]) -> PlateMotion {
        let deflections = vec![0.0; (self.rings + 2 * MARGIN) * self.stride()];
        let mut motion = PlateMotion { deflections, speeds: vec![0.0; deflection.len()] };
        for (ring, row) in deflection.chunks_exact(self.columns).enumerate() {
            let begin = self.begin(ring + 1) + HALO;
            motion.deflections[begin..begin + self.columns].copy_from_slice(row);
        }
        self.repeat_ends(&mut motion);
        motion
    }

    /// The plate with a deflection that stands still in the frame in which the disc turns with `spin`; speeds half a
    /// step of `length` behind.
    pub fn standing_still(&self, deflection: &[f64], spin: f64, length: f64) -> PlateMotion {
        let mut motion = self.at_rest(deflection);
        for ring in 1..=self.rings {
            for column in 0..self.columns {
                let at = self.begin(ring) + HALO + column;
                let [behind, own, ahead] =
                    [-1, 0, 1].map(|next: isize| motion.deflections[at.wrapping_add_signed(next)]);
                let speed = spin * (ahead - behind) / (2.0 * self.angle);
                let acceleration = spin * spin * (ahead - 2.0 * own + behind) / (self.angle * self.angle);
                motion.speeds[(ring - 1) * self.columns + column] = speed - 0.5 * length * acceleration;
            }
        }
        motion
    }

    fn repeat_ends(&self, motion: &mut PlateMotion) {
        for row in motion.deflections.chunks_exact_mut(self.stride()) {
            row.copy_within(self.columns..self.columns + HALO, 0);
            row.copy_within(HALO..2 * HALO, self.columns + HALO);
        }
    }

    /// Deflections of the four nodes from the one before `column` on, on a ring; all zero on the clamped rim, ring 0.
    pub fn four_nodes(&self, motion: &PlateMotion, ring: usize, column: usize) -> [f64; 4] {
        let at = (ring + MARGIN - 1) * self.stride() + HALO + column;
        [motion.deflections[at - 1], motion.deflections[at], motion.deflections[at + 1], motion.deflections[at + 2]]
    }

    /// Explicit steps of `length` with the damping `eta1 (W_t - Om W_theta)`, that of the space-fixed frame in which
    /// the disc turns with `spin`.
    pub fn explicit_step(&self, length: f64, damping: f64, spin: f64) -> ExplicitStep {
        let loss = 0.5 * damping * length;
        let gain = length / (1.0 + loss);
        ExplicitStep {
            length,
            keep: (1.0 - loss) / (1.0 + loss),
            gain,
            drag: gain * damping * spin / (2.0 * self.angle),
            stencils: (1..=self.rings).map(|ring| self.stencil(ring, gain)).collect(),
        }
    }

    /// Speeds from half a step behind to half a step ahead, without loads: central differences in time.
    pub fn accelerate(&self, step: &ExplicitStep, motion: &mut PlateMotion) {
        let (columns, stride) = (self.columns, self.stride());
        for ((ring, stencil), speeds) in (1..).zip(&step.stencils).zip(motion.speeds.chunks_exact_mut(columns)) {
            let row = |offset: usize, nodes: usize| {
                let begin = self.begin(ring) + offset * stride - MARGIN * stride + HALO - nodes;
                &motion.deflections[begin..begin + columns + 2 * nodes]
            };
            let (far_inside, inside, own, outside, far_outside) =
                (row(0, 0), row(1, 1), row(2, 2), row(3, 1), row(4, 0));
            let s = stencil;
            for (j, speed) in speeds.iter_mut().enumerate() {
                let force = s.own[0] * own[j + 2]
                    + s.own[1] * (own[j + 1] + own[j + 3])
                    + s.own[2] * (own[j] + own[j + 4])
                    + s.inside[0] * inside[j + 1]
                    + s.inside[1] * (inside[j] + inside[j + 2])
                    + s.outside[0] * outside[j + 1]
                    + s.outside[1] * (outside[j] + outside[j + 2])
                    + s.far_inside * far_inside[j]
                    + s.far_outside * far_outside[j];
                *speed = step.keep * *speed - force + step.drag * (own[j + 3] - own[j + 1]);
            }
        }
    }

    /// Adds what a load (an acceleration) on one node does to its speed.
    pub fn push(&self, step: &ExplicitStep, motion: &mut PlateMotion, ring: usize, column: usize, load: f64) {
        motion.speeds[(ring - 1) * self.columns + column] += step.gain * load;
    }

    /// Deflections one step on.
    pub fn drift(&self, step: &ExplicitStep, motion: &mut PlateMotion) {
        let first = self.begin(1);
        let rows = motion.deflections[first..].chunks_exact_mut(self.stride());
        for (row, speeds) in rows.zip(motion.speeds.chunks_exact(self.columns)) {
            for (w, speed) in row[HALO..].iter_mut().zip(speeds) {
                *w += step.length * speed;
            }
        }
        self.repeat_ends(motion);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The preset's plate.
    fn plate(rings: usize, columns: usize) -> PlateGrid {
        PlateGrid::new(rings, columns, (3.2, 6.75), 0.02, 0.3)
    }

    /// Numbers between -1/2 and 1/2 from a simple generator.
    fn scatter(count: usize) -> Vec<f64> {
        let mut state = 0x9E37_79B9_7F4A_7C15_u64;
        let mut draw = || {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        (0..count).map(|_| draw()).collect()
    }

    #[test]
    fn frequencies_converge_with_the_square_of_the_spacing() {
        // lambda^2 from the Bessel determinant (physics notes, section 7), by nodal diameters.
        let table = [
            [11.7565, 76.6917, 220.0855],
            [11.9802, 78.4021, 221.8871],
            [13.3679, 83.5585, 227.3205],
            [17.3691, 92.2270, 236.4629],
            [24.6646, 104.4948, 249.4168],
        ];
        for (n, exact) in table.iter().enumerate() {
            let errors = [8, 16, 32].map(|count| {
                let squared = plate(count, 6 * count).squared_frequencies(n).unwrap();
                [0, 1, 2].map(|k| 6.75 * 6.75 * (0.02 * squared[k]).sqrt() / exact[k] - 1.0)
            });
            for k in 0..3 {
                let [coarse, middle, fine] = [errors[0][k], errors[1][k], errors[2][k]];
                // A quarter from grid to grid; the coarsest has 8 intervals for up to 3 half-waves.
                assert!(coarse / middle > 3.5 && coarse / middle < 4.05, "n = {n}, {k}: {coarse} {middle}");
                assert!(middle / fine > 3.84 && middle / fine < 4.05, "n = {n}, {k}: {middle} {fine}");
                assert!(fine.abs() < [0.0021, 0.0049, 0.0094][k], "n = {n}, {k}: {fine}");
            }
        }
    }

    #[test]
    fn poissons_ratio_and_radii_enter_as_they_should() {
        // a/b, nu, n, lambda^2 from the Bessel determinant, as in the tests of the disc's modes.
        for (ratio, poissons_ratio, n, exact) in [
            (0.3, 0.0, 5, 36.680976),
            (0.3, 1.0 / 3.0, 2, 7.854989),
            (0.7, 0.0, 1, 36.854831),
            (0.7, 1.0 / 3.0, 5, 55.139592),
        ] {
            let error = |count: usize| {
                let grid = PlateGrid::new(count, 6 * count, (ratio, 1.0), 1.0, poissons_ratio);
                grid.squared_frequencies(n).unwrap()[0].sqrt() / exact - 1.0
            };
            let (coarse, fine) = (error(16), error(32));
            assert!(coarse / fine > 3.8 && coarse / fine < 4.2 && fine.abs() < 4e-3, "{ratio} {n}: {coarse} {fine}");
        }
    }

    #[test]
    fn the_operator_is_symmetric_and_positive_and_its_bound_is_close() {
        for (inner, poissons_ratio) in [(0.05, 0.3), (0.5, 0.0), (0.5, 0.49), (0.95, 0.3)] {
            for (rings, per_pad) in [(4, 4), (4, 64), (32, 4), (12, 12)] {
                let grid = PlateGrid::new(rings, 6 * per_pad, (inner, 1.0), 1.0, poissons_ratio);
                let mut largest = 0.0_f64;
                for n in 0..=3 * per_pad {
                    let squared = grid.squared_frequencies(n).unwrap();
                    assert!(squared[0] > 0.0, "{inner} {rings} {per_pad} n = {n}: {}", squared[0]);
                    largest = largest.max(squared[rings - 1]);
                    let matrix = grid.radial_operator(n);
                    for row in 0..rings {
                        for column in 0..rings {
                            let a = grid.area(row + 1) * matrix[(row, column)];
                            let b = grid.area(column + 1) * matrix[(column, row)];
                            assert!((a - b).abs() <= 1e-14 * (a.abs() + b.abs()), "{row} {column}: {a} {b}");
                        }
                    }
                }
                let bound = grid.largest_squared_frequency();
                assert!(bound >= largest && bound < 1.2 * largest, "{inner} {rings} {per_pad}: {bound} {largest}");
            }
        }
    }

    #[test]
    fn thirteen_points_are_the_radial_operator() {
        let grid = plate(7, 36);
        let by_ring = scatter(7);
        for n in [0, 1, 4, 18] {
            let shape = |j: usize| libm::cos((n * j) as f64 * grid.angle);
            let deflection: Vec<f64> = by_ring.iter().flat_map(|a| (0..36).map(move |j| a * shape(j))).collect();
            let mut motion = grid.at_rest(&deflection);
            grid.accelerate(&grid.explicit_step(1.0, 0.0, 0.0), &mut motion);
            let expected = grid.radial_operator(n) * DVector::from_column_slice(&by_ring);
            for (ring, speeds) in motion.speeds.chunks_exact(36).enumerate() {
                for (j, speed) in speeds.iter().enumerate() {
                    assert!((speed + expected[ring] * shape(j)).abs() < 1e-11 * expected.amax(), "{n} {ring} {j}");
                }
            }
        }
    }

    #[test]
    fn steps_are_stable_up_to_the_bound_and_not_far_beyond() {
        let grid = plate(6, 36);
        let longest = 2.0 / grid.largest_squared_frequency().sqrt();
        let stays_small = |length: f64| {
            let mut motion = grid.at_rest(&scatter(6 * 36));
            let step = grid.explicit_step(length, 0.0, 0.0);
            for _ in 0..5000 {
                grid.accelerate(&step, &mut motion);
                grid.drift(&step, &mut motion);
            }
            motion.deflections.iter().all(|w| w.abs() < 30.0)
        };
        assert!(stays_small(0.999 * longest));
        assert!(!stays_small(1.1 * longest));
    }

    #[test]
    fn a_steady_deflection_balances_its_load() {
        let grid = plate(8, 48);
        let load = scatter(8 * 48);
        for spin in [0.0, 0.3] {
            let deflection = grid.steady_deflection(spin, &load).unwrap();
            let mut motion = grid.at_rest(&deflection);
            grid.accelerate(&grid.explicit_step(1.0, 0.0, 0.0), &mut motion);
            for (index, load) in load.iter().enumerate() {
                let (begin, column) = (index / 48 * 48, index % 48);
                let at = |column: usize| deflection[begin + column % 48];
                let second = (at(column + 1) - 2.0 * at(column) + at(column + 47)) / (grid.angle * grid.angle);
                let balance = -motion.speeds[index] + spin * spin * second - load;
                assert!(balance.abs() < 1e-11, "{spin} {index}: {balance}");
            }
        }
    }
}
