//! Reading whole columns of Parquet tables.

use parquet::basic::{ConvertedType, LogicalType, Type as PhysicalType};
use parquet::column::reader::{ColumnReader, ColumnReaderImpl};
use parquet::data_type::{ByteArray, DataType};
use parquet::errors::ParquetError;
use parquet::file::reader::{ChunkReader, FileReader as _, SerializedFileReader};
use parquet::schema::types::ColumnDescriptor;

use super::column::Lists;

/// Most bytes of the texts of a column. A text that a file holds once may stand in every row.
const MOST_TEXT: usize = 1 << 26;

/// Columns of a Parquet file that were read.
pub struct ReadTable {
    /// The pairs of key and value in the footer.
    pairs: Vec<(String, Option<String>)>,
    /// The columns, in the order of the file.
    pub columns: Vec<ReadColumn>,
    /// The number of rows.
    pub rows: usize,
}

/// A column that was read.
pub struct ReadColumn {
    /// Name.
    pub name: String,
    /// Values, one for each row.
    pub values: ReadValues,
}

/// The values of a column, `None` where there is none.
pub enum ReadValues {
    /// Whole numbers.
    Integer(Vec<Option<i64>>),
    /// Numbers.
    Real(Vec<Option<f64>>),
    /// Texts.
    Text(Vec<Option<String>>),
    /// Lists of whole numbers.
    Integers(Lists<i64>),
    /// Lists of numbers.
    Reals(Lists<f64>),
}

impl ReadTable {
    /// Reads the columns at some places.
    ///
    /// # Errors
    /// What is wrong with the file, and a column of another type.
    pub fn read<R: ChunkReader + 'static>(file: R, places: &[usize]) -> Result<Self, String> {
        let text = |error: ParquetError| error.to_string();
        let file = SerializedFileReader::new(file).map_err(text)?;
        let metadata = file.metadata().file_metadata();
        let pairs = metadata.key_value_metadata().into_iter().flatten();
        let pairs = pairs.map(|pair| (pair.key.clone(), pair.value.clone())).collect();
        let schema = metadata.schema_descr();
        let mut columns = Vec::new();
        let mut leaves = Vec::new();
        for leaf in (0..schema.num_columns()).filter(|leaf| places.contains(&schema.get_column_root_idx(*leaf))) {
            let name = schema.get_column_root(leaf).name().to_owned();
            let is_optional = schema.get_column_root(leaf).is_optional();
            let values = empty(&schema.column(leaf), is_optional).map_err(|other| {
                format!("its column {name} holds {other}; INT64, DOUBLE and lists of them are read, and texts")
            })?;
            if leaves.last().is_some_and(|(root, _)| *root == schema.get_column_root_idx(leaf)) {
                return Err(format!("its column {name} holds several values"));
            }
            leaves.push((schema.get_column_root_idx(leaf), leaf));
            columns.push(ReadColumn { name, values });
        }
        let mut rows = 0;
        for group in 0..file.num_row_groups() {
            let group = file.get_row_group(group).map_err(text)?;
            let of_group = usize::try_from(group.metadata().num_rows()).map_err(|error| error.to_string())?;
            rows += of_group;
            for (column, (_, leaf)) in columns.iter_mut().zip(&leaves) {
                let descriptor = schema.column(*leaf);
                let reader = group.get_column_reader(*leaf).map_err(text)?;
                column
                    .values
                    .extend(reader, &descriptor, of_group)
                    .map_err(|why| format!("its column {} cannot be read: {why}", column.name))?;
            }
        }
        Ok(Self { pairs, columns, rows })
    }

    /// The text under a key of the footer.
    pub fn pair(&self, key: &str) -> Option<&str> {
        self.pairs.iter().find(|(other, _)| other == key)?.1.as_deref()
    }

    /// The values of a column.
    pub fn column(&self, name: &str) -> Option<&ReadValues> {
        self.columns.iter().find(|column| column.name == name).map(|column| &column.values)
    }

    /// A column of whole numbers, one in each row.
    ///
    /// # Errors
    /// If it is missing, holds something else, or has gaps.
    pub fn integers(&self, name: &str) -> Result<Vec<i64>, String> {
        match self.column(name) {
            Some(ReadValues::Integer(values)) => without_gaps(name, values),
            Some(_) => Err(format!("column {name} is not of integers")),
            None => Err(format!("column {name} is missing")),
        }
    }

    /// A column of numbers, one in each row.
    ///
    /// # Errors
    /// If it is missing, holds something else, or has gaps.
    pub fn reals(&self, name: &str) -> Result<Vec<f64>, String> {
        match self.column(name) {
            Some(ReadValues::Real(values)) => without_gaps(name, values),
            Some(_) => Err(format!("column {name} is not of numbers")),
            None => Err(format!("column {name} is missing")),
        }
    }
}

fn without_gaps<T: Copy>(name: &str, values: &[Option<T>]) -> Result<Vec<T>, String> {
    values.iter().copied().collect::<Option<_>>().ok_or_else(|| format!("column {name} has a value missing"))
}

