//! Reads grain files row by row. The text of a file is longer than its grains, so it is never held as a whole.

use std::collections::BTreeSet;
use std::io::{self, Read as _};
use std::ops::Range;
use std::path::Path;

use csv::{ReaderBuilder, StringRecord};

use crate::grains::MOST_GRAINS;
use crate::grains::file::{ALWAYS, GrainRow, Kind, SHAPE, SOLID, SPIN};
use crate::grains::shaped::{Posture, ShapeFacts};
use siloflow_dem::bodies::Shape;
use siloflow_dem::math;
use siloflow_dem::particle::{GrainId, Species};
use siloflow_dem::space::{Quaternion, Rotor, Solid};
use siloflow_text::encoding::MARK;
use siloflow_text::fault::Fault;
use siloflow_text::file::{GRAIN_BYTES, open_text};

/// Parses the text of a grain file. `name` is the file's name in messages.
///
/// # Errors
/// If a column is missing or unknown, or a value is out of range. The fault points at line and column.
pub fn parse(name: &str, text: &str, kind: Kind<'_>) -> Result<Vec<GrainRow>, Fault> {
    let text = text.strip_prefix(MARK).unwrap_or(text);
    rows(text.as_bytes(), kind).map_err(|defect| defect.fault(name, text))
}

/// Reads the grain file at `path`. `name` is its name in messages.
///
/// # Errors
/// The outer error if the file cannot be read, the inner one as for [`parse`].
pub fn read(name: &str, path: &Path, kind: Kind<'_>) -> io::Result<Result<Vec<GrainRow>, Fault>> {
    match rows(open_text(path, GRAIN_BYTES)?, kind) {
        Ok(rows) => Ok(Ok(rows)),
        Err(Defect { at: Place::Unreadable(error), .. }) => Err(error),
        // The file is read again, up to the defect and a little beyond, to show the place.
        Err(defect) => {
            let mut bytes = Vec::new();
            let shown = open_text(path, GRAIN_BYTES)?.take(defect.shown_bytes()).read_to_end(&mut bytes);
            // Behind the defect the text may have another one.
            if let Err(error) = shown
                && error.kind() != io::ErrorKind::InvalidData
            {
                return Err(error);
            }
            Ok(Err(defect.fault(name, &String::from_utf8_lossy(&bytes))))
        }
    }
}

fn rows(source: impl io::Read, kind: Kind<'_>) -> Result<Vec<GrainRow>, Defect> {
    let mut reader = ReaderBuilder::new().trim(csv::Trim::All).flexible(true).from_reader(source);
    let header = reader.headers().map_err(Defect::syntax)?.clone();
    check_header(&header, kind)?;
    let mut seen = BTreeSet::new();
    let mut rows = Vec::new();
    let mut record = StringRecord::new();
    while reader.read_record(&mut record).map_err(Defect::syntax)? {
        let line = Line { header: &header, record: &record, kind };
        let row = line.grain()?;
        if !seen.insert(row.id) {
            return Err(line.defect(
                "grain_file::duplicate_id",
                "id",
                format!("the id {} occurs twice", row.id.number()),
            ));
        }
        if rows.len() == MOST_GRAINS as usize {
            let message = format!("the file has more than {MOST_GRAINS} grains, the limit of a scene");
            return Err(line.defect("grain_file::too_many", "id", message));
        }
        rows.push(row);
    }
    rows.shrink_to_fit();
    Ok(rows)
}

fn check_header(header: &StringRecord, kind: Kind<'_>) -> Result<(), Defect> {
    let defect = |code, message: String| {
        let needed: Vec<_> = kind.needed().collect();
        let help = format!("the columns are {} and, if wanted, species, wx, wy, wz", needed.join(", "));
        Err(Defect { code, message, help, at: Place::Header })
    };
    let has = |column: &str| header.iter().any(|found| found == column);
    if let Some(missing) = kind.needed().find(|&column| !(has(column) || column == "radius" && has("scale"))) {
        return defect("grain_file::missing_column", format!("the column `{missing}` is missing"));
    }
    let known = |column: &str| {
        [&ALWAYS[..], &SOLID, &SPIN, &SHAPE].iter().any(|columns| columns.contains(&column)) || column == "species"
    };
    if let Some(unknown) = header.iter().find(|column| !known(column)) {
        return defect("grain_file::unknown_column", format!("there is no column `{unknown}`"));
    }
    Ok(())
}

