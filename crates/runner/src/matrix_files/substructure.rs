//! Substructures of Abaqus and CalculiX (`*SUBSTRUCTURE MATRIX OUTPUT`): a `*USER ELEMENT` with its nodes and directions,
//! and matrices row by row, of which a symmetric one has the lower triangle.

use super::entries::{Entries, MOST_ROWS, Symmetry, check_size};
use super::error::{Problem, quoted};
use super::matrix::{Place, ReadMatrix, Stored};
use super::nodes::Numbering;
use super::source::{Listed, Source, choose};
use super::text::{Lines, number, words};

/// Whether a line is one of the keywords of such a file.
pub fn is_keyword(line: &str) -> bool {
    matches!(keyword(line).as_deref(), Some("*USERELEMENT" | "*MATRIX"))
}

/// The keyword of a line in capitals, without blanks.
fn keyword(line: &str) -> Option<String> {
    let line = line.trim_start();
    let is_one = line.starts_with('*') && !line.starts_with("**");
    is_one.then(|| without_blanks(line.split(',').next().unwrap_or_default()))
}

fn without_blanks(text: &str) -> String {
    text.chars().filter(|c| !c.is_whitespace()).map(|c| c.to_ascii_uppercase()).collect()
}

/// The value of a parameter of a keyword, in capitals and without blanks at its ends.
fn parameter(line: &str, name: &str) -> Option<String> {
    line.split(',').skip(1).find_map(|part| {
        let (key, value) = part.split_once('=').unwrap_or((part, ""));
        (without_blanks(key) == name).then(|| value.trim().to_uppercase())
    })
}

/// The names of the matrices.
pub fn list(source: &mut Source) -> Result<Vec<Listed>, Problem> {
    let mut lines = Lines::new(source)?;
    let mut names: Vec<Listed> = Vec::new();
    while let Some((line, text)) = lines.next()? {
        if keyword(text).as_deref() != Some("*MATRIX") {
            continue;
        }
        let name = matrix_name(line, text)?;
        match names.iter_mut().find(|other| other.name == name) {
            Some(other) => {
                other.problem = Some("it is there more than once: these may be matrices of elements; write those of the whole model or of a substructure".to_owned());
            }
            None => names.push(Listed { name, problem: None }),
        }
    }
    Ok(names)
}

fn matrix_name(line: u64, text: &str) -> Result<String, Problem> {
    parameter(text, "TYPE")
        .filter(|name| !name.is_empty())
        .ok_or_else(|| Problem::at(line, "the matrix has no type; the line should be like `*MATRIX,TYPE=STIFFNESS`"))
}

/// What the lines are about.
enum Part {
    Directions,
    Chosen,
    Other,
}

pub fn read(source: &mut Source, name: Option<&str>) -> Result<ReadMatrix, Problem> {
    let names = list(source)?;
    let chosen = names[choose(&names, name)?].name.clone();
    let mut element = Element::default();
    let mut part = Part::Other;
    let mut is_symmetric = true;
    let mut values = Triangle::default();
    let mut lines = Lines::new(source)?;
    let mut lists_nodes = false;
    while let Some((line, text)) = lines.next()? {
        let text = text.trim();
        if let Some(comment) = text.strip_prefix("**") {
            lists_nodes = (lists_nodes && element.add_nodes(comment)) || comment.trim() == "ELEMENT NODES";
            continue;
        }
        if let Some(keyword) = keyword(text) {
            part = match &*keyword {
                "*USERELEMENT" => {
                    is_symmetric = parameter(text, "UNSYMM").is_none();
                    Part::Directions
                }
                "*MATRIX" if matrix_name(line, text)? == chosen => Part::Chosen,
                _ => Part::Other,
            };
            continue;
        }
        match part {
            Part::Directions => element.directions.push((line, text.to_owned())),
            Part::Chosen => {
                for word in words(text) {
                    values.push(number(line, word)?, is_symmetric)?;
                }
            }
            Part::Other => {}
        }
    }
    lines.whole()?;
    let of_it = |problem: Problem| problem.of_matrix(&chosen);
    let places = element.places()?;
    let (mut entries, size) = values.finished(is_symmetric).map_err(of_it)?;
    let mut doubts = Vec::new();
    let places = match places {
        Some(places) if places.len() == size => {
            let mut numbering = Numbering::default();
            let numbers: Vec<u32> = places.iter().map(|place| numbering.number(*place)).collect::<Result<_, _>>()?;
            if numbers.iter().zip(0..).all(|(&number, row)| number == row) {
                Some(numbering.sort(&mut entries))
            } else {
                doubts.push(
                    "the nodes and directions in the file repeat, so that its rows are taken as they come".to_owned(),
                );
                None
            }
        }
        _ => {
            doubts.push(
                "the nodes and directions in the file do not fit its matrix, so that its rows are taken as they come"
                    .to_owned(),
            );
            None
        }
    };
    let (symmetry, stored) =
        if is_symmetric { (Symmetry::Symmetric, Stored::SymmetricTriangle) } else { (Symmetry::None, Stored::General) };
    let mut read = ReadMatrix::new(entries.into_matrix(size, symmetry).map_err(of_it)?, stored);
    read.degrees_of_freedom = places;
    read.doubts.append(&mut doubts);
    Ok(read)
}

