//! The verdict maps of a run: which values of the pair are stable, configuration by configuration.

use std::collections::BTreeSet;
use std::path::Path;

use stickslip_sampler::verdict_map::boundary_curve::{BoundaryCurve, Box2};
use stickslip_sampler::verdict_map::map::VerdictMap;
use stickslip_sampler::verdict_map::tile::Node;

use crate::evaluate::maps::Maps;
use crate::failure::Failure;
use crate::job::Job;
use crate::output::quoted;
use crate::picture::panels::{MOST_PANELS, spread};
use crate::picture::scale::Scale;
use crate::picture::title::title;
use crate::picture::view::GridView;
use crate::plot::canvas::{BLACK, Canvas, Pen, Place, WHITE};
use crate::plot::panel::{
    ABOVE, Arrangement, Axis, LEFT, Layout, Panel, RIGHT, heading, in_lines, space_of, write_notes,
};
use crate::plot::regions::{Region, Regions};
use crate::store::directory::RunDirectory;
use crate::store::file_state::FileState;
use crate::store::map_pieces;
use crate::store::piece::REMEDY_OF_VERSIONS;

/// Height of a panel over its width.
const ASPECT: f64 = 0.78;

/// Space between the panels and the legend.
const BEFORE: f64 = 10.0;

/// Least width of a gap that is drawn, in pixels; narrower ones are closed.
const LEAST_GAP: f64 = 0.4;

/// Distance of the points of a boundary, in pixels, and the most of them across a box.
const STEP: f64 = 2.0;
const MOST_STEPS: f64 = 24.0;

/// Most cells whose expected values are marked.
const MOST_MARKS: usize = 600;
/// So many have large marks.
const FEW_MARKS: usize = 100;

const TILE: Pen = Pen::new(WHITE, 0.4);

const NAMES: [&str; 5] = ["stable", "unstable", "undecided", "failed", "left open: simulated one by one"];

/// The maps of a run.
pub struct VerdictMaps {
    job: Job,
    maps: Maps,
}

impl VerdictMaps {
    /// Reads the maps of a run.
    ///
    /// # Errors
    /// A run without maps, and one whose maps are not complete.
    pub fn read(run: &Path) -> Result<Self, Failure> {
        let directory = RunDirectory::view(run)?;
        let job = directory.job_to_read()?;
        if !job.uses_maps() {
            return Err(Failure::Job(format!(
                "{} has no verdict map: its samples are decided one by one, or in closed form. Runs with a map have evaluate = \"boundary\" or method = \"exact\" in [sampling], and a [criterion] other than \"eigenvalue\"",
                run.display()
            )));
        }
        let mut maps = Maps::new(&job);
        directory.maps()?.map(|folder| map_pieces::load(&mut maps, &folder)).transpose()?;
        let (missing, needed) = (maps.missing().len(), maps.needed());
        if missing > 0 {
            let state = directory.surface_state(&job)?;
            let remedy = if state == FileState::OfAnotherVersion {
                format!(
                    "The run is of another version of stickslip, whose maps this one does not use. {REMEDY_OF_VERSIONS}"
                )
            } else if state == FileState::Sound {
                format!("Files of map/ are lost or damaged; compute them again with `stickslip resume {}`", quoted(run))
            } else {
                format!("Finish it with `stickslip resume {}`", quoted(run))
            };
            return Err(Failure::Job(format!(
                "the verdict map of {} is not complete: {missing} of {needed} tiles are missing. {remedy}",
                run.display()
            )));
        }
        Ok(Self { job, maps })
    }

    /// The number of panels.
    pub fn panels(&self) -> usize {
        self.job.grid.configurations()
    }

