//! Matrix Market files: a header `%%MatrixMarket matrix FORMAT FIELD SYMMETRY`, a line of sizes, then entries.
//!
//! R. Boisvert, R. Pozo, K. Remington, The Matrix Market Exchange Formats, NISTIR 5935 (1996).

use super::{Entries, Matrix};

/// What the file stores of a matrix.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Symmetry {
    General,
    Symmetric,
    SkewSymmetric,
}

/// Reads the one matrix of a file.
pub(super) fn read(bytes: &[u8], name: Option<&str>) -> Result<Matrix, String> {
    if let Some(name) = name {
        return Err(format!(
            "matrix = \"{name}\": a Matrix Market file has one matrix without a name; remove `matrix`"
        ));
    }
    let text = std::str::from_utf8(bytes).map_err(|_| "the file is no text".to_owned())?;
    let mut lines = text.lines().enumerate().map(|(i, line)| (i + 1, line.trim()));
    let header = lines.next().map_or("", |(_, line)| line).to_lowercase();
    let words: Vec<&str> = header.split_whitespace().collect();
    let [_, "matrix", format, field, symmetry] = words[..] else {
        return Err("line 1: the header must be %%MatrixMarket matrix FORMAT FIELD SYMMETRY".to_owned());
    };
    if !matches!(field, "real" | "integer" | "double") {
        return Err(format!("line 1: entries are {field}; only real ones are read"));
    }
    let symmetry = match symmetry {
        "general" => Symmetry::General,
        "symmetric" => Symmetry::Symmetric,
        "skew-symmetric" => Symmetry::SkewSymmetric,
        other => {
            return Err(format!("line 1: the symmetry is {other}; general, symmetric and skew-symmetric are read"));
        }
    };
    let is_array = match format {
        "array" => true,
        "coordinate" => false,
        other => return Err(format!("line 1: the format is {other}; coordinate and array are read")),
    };
    let mut lines = lines.filter(|(_, line)| !line.is_empty() && !line.starts_with('%'));
    let (at, line) = lines.next().ok_or("there is no line with the sizes")?;
    let sizes: Option<Vec<u64>> = line.split_whitespace().map(|word| word.parse().ok()).collect();
    let sizes = sizes.ok_or_else(|| format!("line {at}: \"{line}\" are no sizes"))?;
    let (rows, columns, count) = match sizes[..] {
        [rows, columns, count] if !is_array => (rows, columns, count),
        [rows, columns] if is_array => (rows, columns, 0),
        _ => {
            return Err(format!(
                "line {at}: \"{line}\" has {} numbers; {} are expected",
                sizes.len(),
                if is_array { 2 } else { 3 }
            ));
        }
    };
    // The shortest entry, "1 1 0" and the end of its line, has six bytes.
    let mut entries = Entries::new(rows, columns, count, bytes.len() / 2)?;
    if symmetry != Symmetry::General && rows != columns {
        return Err(format!("the matrix is {rows} by {columns}, but said to be symmetric"));
    }
    let mut add = |at: usize, row: u64, column: u64, value: f64| {
        let placed = |error: String| format!("line {at}: {error}");
        entries.add(row, column, value).map_err(placed)?;
        match symmetry {
            Symmetry::Symmetric if row != column => entries.add(column, row, value).map_err(placed),
            Symmetry::SkewSymmetric if row != column => entries.add(column, row, -value).map_err(placed),
            _ => Ok(()),
        }
    };
    let number = |at: usize, word: &str| -> Result<f64, String> {
        word.parse().map_err(|_| format!("line {at}: \"{word}\" is no number"))
    };
    let mut found = 0;
    let (mut row, mut column) = (if symmetry == Symmetry::SkewSymmetric { 1 } else { 0 }, 0);
    for (at, line) in lines {
        if is_array {
            for word in line.split_whitespace() {
                add(at, row, column, number(at, word)?)?;
                found += 1;
                row += 1;
                if row >= rows {
                    column += 1;
                    row = match symmetry {
                        Symmetry::General => 0,
                        Symmetry::Symmetric => column,
                        Symmetry::SkewSymmetric => column + 1,
                    };
                }
            }
            continue;
        }
        let words: Vec<&str> = line.split_whitespace().collect();
        let [row, column, value] = words[..] else {
            return Err(format!("line {at}: \"{line}\" is no entry; row, column and value are expected"));
        };
        let index = |word: &str| match word.parse::<u64>() {
            Ok(index) if index >= 1 => Ok(index - 1),
            _ => Err(format!("line {at}: \"{word}\" is no row or column; they count from 1")),
        };
        add(at, index(row)?, index(column)?, number(at, value)?)?;
        found += 1;
    }
    let expected = match symmetry {
        _ if !is_array => count,
        Symmetry::General => rows * columns,
        Symmetry::Symmetric => rows * (rows + 1) / 2,
        Symmetry::SkewSymmetric => rows * (rows - 1) / 2,
    };
    if found != expected {
        return Err(format!("the file has {found} entries, but says {expected}: it is cut off or damaged"));
    }
    entries.matrix()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn values(text: &str) -> Vec<(usize, usize, f64)> {
        let read = read(text.as_bytes(), None).unwrap();
        read.triplet_iter().map(|entry| (entry.row, entry.col, *entry.val)).collect()
    }

    #[test]
    fn triangles_are_completed() {
        let head = "%%MatrixMarket matrix coordinate real";
        let body = "\n% a comment\n2 2 2\n1 1 4.0\n2 1 -1.5e0\n";
        assert_eq!(values(&format!("{head} general{body}")), [(0, 0, 4.0), (1, 0, -1.5)]);
        assert_eq!(values(&format!("{head} symmetric{body}")), [(0, 0, 4.0), (1, 0, -1.5), (0, 1, -1.5)]);
        assert_eq!(values(&format!("{head} skew-symmetric\n2 2 1\n2 1 3\n")), [(1, 0, 3.0), (0, 1, -3.0)]);
        let array = "%%MatrixMarket matrix array integer symmetric\n2 2\n1\n2\n3\n";
        assert_eq!(values(array), [(0, 0, 1.0), (1, 0, 2.0), (0, 1, 2.0), (1, 1, 3.0)]);
        let skew = "%%MatrixMarket matrix array real skew-symmetric\n3 3\n1\n2\n3\n";
        assert_eq!(values(skew), [(1, 0, 1.0), (2, 0, 2.0), (0, 1, -1.0), (2, 1, 3.0), (0, 2, -2.0), (1, 2, -3.0)]);
    }

    #[test]
    fn what_is_wrong_is_said_with_its_line() {
        let head = "%%MatrixMarket matrix coordinate real general\n";
        for (text, message) in [
            ("%%MatrixMarket matrix coordinate complex general\n1 1 1\n1 1 1 0\n".to_owned(), "entries are complex"),
            (format!("{head}2 2 1\n3 1 1.0\n"), "line 3: an entry stands in row 3, column 1, but the matrix is 2 by 2"),
            (format!("{head}2 2 1\n0 1 1.0\n"), "line 3: \"0\" is no row or column; they count from 1"),
            (format!("{head}2 2 1\n1 1 nan\n"), "is NaN; it must be a finite number"),
            (format!("{head}2 2 2\n1 1 1\n"), "the file has 1 entries, but says 2"),
            (format!("{head}2 2 99999999999\n1 1 1\n"), "but the file has room for"),
            (format!("{head}2 x 1\n"), "line 2: \"2 x 1\" are no sizes"),
        ] {
            let error = read(text.as_bytes(), None).unwrap_err();
            assert!(error.contains(message), "{text:?}: {error}");
        }
        assert!(read(head.as_bytes(), Some("K")).unwrap_err().contains("remove `matrix`"));
    }
}
