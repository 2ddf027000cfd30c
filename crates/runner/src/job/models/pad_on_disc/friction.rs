//! The friction law of a job: `[model.friction]`.

use std::borrow::Cow;
use std::fmt;
use std::path::Path;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::value::MapAccessDeserializer;
use serde::de::{MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};
use serde_json::json;
use stickslip_core::friction::law::LawKind;
use stickslip_core::friction::measured_curve::{CurveError, HIGHEST_SPEED, MeasuredCurve, SharedCurve};
use stickslip_core::model::quantity::{Quantity, Role};
use stickslip_core::models::pad_on_disc::parameters::Friction;
use toml::Spanned;
use toml_edit::{DocumentMut, InlineTable, Item, Value};

use super::overrides::{Overrides, section_properties};
use crate::files::csv_file::{CsvFile, MOST_ROWS, read_csv};
use crate::job::diagnosis::{Complaint, Complaints};
use crate::job::keys::nearest;
use crate::job::model::{Parts, written};
use crate::shell::shown;
use crate::units::significant;

/// Names of friction laws.
pub const LAWS: [&str; 3] = ["stribeck", "rational", "table"];

/// Columns of a measured curve; the last one may be left out.
const COLUMNS: [&str; 3] = ["speed", "coefficient", "std"];

/// `[model.friction]`: the law, its measured curve, and its values.
#[derive(Debug, Default, Serialize)]
pub struct FrictionSpec {
    pub law: Option<Spanned<LawSpec>>,
    pub table: Option<Spanned<TableSpec>>,
    pub smoothing: Option<Spanned<SmoothingSpec>>,
    #[serde(flatten)]
    pub values: Overrides,
}

/// A friction law by its name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum LawSpec {
    Stribeck,
    Rational,
    Table,
}

impl LawSpec {
    pub fn from_name(name: &str) -> Result<Self, String> {
        match name {
            "stribeck" => Ok(Self::Stribeck),
            "rational" => Ok(Self::Rational),
            "table" => Ok(Self::Table),
            _ => {
                let hint = nearest(name, LAWS).map_or(String::new(), |right| format!("; did you mean \"{right}\"?"));
                Err(format!("there is no friction law \"{name}\"{hint} (there are {})", LAWS.join(", ")))
            }
        }
    }

    fn name(self) -> &'static str {
        LAWS[self as usize]
    }

    /// The law that a parameter of friction belongs to, where that is not this one.
    fn stranger(self, name: &str) -> Option<&'static str> {
        let laws: &[Self] = match name {
            "stribeck_exponent" => &[Self::Stribeck],
            "kinetic_coefficient" | "stribeck_velocity" | "viscous" => &[Self::Stribeck, Self::Rational],
            "band" | "table" | "smoothing" => &[Self::Table],
            _ => return None,
        };
        if laws.contains(&self) {
            return None;
        }
        Some(if laws.len() == 2 {
            "\"stribeck\" or \"rational\""
        } else {
            ["\"stribeck\"", "", "\"table\""][laws[0] as usize]
        })
    }

    /// What is wrong with a key of another law, if it is one.
    pub fn refusal(self, name: &str, key: &str) -> Option<String> {
        self.stranger(name).map(|laws| {
            let own = self.name();
            format!("{key} belongs to law = {laws}, but the friction law is \"{own}\"; remove it, or change the law")
        })
    }
}

impl From<&LawKind> for LawSpec {
    fn from(law: &LawKind) -> Self {
        match law {
            LawKind::Stribeck => Self::Stribeck,
            LawKind::Rational => Self::Rational,
            LawKind::Table(_) => Self::Table,
        }
    }
}

/// How the rows of a measured curve are smoothed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum SmoothingSpec {
    Spline,
}

impl SmoothingSpec {
    pub fn from_name(name: &str) -> Result<Self, String> {
        match name {
            SPLINE => Ok(Self::Spline),
            _ => Err(format!("there is no smoothing \"{name}\" of a friction curve (there is {SPLINE})")),
        }
    }
}

/// The name of the smoothing.
pub const SPLINE: &str = "spline";

/// A measured curve: a file, or its columns.
#[derive(Debug, Clone, Serialize)]
#[serde(untagged)]
pub enum TableSpec {
    /// Path, relative to the job's.
    Csv(String),
    /// The curve itself.
    Columns(CurveColumns),
}

