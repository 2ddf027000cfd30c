//! Verdicts on rigid brakes of all kinds against independent return maps.

use stickslip_core::{
    DiscModel, JudgedMotion, PadOnDisc, Parameters, RandomInputs, Start, TimeDomain, TimeDomainSettings, Verdict,
};

/// One brake of a file of fates.
struct Case {
    line: usize,
    parameters: Parameters,
    start: Start,
    displacement: f64,
    fate: Verdict,
}

impl Case {
    fn judge(&self, divisor: f64) -> JudgedMotion {
        let settings = TimeDomainSettings {
            start: self.start,
            displacement: self.displacement,
            horizon: 1e5,
            ..Default::default()
        };
        let brake = PadOnDisc::new(self.parameters.clone()).unwrap();
        let criterion = TimeDomain::new(&brake, &DiscModel::Rigid, settings).unwrap().with_steps_divided_by(divisor);
        criterion.judge(RandomInputs {
            preload: self.parameters.operating_point.preload,
            static_friction: self.parameters.friction.static_coefficient,
        })
    }
}

/// The cases of a file: columns named by their parameters, lines that begin with `#` are comments.
fn cases(text: &str) -> Vec<Case> {
    let mut lines = text.lines().enumerate().filter(|(_, line)| !line.starts_with('#'));
    let header: Vec<&str> = lines.next().unwrap().1.split(',').collect();
    let case = |(line, row): (usize, &str)| {
        let mut case = Case {
            line: line + 1,
            parameters: Parameters::sui_ding_2018(),
            start: Start::Rest,
            displacement: f64::NAN,
            fate: Verdict::Failed,
        };
        for (name, value) in header.iter().zip(row.split(',')) {
            let number = || value.parse::<f64>().unwrap();
            match *name {
                "preload" | "rotating_speed" => {
                    case.parameters.set(&format!("operating_point.{name}"), number()).unwrap();
                }
                "static_friction" => case.parameters.set("friction.static_coefficient", number()).unwrap(),
                "displacement" => case.displacement = number(),
                "start" => {
                    case.start = match value {
                        "rest" => Start::Rest,
                        "near-equilibrium" => Start::NearEquilibrium,
                        "limit-cycle" => Start::LimitCycle,
                        other => panic!("line {}: start {other}", line + 1),
                    }
                }
                "fate" => {
                    case.fate = match value {
                        "stable" => Verdict::Stable,
                        "unstable" => Verdict::Unstable,
                        other => panic!("line {}: fate {other}", line + 1),
                    }
                }
                "kind" | "damping_ratio" | "margin" => {}
                key => case.parameters.set(key, number()).unwrap(),
            }
        }
        case
    };
    lines.map(case).collect()
}

#[test]
fn dev() {
    for file in std::env::var("FATES").unwrap().split(':') {
        let text = std::fs::read_to_string(file).unwrap();
        let (mut wrong, mut open) = (0, 0);
        let cases = cases(&text);
        let begin = std::time::Instant::now();
        for case in &cases {
            let t = std::time::Instant::now();
            let base = case.judge(1.0);
            let e = t.elapsed().as_secs_f64();
            if e > 0.05 {
                println!("slow {} {e}", case.line);
            }
            if base.verdict != case.fate {
                println!("{file} line {}: {:?} {:?} expected {:?}", case.line, base.verdict, base.time, case.fate);
                if base.verdict == Verdict::Undecided { open += 1 } else { wrong += 1 }
            }
            if std::env::var("DIV").is_ok() {
                for d in [0.5, 2.0, 8.0] {
                    let other = case.judge(d);
                    if other.verdict != base.verdict {
                        println!("line {} differs at /{d}: {:?} {:?}", case.line, base, other);
                    }
                }
            }
        }
        println!("{file}: {} cases, wrong {wrong} open {open}, {:?}", cases.len(), begin.elapsed());
    }
}
