//! Models of two degrees of freedom whose critical values have formulas.

use stickslip_core::models::matrices::problem::Solver;

use super::entry::{Entry, Kind};
use super::model::{Parts, of_two};
use crate::failure::Failure;

const HOFFMANN: &str = "N. Hoffmann, M. Fischer, R. Allgaier, L. Gaul, Mech. Res. Commun. 29 (2002) 197; N. Hoffmann, L. Gaul, ZAMM 83 (2003) 524";
const HULTEN: &str = "J. Hulten (1993), with the parameters of J.-J. Sinou, L. Jezequel, Eur. J. Mech. A 26 (2007) 106";
const TWO_MASSES: &str = "M = I, K = [[k11, k12 - D], [k12, k22]], C = diag(c1, c2)";
const DRUM: &str = "x1'' + e1 w1 x1' + w1^2 x1 - mu w2^2 x2 = 0, x2'' + e2 w2 x2' + w2^2 x2 + mu w1^2 x1 = 0";

/// Digits of formulas, relative. Where modes meet without damping, half of them are lost.
const EXACT: f64 = 1e-8;

/// Stiffnesses of the two masses but for k22.
const K11: f64 = 2.0;
const K12: f64 = 1.0;

/// The critical det K of `lambda^4 + a3 lambda^3 + a2 lambda^2 + a1 lambda + det K`, by Routh and Hurwitz.
fn critical_determinant(a3: f64, a2: f64, a1: f64) -> f64 {
    a1 * (a3 * a2 - a1) / (a3 * a3)
}

pub fn entries() -> Result<Vec<Entry>, Failure> {
    let mut entries = Vec::new();
    let (mu, _) = two_masses(2.0, [0.0; 2], "1.3333333333333333 * D")?.critical([0.1, 2.0])?;
    entries.push(Entry {
        quantity: "two masses, undamped, D = 4 mu/3: critical mu".to_owned(),
        theirs: 0.75,
        ours: mu,
        tolerance: EXACT,
        kind: Kind::Formula,
        formula: "D = k12 + (k11 - k22)^2 / (4 k12)",
        source: HOFFMANN,
    });
    let k22 = 2.2;
    let undamped = K12 + (K11 - k22) * (K11 - k22) / (4.0 * K12);
    let cases = [
        ("two masses, k22 = 2.2, undamped: critical D", [0.0, 0.0]),
        ("  c = (0.1, 0.3)", [0.1, 0.3]),
        ("  c = (0.01, 0.05)", [0.01, 0.05]),
        ("  c1 = c2 = 1e-4 (1.0100 for none)", [1e-4, 1e-4]),
        ("  c2 = 10 c1 = 1e-3 (1.003306 for c1 -> 0)", [1e-4, 1e-3]),
    ];
    for (quantity, [c1, c2]) in cases {
        let theirs = if c1 == 0.0 {
            undamped
        } else {
            let determinant = critical_determinant(c1 + c2, K11 + k22 + c1 * c2, c1 * k22 + c2 * K11);
            (determinant - (K11 * k22 - K12 * K12)) / K12
        };
        entries.push(Entry {
            quantity: quantity.to_owned(),
            theirs,
            ours: two_masses(k22, [c1, c2], "D")?.critical([0.5, 2.0])?.0,
            tolerance: EXACT,
            kind: Kind::Formula,
            formula: TWO_MASSES,
            source: HOFFMANN,
        });
    }
    let [w1, w2] = [100.0, 75.0].map(|hertz| std::f64::consts::TAU * hertz);
    for (quantity, [e1, e2]) in [
        ("drum brake, undamped: critical mu", [0.0, 0.0]),
        ("  e = (0.02, 0.02)", [0.02, 0.02]),
        ("  e = (0.01, 0.05)", [0.01, 0.05]),
    ] {
        let (c1, c2, k1, k2) = (e1 * w1, e2 * w2, w1 * w1, w2 * w2);
        let theirs = if e1 == 0.0 {
            (k1 - k2).abs() / (2.0 * w1 * w2)
        } else {
            let determinant = critical_determinant(c1 + c2, k1 + k2 + c1 * c2, c1 * k2 + c2 * k1);
            (determinant / (k1 * k2) - 1.0).sqrt()
        };
        let mut damping = Vec::new();
        if e1 > 0.0 {
            damping.push((of_two([c1, 0.0, 0.0, c2])?, "1"));
        }
        let brake = Parts {
            mass: of_two([1.0, 0.0, 0.0, 1.0])?,
            damping,
            stiffness: vec![(of_two([k1, 0.0, 0.0, k2])?, "1"), (of_two([0.0, -k2, k1, 0.0])?, "mu")],
            parameters: vec![("mu", 0.2)],
            band: [0.0, f64::INFINITY],
            solver: Solver::Dense,
        };
        entries.push(Entry {
            quantity: quantity.to_owned(),
            theirs,
            ours: brake.critical([0.01, 1.0])?.0,
            tolerance: EXACT,
            kind: Kind::Formula,
            formula: DRUM,
            source: HULTEN,
        });
    }
    Ok(entries)
}

/// The two masses over the force D of friction.
fn two_masses(k22: f64, [c1, c2]: [f64; 2], factor: &'static str) -> Result<Parts<'static>, Failure> {
    Ok(Parts {
        mass: of_two([1.0, 0.0, 0.0, 1.0])?,
        damping: if c1 > 0.0 { vec![(of_two([c1, 0.0, 0.0, c2])?, "1")] } else { Vec::new() },
        stiffness: vec![(of_two([K11, K12, K12, k22])?, "1"), (of_two([0.0, -1.0, 0.0, 0.0])?, factor)],
        parameters: vec![("D", 0.5)],
        band: [0.0, f64::INFINITY],
        solver: Solver::Dense,
    })
}