/// Nodes of the element, and the lines with their directions.
#[derive(Default)]
struct Element {
    nodes: Vec<i64>,
    directions: Vec<(u64, String)>,
}

impl Element {
    /// Adds the nodes of a comment, if it lists any.
    fn add_nodes(&mut self, comment: &str) -> bool {
        let nodes: Option<Vec<i64>> = words(comment).map(|word| word.parse().ok()).collect();
        match nodes {
            Some(nodes) if !nodes.is_empty() && self.nodes.len() + nodes.len() <= MOST_ROWS => {
                self.nodes.extend(nodes);
                true
            }
            _ => false,
        }
    }

    /// The degrees of freedom, node by node. The first line has the directions of the first node; each other line the place of
    /// a node from which on there are other directions, and these.
    fn places(&self) -> Result<Option<Vec<Place>>, Problem> {
        let mut at_node: Vec<(usize, Vec<u32>)> = Vec::new();
        for (line, text) in &self.directions {
            let numbers = words(text).map(|word| word.parse::<u32>().map_err(|_| (line, word)));
            let numbers: Vec<u32> = numbers.collect::<Result<_, _>>().map_err(|(line, word)| {
                Problem::at(*line, format!("{} is no direction of a degree of freedom", quoted(word)))
            })?;
            match (&numbers[..], at_node.last()) {
                (directions, None) => at_node.push((0, directions.to_vec())),
                // A long list of directions goes on in a line of its own; that cannot be told from a new node.
                ([node, directions @ ..], Some((last, _))) if *node as usize > last + 1 => {
                    at_node.push((*node as usize - 1, directions.to_vec()));
                }
                _ => return Ok(None),
            }
        }
        let mut places = Vec::new();
        let mut next = at_node.iter().peekable();
        let mut directions: &[u32] = &[];
        for (position, node) in self.nodes.iter().enumerate() {
            if let Some((_, new)) = next.next_if(|(start, _)| *start == position) {
                directions = new;
            }
            places.extend(directions.iter().map(|direction| (*node, *direction)));
            if places.len() > MOST_ROWS {
                return Ok(None);
            }
        }
        Ok(Some(places))
    }
}

/// Values row by row: up to the diagonal, or all where the matrix is not symmetric.
#[derive(Default)]
struct Triangle {
    entries: Entries,
    /// Values of a matrix whose size is known at the end alone.
    all: Vec<f64>,
    row: u32,
    column: u32,
}

impl Triangle {
    fn push(&mut self, value: f64, is_symmetric: bool) -> Result<(), Problem> {
        if !is_symmetric {
            self.all.push(value);
            return Ok(());
        }
        if value != 0.0 {
            self.entries.push(self.row, self.column, value)?;
        }
        self.column += 1;
        if self.column > self.row {
            (self.row, self.column) = (self.row + 1, 0);
        }
        Ok(())
    }

    fn finished(mut self, is_symmetric: bool) -> Result<(Entries, usize), Problem> {
        if is_symmetric {
            if self.column > 0 {
                let text = format!(
                    "the file ends within row {}, after {} of {} values; it is cut off",
                    self.row + 1,
                    self.column,
                    self.row + 1
                );
                return Err(Problem::new(text));
            }
            check_size(self.row as usize)?;
            return Ok((self.entries, self.row as usize));
        }
        let size = self.all.len().isqrt();
        if size * size != self.all.len() {
            let text = format!(
                "there are {} values, which is no square of a number of rows; the file is cut off",
                self.all.len()
            );
            return Err(Problem::new(text));
        }
        check_size(size)?;
        for (at, &value) in self.all.iter().enumerate().filter(|(_, value)| **value != 0.0) {
            self.entries.push((at / size) as u32, (at % size) as u32, value)?;
        }
        Ok((self.entries, size))
    }
}
