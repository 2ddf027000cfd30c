//! The tables and figures that can be reproduced, and the job specs behind them.

use clap::ValueEnum;

/// A table or figure that can be reproduced.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Target {
    /// Ten preloads (of the paper's numbers, only the range is known)
    Table2,
    /// Ten static friction coefficients, four scatters
    Table3,
    /// Growth rate against rotating speed for three preloads
    Fig4,
    /// Phase portraits at 35, 10 and 20 rad/s
    Fig5,
    /// Bifurcation diagram, swept down and up
    Fig6,
    /// Tangential motion above and below the boundaries
    Fig7,
    /// Sliding speed, friction and contact force in steady sliding
    Fig8,
    /// Sliding speed and friction in stick-slip
    Fig9,
    /// Spectra of the pad
    Fig10,
    /// Vibration of the disc and its spectrum
    Fig11,
    /// Random preload: distribution of input and instability
    Fig12,
    /// Random static friction, four scatters
    Fig13,
    /// Surface at 15 rad/s
    Fig14a,
    /// Figure 14a in the time domain, every sample simulated
    Fig14b,
    /// Surface at 10 rad/s
    Fig14c,
    /// Surface at 20 rad/s
    Fig14d,
    /// Surface at 15 rad/s, standard deviation 0.1
    Fig15a,
    /// Surface at 15 rad/s, standard deviation 0.3
    Fig15b,
    /// Every number printed in the paper beside the computed one
    Scoreboard,
    /// All of the above
    All,
}

impl Target {
    /// Its name on the command line.
    pub fn name(self) -> String {
        self.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned())
    }

    /// The job spec of a target, if it has one.
    pub fn job(self) -> Option<&'static str> {
        match self {
            Self::Table2 => Some(include_str!("../jobs/table2.toml")),
            Self::Table3 => Some(include_str!("../jobs/table3.toml")),
            Self::Fig4 => Some(include_str!("../jobs/fig4.toml")),
            Self::Fig12 => Some(include_str!("../jobs/fig12.toml")),
            Self::Fig13 => Some(include_str!("../jobs/fig13.toml")),
            Self::Fig14a => Some(include_str!("../jobs/fig14a.toml")),
            Self::Fig14b => Some(include_str!("../jobs/fig14b.toml")),
            Self::Fig14c => Some(include_str!("../jobs/fig14c.toml")),
            Self::Fig14d => Some(include_str!("../jobs/fig14d.toml")),
            Self::Fig15a => Some(include_str!("../jobs/fig15a.toml")),
            Self::Fig15b => Some(include_str!("../jobs/fig15b.toml")),
            Self::Fig5 | Self::Fig6 | Self::Fig7 | Self::Fig8 | Self::Fig9 | Self::Fig10 | Self::Fig11 => None,
            Self::Scoreboard | Self::All => None,
        }
    }
}
