//! The range of a probability whose inputs are known roughly: the least and the greatest of an exact grid.

use crate::common::{EIGENVALUE, Place, submitted};

/// The numbers are those of a search whose bounds were proved by bounds of the derivatives, and of no grid.
#[test]
fn least_and_greatest_probabilities_are_read_from_an_exact_grid() {
    let values = |from: f64, to: f64| (0..=100).map(move |i| from + (to - from) * f64::from(i) / 100.0);
    let stds: Vec<String> =
        values(0.1, 0.3).map(|std| format!("{{ preload = {std}, static_friction = 0.1 }}")).collect();
    let job = format!(
        "name = \"rough\"\n[axes]\nrotating_speed = 15.0\npreload = [0.05, 0.1, 0.2]\n\
         static_friction = {:?}\n[random]\ninputs = [\"preload\", \"static_friction\"]\nrelative_std = [{}]\n\
         [criterion]\n{EIGENVALUE}\n[sampling]\nmethod = \"exact\"\n",
        values(0.37, 0.39).collect::<Vec<_>>(),
        stds.join(", ")
    );
    let table = submitted(&Place::new(), "rough", &job);
    let cells = |column: &str| table.column(column).to_vec();
    let (preloads, frictions) = (cells("preload"), cells("static_friction"));
    let (stds, probabilities) = (cells("std_preload"), cells("p_unstable"));
    assert_eq!(probabilities.len(), 30_603);
    // Each with the static friction coefficient and the standard deviation of the preload at which it is reached.
    let expected = [
        (0.05, (9.674382e-4, 0.37, 0.1), (0.04114090, 0.39, 0.3)),
        (0.1, (0.41500524, 0.37, 0.27889), (0.62202238, 0.39, 0.1)),
        (0.2, (0.86867597, 0.37, 0.3), (0.97310207, 0.39, 0.1)),
    ];
    for (preload, least, greatest) in expected {
        let of_it = || (0..probabilities.len()).filter(|&cell| preloads[cell] == preload);
        let by_probability = |a: &usize, b: &usize| probabilities[*a].total_cmp(&probabilities[*b]);
        let found = [of_it().min_by(by_probability), of_it().max_by(by_probability)];
        for (cell, (probability, friction, std)) in found.into_iter().flatten().zip([least, greatest]) {
            assert!(
                (probabilities[cell] - probability).abs() < 1e-6 * probability,
                "{preload}: {}",
                probabilities[cell]
            );
            assert!((frictions[cell] - friction).abs() < 1e-9, "{preload}: {}", frictions[cell]);
            assert!((stds[cell] - std).abs() < 1.1e-3, "{preload}: {}", stds[cell]);
        }
    }
}
