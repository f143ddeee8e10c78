//! Tables of a simulation as columns of numbers: grains in the order of their ids, contacts, walls, fields.

use pyo3::exceptions::{PyIndexError, PyKeyError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use siloflow::dem::bodies::Orientation;
use siloflow::dem::math;
use siloflow::dem::space::{Dimension, Linear, Rotor, Space};
use siloflow::dem::step::Clock;
use siloflow::dem::store::ParticleStore;
use siloflow::dem::survey::Survey;
use siloflow::dem::survey::contact_state::Touched;
use siloflow::dem::walls::surfaces::Surfaces;
use siloflow::prelude::World;
use siloflow::scene::loaded::Loaded;
use siloflow::simulation::assign::grains_by_id;

use crate::{Column, column, set_column};

/// Names of the columns of grains.
pub const GRAINS: [&str; 9] =
    ["id", "species", "radius", "mass", "position", "velocity", "force", "spin", "orientation"];

fn number(x: f64) -> [u8; 8] {
    x.to_le_bytes()
}

/// The components of a vector.
fn components<T: Linear>(vector: T) -> impl Iterator<Item = f64> {
    (0..T::COUNT).map(move |axis| vector.component(axis))
}

/// A column of vectors.
fn vectors<T: Linear>(py: Python<'_>, all: impl Iterator<Item = T>) -> PyResult<Column<'_>> {
    let numbers: Vec<f64> = all.flat_map(components).collect();
    Ok(column(py, "<f8", u8::try_from(T::COUNT)?, &numbers, number))
}

/// Whether grains have a column in this scene.
pub fn has_column<V: Space>(store: &ParticleStore<V>, name: &str) -> bool {
    match name {
        "spin" => store.has_spins(),
        "orientation" => !store.bodies.shapes.is_empty(),
        _ => GRAINS.contains(&name),
    }
}

/// A column of the grains, SI.
pub fn of_grains<'py, V: Space>(py: Python<'py>, world: &World, name: &str) -> PyResult<Column<'py>> {
    let store = world.resource::<ParticleStore<V>>();
    if !has_column(store, name) {
        return Err(PyKeyError::new_err(format!("grains of this scene have no `{name}`")));
    }
    let rows = grains_by_id(store);
    let numbers = |of: &dyn Fn(usize) -> f64| -> Vec<f64> { rows.iter().map(|&row| of(row)).collect() };
    let all = || rows.iter().copied();
    Ok(match name {
        "id" => {
            let ids: Vec<_> = all().map(|row| store.id[row].number()).collect();
            column(py, "<u4", 1, &ids, |x| x.to_le_bytes())
        }
        "species" => {
            let species: Vec<_> = all().map(|row| store.species[row].0).collect();
            column(py, "|u1", 1, &species, |x| [x])
        }
        "radius" => column(py, "<f8", 1, &numbers(&|row| store.body[row].radius), number),
        "mass" => column(py, "<f8", 1, &numbers(&|row| store.mass[row]), number),
        "position" => vectors(py, all().map(|row| store.body[row].position))?,
        "velocity" => vectors(py, all().map(|row| store.body[row].velocity))?,
        "force" => vectors(py, all().map(|row| store.loads.force.of(row)))?,
        "spin" => vectors(py, all().map(|row| store.spin(row)))?,
        _ => {
            // The angle of the x axis in the plane, the quaternion w, x, y, z in solid space; NaN for round grains.
            let of = |row: usize| {
                let rotor = store.body_of_row(row).map(|body| Orientation::<V>(store.bodies.rotor[body.index()]));
                let turn = rotor.map(|rotor| rotor.0.to_quaternion());
                let all = turn.map_or([f64::NAN; 4], |turn| [turn.w, turn.x, turn.y, turn.z]);
                match V::DIMENSION {
                    Dimension::Plane => vec![2.0 * math::atan2(all[3], all[0])],
                    Dimension::Solid => all.to_vec(),
                }
            };
            let width = if V::DIMENSION == Dimension::Plane { 1 } else { 4 };
            column(py, "<f8", width, &all().flat_map(of).collect::<Vec<_>>(), number)
        }
    })
}