/// The columns of a measured curve, before it is smoothed.
#[derive(Debug, Clone, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct CurveColumns {
    pub speed: Vec<f64>,
    pub coefficient: Vec<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub std: Option<Vec<f64>>,
}

impl From<&MeasuredCurve> for CurveColumns {
    fn from(curve: &MeasuredCurve) -> Self {
        let (coefficients, deviations) = match curve.smoothing() {
            Some(measured) => (&measured.coefficients[..], measured.deviations.as_deref()),
            None => (curve.coefficients(), curve.deviations()),
        };
        Self {
            speed: curve.speeds().to_vec(),
            coefficient: coefficients.to_vec(),
            std: deviations.map(<[f64]>::to_vec),
        }
    }
}

impl CurveColumns {
    fn curve(&self, smoothing: Option<SmoothingSpec>) -> Result<SharedCurve, CurveError> {
        let made = match smoothing {
            Some(SmoothingSpec::Spline) => MeasuredCurve::smoothed,
            None => MeasuredCurve::new,
        };
        made(&self.speed, &self.coefficient, self.std.as_deref()).map(SharedCurve::new)
    }
}

impl<'de> Deserialize<'de> for TableSpec {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct TableVisitor;

        impl<'de> Visitor<'de> for TableVisitor {
            type Value = TableSpec;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("the path of a CSV file, or { speed = [...], coefficient = [...] }")
            }

            fn visit_str<E>(self, path: &str) -> Result<TableSpec, E> {
                Ok(TableSpec::Csv(path.to_owned()))
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<TableSpec, A::Error> {
                CurveColumns::deserialize(MapAccessDeserializer::new(map)).map(TableSpec::Columns)
            }
        }

        deserializer.deserialize_any(TableVisitor)
    }
}

impl<'de> Deserialize<'de> for FrictionSpec {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct FrictionVisitor;

        impl<'de> Visitor<'de> for FrictionVisitor {
            type Value = FrictionSpec;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a table of the friction law and its values")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<FrictionSpec, A::Error> {
                let mut spec = FrictionSpec::default();
                while let Some(key) = map.next_key::<Spanned<String>>()? {
                    match key.get_ref().as_str() {
                        "law" => spec.law = Some(map.next_value()?),
                        "table" => spec.table = Some(map.next_value()?),
                        "smoothing" => spec.smoothing = Some(map.next_value()?),
                        _ => drop(spec.values.insert(key, map.next_value()?)),
                    }
                }
                Ok(spec)
            }
        }

        deserializer.deserialize_map(FrictionVisitor)
    }
}

impl JsonSchema for FrictionSpec {
    fn schema_name() -> Cow<'static, str> {
        "Friction".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let mut properties = section_properties("friction");
        let column = |description: &str| {
            let number = json!({ "type": "number", "minimum": 0 });
            json!({ "type": "array", "items": number, "minItems": 2, "description": description })
        };
        properties.insert(
            "law".to_owned(),
            json!({ "enum": LAWS, "default": LAWS[0], "description": "The friction law. A value of another law is refused" }),
        );
        properties.insert(
            "table".to_owned(),
            json!({
                "description": "The measured curve of `law = \"table\"`: a CSV file, relative to the job's folder, or its columns, `{ speed = [...], coefficient = [...], std = [...] }`",
                "anyOf": [
                    { "type": "string" },
                    {
                        "type": "object",
                        "properties": {
                            "speed": column("Sliding speeds in rising order, m/s"),
                            "coefficient": column("Friction coefficients"),
                            "std": column("Standard deviations of the coefficients"),
                        },
                        "required": ["speed", "coefficient"],
                        "additionalProperties": false,
                    },
                ],
            }),
        );
        properties.insert(
            "smoothing".to_owned(),
            json!({
                "const": SPLINE,
                "description": "`\"spline\"` replaces the rows of a noisy `table` by a cubic smoothing spline, as smooth as generalised cross-validation says; without it the curve goes through the rows as they are",
            }),
        );
        json_schema!({ "type": "object", "properties": properties, "additionalProperties": false })
    }
}

impl FrictionSpec {
    /// A law and its values.
    pub fn written_out(law: &LawKind, values: Overrides) -> Self {
        let table = law.table().map(|curve| written(TableSpec::Columns(CurveColumns::from(&**curve))));
        let smoothing = law.table().and_then(|curve| curve.smoothing());
        let smoothing = smoothing.map(|_| written(SmoothingSpec::Spline));
        Self { law: Some(written(law.into())), table, smoothing, values }
    }
}

