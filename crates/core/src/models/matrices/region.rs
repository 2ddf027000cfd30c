//! Which eigenvalues make a brake unstable: those in a band of frequencies whose damping ratio is below a threshold.

use crate::numerics::eigenvalues::Eigenvalue;

/// What separates a damping ratio from the threshold at least to count as below it, of samples and of critical values alike. So the
/// rounding of undamped modes, whose damping ratio is zero, makes none unstable.
pub const RESOLUTION: f64 = 1e-9;

/// Eigenvalues near the real axis that grow by no more than this do so by rounding alone, in the unit of the problem. It is not more
/// than rounding, as the load at which a soft mode diverges beside stiff ones would be missed by it.
pub const ZERO: f64 = 1e-14;

/// `|z|`.
#[must_use]
pub(super) fn magnitude(z: Eigenvalue) -> f64 {
    libm::hypot(z.re, z.im)
}

/// The square root in the right half plane.
pub(super) fn square_root(of: Eigenvalue) -> Eigenvalue {
    let size = magnitude(of);
    if size == 0.0 {
        return Eigenvalue::from(0.0);
    }
    let larger = (0.5 * (size + of.re.abs())).sqrt();
    let smaller = 0.5 * of.im.abs() / larger;
    let (re, im) = if of.re >= 0.0 { (larger, smaller) } else { (smaller, larger) };
    Eigenvalue::new(re, if of.im < 0.0 { -im } else { im })
}

/// `-Re lambda / |lambda|`: 1 for a motion that only decays, -1 for one that only grows, 0 for `lambda = 0`.
#[must_use]
pub fn damping_ratio(eigenvalue: Eigenvalue) -> f64 {
    let size = magnitude(eigenvalue);
    if size == 0.0 { 0.0 } else { -eigenvalue.re / size }
}

/// A band of frequencies with a threshold of the damping ratio.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Region {
    /// The lower end of the band, rad/s, which belongs to it. Where a proof looks from below 0, it is negative, and of negative
    /// frequencies those above it belong to the band.
    pub lowest: f64,
    /// The upper end, rad/s, which belongs to it; may be infinite.
    pub highest: f64,
    /// Damping ratios below it are unstable.
    pub damping_ratio: f64,
}

impl Region {
    /// Whether the frequency of an eigenvalue lies in the band.
    #[must_use]
    pub fn has_frequency_of(&self, eigenvalue: Eigenvalue) -> bool {
        let frequency = eigenvalue.im.abs();
        self.lowest <= frequency && frequency <= self.highest
    }

    /// Whether an eigenvalue is unstable: of a pair by its damping ratio, a real one if it grows.
    #[must_use]
    pub fn contains(&self, eigenvalue: Eigenvalue) -> bool {
        let grows = eigenvalue.im.abs() > ZERO || eigenvalue.re > ZERO;
        grows && self.has_frequency_of(eigenvalue) && damping_ratio(eigenvalue) < self.damping_ratio - RESOLUTION
    }

    /// A lower bound of the distance of an eigenvalue from all that are unstable, rad/s; zero if it may be one.
    #[must_use]
    pub fn distance(&self, eigenvalue: Eigenvalue) -> f64 {
        let of_band = (self.lowest - eigenvalue.im).max(eigenvalue.im - self.highest).max(0.0);
        of_band.max(self.distance_from_cone(eigenvalue))
    }

    /// The distance from the cone of all eigenvalues with smaller damping ratios.
    fn distance_from_cone(&self, eigenvalue: Eigenvalue) -> f64 {
        let size = magnitude(eigenvalue);
        if size == 0.0 {
            return 0.0;
        }
        // Sine and cosine of the angle between both, whose sines are the damping ratios.
        let [own, threshold] =
            [damping_ratio(eigenvalue), self.damping_ratio - RESOLUTION].map(|ratio| ratio.clamp(-1.0, 1.0));
        let cosine_of = |sine: f64| ((1.0 - sine) * (1.0 + sine)).sqrt();
        let sine = own * cosine_of(threshold) - threshold * cosine_of(own);
        let cosine = cosine_of(own) * cosine_of(threshold) + own * threshold;
        match (sine > 0.0, cosine > 0.0) {
            (true, true) => size * sine,
            (true, false) => size,
            (false, _) => 0.0,
        }
    }

