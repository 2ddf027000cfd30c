//! Where a fit begins. The intervals find a better maximum by themselves, and would hide a bad beginning.

use super::*;
use stickslip_core::models::pad_on_disc::parameters::Parameters;
use stickslip_core::models::pad_on_disc::rigid_disc::pad_on_disc::PadOnDisc;

fn boundary_at(rotating_speed: f64) -> PairBoundary {
    let mut parameters = Parameters::sui_ding_2018();
    parameters.set("operating_point.rotating_speed", rotating_speed).unwrap();
    PadOnDisc::new(parameters).unwrap().stability_boundary()
}

#[test]
fn a_fit_begins_where_the_likelihood_has_a_slope() {
    let mut data = TestData::default();
    for (speed, squealed) in [(12.0, 38), (14.0, 33), (16.0, 21), (18.0, 11), (20.0, 4)] {
        data.add_verdict(0.1, &boundary_at(speed), true, squealed);
        data.add_verdict(0.1, &boundary_at(speed), false, 40 - squealed);
    }
    let best = |static_friction: f64, static_friction_std: f64| {
        let values =
            FitValues { expected: [1.0, static_friction], relative_std: [0.0, static_friction_std], correlation: 0.0 };
        let names = ["preload", "static_friction"].map(str::to_owned);
        let model = FitModel { names, marginals: [Marginal::Normal, Marginal::Normal], values };
        let estimated = [PairParameter::Expected(1), PairParameter::RelativeStd(1)]
            .map(|parameter| (parameter, Range::new(parameter, &model.marginals)))
            .to_vec();
        best_of_starts(&Likelihood { model: &model, data: &data, estimated }, &[]).value
    };
    // Near the maximum, and with so little scatter that most candidates make the tests impossible: there the likelihood
    // is flat, and no iteration moves.
    let usual = best(0.38, 0.1);
    for (static_friction, std) in [(0.9, 3e-3), (0.2, 3e-3), (0.42, 3e-3)] {
        let found = best(static_friction, std);
        assert!((found - usual).abs() < 1e-6, "{static_friction} {std}: {found} {usual}");
    }
}