/// Gives a model the law of a job. Its values come later.
pub fn use_law(spec: &FrictionSpec, folder: &Path, friction: &mut Friction, complaints: &mut Complaints) {
    let law = spec.law.as_ref().map_or(LawSpec::Stribeck, |law| *law.get_ref());
    for (name, value) in &spec.values {
        let key = format!("model.friction.{}", name.get_ref());
        let refusal = law.refusal(name.get_ref(), &key).map(|message| Complaint::at(value.span(), message));
        complaints.push_some(refusal);
    }
    let smoothing = spec.smoothing.as_ref().map(|smoothing| *smoothing.get_ref());
    if let Some(smoothing) = &spec.smoothing
        && !complaints.has_unread(&["model", "friction", "law"])
    {
        let refusal = law.refusal("smoothing", "model.friction.smoothing");
        complaints.push_some(refusal.map(|message| Complaint::at(smoothing.span(), message)));
    }
    match (law, &spec.table) {
        (LawSpec::Stribeck, None) => {}
        (LawSpec::Rational, None) => friction.law = LawKind::Rational,
        (LawSpec::Table, None) => {
            let span = spec.law.as_ref().map(Spanned::span);
            if !complaints.has_unread(&["model", "friction", "table"]) {
                complaints.push(Complaint::missing("table", span, NO_TABLE));
            }
        }
        (LawSpec::Table, Some(table)) => {
            let curve = match table.get_ref() {
                TableSpec::Csv(file) => read_curve(&folder.join(file), smoothing),
                TableSpec::Columns(columns) => columns.curve(smoothing).map_err(|error| in_rows(&error)),
            };
            let curve =
                curve.map_err(|message| Complaint::at(table.span(), format!("model.friction.table: {message}")));
            if let Some(curve) = complaints.take(curve) {
                friction.use_table(curve);
            }
        }
        (_, Some(table)) if !complaints.has_unread(&["model", "friction", "law"]) => {
            let message = format!(
                "model.friction.table belongs to law = \"table\", but the friction law is \"{}\"; write law = \"table\", or remove the table",
                law.name()
            );
            complaints.push(Complaint::at(table.span(), message));
        }
        (_, Some(_)) => {}
    }
}

const NO_TABLE: &str = "law = \"table\" needs the measured curve: table = \"curve.csv\", with the columns speed (m/s), coefficient and perhaps std; or table = { speed = [...], coefficient = [...] }";

/// Refuses a shift by standard deviations that a curve does not have.
pub fn check_band(friction: &Friction, is_random: bool) -> Result<(), String> {
    let Some(curve) = friction.law.table() else { return Ok(()) };
    if curve.deviations().is_some() || (friction.band == 0.0 && !is_random) {
        return Ok(());
    }
    Err("friction.band shifts the measured curve by its standard deviations, but the table has no column std; add it, or leave friction.band out".to_owned())
}

/// What is wrong with a random input, or an axis, of a parameter that belongs to another friction law. `place` is its
/// key in the job, `path` that in the tables of the model.
pub fn check_varied(place: &str, path: &str, friction: &Friction) -> Result<(), String> {
    let law = LawSpec::from(&friction.law);
    let Some(name) = path.strip_prefix("friction.") else { return Ok(()) };
    if let Some(message) = law.refusal(name, place) {
        return Err(message);
    }
    check_band(friction, name == "band")
}

/// Refuses random inputs and axes of parameters that belong to another friction law.
pub fn check_law_of_varied(
    Parts { spec, random }: Parts<'_>,
    quantities: &[Quantity],
    friction: &Friction,
    complaints: &mut Complaints,
) {
    let span = spec.random.inputs.as_ref().map(Spanned::span);
    // The pair has a value with every law.
    let path =
        |quantity: &Quantity| if quantity.role == Role::Input { String::new() } else { quantity.path.to_string() };
    for quantity in random.into_iter().flat_map(|random| &random.inputs).map(|input| &quantities[*input]) {
        let checked = check_varied(&format!("random.inputs: {}", quantity.name), &path(quantity), friction);
        complaints.take(checked.map_err(|message| Complaint::maybe_at(span.clone(), message)));
    }
    for entry in &spec.axes.0 {
        let name = entry.name.get_ref();
        let known = quantities.iter().find(|quantity| quantity.name == *name || quantity.path == *name);
        let checked = check_varied(&format!("axes: {name}"), &known.map_or_else(String::new, path), friction);
        complaints.take(checked.map_err(|message| Complaint::at(entry.name.span(), message)));
    }
}

