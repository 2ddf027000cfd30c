//! Verdicts beside their references, binned and printed as Markdown.

use stickslip_core::{PadOnDisc, Start, Verdict};

use crate::is_decided;

/// Where a case lies in the range of brakes.
pub struct Place {
    speed_ratio: f64,
    exponent: f64,
    damping_ratio: f64,
    friction_ratio: f64,
    start: Start,
}

impl Place {
    pub fn of(brake: &PadOnDisc, start: Start) -> Self {
        let parameters = brake.parameters();
        let friction = &parameters.friction;
        let tangential = brake.tangential_stiffness();
        Self {
            speed_ratio: brake.disc_speed() / brake.friction_law().stribeck_velocity,
            exponent: friction.stribeck_exponent,
            damping_ratio: parameters.damping.tangential / (2.0 * (tangential * parameters.pad.mass).sqrt()),
            friction_ratio: friction.static_coefficient / friction.kinetic_coefficient,
            start,
        }
    }
}

/// A verdict held against its reference.
pub struct Held {
    pub place: Place,
    /// Undecided if the reference cannot tell.
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
    print_bins("v / v_s", all, &SPEED_RATIOS, |place| place.speed_ratio);
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
        print_row(&format!("exponent {name}"), all, |held| contains(held.place.exponent));
    }
    print_bins("damping ratio", all, &DAMPING_RATIOS, |place| place.damping_ratio);
    print_bins("f_s / f_c", all, &FRICTION_RATIOS, |place| place.friction_ratio);
    for (name, start) in
        [("near the equilibrium", Start::NearEquilibrium), ("rest", Start::Rest), ("limit cycle", Start::LimitCycle)]
    {
        print_row(&format!("start: {name}"), all, |held| held.place.start == start);
    }
}

fn print_bins(name: &str, all: &[Held], ends: &[f64], value: impl Fn(&Place) -> f64) {
    for (index, pair) in ends.windows(2).enumerate() {
        let is_last = index + 2 == ends.len();
        let contains =
            |held: &Held| (pair[0]..pair[1]).contains(&value(&held.place)) || is_last && value(&held.place) >= pair[1];
        if is_last && all.iter().any(|held| value(&held.place) > pair[1]) {
            print_row(&format!("{name} {} and more", pair[0]), all, contains);
        } else {
            print_row(&format!("{name} {} to {}", pair[0], pair[1]), all, contains);
        }
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
pub fn print_cases(all: &[Held]) {
    for held in all {
        let counted =
            held.is_wrong() || held.is_undecided() || held.changes() || held.contradicted || !held.has_reference();
        if counted {
            let contradicted = if held.contradicted { " (motion and eigenvalues contradict each other)" } else { "" };
            println!(
                "- {:?}, with half steps {:?}, reference {:?}{contradicted}: {}",
                held.verdict, held.halved, held.reference, held.case
            );
        }
    }
}