    /// The figure, this wide in pixels.
    pub fn figure(&self, width: f64) -> Canvas {
        let drawn = spread(self.panels().min(MOST_PANELS), self.panels());
        let drawn = drawn.into_iter().filter_map(|number| self.maps.get(number).map(|map| (number, map)));
        let (configurations, maps): (Vec<usize>, Vec<&VerdictMap>) = drawn.unzip();
        let marks = marks(&self.job);
        let [horizontal, vertical] = axes(&self.job, &maps);
        let has_marks = marks.len() <= MOST_MARKS;
        let notes: Vec<String> = [
            (has_marks, "dots: expected values of the cells"),
            (maps.iter().any(|map| !fills_rectangle(map)), "blank: reached by no sample"),
        ]
        .into_iter()
        .filter(|(is_there, _)| *is_there)
        .map(|(_, note)| note.to_owned())
        .collect();
        let notes = in_lines(&notes, width);
        let layout = Layout { above: ABOVE, right: RIGHT, below: 0.0, aspect: ASPECT, most_columns: usize::MAX };
        let Arrangement { panels, height } = layout.arrange(maps.len(), width);
        let drawn = |(panel, map): (&Panel, &&VerdictMap)| {
            Plane { panel, map, horizontal: &horizontal, vertical: &vertical }.regions()
        };
        let regions: Vec<Regions> = panels.iter().zip(&maps).map(drawn).collect();
        let legend = Regions::legend(&regions, NAMES, width - LEFT - RIGHT);
        let total = height + BEFORE + legend.height() + space_of(&notes);
        let mut canvas = Canvas::new(width, total);
        let view = GridView::new(&self.job);
        for (configuration, ((panel, map), regions)) in
            configurations.into_iter().zip(panels.iter().zip(&maps).zip(&regions))
        {
            regions.draw(&mut canvas);
            let plane = Plane { panel, map, horizontal: &horizontal, vertical: &vertical };
            plane.tiles(&mut canvas);
            if has_marks {
                plane.mark(&mut canvas, &marks);
            }
            panel.frame(&mut canvas, &horizontal, &vertical);
            let first = self.job.grid.first_cell_with(configuration).index;
            heading(&mut canvas, panel, &view.configuration_of(first));
        }
        legend.draw(&mut canvas, (LEFT, height + BEFORE));
        write_notes(&mut canvas, &notes, total);
        canvas
    }
}

/// Whether the tiles of a map fill a rectangle.
fn fills_rectangle(map: &VerdictMap) -> bool {
    let (columns, rows): (BTreeSet<u32>, BTreeSet<u32>) =
        map.tiles().map(|(index, _)| (index.column, index.row)).unzip();
    map.tiles().count() == columns.len() * rows.len()
}

fn distance(a: Place, b: Place) -> f64 {
    libm::hypot(a.0 - b.0, a.1 - b.1)
}

/// The expected values of the pair in the cells.
fn marks(job: &Job) -> Vec<[f64; 2]> {
    let Some([first, second]) = job.model().pair().map(|pair| pair.map(|place| job.grid.values_of(place))) else {
        return Vec::new();
    };
    first.iter().flat_map(|&first| second.iter().map(move |&second| [first, second])).collect()
}

/// The axes of the second and the first of the pair, as far as the tiles of all maps reach.
fn axes(job: &Job, maps: &[&VerdictMap]) -> [Axis; 2] {
    let mut ends = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
    for map in maps {
        for (index, _) in map.tiles() {
            let bounds = index.bounds();
            for corner in [bounds.low, bounds.high] {
                for (end, value) in ends.iter_mut().zip(map.inputs(corner)) {
                    *end = [end[0].min(value), end[1].max(value)];
                }
            }
        }
    }
    let titles = job.model().pair().map(|pair| pair.map(|place| title(job.quantity(place)))).unwrap_or_default();
    let axis = |input: usize| {
        let [low, high] = ends[input];
        Axis {
            scale: if low < high { Scale::linear(low, high) } else { Scale::linear(0.0, 1.0) },
            title: titles[input].clone(),
            unit: String::new(),
        }
    };
    [axis(1), axis(0)]
}

/// A map in its panel.
struct Plane<'a> {
    panel: &'a Panel,
    map: &'a VerdictMap,
    horizontal: &'a Axis,
    vertical: &'a Axis,
}

