//! The schema of Arrow that goes into the footer of a Parquet file. From it pyarrow, pandas and polars take the unit and
//! the meaning of each column, for which Parquet itself has no place.
//!
//! It is a message of Arrow's interprocess format: tables of the FlatBuffers that Schema.fbs and Message.fbs of the
//! Apache Arrow format describe. The numbers of the slots are the places of the fields there.

use base64::Engine as _;
use base64::prelude::BASE64_STANDARD;
use flatbuffers::{FlatBufferBuilder, TableFinishedWIPOffset, VOffsetT, WIPOffset};

use super::column::{Field, Kind};

/// Its key in the footer.
pub const KEY: &str = "ARROW:schema";

type Table = WIPOffset<TableFinishedWIPOffset>;

/// `MetadataVersion.V5`.
const VERSION: i16 = 4;

/// `MessageHeader.Schema`.
const HEADER: u8 = 1;

/// The members of the union `Type`.
const INT: u8 = 2;
const FLOATING_POINT: u8 = 3;
const UTF8: u8 = 5;
const LIST: u8 = 12;

/// `Precision.DOUBLE`.
const DOUBLE: i16 = 2;

/// What stands before a message: a mark, and the length of the message in four bytes.
const CONTINUATION: [u8; 4] = [0xff; 4];

/// The schema of columns, as text. Its parts are in the order in which Arrow's own library writes them, so that a file has
/// the same bytes as one that it wrote.
pub fn encoded(fields: &[Field]) -> String {
    let mut builder = FlatBufferBuilder::new();
    let fields: Vec<Table> = fields.iter().map(|field| column(&mut builder, field)).collect();
    let fields = builder.create_vector(&fields);
    let start = builder.start_table();
    builder.push_slot_always(slot(1), fields);
    let schema = builder.end_table(start);
    let start = builder.start_table();
    builder.push_slot_always(slot(0), VERSION);
    builder.push_slot_always(slot(1), HEADER);
    builder.push_slot_always(slot(2), schema);
    let message = builder.end_table(start);
    builder.finish_minimal(message);
    let message = builder.finished_data();
    let length = (message.len() as u32).to_le_bytes();
    BASE64_STANDARD.encode([&CONTINUATION[..], &length, message].concat())
}

/// The place of a field in the list of a table's fields.
const fn slot(field: u16) -> VOffsetT {
    4 + 2 * field
}

/// The table of a column.
fn column(builder: &mut FlatBufferBuilder<'_>, column: &Field) -> Table {
    let metadata = [("long_name", &*column.long_name), ("unit", &*column.unit)];
    let metadata = if column.long_name.is_empty() { &[] } else { &metadata[..] };
    let (kind, is_nullable, element) = match column.kind {
        Kind::Integer => (INT, false, None),
        Kind::Real => (FLOATING_POINT, false, None),
        Kind::OptionalReal => (FLOATING_POINT, true, None),
        Kind::Text => (UTF8, false, None),
        Kind::OptionalText => (UTF8, true, None),
        Kind::Integers => (LIST, false, Some(INT)),
        Kind::Reals => (LIST, false, Some(FLOATING_POINT)),
    };
    field(builder, &column.name, kind, is_nullable, element, metadata)
}

/// The name of the elements of a list.
pub const ELEMENT: &str = "element";

/// `Field` of Schema.fbs; a list has elements of some type.
fn field(
    builder: &mut FlatBufferBuilder<'_>,
    name: &str,
    kind: u8,
    is_nullable: bool,
    element: Option<u8>,
    metadata: &[(&str, &str)],
) -> Table {
    let pairs: Vec<Table> = metadata
        .iter()
        .map(|(key, value)| {
            let (key, value) = (builder.create_string(key), builder.create_string(value));
            let start = builder.start_table();
            builder.push_slot_always(slot(0), key);
            builder.push_slot_always(slot(1), value);
            builder.end_table(start)
        })
        .collect();
    let pairs = (!pairs.is_empty()).then(|| builder.create_vector(&pairs));
    let name = builder.create_string(name);
    // Readers expect the list of children even where there are none.
    let (of_kind, children) = match (kind, element) {
        (INT, _) => {
            let children = builder.create_vector::<Table>(&[]);
            let start = builder.start_table();
            builder.push_slot_always(slot(1), true);
            builder.push_slot_always(slot(0), 64_i32);
            (builder.end_table(start), children)
        }
        (FLOATING_POINT, _) => {
            let children = builder.create_vector::<Table>(&[]);
            let start = builder.start_table();
            builder.push_slot_always(slot(0), DOUBLE);
            (builder.end_table(start), children)
        }
        (_, element) => {
            let element = element.map(|element| field(builder, ELEMENT, element, false, None, &[]));
            let start = builder.start_table();
            let of_kind = builder.end_table(start);
            (of_kind, builder.create_vector(element.as_slice()))
        }
    };
    let start = builder.start_table();
    builder.push_slot_always(slot(0), name);
    builder.push_slot_always(slot(2), kind);
    builder.push_slot(slot(1), is_nullable, false);
    builder.push_slot_always(slot(5), children);
    builder.push_slot_always(slot(3), of_kind);
    if let Some(pairs) = pairs {
        builder.push_slot_always(slot(6), pairs);
    }
    builder.end_table(start)
}
