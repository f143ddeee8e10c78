//! Rules on `fields`: a grid of the scene's space, with an extent and not too many cells.

use crate::measure::fields::{FieldGrid, Kernel, Layout, MOST_BLOCKS};
use crate::scene::loaded::Loaded;
use siloflow_dem::space::Dimension;
use siloflow_dem::values::Finite;
use siloflow_text::fault::Fault;

/// Most cells along an axis.
const MOST_ALONG: u16 = 10_000;

/// Most numbers in the sums of all fields, 8 B each: a block has a number for each sum of each cell.
const MOST_NUMBERS: usize = 60_000_000;

/// Checks the grids of all fields.
pub(super) fn fields(loaded: &Loaded) -> Result<(), Fault> {
    let layout = Layout { components: loaded.scene.space.count(), species: loaded.field_species() };
    let mut total: usize = 0;
    for (index, field) in loaded.scene.fields.iter().enumerate() {
        let key = |name: &str| format!("fields[{index}].{name}");
        let is_planar = matches!(field.grid, FieldGrid::XY { .. });
        if is_planar != (loaded.scene.space == Dimension::Plane) {
            return Err(loaded
                .fault("scene::dimension", &key("grid"), "the grid belongs to the other `space`")
                .help("in the plane give `XY(...)`, in solid space `XZ(...)`, `RZ(...)` or `XYZ(...)`"));
        }
        let (ends, cells) = extents(&field.grid);
        if ends.iter().any(|(low, high)| low.get() >= high.get()) {
            return Err(loaded
                .fault(
                    "scene::empty_box",
                    &key("grid"),
                    "the grid has no extent: a lower end is not below its upper end",
                )
                .help("give ends in m, each `low` below its `high`"));
        }
        if cells.iter().any(|cells| !(1..=MOST_ALONG).contains(cells)) {
            let message = format!("expected 1 to {MOST_ALONG} cells along each axis");
            return Err(loaded
                .fault("scene::out_of_range", &key("grid.cells"), message)
                .help("cells a few grains wide give smooth fields"));
        }
        if let FieldGrid::XZ { y: None, .. } = field.grid
            && loaded.scene.periodic.y.is_none()
        {
            return Err(loaded
                .fault("scene::missing_key", &key("grid"), "the grid does not say how far its cells reach along y")
                .help("give for example `y: (-0.1, 0.1)`, in m"));
        }
        if matches!((field.grid, field.kernel), (FieldGrid::RZ { .. }, Kernel::Gaussian(_))) {
            return Err(loaded
                .fault("scene::out_of_range", &key("kernel"), "an (r, z) grid has sharp cells only")
                .help("leave out `kernel`, or choose a grid of boxes"));
        }
        total = total.saturating_add(field.grid.cells().saturating_mul(layout.sums() * (MOST_BLOCKS + 1)));
        if total > MOST_NUMBERS {
            let message = format!(
                "with these cells the sums of all fields are {total} numbers, more than the limit of {MOST_NUMBERS}"
            );
            return Err(loaded
                .fault("scene::out_of_range", &key("grid.cells"), message)
                .help(format!("a cell takes {} numbers: give fewer cells", layout.sums() * (MOST_BLOCKS + 1))));
        }
    }
    Ok(())
}

/// Returns the ends along the axes that a grid has, and the numbers of cells along them.
fn extents(grid: &FieldGrid) -> (Vec<(Finite, Finite)>, Vec<u16>) {
    match *grid {
        FieldGrid::XY { low, high, cells } => (vec![(low.0, high.0), (low.1, high.1)], vec![cells.0, cells.1]),
        FieldGrid::XZ { low, high, cells, y } => {
            ([(low.0, high.0), (low.1, high.1)].into_iter().chain(y).collect(), vec![cells.0, cells.1])
        }
        FieldGrid::RZ { low, high, cells, .. } => (vec![(low, high)], vec![cells.0, cells.1]),
        FieldGrid::XYZ { low, high, cells } => {
            (vec![(low.0, high.0), (low.1, high.1), (low.2, high.2)], vec![cells.0, cells.1, cells.2])
        }
    }
}