/// The contacts in the order of ids, SI.
pub fn of_contacts<'py, V: Space>(py: Python<'py>, world: &World) -> PyResult<Bound<'py, PyDict>> {
    let states = Survey::<V>::of_world(world).view(world.resource::<Clock>().dt);
    let columns = PyDict::new(py);
    let grains: Vec<_> = states.iter().map(|state| state.grain.number()).collect();
    set_column(&columns, "grain", "<u4", 1, &grains, |x| x.to_le_bytes())?;
    let partner = |with: Touched| match with {
        Touched::Particle(id) if id.is_wall() => (1u8, id.number()),
        Touched::Particle(id) => (0, id.number()),
        Touched::Wall(wall) => (2, u32::try_from(wall).unwrap_or(u32::MAX)),
    };
    let partners: Vec<_> = states.iter().map(|state| partner(state.with)).collect();
    let kinds: Vec<_> = partners.iter().map(|partner| partner.0).collect();
    let numbers: Vec<_> = partners.iter().map(|partner| partner.1).collect();
    set_column(&columns, "partner_kind", "|u1", 1, &kinds, |x| [x])?;
    set_column(&columns, "partner", "<u4", 1, &numbers, |x| x.to_le_bytes())?;
    let floats = |name: &str, of: &dyn Fn(usize) -> f64| {
        let numbers: Vec<f64> = (0..states.len()).map(of).collect();
        set_column(&columns, name, "<f8", 1, &numbers, number)
    };
    floats("overlap", &|at| states[at].overlap)?;
    floats("normal_force", &|at| states[at].normal_force)?;
    floats("mobilised", &|at| states[at].mobilised)?;
    columns.set_item("friction", vectors(py, states.iter().map(|state| state.friction))?)?;
    columns.set_item("normal", vectors(py, states.iter().map(|state| state.normal))?)?;
    columns.set_item("centre", vectors(py, states.iter().map(|state| state.from))?)?;
    columns.set_item("branch", vectors(py, states.iter().map(|state| state.to_partner))?)?;
    Ok(columns)
}

/// The wall surfaces in the order of the scene, SI: names, and what grains press on them with.
pub fn of_walls<'py, V: Space>(py: Python<'py>, world: &World, loaded: &Loaded) -> PyResult<Bound<'py, PyDict>> {
    let walls = world.resource::<Surfaces<V>>();
    let names = loaded.wall_names();
    let columns = PyDict::new(py);
    columns.set_item("force", vectors(py, walls.loads.iter().take(names.len()).map(|load| load.force))?)?;
    columns.set_item("torque", vectors(py, walls.loads.iter().take(names.len()).map(|load| load.torque))?)?;
    columns.set_item("name", names)?;
    Ok(columns)
}

/// One sample of an entry of the scene's `fields`, SI: a column for each mean, and the places of the cells.
pub fn of_field<'py, V: Space>(
    py: Python<'py>,
    world: &World,
    loaded: &Loaded,
    which: usize,
) -> PyResult<Bound<'py, PyDict>> {
    let mut samplers = loaded.fields::<V>();
    if which >= samplers.len() {
        let text = format!("there is no field {which}: the scene has {} under `fields`", samplers.len());
        return Err(PyIndexError::new_err(text));
    }
    let mut sampler = samplers.swap_remove(which);
    sampler.add(&Survey::<V>::of_world(world));
    let layout = sampler.layout;
    let names = layout.names();
    let mut means = vec![Vec::new(); names.len()];
    let mut places = vec![Vec::new(); 3];
    for cell in 0..sampler.grid.len() {
        let sums = cell * layout.sums()..(cell + 1) * layout.sums();
        let found = sampler.blocks.estimate(sums, |sums| layout.means_of(sums));
        for (mean, (value, _)) in means.iter_mut().zip(found) {
            mean.push(value);
        }
        for (place, value) in places.iter_mut().zip(sampler.grid.place(cell)) {
            place.push(value.unwrap_or(f64::NAN));
        }
    }
    let columns = PyDict::new(py);
    for (name, numbers) in ["x", "y", "z"].into_iter().zip(&places) {
        if numbers.iter().any(|number| number.is_finite()) {
            set_column(&columns, name, "<f8", 1, numbers, number)?;
        }
    }
    for (name, numbers) in names.iter().zip(&means) {
        set_column(&columns, name, "<f8", 1, numbers, number)?;
    }
    Ok(columns)
}

/// Reads vectors from their bytes.
pub fn read<T: Linear>(bytes: &[u8]) -> Vec<T> {
    let numbers: Vec<f64> =
        bytes.chunks_exact(8).map(|eight| f64::from_le_bytes(eight.try_into().unwrap_or_default())).collect();
    numbers.chunks_exact(T::COUNT).map(|vector| T::from_components(|axis| vector[axis])).collect()
}
