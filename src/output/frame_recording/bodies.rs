//! The table `bodies` of frames: grains with a shape.
//!
//! | column | unit | meaning |
//! |---|---|---|
//! | `id` | | id of the grain |
//! | `shape` | | number of its shape in the scene, from 0 |
//! | `radius` | m | radius of the sphere (disc) of equal volume (area) |
//! | `mass` | kg | its mass |
//! | `position`, `velocity` | m, m/s | of the centre of mass |
//! | `spin` | rad/s | angular velocity |
//! | `angle`, or `qw`, `qx`, `qy`, `qz` | rad | orientation: turns the shape as the scene describes it, as in `state.csv` |
//! | `director` | | unit vector along a long grain, across a flat one; zero if no direction stands out |

use super::{column, id_number, vectors};
use siloflow_dem::math;
use siloflow_dem::space::{Dimension, Linear, Rotor, Space};
use siloflow_dem::store::ParticleStore;
use siloflow_files::frames::{Table, Values};

/// Returns the table, in ascending order of ids.
pub(super) fn table<V: Space>(store: &ParticleStore<V>) -> Table {
    let mut bodies: Vec<_> = store.bodies.all().map(|body| (body, store.row_of_body(body))).collect();
    bodies.retain(|&(_, row)| store.is_present(row));
    bodies.sort_unstable_by_key(|&(_, row)| store.id[row]);
    let rows = || bodies.iter().map(|&(_, row)| row);
    let floats = |of: &dyn Fn(usize) -> f64| Values::F64(rows().map(of).collect());
    let rotors = bodies.iter().map(|&(body, _)| {
        let rotor = store.bodies.rotor[body.index()].to_quaternion();
        rotor * store.bodies.shape_of(body).axes.to_quaternion().conjugate()
    });
    let rotors: Vec<_> = rotors.collect();
    let of_rotor =
        |number: fn(&siloflow_dem::space::Quaternion) -> f64| Values::F64(rotors.iter().map(number).collect());
    let radius = bodies
        .iter()
        .map(|&(body, _)| store.bodies.scale[body.index()] * store.bodies.shape_of(body).equivalent_radius());
    let d = V::COMPONENTS;
    let mut columns = vec![
        column("id", "", 1, Values::I32(rows().map(|row| id_number(store.id[row])).collect())),
        column(
            "shape",
            "",
            1,
            Values::U16(bodies.iter().map(|&(body, _)| store.bodies.shape[body.index()].0).collect()),
        ),
        column("radius", "m", 1, Values::F64(radius.collect())),
        column("mass", "kg", 1, floats(&|row| store.mass[row])),
        column("position", "m", d, vectors(rows().map(|row| store.body[row].position))),
        column("velocity", "m/s", d, vectors(rows().map(|row| store.body[row].velocity))),
        column("spin", "rad/s", V::Spin::COUNT, vectors(rows().map(|row| store.spin(row)))),
    ];
    match V::DIMENSION {
        Dimension::Plane => {
            columns.push(column("angle", "rad", 1, of_rotor(|rotor| 2.0 * math::atan2(rotor.z, rotor.w))));
        }
        Dimension::Solid => columns.extend([
            column("qw", "", 1, of_rotor(|rotor| rotor.w)),
            column("qx", "", 1, of_rotor(|rotor| rotor.x)),
            column("qy", "", 1, of_rotor(|rotor| rotor.y)),
            column("qz", "", 1, of_rotor(|rotor| rotor.z)),
        ]),
    }
    columns.push(column("director", "", d, vectors(rows().map(|row| store.director(row).unwrap_or(V::ZERO)))));
    Table { name: "bodies".to_owned(), rows: bodies.len(), columns }
}