/// Writes the measured curve of a law into the text of a job, in place of the file that it was read from; a comment that
/// says which that was.
pub fn freeze(document: &mut DocumentMut, law: &LawKind) -> String {
    let mut origins = String::new();
    let friction = document.get_mut("model").and_then(|model| model.get_mut("friction"));
    if let (Some(friction), Some(curve)) = (friction, law.table())
        && let Some(table) = friction.get_mut("table")
        && let Some(file) = table.as_str()
    {
        origins += &format!("# model.friction.table: measured curve from {file:?}\n");
        let columns = CurveColumns::from(&**curve);
        let named = [("speed", Some(columns.speed)), ("coefficient", Some(columns.coefficient)), ("std", columns.std)];
        let mut inline = InlineTable::new();
        for (name, values) in named {
            let Some(values) = values else { continue };
            inline.insert(name, Value::Array(values.into_iter().collect()));
        }
        *table = Item::Value(Value::InlineTable(inline));
    }
    origins
}

/// A measured curve from a CSV file with names in the first line, smoothed if that is asked for. Says file, line and value
/// where it cannot be read.
pub fn read_curve(path: &Path, smoothing: Option<SmoothingSpec>) -> Result<SharedCurve, String> {
    let file = CsvFile::new(path, read_csv(path)?).map_err(|error| error.to_string())?;
    let refused = |line: u64, message: &str| file.error(line, message).to_string();
    if let Some(unknown) = file.names.iter().find(|name| !COLUMNS.contains(name)) {
        return Err(refused(
            1,
            &format!(
                "there is a column \"{unknown}\"; a friction curve has the columns speed, coefficient and perhaps std, named in the first line, separated by commas or semicolons"
            ),
        ));
    }
    let missing = COLUMNS[..2].iter().find(|column| file.place(column).is_none());
    if let Some(missing) = missing {
        return Err(refused(
            1,
            &format!(
                "there is no column \"{missing}\"; the first line should name the columns speed, coefficient and perhaps std, separated by commas or semicolons"
            ),
        ));
    }
    if let Some(twice) = file.twice() {
        return Err(refused(1, &format!("two columns are named \"{twice}\"")));
    }
    let places = COLUMNS.map(|column| file.place(column));
    let rows = file.rows(&places.into_iter().flatten().collect::<Vec<_>>()).map_err(|error| error.to_string())?;
    if let Some(row) = rows.get(MOST_ROWS) {
        return Err(refused(row.line, &format!("a curve has at most {MOST_ROWS} rows; thin it out")));
    }
    let mut columns: [Vec<f64>; 3] = Default::default();
    for row in &rows {
        for ((values, place), column) in columns.iter_mut().zip(places).zip(COLUMNS) {
            let Some(place) = place else { continue };
            values.push(row.number(place, column).map_err(|message| refused(row.line, &message))?);
        }
    }
    let [speed, coefficient, std] = columns;
    let curve = CurveColumns { speed, coefficient, std: places[2].is_some().then_some(std) };
    curve.curve(smoothing).map_err(|error| match row_of(&error).and_then(|row| rows.get(row)) {
        Some(row) => refused(row.line, &said(&error)),
        None => format!("{}: {error}", shown(path)),
    })
}

/// The message about columns that stand in the job itself.
fn in_rows(error: &CurveError) -> String {
    row_of(error).map_or_else(|| error.to_string(), |row| format!("row {}: {}", row + 1, said(error)))
}

/// An error with the unit that was probably meant.
fn said(error: &CurveError) -> String {
    match error {
        CurveError::OutOfRange { column: "speed", value, .. } if *value > HIGHEST_SPEED && value.is_finite() => {
            format!("{error}; did you mean {} m/s ({} mm/s)?", significant(1e-3 * value), significant(*value))
        }
        _ => error.to_string(),
    }
}

/// The row that an error is about.
fn row_of(error: &CurveError) -> Option<usize> {
    match error {
        CurveError::OutOfRange { row, .. } | CurveError::NotRising { row, .. } | CurveError::TooNear { row, .. } => {
            Some(*row)
        }
        CurveError::NothingAtRest => Some(0),
        _ => None,
    }
}
