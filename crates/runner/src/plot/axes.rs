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
