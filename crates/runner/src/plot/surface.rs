//! The probability of a run: filled contours over two axes, curves with their intervals over one.

use stickslip_core::model::ClosedForm;

use crate::picture::scale::Scale;
use crate::picture::view::{GridView, Slice, ViewAxis};
use crate::plot::area::{Area, AreaPanel, LINE, LabelledLine, Level, labelled_lines};
use crate::plot::canvas::{BLACK, Canvas, Pen, Place, Rgb, WHITE};
use crate::plot::curves::Curves;
use crate::plot::form::Form;
use crate::plot::level_lines::level_lines;
use crate::plot::levels::{Levels, deviate, label};
use crate::plot::limit_lines::{LimitLine, lines, note, target_label};
use crate::plot::panel::Axis;
use crate::plot::values::Values;

/// Upper ends of the axis of probabilities.
const TOPS: [f64; 7] = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0];

/// How lines of limits are drawn.
const RED: Rgb = (0xe0, 0x10, 0x30);
const LIMIT: Pen = Pen::new(RED, 1.8);

/// A figure of a run, this wide in pixels; none for a single cell.
pub fn figure(values: &Values, view: &GridView, width: f64) -> Option<Canvas> {
    match Form::for_grid(view)? {
        Form::Curves(along) => {
            let vertical = Axis {
                scale: Scale::linear(0.0, top(values)),
                title: "Probability of instability P".to_owned(),
                unit: String::new(),
            };
            let Values { job, probability, low, high, .. } = values;
            let curves = Curves {
                job,
                view,
                along,
                values: probability,
                low,
                high,
                vertical,
                has_zero: false,
                target: job.target.map(|target| (target, target_label(target))),
                notes: blank_note(values)
                    .map(str::to_owned)
                    .into_iter()
                    .chain(values.exceptions().sentences(&values.job))
                    .collect(),
            };
            Some(curves.figure(width))
        }
        Form::Area { vertical, horizontal } => {
            let levels = Levels::up_to(values.largest());
            // The boundary is known in closed form, and lies in the plane that is shown.
            let model = values.job.model();
            let is_of = |place: usize, axis: &ViewAxis| axis.quantity == Some(place);
            let has_boundary = model.has_closed_form()
                && model.pair().is_some_and(|[first, second]| is_of(first, vertical) && is_of(second, horizontal));
            let boundary_note = has_boundary.then_some("dashed: stability boundary of the expected values");
            let limits_of =
                |slice: &Slice<'_>| values.limits.as_ref().map_or_else(Vec::new, |found| lines(found, view, slice));
            let has_limits = (0..view.slices()).any(|number| !limits_of(&view.slice(number)).is_empty());
            let limits_note = values.limits.as_ref().filter(|_| has_limits).map(note);
            let is_wide = |(low, high): (&f64, &f64)| levels.band(*high) > levels.band(*low) + 1;
            let known = values.probability.iter().map(Option::is_some);
            let is_hatched: Vec<bool> =
                values.low.iter().zip(&values.high).map(is_wide).zip(known).map(|(a, b)| a && b).collect();
            let hatching = "hatched: the interval reaches beyond the neighbouring colours";
            let area = Area {
                job: &values.job,
                view,
                vertical,
                horizontal,
                values: values.probability.iter().map(|p| p.map(deviate)).collect(),
                notes: boundary_note
                    .into_iter()
                    .chain(is_hatched.contains(&true).then_some(hatching))
                    .chain(blank_note(values))
                    .map(str::to_owned)
                    .chain(limits_note)
                    .chain(values.exceptions().sentences(&values.job))
                    .collect(),
                is_hatched,
                levels: levels
                    .all()
                    .iter()
                    .map(|&level| Level { value: deviate(level), label: label(level) })
                    .collect(),
                colours: (0..levels.bands()).map(|band| levels.colour(band)).collect(),
                title: "Probability of instability",
            };
            let drawn_lines = |canvas: &mut Canvas, drawn: &AreaPanel<'_>| {
                if has_boundary {
                    boundary(canvas, values, drawn, horizontal.ends());
                }
                let limits = limits_of(&drawn.slice);
                let mut lines = limit_lines(canvas, &levels, &limits, drawn);
                lines.extend(contour_lines(values, view, drawn, &limits));
                labelled_lines(canvas, &drawn.panel, &lines);
            };
            Some(area.figure(width, drawn_lines))
        }
    }
}

