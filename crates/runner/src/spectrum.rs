//! Amplitude spectra of motions.

use std::f64::consts::TAU;

use rustfft::FftPlanner;
use rustfft::num_complex::Complex;

/// An amplitude spectrum: one-sided, of a signal without its mean, under a Hann window that is scaled so that a sine
/// wave in the middle of a bin shows its amplitude.
pub struct Spectrum {
    /// Hz of scaled time.
    pub frequencies: Vec<f64>,
    /// Of the unit of the signal.
    pub amplitudes: Vec<f64>,
}

/// The spectrum of evenly spaced values.
pub fn spectrum(values: &[f64], interval: f64) -> Spectrum {
    let n = values.len();
    let mean = values.iter().sum::<f64>() / n.max(1) as f64;
    let window = |i: usize| 0.5 - 0.5 * libm::cos(TAU * i as f64 / n as f64);
    let mut signal: Vec<Complex<f64>> =
        values.iter().enumerate().map(|(i, value)| Complex::new((value - mean) * window(i), 0.0)).collect();
    FftPlanner::new().plan_fft_forward(n).process(&mut signal);
    // The window halves the amplitude, and half of it lies at negative frequencies.
    let scale = 4.0 / n.max(1) as f64;
    Spectrum {
        frequencies: (0..n / 2).map(|k| k as f64 / (n as f64 * interval)).collect(),
        amplitudes: signal.iter().take(n / 2).map(|value| scale * value.norm()).collect(),
    }
}

impl Spectrum {
    /// The highest peaks, at most `count`, as frequency and amplitude, by falling amplitude; each at least `share` of
    /// the highest. Their frequencies are those of the parabola through the logarithms of a peak and its neighbours.
    pub fn peaks(&self, count: usize, share: f64) -> Vec<(f64, f64)> {
        let a = &self.amplitudes;
        let highest = a.iter().copied().fold(0.0, f64::max);
        let resolution = self.frequencies.get(1).copied().unwrap_or(0.0);
        let is_peak = |&k: &usize| a[k] > a[k - 1] && a[k] >= a[k + 1] && a[k] >= share * highest && a[k] > 0.0;
        let mut peaks: Vec<(f64, f64)> = (1..a.len().saturating_sub(1))
            .filter(is_peak)
            .map(|k| {
                let [before, here, after] = [a[k - 1], a[k], a[k + 1]].map(|value| libm::log(value.max(1e-300)));
                let bend = before - 2.0 * here + after;
                let offset = if bend < 0.0 { 0.5 * (before - after) / bend } else { 0.0 };
                (self.frequencies[k] + offset * resolution, a[k])
            })
            .collect();
        peaks.sort_by(|p, q| q.1.total_cmp(&p.1));
        peaks.truncate(count);
        peaks
    }

    /// The peak nearest to a frequency, within `tolerance` of it (relative).
    pub fn peak_near(&self, frequency: f64, tolerance: f64) -> Option<(f64, f64)> {
        let all = self.peaks(usize::MAX, 0.0);
        let near = all.into_iter().filter(|peak| (peak.0 / frequency - 1.0).abs() <= tolerance);
        near.max_by(|p, q| p.1.total_cmp(&q.1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_sine_waves_show_their_frequencies_and_amplitudes() {
        let interval = 0.1;
        let value = |i: usize| {
            let t = interval * i as f64;
            3.0 + 0.02 * libm::sin(TAU * 0.2806 * t) + 0.003 * libm::cos(TAU * 1.87 * t)
        };
        let values: Vec<f64> = (0..5000).map(value).collect();
        let peaks = spectrum(&values, interval).peaks(2, 0.01);
        assert!((peaks[0].0 - 0.2806).abs() < 1e-4 && (peaks[0].1 / 0.02 - 1.0).abs() < 0.15, "{peaks:?}");
        assert!((peaks[1].0 - 1.87).abs() < 1e-4 && (peaks[1].1 / 0.003 - 1.0).abs() < 0.15, "{peaks:?}");
    }

    #[test]
    fn silence_has_no_peaks() {
        assert!(spectrum(&[0.5; 100], 0.1).peaks(3, 0.1).is_empty());
        assert!(spectrum(&[], 0.1).peaks(3, 0.1).is_empty());
    }
}
