//! Maxima of smooth functions on the whole space.

/// Step of the numerical derivatives: the functions have errors of about 1e-10 of their terms, and may change within some
/// thousandths.
const STEP: f64 = 2e-4;

/// Most iterations.
const MOST: usize = 200;

/// Iteration stops when the function would grow by less than this.
const GROWTH: f64 = 1e-9;

/// Longest step, in any coordinate.
const LONGEST: f64 = 1.5;

/// Coordinates do not go beyond this, where the values of parameters no longer change.
const FARTHEST: f64 = 30.0;

/// Least curvature from which a step is computed.
const LEAST_CURVATURE: f64 = 1e-3;

/// A square matrix, row by row.
pub(super) type Matrix = Vec<Vec<f64>>;

/// Where a function is greatest, its value there, and about the inverse of its curvature.
#[derive(Debug, Clone)]
pub(super) struct Maximum {
    pub(super) place: Vec<f64>,
    pub(super) value: f64,
    pub(super) inverse: Matrix,
}

/// The gradient of a function, and its curvature along each coordinate.
pub(super) fn slopes(f: &dyn Fn(&[f64]) -> f64, place: &[f64], value: f64) -> (Vec<f64>, Vec<f64>) {
    let mut near = place.to_vec();
    let of = |i: usize| {
        let [above, below] = [STEP, -STEP].map(|step| {
            near[i] = place[i] + step;
            f(&near)
        });
        near[i] = place[i];
        ((above - below) / (2.0 * STEP), (2.0 * value - above - below) / (STEP * STEP))
    };
    (0..place.len()).map(of).unzip()
}

pub(super) fn product(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// The maximum that a quasi-Newton iteration reaches from `start`: the inverse of the curvature is gathered from the
/// gradients (Broyden, Fletcher, Goldfarb, Shanno; J. Nocedal, S. J. Wright, Numerical Optimization, 2nd ed. 2006,
/// section 6.1), beginning with `inverse`, or with the curvatures along the coordinates.
pub(super) fn maximum(f: &dyn Fn(&[f64]) -> f64, start: &[f64], inverse: Option<&Matrix>) -> Maximum {
    let size = start.len();
    let mut place = start.to_vec();
    let mut value = f(&place);
    if size == 0 {
        return Maximum { place, value, inverse: Vec::new() };
    }
    let diagonal = |curvatures: &[f64]| -> Matrix {
        let of = |i: usize| {
            let mut row = vec![0.0; size];
            row[i] = 1.0 / curvatures[i].abs().max(LEAST_CURVATURE);
            row
        };
        (0..size).map(of).collect()
    };
    let (mut gradient, curvatures) = slopes(f, &place, value);
    let mut is_fresh = inverse.is_none();
    let mut inverse = inverse.map_or_else(|| diagonal(&curvatures), Clone::clone);
    for _ in 0..MOST {
        let mut step: Vec<f64> = inverse.iter().map(|row| product(row, &gradient)).collect();
        if product(&step, &gradient) < 2.0 * GROWTH {
            if is_fresh {
                break;
            }
            // What was gathered may be wrong; ask the curvatures here.
            let (_, curvatures) = slopes(f, &place, value);
            inverse = diagonal(&curvatures);
            is_fresh = true;
            step = inverse.iter().map(|row| product(row, &gradient)).collect();
            if product(&step, &gradient) < 2.0 * GROWTH {
                break;
            }
        }
        let longest = step.iter().fold(0.0_f64, |longest, part| longest.max(part.abs()));
        if longest > LONGEST {
            step.iter_mut().for_each(|part| *part *= LONGEST / longest);
        }
        let Some((next, next_value)) = climb(f, &place, value, &step, &gradient) else {
            if is_fresh {
                break;
            }
            let (_, curvatures) = slopes(f, &place, value);
            inverse = diagonal(&curvatures);
            is_fresh = true;
            continue;
        };
        let (next_gradient, _) = slopes(f, &next, next_value);
        let moved: Vec<f64> = next.iter().zip(&place).map(|(next, place)| next - place).collect();
        let changed: Vec<f64> = gradient.iter().zip(&next_gradient).map(|(before, after)| before - after).collect();
        update(&mut inverse, &moved, &changed);
        is_fresh = false;
        (place, value, gradient) = (next, next_value, next_gradient);
    }
    Maximum { place, value, inverse }
}

/// A point along a step at which the function has grown as the gradient promises, to a ten-thousandth; the step is halved
/// until it does.
fn climb(
    f: &dyn Fn(&[f64]) -> f64,
    place: &[f64],
    value: f64,
    step: &[f64],
    gradient: &[f64],
) -> Option<(Vec<f64>, f64)> {
    let promised = product(step, gradient);
    let mut length = 1.0;
    for _ in 0..30 {
        let moved = |(place, step): (&f64, &f64)| (place + length * step).clamp(-FARTHEST, FARTHEST);
        let next: Vec<f64> = place.iter().zip(step).map(moved).collect();
        let next_value = f(&next);
        if next_value > value + 1e-4 * length * promised {
            return Some((next, next_value));
        }
        length *= 0.5;
    }
    None
}

/// Brings the change of the gradient over a step into the inverse of the curvature, unless it would not stay positive.
fn update(inverse: &mut Matrix, moved: &[f64], changed: &[f64]) {
    let along = product(moved, changed);
    if along < 1e-10 {
        return;
    }
    let image: Vec<f64> = inverse.iter().map(|row| product(row, changed)).collect();
    let scale = (1.0 + product(changed, &image) / along) / along;
    for (i, row) in inverse.iter_mut().enumerate() {
        for (j, element) in row.iter_mut().enumerate() {
            *element += scale * moved[i] * moved[j] - (image[i] * moved[j] + moved[i] * image[j]) / along;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_curved_ridge_is_climbed_to_its_top() {
        // Rosenbrock's function, in the textbook's coordinates.
        let f = |x: &[f64]| -((1.0 - x[0]).powi(2) + 100.0 * (x[1] - x[0] * x[0]).powi(2));
        let Maximum { place, value, .. } = maximum(&f, &[-1.2, 1.0], None);
        assert!(value > -1e-5, "{value}");
        assert!((place[0] - 1.0).abs() < 3e-3 && (place[1] - 1.0).abs() < 6e-3, "{place:?}");
    }

    #[test]
    fn a_function_that_grows_for_ever_is_followed_to_the_end() {
        let Maximum { place, .. } = maximum(&|x: &[f64]| -(-x[0]).exp(), &[0.0], None);
        assert!(place[0] > 15.0, "{place:?}");
    }
}
