//! Figure 6: the bifurcation diagram of the tangential motion, swept down and up.

use std::path::Path;

use stickslip_core::models::pad_on_disc::criterion::settings::TimeDomainSettings;
use stickslip_core::models::pad_on_disc::criterion::time_domain::{DiscModel, TimeDomain};
use stickslip_core::models::pad_on_disc::flexible_disc::brake::DISC_MODES;
use stickslip_core::models::pad_on_disc::parameters::Parameters;
use stickslip_core::models::pad_on_disc::rigid_disc::pad_on_disc::RandomInputs;
use stickslip_core::models::pad_on_disc::trajectory::sweep::{SweepPoint, sweep};

use super::part::Part;
use super::preset::brake_at;
use crate::commands::scales_line;
use crate::failure::Failure;
use crate::files::table::{DescribedColumn, write_columns};
use crate::picture::chart::{Chart, ChartAxis, Form, Marks, Series};
use crate::picture::scale::Scale;
use crate::units::speed;

/// Speeds of the sweep, rad/s.
const SLOWEST: f64 = 10.0;
const STEP: f64 = 0.2;
const STEPS: i32 = 150;

/// Scaled time at each speed, some 120 cycles of the pad.
const DWELL: f64 = 400.0;

/// Speeds that the paper prints: of the Hopf bifurcation, and of the saddle-node.
const PRINTED: [f64; 2] = [15.56, 30.0];

/// Sweeps both discs down and up, writes every point, and draws the sweeps.
pub fn diagram(directory: &Path) -> Result<Vec<Part>, Failure> {
    let preset = brake_at(SLOWEST)?;
    let scales = preset.scales();
    let mut columns = [const { Vec::new() }; 6];
    let mut parts = vec![Part::text(
        "Figure 6: bifurcation diagram of the tangential motion, preload 0.1\nlargest and smallest x at each speed\n\n",
    )];
    let mut boundaries = String::new();
    for (name, disc) in [("rigid", DiscModel::Rigid), ("flexible", DiscModel::Flexible { modes: DISC_MODES })] {
        let (down, up) = (sweep_disc(&disc, true)?, sweep_disc(&disc, false)?);
        for (direction, points) in [(-1.0, &down), (1.0, &up)] {
            for point in points {
                let flexible = f64::from(u8::from(name == "flexible"));
                let row = [
                    flexible,
                    direction,
                    point.rotating_speed,
                    point.tangential_max,
                    point.tangential_min,
                    point.stick_fraction,
                ];
                columns.iter_mut().zip(row).for_each(|(column, value)| column.push(value));
            }
        }
        let jump = |points: &[SweepPoint], sticks: bool| {
            let found = points.iter().find(|point| (point.stick_fraction > 0.0) == sticks);
            found.map_or("none".to_owned(), |point| {
                let under_pad = speed(preset.speed_under_pad(point.rotating_speed));
                format!("{:.1} rad/s ({under_pad})", point.rotating_speed)
            })
        };
        boundaries += &format!(
            "{name} disc: stick-slip begins at {} on the way down\n\
             {:>length$}ends at {} on the way up\n",
            jump(&down, true),
            "",
            jump(&up, false),
            length = name.len() + 18,
        );
        let title = if name == "flexible" { "Flexible disc" } else { "Rigid disc" };
        parts.push(Part::chart(sweeps(title, &down, &up)));
    }
    let mut text = boundaries;
    text += "the paper prints 15.56 (Hopf) and 30 (saddle-node). On the way down growth takes\n\
        its time beyond the boundary; on the way up each step of the speed disturbs the\n\
        motion, and just below the saddle-node little is enough.\n";
    let [flexible, direction, speeds, largest, smallest, stick] = columns;
    let millimetres = |values: &[f64]| values.iter().map(|&x| scales.millimetres(x)).collect::<Vec<f64>>();
    let (largest_mm, smallest_mm) = (millimetres(&largest), millimetres(&smallest));
    let under_pad = speeds.iter().map(|&rad_s| preset.speed_under_pad(rad_s)).collect();
    let column = |name, unit, long_name, values: Vec<f64>| DescribedColumn { name, unit, long_name, values };
    write_columns(
        directory,
        "bifurcation.parquet",
        &[
            column("flexible_disc", "1", "1 for the flexible disc, 0 for the rigid one", flexible),
            column("direction", "1", "-1 for the sweep down, 1 for the sweep up", direction),
            column("rotating_speed_rad_s", "rad/s", "rotating speed of the disc", speeds),
            column("x_max", "1", "largest settled tangential displacement over disc thickness", largest),
            column("x_min", "1", "smallest settled tangential displacement over disc thickness", smallest),
            column("stick_fraction", "1", "share of the time in stick", stick),
            column("speed_under_pad_m_s", "m/s", "speed of the disc under the pad", under_pad),
            column("x_max_mm", "mm", "largest settled tangential displacement", largest_mm),
            column("x_min_mm", "mm", "smallest settled tangential displacement", smallest_mm),
        ],
    )?;
    text += &format!("data: {}\n", directory.join("bifurcation.parquet").display());
    text += &scales_line(scales);
    parts.push(Part::Text(text));
    Ok(parts)
}

/// Both sweeps of a disc.
fn sweeps(title: &str, down: &[SweepPoint], up: &[SweepPoint]) -> Chart {
    let series = |name: &str, symbol: char, points: &[SweepPoint]| {
        let both = points.iter().map(|p| (p.rotating_speed, p.tangential_max));
        let points = both.chain(points.iter().map(|p| (p.rotating_speed, p.tangential_min))).collect();
        Series { name: name.to_owned(), symbol, form: Form::Points, points, band: Vec::new() }
    };
    let series = vec![series("on the way up", '^', up), series("on the way down", 'v', down)];
    let x = Scale::around(series.iter().flat_map(|series| series.points.iter().map(|point| point.1)));
    let fastest = SLOWEST + STEP * f64::from(STEPS);
    let mut chart = Chart::new(
        title,
        ChartAxis::new("Rotating speed", "rad/s", Scale::linear(SLOWEST, fastest)),
        ChartAxis::new("Displacement x over h", "", x),
        series,
    );
    chart.marks = Some(Marks { what: "printed in the paper".to_owned(), values: PRINTED.to_vec() });
    chart
}

fn sweep_disc(disc: &DiscModel, down: bool) -> Result<Vec<SweepPoint>, Failure> {
    let failed = |error: &dyn std::fmt::Display| Failure::Job(error.to_string());
    let parameters = Parameters::sui_ding_2018();
    let inputs = RandomInputs {
        preload: parameters.operating_point.preload,
        static_friction: parameters.friction.static_coefficient,
    };
    let criterion = |index: i32| {
        let index = if down { STEPS - index } else { index };
        let brake = brake_at(SLOWEST + STEP * f64::from(index))?;
        TimeDomain::new(&brake, disc, TimeDomainSettings::default()).map_err(|error| failed(&error))
    };
    let criteria = (0..=STEPS).map(criterion).collect::<Result<Vec<_>, _>>()?;
    sweep(&criteria, inputs, DWELL).map_err(|error| failed(&error))
}