    /// Whether an eigenvalue that lies at most `radius` from this one is surely unstable (`Some(true)`), surely not, or
    /// may be either.
    #[must_use]
    pub fn sure(&self, eigenvalue: Eigenvalue, radius: f64) -> Option<bool> {
        if self.distance(eigenvalue) > radius {
            return Some(false);
        }
        let frequency = eigenvalue.im.abs();
        let is_above = self.lowest <= 0.0 || frequency - radius >= self.lowest;
        let in_band = is_above && frequency + radius <= self.highest;
        let size = magnitude(eigenvalue);
        let most = damping_ratio(eigenvalue) + 1.1 * radius / (size - radius);
        (in_band && size > 2.0 * radius && most < self.damping_ratio - RESOLUTION).then_some(true)
    }

    /// The same region with frequencies in another unit, of which one is `unit` rad/s.
    #[must_use]
    pub fn in_unit(&self, unit: f64) -> Self {
        Self { lowest: self.lowest / unit, highest: self.highest / unit, ..*self }
    }
}

/// The damping ratio of an eigenvalue less the threshold, the least over regions that have its frequency; infinite outside
/// all, and for an eigenvalue of zero, which neither grows nor decays.
#[must_use]
pub fn excess(regions: &[Region], eigenvalue: Eigenvalue) -> f64 {
    let is_zero = eigenvalue == Eigenvalue::from(0.0);
    let bands = regions.iter().filter(|region| !is_zero && region.has_frequency_of(eigenvalue));
    bands.map(|region| damping_ratio(eigenvalue) - region.damping_ratio).fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;

    const BAND: Region = Region { lowest: 100.0, highest: 200.0, damping_ratio: 0.0 };

    #[test]
    fn unstable_is_below_the_threshold_in_the_band() {
        let strict = Region { damping_ratio: -0.01, ..BAND };
        for (region, re, im, unstable) in [
            (BAND, 1.0, 150.0, true),
            (BAND, 1.0, -150.0, true),
            (BAND, -1.0, 150.0, false),
            (BAND, 1.0, 99.0, false),
            (BAND, 1.0, 200.0, true),
            (BAND, 1e-8, 150.0, false),
            (strict, 1.0, 150.0, false),
            (strict, 2.0, 150.0, true),
            (Region { lowest: 0.0, ..BAND }, 1.0, 0.0, true),
        ] {
            assert_eq!(region.contains(Eigenvalue::new(re, im)), unstable, "{region:?} {re} {im}");
        }
    }

    #[test]
    fn nothing_unstable_is_nearer_than_the_distance_and_what_is_sure_is_so_all_around() {
        let mut checked = 0;
        for ratio in [-0.2, -0.01, 0.0, 0.05, 0.4] {
            let region = Region { damping_ratio: ratio, ..BAND };
            for i in 0..60 {
                for j in 0..60 {
                    let centre = Eigenvalue::new(4.0 * f64::from(i) - 120.0, 5.0 * f64::from(j) - 20.0);
                    let distance = region.distance(centre);
                    for radius in [0.999 * distance, 3.0, 20.0] {
                        let around = (0..32).map(|k| {
                            let (sine, cosine) = libm::sincos(f64::from(k) * std::f64::consts::PI / 16.0);
                            centre + Eigenvalue::new(cosine, sine) * radius
                        });
                        let unstable = around.filter(|value| value.im >= 0.0 && region.contains(*value)).count();
                        if radius < distance {
                            assert_eq!(unstable, 0, "{region:?} {centre} {radius}");
                        }
                        if centre.im > radius && region.sure(centre, radius) == Some(true) {
                            assert_eq!(unstable, 32);
                            checked += 1;
                        }
                    }
                }
            }
        }
        assert!(checked > 1000, "{checked}");
    }
}
