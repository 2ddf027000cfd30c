//! The grid of the plate and its operator.

#[cfg(test)]
use nalgebra::SymmetricEigen;
use nalgebra::{DMatrix, DVector};

#[cfg(test)]
use crate::numerics::eigenvalues::EigenvalueError;

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

/// The thirteen factors for the nodes of one ring, those that are equal once.
#[derive(Debug, Clone, Copy)]
pub(super) struct Stencil {
    pub own: [f64; 3],
    pub inside: [f64; 2],
    pub outside: [f64; 2],
    pub far_inside: f64,
    pub far_outside: f64,
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
    pub(super) fn radial_operator(&self, nodal_diameters: usize) -> DMatrix<f64> {
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
    #[cfg(test)]
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

    pub(super) fn stencil(&self, ring: usize, factor: f64) -> Stencil {
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
}

#[cfg(test)]
mod tests;