/// A defect of a file. It becomes a fault once the text is available to show the place.
struct Defect {
    code: &'static str,
    message: String,
    help: String,
    at: Place,
}

/// Place of a defect.
enum Place {
    /// The file cannot be read.
    Unreadable(io::Error),
    /// The header line.
    Header,
    /// A byte, counted from the start of the file.
    Byte(usize),
    /// The start byte of a record, and a column in the order of the file.
    Cell(usize, usize),
}

impl Defect {
    fn syntax(error: csv::Error) -> Self {
        let at = position(error.position());
        let message = format!("this is not CSV: {error}");
        let at = match error.into_kind() {
            csv::ErrorKind::Io(error) => Place::Unreadable(error),
            _ => Place::Byte(at),
        };
        Self { code: "grain_file::syntax", message, help: "separate values by commas".to_owned(), at }
    }

    /// Number of bytes of the file that a message about this defect needs: up to the place, and some lines.
    fn shown_bytes(&self) -> u64 {
        const BEYOND: u64 = 1 << 16;
        match self.at {
            Place::Unreadable(_) | Place::Header => BEYOND,
            Place::Byte(at) | Place::Cell(at, _) => (at as u64).saturating_add(BEYOND),
        }
    }

    fn fault(self, name: &str, text: &str) -> Fault {
        let place = match self.at {
            Place::Unreadable(_) => 0..0,
            Place::Header => 0..text.find('\n').unwrap_or(text.len()),
            Place::Byte(at) => {
                let at = text.floor_char_boundary(at);
                at..at
            }
            Place::Cell(record, column) => cell(text, text.floor_char_boundary(record), column),
        };
        Fault::new(self.code, self.message).help(self.help).at(name, text, place)
    }
}

fn position(position: Option<&csv::Position>) -> usize {
    position.and_then(|position| usize::try_from(position.byte()).ok()).unwrap_or(0)
}

/// Returns the byte range of a column in the record that starts at `from`.
fn cell(text: &str, from: usize, column: usize) -> Range<usize> {
    // The byte position of a record is the end of the previous record, so the line break in between is skipped.
    let from = from + text[from..].len() - text[from..].trim_start().len();
    let line = &text[from..from + text[from..].find('\n').unwrap_or(text.len() - from)];
    let start: usize = line.split(',').take(column).map(|cell| cell.len() + 1).sum();
    let start = start.min(line.len());
    let length = line[start..].find(',').unwrap_or(line.len() - start);
    from + start..from + start + length
}

/// One record of the file.
struct Line<'a> {
    header: &'a StringRecord,
    record: &'a StringRecord,
    kind: Kind<'a>,
}