/// No values yet of the type of a column, or what else it holds. A list, or a value that is none, may be optional.
fn empty(column: &ColumnDescriptor, is_optional: bool) -> Result<ReadValues, String> {
    let is_list = column.max_rep_level() > 0;
    let optional = column.self_type().is_optional() || (!is_list && is_optional);
    let known = i16::from(optional) + if is_list { 1 + i16::from(is_optional) } else { 0 };
    if column.max_def_level() != known {
        return Err("values in groups".to_owned());
    }
    let is_plain = column.logical_type_ref().is_none() && column.converted_type() == ConvertedType::NONE;
    let is_text = matches!(column.logical_type_ref(), Some(LogicalType::String))
        || column.converted_type() == ConvertedType::UTF8;
    Ok(match (column.physical_type(), column.max_rep_level()) {
        (PhysicalType::INT64, 0) if is_plain => ReadValues::Integer(Vec::new()),
        (PhysicalType::DOUBLE, 0) if is_plain => ReadValues::Real(Vec::new()),
        (PhysicalType::BYTE_ARRAY, 0) if is_text => ReadValues::Text(Vec::new()),
        (PhysicalType::INT64, 1) if is_plain => ReadValues::Integers(Lists::default()),
        (PhysicalType::DOUBLE, 1) if is_plain => ReadValues::Reals(Lists::default()),
        (other, _) => return Err(other.to_string()),
    })
}

impl ReadValues {
    /// Adds the rows of a group.
    fn extend(&mut self, reader: ColumnReader, column: &ColumnDescriptor, rows: usize) -> Result<(), String> {
        match (self, reader) {
            (Self::Integer(values), ColumnReader::Int64ColumnReader(reader)) => {
                values.extend(Levelled::read(reader, column, rows)?.optional()?);
            }
            (Self::Real(values), ColumnReader::DoubleColumnReader(reader)) => {
                values.extend(Levelled::read(reader, column, rows)?.optional()?);
            }
            (Self::Text(values), ColumnReader::ByteArrayColumnReader(reader)) => {
                let mut bytes: usize = values.iter().flatten().map(String::len).sum();
                for value in Levelled::read(reader, column, rows)?.optional()? {
                    bytes += value.as_ref().map_or(0, ByteArray::len);
                    if bytes > MOST_TEXT {
                        return Err(format!("its texts are longer than {MOST_TEXT} bytes"));
                    }
                    let text = |bytes: ByteArray| String::from_utf8(bytes.data().to_vec());
                    values.push(value.map(text).transpose().map_err(|error| error.to_string())?);
                }
            }
            (Self::Integers(lists), ColumnReader::Int64ColumnReader(reader)) => {
                Levelled::read(reader, column, rows)?.lists_into(lists)?;
            }
            (Self::Reals(lists), ColumnReader::DoubleColumnReader(reader)) => {
                Levelled::read(reader, column, rows)?.lists_into(lists)?;
            }
            _ => return Err("it changes its type".to_owned()),
        }
        Ok(())
    }
}

/// Values with the levels by which Parquet tells gaps and lists.
struct Levelled<T> {
    values: Vec<T>,
    /// How much of what is optional or repeated is there, for each value or gap.
    definitions: Vec<i16>,
    /// The level at which a value is there.
    defined: i16,
    /// The level at which a value is missing in a list that goes on; smaller ones are empty lists.
    gap: Option<i16>,
    /// 0 where a row begins.
    repetitions: Vec<i16>,
    rows: usize,
}

impl<T: Clone> Levelled<T> {
    fn read<D: DataType<T = T>>(
        mut reader: ColumnReaderImpl<D>,
        column: &ColumnDescriptor,
        rows: usize,
    ) -> Result<Self, String> {
        let defined = column.max_def_level();
        let gap = column.self_type().is_optional().then_some(defined - 1);
        let (mut values, mut definitions, mut repetitions) = (Vec::new(), Vec::new(), Vec::new());
        let mut left = rows;
        while left > 0 {
            let read = reader.read_records(left, Some(&mut definitions), Some(&mut repetitions), &mut values);
            match read.map_err(|error| error.to_string())? {
                (0, _, _) => return Err("rows are missing".to_owned()),
                (records, _, _) => left = left.checked_sub(records).ok_or("it has more rows than it should")?,
            }
        }
        Ok(Self { values, definitions, defined, gap, repetitions, rows })
    }

    /// One value or none for each row.
    fn optional(self) -> Result<Vec<Option<T>>, String> {
        if self.defined == 0 {
            return Ok(self.values.into_iter().map(Some).collect());
        }
        let defined = self.defined;
        let mut values = self.values.into_iter();
        let value_at =
            |level| if level == defined { values.next().ok_or("values are missing").map(Some) } else { Ok(None) };
        Ok(self.definitions.into_iter().map(value_at).collect::<Result<_, _>>()?)
    }

    /// Adds a list for each row.
    fn lists_into(self, lists: &mut Lists<T>) -> Result<(), String>
    where
        T: Copy,
    {
        let mut values = self.values.into_iter();
        let levels = self.definitions.iter().zip(&self.repetitions);
        let expected = lists.len() + self.rows;
        let mut list = Vec::new();
        for (place, (definition, repetition)) in levels.enumerate() {
            if place > 0 && *repetition == 0 {
                lists.push(list.drain(..));
            }
            if *definition == self.defined {
                list.push(values.next().ok_or("values are missing")?);
            } else if self.gap == Some(*definition) {
                return Err("a value is missing in a list".to_owned());
            }
        }
        if self.rows > 0 {
            lists.push(list);
        }
        if lists.len() == expected { Ok(()) } else { Err("its lists are not as many as its rows".to_owned()) }
    }
}
