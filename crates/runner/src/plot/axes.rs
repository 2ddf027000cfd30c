//! What the axes of plots are called.

use crate::picture::scale::Scale;
use crate::picture::view::ViewAxis;
use crate::plot::panel::Axis;

/// The axis of a grid, with its symbol, name and unit.
pub fn axis(of: &ViewAxis) -> Axis {
    Axis { scale: Scale::for_values(&of.values), title: of.title.clone(), unit: of.unit().to_owned() }
}

/// The same, with space for the cells about its values.
pub fn axis_of_cells(of: &ViewAxis) -> Axis {
    Axis { scale: Scale::with_cells(&of.values), ..axis(of) }
}

/// The edges of the cell about a place: half way to its neighbours, and as far where it has none.
pub fn edges_of(places: &[f64], i: usize) -> [f64; 2] {
    let neighbour = |by: isize| i.checked_add_signed(by).and_then(|other| places.get(other));
    [-1, 1].map(|by| match (neighbour(by), neighbour(-by)) {
        (Some(other), _) => 0.5 * (places[i] + other),
        (None, Some(other)) => places[i] - 0.5 * (other - places[i]),
        (None, None) => places[i],
    })
}