impl Plane<'_> {
    /// Where values of the pair lie.
    fn place(&self, [first, second]: [f64; 2]) -> Place {
        self.panel.place(self.horizontal.scale.at(second), self.vertical.scale.at(first))
    }

    /// The corners of a box, around it.
    fn corners(&self, Box2 { low, high }: &Box2) -> Vec<Place> {
        let corners = [*low, [high[0], low[1]], *high, [low[0], high[1]]];
        corners.map(|point| self.place(self.map.inputs(point))).to_vec()
    }

    /// The regions that the boxes of its tiles show.
    fn regions(&self) -> Regions {
        let mut regions = Regions::default();
        for (index, tile) in self.map.tiles() {
            for (bounds, node) in tile.boxes(index) {
                match node {
                    Node::Uniform(verdict) => regions.add(verdict.into(), self.corners(&bounds)),
                    Node::Crossed(curve) => self.add_crossed(&mut regions, &bounds, &curve),
                    Node::Unresolved => regions.add(Region::Open, self.corners(&bounds)),
                    // Its quarters are boxes of their own.
                    Node::Cut(_) => {}
                }
            }
        }
        regions
    }

    /// The parts of a box on the sides of a curve, and what is open between them.
    fn add_crossed(&self, regions: &mut Regions, bounds: &Box2, curve: &BoundaryCurve) {
        let (across, up) = (curve.abscissa, 1 - curve.abscissa);
        let [floor, ceiling] = [bounds.low[up], bounds.high[up]];
        let at = |abscissa: f64, ordinate: f64| {
            let mut point = [0.0; 2];
            (point[across], point[up]) = (abscissa, ordinate);
            self.place(self.map.inputs(point))
        };
        let corners = self.corners(bounds);
        let steps = (distance(corners[0], corners[2]) / STEP).clamp(2.0, MOST_STEPS).ceil();
        // Where the sides of the curve begin and end, along the abscissa.
        let slices: Vec<[Place; 4]> = (0..=steps as u32)
            .map(|step| {
                let share = f64::from(step) / steps;
                let abscissa = bounds.low[across] + share * (bounds.high[across] - bounds.low[across]);
                let (below, above) = curve.gap(bounds, abscissa);
                let [below, above] = [below, above].map(|ordinate| ordinate.clamp(floor, ceiling));
                let is_closed = distance(at(abscissa, below), at(abscissa, above)) < LEAST_GAP;
                let middle = 0.5 * (below + above);
                let [below, above] = if is_closed { [middle, middle] } else { [below, above] };
                [floor, below, above, ceiling].map(|ordinate| at(abscissa, ordinate))
            })
            .collect();
        for (side, region) in [curve.below.into(), Region::Open, curve.above.into()].into_iter().enumerate() {
            // Only where it has some width.
            let is_wide = |slice: &[Place; 4]| distance(slice[side], slice[side + 1]) > 0.0;
            let is_part = |i: usize| {
                is_wide(&slices[i]) || (i > 0 && is_wide(&slices[i - 1])) || slices.get(i + 1).is_some_and(is_wide)
            };
            let places: Vec<usize> = (0..slices.len()).collect();
            for part in places.split(|i| !is_part(*i)).filter(|part| part.len() > 1) {
                let lower = part.iter().map(|&i| slices[i][side]);
                let upper = part.iter().rev().map(|&i| slices[i][side + 1]);
                regions.add(region, lower.chain(upper).collect());
            }
        }
    }

    /// The outlines of the tiles.
    fn tiles(&self, canvas: &mut Canvas) {
        for (index, _) in self.map.tiles() {
            let mut outline = self.corners(&index.bounds());
            outline.extend(outline.first().copied());
            canvas.lines(&outline, TILE);
        }
    }

    /// Marks the expected values of the cells.
    fn mark(&self, canvas: &mut Canvas, marks: &[[f64; 2]]) {
        let radius = if marks.len() <= FEW_MARKS { 1.6 } else { 0.8 };
        for &mark in marks {
            let place = self.place(mark);
            if self.panel.contains(place) {
                canvas.dot(place, radius, BLACK);
            }
        }
    }
}
