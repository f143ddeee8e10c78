//! One file of VTK XML PolyData (`.vtp`) with points, cells and appended binary arrays.
//!
//! Points without cells are not shown by ParaView, so each grain is also a cell of kind `Verts`. An array is its length in bytes
//! (8 bytes) and its numbers, all little-endian. Vectors have three components; z is 0 in the plane. Source: "VTK XML formats",
//! <https://docs.vtk.org/en/latest/vtk_file_formats/vtkxml_file_format.html>.

use std::fmt::Write as _;

use siloflow_files::frames::{Column, Values};
use siloflow_text::safe::for_xml;

/// The content of a file.
#[derive(Debug, Default)]
pub(super) struct PolyData {
    /// Simulated time, s.
    pub time: f64,
    /// Points, m.
    pub points: Vec<[f64; 3]>,
    /// Columns of points.
    pub point_data: Vec<Column>,
    /// Whether every point is a cell.
    pub verts: bool,
    /// Lines between points.
    pub lines: Vec<[u32; 2]>,
    /// Triangles between points.
    pub triangles: Vec<[u32; 3]>,
    /// Columns of cells: lines, then triangles.
    pub cell_data: Vec<Column>,
}

/// The XML of a file, and the arrays that are appended to it.
#[derive(Default)]
struct Parts {
    xml: String,
    appended: Vec<u8>,
}

impl Parts {
    fn array(&mut self, name: &str, kind: &str, components: usize, bytes: impl Iterator<Item = u8>) {
        let offset = self.appended.len();
        self.appended.extend([0; 8]);
        self.appended.extend(bytes);
        let length = (self.appended.len() - offset - 8) as u64;
        self.appended[offset..offset + 8].copy_from_slice(&length.to_le_bytes());
        // Writing to a string cannot fail.
        let _ = writeln!(
            self.xml,
            r#"<DataArray type="{kind}" Name="{}" NumberOfComponents="{components}" format="appended" offset="{offset}"/>"#,
            for_xml(name)
        );
    }

    fn column(&mut self, column: &Column) {
        let name = &column.name;
        match (&column.values, column.components) {
            (Values::F64(numbers), 2) => {
                let padded = numbers.chunks(2).flat_map(|pair| [pair[0], pair.get(1).copied().unwrap_or(0.0), 0.0]);
                self.array(name, "Float64", 3, padded.flat_map(f64::to_le_bytes));
            }
            (Values::F64(numbers), 1) if name == "spin" => {
                let padded = numbers.iter().flat_map(|&spin| [0.0, 0.0, spin]);
                self.array(name, "Float64", 3, padded.flat_map(f64::to_le_bytes));
            }
            (Values::F64(numbers), components) => {
                self.array(name, "Float64", components.into(), numbers.iter().flat_map(|x| x.to_le_bytes()));
            }
            (Values::I32(numbers), components) => {
                self.array(name, "Int32", components.into(), numbers.iter().flat_map(|x| x.to_le_bytes()));
            }
            (Values::U32(numbers), components) => {
                self.array(name, "UInt32", components.into(), numbers.iter().flat_map(|x| x.to_le_bytes()));
            }
            (Values::U16(numbers), components) => {
                self.array(name, "UInt16", components.into(), numbers.iter().flat_map(|x| x.to_le_bytes()));
            }
            (Values::U8(numbers), components) => {
                self.array(name, "UInt8", components.into(), numbers.iter().copied());
            }
        }
    }

    fn columns(&mut self, element: &str, columns: &[Column]) {
        let _ = writeln!(self.xml, "<{element}>");
        for column in columns {
            self.column(column);
        }
        let _ = writeln!(self.xml, "</{element}>");
    }

    /// Adds cells with `corners` points each.
    fn cells(&mut self, element: &str, corners: usize, places: &[u32]) {
        let _ = writeln!(self.xml, "<{element}>");
        let whole = |number: u64| number.to_le_bytes();
        self.array("connectivity", "Int64", 1, places.iter().flat_map(|&place| whole(place.into())));
        let ends = (1..=places.len() / corners).map(|cell| (cell * corners) as u64);
        self.array("offsets", "Int64", 1, ends.flat_map(whole));
        let _ = writeln!(self.xml, "</{element}>");
    }
}

impl PolyData {
    /// Returns the bytes of the file.
    pub fn bytes(&self) -> Vec<u8> {
        let mut parts = Parts::default();
        let points = self.points.len();
        let verts = if self.verts { self.points.len() } else { 0 };
        let _ = writeln!(
            parts.xml,
            "<?xml version=\"1.0\"?>\n\
             <VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n<PolyData>\n\
             <FieldData>\n<DataArray type=\"Float64\" Name=\"TimeValue\" NumberOfTuples=\"1\" format=\"ascii\">{:e}</DataArray>\n\
             </FieldData>\n\
             <Piece NumberOfPoints=\"{points}\" NumberOfVerts=\"{verts}\" NumberOfLines=\"{}\" NumberOfStrips=\"0\" \
             NumberOfPolys=\"{}\">",
            self.time,
            self.lines.len(),
            self.triangles.len()
        );
        parts.columns("PointData", &self.point_data);
        parts.columns("CellData", &self.cell_data);
        parts.xml.push_str("<Points>\n");
        parts.array("Points", "Float64", 3, self.points.as_flattened().iter().flat_map(|x| x.to_le_bytes()));
        parts.xml.push_str("</Points>\n");
        // There are fewer than 2^32 points.
        let every: Vec<u32> = (0..u32::try_from(verts).unwrap_or(u32::MAX)).collect();
        parts.cells("Verts", 1, &every);
        parts.cells("Lines", 2, self.lines.as_flattened());
        parts.cells("Polys", 3, self.triangles.as_flattened());
        parts.xml.push_str("</Piece>\n</PolyData>\n<AppendedData encoding=\"raw\">\n_");
        let mut bytes = parts.xml.into_bytes();
        bytes.extend(parts.appended);
        bytes.extend(b"\n</AppendedData>\n</VTKFile>\n");
        bytes
    }
}
