//! Verdicts beside their references, binned and printed as Markdown.

use stickslip_core::model::verdict::Verdict;
use stickslip_core::models::pad_on_disc::criterion::validity::Quantity;
use stickslip_core::models::pad_on_disc::motion::start::Start;
use stickslip_core::models::pad_on_disc::rigid_disc::pad_on_disc::PadOnDisc;

use crate::is_decided;

/// Where a case lies in the range of brakes.
pub struct Place {
    brake: PadOnDisc,
    start: Start,
}

impl Place {
    pub fn new(brake: &PadOnDisc, start: Start) -> Self {
        Self { brake: brake.clone(), start }
    }

    fn value(&self, quantity: Quantity) -> f64 {
        quantity.value(&self.brake)
    }
}

/// A verdict held against its reference.
pub struct Held {
    pub place: Place,
    /// Undecided if the reference is.
    pub reference: Verdict,
    pub verdict: Verdict,
    /// With steps half as long.
    pub halved: Verdict,
    /// The parts of the reference contradict each other.
    pub contradicted: bool,
    /// What it takes to repeat it.
    pub case: String,
}

impl Held {
    fn has_reference(&self) -> bool {
        is_decided(self.reference)
    }

    fn is_wrong(&self) -> bool {
        self.has_reference() && is_decided(self.verdict) && self.verdict != self.reference
    }

    fn is_undecided(&self) -> bool {
        !is_decided(self.verdict)
    }

    fn changes(&self) -> bool {
        self.verdict != self.halved
    }
}

/// What every axis is cut into: lower ends, which belong to their bin, up to an end that belongs to the last.
const SPEED_RATIOS: [f64; 9] = [1e-5, 1e-4, 1e-3, 1e-2, 0.1, 1.0, 10.0, 100.0, 1e3];
const DAMPING_RATIOS: [f64; 4] = [1e-3, 1e-2, 0.1, 0.5];
const FRICTION_RATIOS: [f64; 6] = [1.0, 1.01, 1.1, 1.5, 2.0, 3.0];

/// Prints the shares of wrong and undecided verdicts, overall and bin by bin.
pub fn print_table(all: &[Held]) {
    println!("| range | cases | wrong | undecided | share of both | no reference | changed by half steps |");
    println!("|---|---|---|---|---|---|---|");
    print_row("all", all, |_| true);
    print_bins(Quantity::SpeedRatio, all, &SPEED_RATIOS);
    for (name, low, high) in [
        ("0.5 to less than 1", 0.5, 1.0),
        ("1", 1.0, 1.0),
        ("more than 1 to 2", 1.0, 2.0),
        ("more than 2 to 3", 2.0, 3.0),
    ] {
        let contains = |exponent: f64| match (low, high) {
            (low, high) if low == high => exponent == low,
            (low, high) if low < 1.0 => (low..high).contains(&exponent),
            (low, high) => exponent > low && exponent <= high,
        };
        print_row(&format!("exponent {name}"), all, |held| contains(held.place.value(Quantity::Exponent)));
    }
    print_bins(Quantity::DampingRatio, all, &DAMPING_RATIOS);
    print_bins(Quantity::FrictionRatio, all, &FRICTION_RATIOS);
    for (name, start) in
        [("near the equilibrium", Start::NearEquilibrium), ("rest", Start::Rest), ("limit cycle", Start::LimitCycle)]
    {
        print_row(&format!("start: {name}"), all, |held| held.place.start == start);
    }
}

fn print_bins(quantity: Quantity, all: &[Held], ends: &[f64]) {
    let last = ends[ends.len() - 1];
    for pair in ends.windows(2) {
        let is_last = pair[1] == last;
        let contains = |value: f64| value >= pair[0] && (value < pair[1] || is_last);
        let beyond = is_last && all.iter().any(|held| held.place.value(quantity) > last);
        let upper = if beyond { "and more".to_owned() } else { format!("to {}", pair[1]) };
        print_row(&format!("{quantity} {} {upper}", pair[0]), all, |held| contains(held.place.value(quantity)));
    }
}

fn print_row(name: &str, all: &[Held], belongs: impl Fn(&Held) -> bool) {
    let inside: Vec<&Held> = all.iter().filter(|held| belongs(held)).collect();
    if inside.is_empty() {
        return;
    }
    let count = |is: fn(&Held) -> bool| inside.iter().filter(|held| is(held)).count();
    let (wrong, undecided) = (count(Held::is_wrong), count(Held::is_undecided));
    let share = 100.0 * (wrong + undecided) as f64 / inside.len() as f64;
    let (open, changed) = (count(|held| !held.has_reference()), count(Held::changes));
    println!("| {name} | {} | {wrong} | {undecided} | {share:.2} % | {open} | {changed} |", inside.len());
}

/// Lists every case that the table counts anywhere but among the cases.
pub fn print_cases(all: &[Held], out: &mut impl std::io::Write) {
    for held in all {
        let counted =
            held.is_wrong() || held.is_undecided() || held.changes() || held.contradicted || !held.has_reference();
        if counted {
            let contradicted = if held.contradicted { " (motion and eigenvalues contradict each other)" } else { "" };
            let line = format!(
                "- {:?}, with half steps {:?}, reference {:?}{contradicted}: {}",
                held.verdict, held.halved, held.reference, held.case
            );
            writeln!(out, "{line}").expect("somebody reads the cases");
        }
    }
}
