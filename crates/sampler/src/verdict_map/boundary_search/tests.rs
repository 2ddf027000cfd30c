//! Curves located on planes whose verdicts are known.

use super::*;

fn locate(within: Box2, abscissa: usize, verdict_at: impl Fn(Point) -> Verdict) -> Option<(BoundaryCurve, usize)> {
    let mut asked = 0;
    let mut ask = |points: &[Point]| -> Vec<Verdict> {
        asked += points.len();
        points.iter().map(|&point| verdict_at(point)).collect()
    };
    let expected = |_| (within.low[1 - abscissa], within.high[1 - abscissa]);
    let mut search = Search::new(within, abscissa, (Verdict::Stable, Verdict::Unstable), expected);
    if !search.accepts(&ask(&search.ends())) {
        search.widen();
        if !search.accepts(&ask(&search.ends())) {
            return None;
        }
    }
    loop {
        let questions = search.questions();
        if questions.is_empty() {
            break;
        }
        search.record(&ask(&questions));
    }
    let (curve, checks) = search.curve(1.0);
    search.accepts(&ask(&checks)).then_some((curve, asked))
}

const BOX: Box2 = Box2 { low: [0.125, 0.0625], high: [0.1875, 0.125] };

#[test]
fn a_hyperbola_is_located_to_a_few_millionths() {
    let verdict_at = |[x, y]: Point| if x * y > 0.0135 { Verdict::Unstable } else { Verdict::Stable };
    for abscissa in [0, 1] {
        let (curve, asked) = locate(BOX, abscissa, verdict_at).unwrap();
        assert!(asked < 250, "{asked}");
        for i in 0..1000 {
            let coordinate = BOX.low[abscissa] + 0.0625 * (f64::from(i) + 0.5) / 1000.0;
            let (low, high) = curve.gap(&BOX, coordinate);
            let exact = 0.0135 / coordinate;
            assert!(low < exact && exact < high && high - low < 4e-5 * exact, "{coordinate}: {low} {exact} {high}");
        }
    }
}

#[test]
fn a_corner_and_a_missing_boundary_are_rejected() {
    let corner = |[x, y]: Point| if y > 0.09 + (x - 0.15).abs() { Verdict::Unstable } else { Verdict::Stable };
    assert!(locate(BOX, 0, corner).is_none());
    assert!(locate(BOX, 0, |_| Verdict::Stable).is_none());
    assert!(locate(BOX, 0, |[x, _]| if x > 0.15 { Verdict::Unstable } else { Verdict::Stable }).is_none());
}

#[test]
fn samples_of_a_third_verdict_between_two_are_left_out() {
    let verdict_at = |[x, y]: Point| match x * y {
        product if product > 0.0136 => Verdict::Unstable,
        product if product > 0.0134 => Verdict::Undecided,
        _ => Verdict::Stable,
    };
    let (curve, _) = locate(BOX, 0, verdict_at).unwrap();
    for i in 0..100 {
        let x = 0.125 + 0.0625 * (f64::from(i) + 0.5) / 100.0;
        let (low, high) = curve.gap(&BOX, x);
        assert!(low < 0.0134 / x && low > 0.0134 / x - 4e-6 && high > 0.0136 / x && high < 0.0136 / x + 4e-6);
        assert_eq!(curve.verdict(&BOX, [x, 0.0135 / x]), None);
        assert_eq!(curve.verdict(&BOX, [x, 0.0133 / x]), Some(Verdict::Stable));
        assert_eq!(curve.verdict(&BOX, [x, 0.0137 / x]), Some(Verdict::Unstable));
    }
}

#[test]
fn the_search_ends_where_verdicts_along_a_line_have_no_order() {
    // From below: stable, undecided, stable again, unstable, undecided, unstable; and the other way round.
    let stripes = |value: f64| match (value * 1600.0) as i64 % 8 {
        0 | 1 | 4 => Verdict::Stable,
        3 | 5 => Verdict::Undecided,
        _ => Verdict::Unstable,
    };
    for shift in 0..200 {
        let shift = f64::from(shift) * 7.3e-5;
        let verdict_at = |point: Point| match point[1] + shift {
            value if value < 0.064 => Verdict::Stable,
            value if value > 0.136 => Verdict::Unstable,
            value => stripes(value),
        };
        let mut search =
            Search::new(BOX, 0, (Verdict::Stable, Verdict::Unstable), |coordinate| (0.05, 0.1375 + 0.01 * coordinate));
        let mut rounds = 0;
        while !search.questions().is_empty() {
            let verdicts: Vec<Verdict> = search.questions().into_iter().map(verdict_at).collect();
            search.record(&verdicts);
            rounds += 1;
            assert!(rounds < 60, "{shift}");
        }
    }
}

#[test]
fn an_answer_on_the_wrong_side_of_a_third_verdict_is_a_contradiction() {
    let (below, above, third) = (Verdict::Stable, Verdict::Unstable, Verdict::Undecided);
    let open = Bracket { coordinate: 0.0, below_at: 0.0, above_at: 1.0, third: None };
    let divided = Bracket { third: Some((0.5, 0.5)), ..open };
    let agrees = |node: Bracket, at: f64, verdict: Verdict| {
        let mut node = node;
        node.record(at, verdict, below, above)
    };
    assert!([below, above, third].into_iter().all(|verdict| agrees(open, 0.5, verdict)));
    assert!([below, third].into_iter().all(|verdict| agrees(divided, 0.25, verdict)));
    assert!([above, third].into_iter().all(|verdict| agrees(divided, 0.75, verdict)));
    assert!(!agrees(divided, 0.25, above) && !agrees(divided, 0.75, below));
}