/// What cells without a probability are.
fn blank_note(values: &Values) -> Option<&'static str> {
    values.probability.contains(&None).then_some("blank: no probability")
}

/// The upper end of the axis of probabilities: a round one, or just above the largest probability, or the target, if that is
/// tiny.
fn top(values: &Values) -> f64 {
    if values.probability.iter().all(Option::is_none) {
        return 1.0;
    }
    let target = values.job.target.unwrap_or(0.0);
    let largest = values.largest().max(target);
    if largest < 1e-3 {
        return largest * 1.2 + 1e-12;
    }
    let highest = values.high.iter().copied().filter(|high| high.is_finite()).fold(target, f64::max);
    TOPS.into_iter().find(|limit| *limit >= highest).unwrap_or(1.0)
}

/// The boundary of stability with the expected values, which is known in closed form.
fn boundary(canvas: &mut Canvas, values: &Values, drawn: &AreaPanel<'_>, [from, to]: [f64; 2]) {
    let job = &values.job;
    let Ok(configuration) = job.configuration_in(&job.grid.cell(drawn.slice.first)) else { return };
    let Some(boundary) = configuration.closed_form().map(ClosedForm::boundary) else { return };
    let mut line: Vec<Place> = Vec::new();
    for i in 0..=200 {
        let second = from + (to - from) * f64::from(i) / 200.0;
        let place = drawn.place([second, boundary.critical_first(second)]);
        if drawn.panel.contains(place) {
            line.push(place);
        }
    }
    canvas.dashes(&line, Pen::new(WHITE, 1.2));
}

/// Lines at some of the levels, with their labels; not at those that are targets of limits.
fn contour_lines(values: &Values, view: &GridView, drawn: &AreaPanel<'_>, limits: &[LimitLine]) -> Vec<LabelledLine> {
    let levels = Levels::up_to(values.largest());
    let mut lines = Vec::new();
    for level in values.lines().into_iter().filter(|level| limits.iter().all(|line| line.target != *level)) {
        let (ink, is_target) = (ink_at(&levels, level), values.job.target == Some(level));
        let (label, width) = if is_target { (target_label(level), 2.0 * LINE) } else { (label(level), LINE) };
        for line in level_lines(&values.probability, view, &drawn.slice, level) {
            let points = line.iter().map(|point| drawn.place(*point)).collect();
            lines.push(LabelledLine { points, label: label.clone(), pen: Pen::new(ink, width), ink });
        }
    }
    lines
}

/// The colour that is seen where the probability is that of a level.
fn ink_at(levels: &Levels, level: f64) -> Rgb {
    if 2 * levels.band(level) > levels.bands() + 4 { WHITE } else { BLACK }
}

/// The lines of limits with their targets. A limit without another beside it is a dot.
fn limit_lines(canvas: &mut Canvas, levels: &Levels, limits: &[LimitLine], drawn: &AreaPanel<'_>) -> Vec<LabelledLine> {
    let mut lines = Vec::new();
    for LimitLine { target, points, .. } in limits {
        let points: Vec<Place> = points.iter().map(|point| drawn.place(*point)).collect();
        match points[..] {
            [only] => canvas.dot(only, 2.0, RED),
            _ => {
                let ink = ink_at(levels, *target);
                lines.push(LabelledLine { points, label: target_label(*target), pen: LIMIT, ink });
            }
        }
    }
    lines
}
