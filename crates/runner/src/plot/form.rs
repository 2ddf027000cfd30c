//! How a grid is drawn: as an area, or as curves.

use crate::picture::view::{GridView, ViewAxis, is_family};

/// How the cells of a grid are drawn.
pub enum Form<'a> {
    /// Curves along one axis, one for each value of another.
    Curves(Along<'a>),
    /// An area over two axes.
    Area { vertical: &'a ViewAxis, horizontal: &'a ViewAxis },
}

/// Along which axis curves run.
#[derive(Clone, Copy)]
pub struct Along<'a> {
    pub axis: &'a ViewAxis,
    /// The axis whose values have a curve each.
    pub several: Option<&'a ViewAxis>,
    /// Whether the curves run along the axis that is the vertical one of areas.
    pub is_vertical: bool,
}

impl<'a> Form<'a> {
    /// The form that suits a grid; none for a single cell.
    pub fn for_grid(view: &'a GridView) -> Option<Self> {
        let horizontal = view.horizontal()?;
        let Some(vertical) = view.vertical() else {
            return Some(Self::Curves(Along { axis: horizontal, several: None, is_vertical: false }));
        };
        Some(if is_family(vertical, horizontal) {
            Self::Curves(Along { axis: horizontal, several: Some(vertical), is_vertical: false })
        } else if is_family(horizontal, vertical) {
            Self::Curves(Along { axis: vertical, several: Some(horizontal), is_vertical: true })
        } else {
            Self::Area { vertical, horizontal }
        })
    }
}
