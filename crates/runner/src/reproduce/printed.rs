//! What the text of the paper prints about each table and figure, for the gallery.

use crate::target::Target;

/// What a target is called.
pub fn name(target: Target) -> &'static str {
    match target {
        Target::Table2 => "Table 2: random preload",
        Target::Table3 => "Table 3: random static friction",
        Target::Fig4 => "Figure 4: growth rate against rotating speed",
        Target::Fig5 => "Figure 5: phase portraits",
        Target::Fig6 => "Figure 6: bifurcation diagram",
        Target::Fig7 => "Figure 7: tangential motion",
        Target::Fig8 => "Figure 8: friction in steady sliding",
        Target::Fig9 => "Figure 9: friction in stick-slip",
        Target::Fig10 => "Figure 10: spectra of the pad",
        Target::Fig11 => "Figure 11: vibration of the disc",
        Target::Fig12 => "Figure 12: random preload",
        Target::Fig13 => "Figure 13: random static friction",
        Target::Fig14a => "Figure 14a: surface at 15 rad/s",
        Target::Fig14b => "Figure 14b: the same in the time domain",
        Target::Fig14c => "Figure 14c: surface at 10 rad/s",
        Target::Fig14d => "Figure 14d: surface at 20 rad/s",
        Target::Fig15a => "Figure 15a: surface with standard deviation 0.1",
        Target::Fig15b => "Figure 15b: surface with standard deviation 0.3",
        Target::Scoreboard | Target::All => "Scoreboard",
    }
}

/// What the paper says that can be compared, one statement each.
pub fn statements(target: Target) -> &'static [&'static str] {
    match target {
        Target::Table2 => &[
            "Its ten numbers are lost. The text says that outside preloads of 0.072 to 0.256 the probability is 0 or 1.",
        ],
        Target::Table3 => &["Forty probabilities, in the column \"paper\"."],
        Target::Fig4 => &[
            "Critical speed 15.56 rad/s at preload 0.1 (16.56 in two other places).",
            "A larger preload has a larger critical speed.",
        ],
        Target::Fig5 => &[
            "35 rad/s: one equilibrium. 10 rad/s: one limit cycle.",
            "20 rad/s: equilibrium or limit cycle, as the motion starts.",
        ],
        Target::Fig6 => &[
            "Hopf bifurcation at 15.56 rad/s (16.56 in two places), swept down.",
            "Saddle-node of the limit cycle at 30 rad/s, swept up.",
            "Amplitude of the limit cycle: about 0.02.",
        ],
        Target::Fig7 => &["35 rad/s: x settles at about 8.15e-3.", "10 rad/s: stick-slip, a limit cycle."],
        Target::Fig8 => &["The pad slides all the time.", "The friction coefficient settles at about 0.25."],
        Target::Fig9 => &[
            "In stick the pad moves with the disc, and the sliding speed is zero.",
            "Friction falls while the sliding speed rises.",
        ],
        Target::Fig10 => &[
            "Main frequency 0.23 Hz, second order 0.45 Hz, third order 0.68 Hz.",
            "0.29 Hz of the disc in y, 0.16 Hz of the pad's rotation in the angle.",
        ],
        Target::Fig11 => &[
            "Disc frequencies 0.29, 1.87 and 5.03 Hz; 0.23 and 0.45 Hz of the pad.",
            "The outer edge moves more than the inner one.",
        ],
        Target::Fig12 => &["Preloads from 0.01 to 0.30, scatter 0.2.", "The text prints no other number of it."],
        Target::Fig13 => &[
            "Static friction from 0.25 to 0.50, scatter 0.1, 0.2, 0.25 and 0.3.",
            "Ten points of each curve are Table 3.",
        ],
        Target::Fig14a => {
            &["15 rad/s, scatter 0.2, by eigenvalues.", "No numbers; small preload or friction is stable."]
        }
        Target::Fig14b => &["15 rad/s, scatter 0.2, by motions in time.", "It tends to coincide with Figure 14a."],
        Target::Fig14c => &["10 rad/s, scatter 0.2.", "The stable region is smaller than at higher speeds."],
        Target::Fig14d => &["20 rad/s, scatter 0.2.", "The stable region is wider than at lower speeds."],
        Target::Fig15a => &["15 rad/s, scatter 0.1.", "The text prints no number of it."],
        Target::Fig15b => &["15 rad/s, scatter 0.3.", "The text prints no number of it."],
        Target::Scoreboard | Target::All => &[],
    }
}
