//! Which slices of a grid a figure shows, each as a panel: those that fit on a page, spread over their axes.

use crate::picture::view::GridView;

/// Largest number of panels of a figure.
pub const MOST_PANELS: usize = 12;

/// The slices of a grid that a figure shows, by their numbers.
pub fn drawn_slices(view: &GridView) -> Vec<usize> {
    let lengths: Vec<usize> = view.sliced_axes().map(|axis| axis.values.len()).collect();
    let mut numbers = vec![0];
    for (&length, chosen) in lengths.iter().zip(chosen(&lengths)) {
        let places = spread(chosen, length);
        numbers = numbers.iter().flat_map(|number| places.iter().map(move |place| number * length + place)).collect();
    }
    numbers
}

/// What is said of slices that are left out: of each axis how many of its values are drawn.
pub fn left_out(view: &GridView) -> Option<String> {
    let lengths: Vec<usize> = view.sliced_axes().map(|axis| axis.values.len()).collect();
    let chosen = chosen(&lengths);
    let thinned: Vec<(&str, usize, usize)> = view
        .sliced_axes()
        .zip(lengths.iter().zip(&chosen))
        .filter(|(_, (length, chosen))| chosen < length)
        .map(|(axis, (&length, &chosen))| (&*axis.name_in_job, chosen, length))
        .collect();
    let (first, ..) = thinned.first()?;
    let axes: Vec<String> =
        thinned.iter().map(|(name, chosen, length)| format!("{chosen} of the {length} values of {name}")).collect();
    Some(format!(
        "{} panels are too many for one figure; those with {} are drawn. `--at {first}=VALUE` draws any other",
        view.slices(),
        axes.join(" and ")
    ))
}

/// How many values of axes of these lengths are drawn, so that their combinations are few enough.
fn chosen(lengths: &[usize]) -> Vec<usize> {
    let mut chosen = lengths.to_vec();
    while chosen.iter().product::<usize>() > MOST_PANELS
        && let Some(longest) = chosen.iter_mut().max()
    {
        *longest = if *longest > MOST_PANELS { MOST_PANELS } else { *longest - 1 };
    }
    chosen
}

/// So many of the places on an axis, from one end to the other; of a single one the middle.
pub fn spread(count: usize, length: usize) -> Vec<usize> {
    match count {
        0 => Vec::new(),
        1 => vec![length.saturating_sub(1) / 2],
        _ => (0..count).map(|i| (i * (length - 1) + (count - 1) / 2) / (count - 1)).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn panels_are_spread_from_end_to_end_of_each_axis() {
        assert_eq!(chosen(&[5, 2]), [5, 2]);
        assert_eq!(chosen(&[60]), [12]);
        assert_eq!(chosen(&[8, 8]), [4, 3]);
        assert_eq!(chosen(&[1000, 1000, 2]), [3, 2, 2]);
        assert!(chosen(&[]).is_empty());
        assert_eq!(spread(12, 12), (0..12).collect::<Vec<_>>());
        assert_eq!(spread(3, 9), [0, 4, 8]);
        assert_eq!((spread(1, 9), spread(1, 1)), (vec![4], vec![0]));
        for length in 12..100 {
            let places = spread(12, length);
            assert_eq!((places[0], places[11]), (0, length - 1));
            assert!(places.windows(2).all(|pair| pair[0] < pair[1]), "{length}: {places:?}");
        }
    }
}