impl Line<'_> {
    fn value(&self, column: &str) -> Option<&str> {
        self.record.get(self.header.iter().position(|found| found == column)?)
    }

    fn defect(&self, code: &'static str, column: &str, message: String) -> Defect {
        let index = self.header.iter().position(|found| found == column).unwrap_or(0);
        Defect {
            code,
            message: format!("column `{column}`: {message}"),
            help: "one grain per row; numbers in SI units".to_owned(),
            at: Place::Cell(position(self.record.position()), index),
        }
    }

    fn number(&self, column: &str, is_valid: impl Fn(f64) -> bool, expected: &str) -> Result<f64, Defect> {
        let found = self.value(column).unwrap_or("");
        match found.parse::<f64>() {
            Ok(number) if number.is_finite() && is_valid(number) => Ok(number),
            _ => Err(self.defect("grain_file::value", column, format!("expected {expected}, got `{found}`"))),
        }
    }

    /// Returns the shape that the line names, if it names one.
    fn shape(&self) -> Result<Option<(Shape, &ShapeFacts)>, Defect> {
        let Some(name) = self.value("shape").filter(|name| !name.is_empty()) else { return Ok(None) };
        let shapes = self.kind.shapes;
        if let Some((number, facts)) = (0u16..).zip(shapes).find(|(_, facts)| facts.name == name) {
            return Ok(Some((Shape(number), facts)));
        }
        let names: Vec<_> = shapes.iter().map(|facts| facts.name.as_str()).collect();
        let message = format!("expected a shape of the scene ({}), got `{name}`", names.join(", "));
        Err(self.defect("grain_file::value", "shape", message))
    }

    /// Returns the radius (m), and the posture of a grain with a shape.
    fn size_and_posture(&self) -> Result<(f64, Option<Posture>), Defect> {
        let positive = |column| self.number(column, |x| x > 0.0, "a number greater than 0");
        let is_given = |column: &str| self.value(column).is_some_and(|value| !value.is_empty());
        let Some((shape, facts)) = self.shape()? else {
            let of_shapes = SHAPE.into_iter().filter(|&column| column != "shape");
            return match of_shapes.into_iter().find(|column| is_given(column)) {
                Some(stray) => Err(self.defect("grain_file::value", stray, "this grain has no `shape`".to_owned())),
                None => Ok((positive("radius")?, None)),
            };
        };
        let radius = match (is_given("radius"), is_given("scale")) {
            (true, true) => {
                let message = "`radius` and `scale` both give the size".to_owned();
                return Err(self.defect("grain_file::value", "scale", message));
            }
            (false, true) => positive("scale")? * facts.equivalent_radius,
            _ => positive("radius")?,
        };
        let any = |column| self.number(column, |_| true, "a finite number");
        let described = if self.kind.is_solid() {
            let rotor = Quaternion::from_xyzw(any("qx")?, any("qy")?, any("qz")?, any("qw")?);
            let message = || "the quaternion has no length".to_owned();
            <Quaternion as Rotor<Solid>>::normalised(rotor)
                .ok_or_else(|| self.defect("grain_file::value", "qw", message()))?
        } else {
            let (sine, cosine) = math::sincos(0.5 * any("angle")?);
            Quaternion::from_xyzw(0.0, 0.0, sine, cosine)
        };
        Ok((radius, Some(Posture { shape, rotor: described * facts.axes, reach: facts.reach_of(radius) })))
    }

    fn grain(&self) -> Result<GrainRow, Defect> {
        let any = |column| self.number(column, |_| true, "a finite number");
        let positive = |column| self.number(column, |x| x > 0.0, "a number greater than 0");
        let id = self.value("id").and_then(|id| id.parse().ok()).and_then(GrainId::grain).ok_or_else(|| {
            let found = self.value("id").unwrap_or("");
            let message = format!("expected a whole number from 0 to {}, got `{found}`", GrainId::MAX_GRAIN);
            self.defect("grain_file::value", "id", message)
        })?;
        let has = |column: &str| self.value(column).is_some();
        for column in SOLID.into_iter().chain(SPIN).filter(|column| self.kind.must_be_zero(column) && has(column)) {
            self.number(column, |x| x == 0.0, "0, because this scene is planar or its grains do not spin")?;
        }
        let or_zero = |column: &'static str| if has(column) { any(column) } else { Ok(0.0) };
        let species = match self.value("species") {
            None => 0,
            Some(found) => found.parse().map_err(|_| {
                let message = format!("expected a whole number from 0 to 255, got `{found}`");
                self.defect("grain_file::value", "species", message)
            })?,
        };
        let (radius, posture) = self.size_and_posture()?;
        Ok(GrainRow {
            id,
            radius,
            mass: positive("mass")?,
            position: Solid::new(any("x")?, any("y")?, or_zero("z")?),
            velocity: Solid::new(any("vx")?, any("vy")?, or_zero("vz")?),
            spin: Solid::new(or_zero("wx")?, or_zero("wy")?, or_zero("wz")?),
            posture,
            species: Species(species),
        })
    }
}
