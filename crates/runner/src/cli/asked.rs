//! What the result of a run says first.

use std::path::Path;

use clap::Args;

use super::values::{axis_value, probability};
use crate::shell::quoted;

/// The target and the operating point that are asked about, in place of those of the job.
#[derive(Debug, Clone, Default, Args)]
pub struct AskedArguments {
    /// Say first whether the probability is below this one, in place of the job's target
    #[arg(long, value_name = "P", value_parser = probability, allow_negative_numbers = true)]
    pub target: Option<f64>,
    /// Say first what holds at this operating point, for example rotating_speed=15; once for each axis of several
    /// values
    #[arg(long, value_name = "AXIS=VALUE", value_parser = axis_value)]
    pub at: Vec<(String, f64)>,
}

impl AskedArguments {
    /// The options, each a word of a command.
    pub fn options(&self) -> impl Iterator<Item = String> {
        let target = self.target.map(|target| format!("--target={target}"));
        target.into_iter().chain(self.at.iter().map(|(axis, value)| format!("--at={axis}={value}")))
    }

    /// The command that goes on with a run and asks the same, for messages.
    pub fn resume(&self, run: &Path) -> String {
        format!("stickslip resume {}{}", quoted(run), self.words())
    }

    /// The end of a command that asks the same.
    pub fn words(&self) -> String {
        let target = self.target.map(|target| format!(" --target {target}"));
        let at = |(axis, value): &(String, f64)| format!(" --at {}", quoted(Path::new(&format!("{axis}={value}"))));
        target.into_iter().chain(self.at.iter().map(at)).collect()
    }
}
