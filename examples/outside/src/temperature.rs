//! A temperature of each grain, and conduction of heat at contacts.
//!
//! The heat flow from grain j to grain i in contact is Q = h (T_j - T_i), W, with the conductance h in W/K. A grain of
//! mass m has the heat capacity c m. Walls do not conduct. The temperatures of two isolated grains approach each other
//! as exp(-h t (1/(c m_i) + 1/(c m_j))). The sum of c m T is conserved.
//!
//! | output | content |
//! |---|---|
//! | `frames.bin`, and all that is made of it | the column `temperature`, K |
//! | `series.csv` | `mean_temperature_k`, by mass, and `heat_j`, the sum of c m T |
//! | `summary.json` | `behaviours.conduction.heat`, J |

use serde::{Deserialize, Serialize};
use siloflow::prelude::*;

/// The scene's `behaviours: {"conduction": (...)}`.
#[derive(Resource, Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Conduction {
    /// Initial temperatures of grains, K, by species. The last one applies to all further species.
    temperatures: Vec<f64>,
    /// h, W/K.
    conductance: f64,
    /// c, J/(kg K).
    heat_capacity: f64,
    /// Interval at which the largest difference is recorded, s.
    interval: f64,
}

/// Temperature of a grain, K.
#[derive(Component, Clone, Copy, Debug, Deserialize, Serialize)]
pub struct Temperature(pub f64);

/// Times in s, each with the largest difference of two temperatures in K.
#[derive(Resource, Default, Deserialize, Serialize)]
pub struct Differences(pub Vec<(f64, f64)>);

/// Grains without a temperature.
type WithoutTemperature = (With<Grain>, Without<Temperature>);

fn set_initial_temperature(
    mut commands: Commands,
    conduction: Res<Conduction>,
    new: Query<(Entity, &Species), WithoutTemperature>,
) {
    for (grain, species) in &new {
        let of_species = conduction.temperatures.get(usize::from(species.0));
        let temperature = of_species.or(conduction.temperatures.last()).copied().unwrap_or_default();
        commands.entity(grain).insert(Temperature(temperature));
    }
}

fn conduct<V: Space>(
    contacts: ContactView<V>,
    (clock, conduction): (Res<Clock>, Res<Conduction>),
    mut grains: Query<(&Slot, &Mass, &mut Temperature)>,
    mut gains: Local<Vec<f64>>,
) {
    if clock.is_step_zero() {
        return;
    }
    // Heat gained in this step, J, by row of the store.
    gains.clear();
    gains.resize(contacts.rows(), 0.0);
    for contact in contacts.iter() {
        let (Some(partner), Some(row)) = (contact.partner_entity(), contact.partner_row()) else { continue };
        let Ok([(.., a), (.., b)]) = grains.get_many([contact.entity(), partner]) else { continue };
        let heat = conduction.conductance * (b.0 - a.0) * clock.dt;
        gains[contact.row()] += heat;
        gains[row] -= heat;
    }
    for (slot, mass, mut temperature) in &mut grains {
        if let Some(gain) = gains.get(slot.index()) {
            temperature.0 += gain / (conduction.heat_capacity * mass.0);
        }
    }
}

fn record_difference(clock: Res<Clock>, grains: Query<&Temperature>, mut differences: ResMut<Differences>) {
    let (lowest, highest) = grains
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &Temperature(t)| (low.min(t), high.max(t)));
    differences.0.push((clock.time(), (highest - lowest).max(0.0)));
}

/// Returns the sum of m T over all grains, kg K, and the sum of m.
fn sums(grains: &Query<(&Mass, &Temperature)>) -> [f64; 2] {
    grains.iter().fold([0.0, 0.0], |[heat, mass], (m, t)| [heat + m.0 * t.0, mass + m.0])
}

/// Returns the mean temperature by mass, K; NaN without grains.
fn mean_temperature(grains: Query<(&Mass, &Temperature)>) -> f64 {
    let [heat, mass] = sums(&grains);
    heat / mass
}

/// Returns the heat of all grains, J, from 0 K on.
fn heat(conduction: Res<Conduction>, grains: Query<(&Mass, &Temperature)>) -> f64 {
    conduction.heat_capacity * sums(&grains)[0]
}

impl Behaviour for Conduction {
    fn lives_in(&self, _: Dimension) -> bool {
        true
    }

    fn check(&self, _: &Loaded) -> Result<(), String> {
        let positive = [self.conductance, self.heat_capacity, self.interval].iter().all(|&number| number > 0.0);
        if positive && !self.temperatures.is_empty() {
            return Ok(());
        }
        Err("conductance, heat_capacity and interval must be above 0, and temperatures must have at least one entry"
            .to_owned())
    }

    fn build(self: Box<Self>, app: &mut App) {
        observe_every::<Differences>(app, self.interval);
        // Saved with checkpoints.
        app.persist_component::<Temperature>().persist::<Differences>();
        app.grain_column::<Temperature>("temperature", "K", |temperature| temperature.0)
            .series_column("mean_temperature_k", "K", mean_temperature)
            .series_column("heat_j", "J", heat)
            .summary_value("heat", "J", heat);
        // No grain becomes hotter than the hottest at the start, or colder than the coldest.
        let [from, to] = [f64::min, f64::max].map(|pick| self.temperatures.iter().copied().reduce(pick).unwrap_or(0.0));
        if from < to {
            app.column_scale("temperature", Scale { from, to, palette: Palette::BlueRed });
        }
        app.insert_resource(*self).init_resource::<Differences>().add_systems(
            Step,
            (
                set_initial_temperature.in_set(Phase::Spawn),
                record_difference.in_set(ObserveStage::Measure).run_if(due::<Differences>),
            ),
        );
        in_space!(app, V => app.add_systems(Step, conduct::<V>.in_set(Phase::Kick)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::{columns, pair, run_pair, simulation};

    fn total_heat(run: &mut Simulation) -> f64 {
        let world = run.world_mut();
        world
            .query::<(&Mass, &Temperature)>()
            .iter(world)
            .map(|(mass, temperature)| 800.0 * mass.0 * temperature.0)
            .sum()
    }

    #[test]
    fn grains_conduct_in_a_scene_with_a_door() {
        let keys =
            "{\"conduction\": (temperatures: [400.0, 300.0], conductance: 50.0, heat_capacity: 800.0, interval: 0.25)}";
        let scene = format!(
            "(gravity: (0.0, 0.0), grains: (file: \"pair.csv\"), step: Fixed(1.0e-4), until: 0.01, \
              contact: Linear(k: 1.0e4, damping: B(20.0), attraction: Allowed), pictures: None, \
              walls: [Segment(from: (-9.0, -9.0), to: (9.0, -9.0), door: true)], door: (opens: At(0.005)), \
              behaviours: {keys})"
        );
        let mut run = simulation("door", scene);
        assert_eq!(run.run(), End::TimeReached);
    }

    #[test]
    fn two_grains_relax_as_in_the_closed_form() {
        for space in [Dimension::Plane, Dimension::Solid] {
            let keys = "{\"conduction\": (temperatures: [400.0, 300.0], conductance: 50.0, heat_capacity: 800.0, interval: 0.25), \
                         \"attraction\": (force: 1.0)}";
            let mut run = pair(space, keys, 2.0);
            assert_eq!(run.run(), End::TimeReached);
            let rate = 50.0 / 800.0 * (1.0 / 0.16 + 1.0 / 0.09);
            let recorded = &run.world().resource::<Differences>().0;
            assert_eq!(recorded.len(), 9, "{recorded:?}");
            for &(time, difference) in recorded {
                let expected = 100.0 * f64::exp(-rate * time);
                // Error of Euler's method: rate^2 t dt/2.
                assert!(
                    (difference / expected - 1.0).abs() < rate * rate * time * 1e-4 * 0.51 + 1e-12,
                    "{time} {difference} {expected}"
                );
            }
            let initial = 800.0 * (0.16 * 400.0 + 0.09 * 300.0);
            assert!((total_heat(&mut run) / initial - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn outputs_of_two_grains_follow_the_closed_form() {
        let keys = "{\"conduction\": (temperatures: [400.0, 300.0], conductance: 50.0, heat_capacity: 800.0, interval: 0.25), \
                     \"attraction\": (force: 1.0)}";
        let [a, b] = [0.16, 0.09];
        let rate = 50.0 / 800.0 * (1.0 / a + 1.0 / b);
        let mean = (a * 400.0 + b * 300.0) / (a + b);
        for space in [Dimension::Plane, Dimension::Solid] {
            let here = tempfile::tempdir().expect("a directory");
            let run = run_pair(here.path(), space, keys, 2.0);
            let frames: Vec<_> = columns(&run, "temperature");
            assert_eq!(frames.len(), 5);
            for (time, temperatures) in frames {
                // Euler's method with steps of 0.1 ms: relative error of the difference rate^2 t dt/2.
                let difference = 100.0 * f64::exp(-rate * time);
                let expected = [mean + b / (a + b) * difference, mean - a / (a + b) * difference];
                let limit = difference * rate * rate * time * 1e-4 * 0.51 + 1e-9;
                for (found, expected) in temperatures.iter().zip(expected) {
                    assert!((found - expected).abs() < limit, "{space:?}, {time} s: {found} K, {expected} K");
                }
            }
            let series = std::fs::read_to_string(run.join("series.csv")).expect("a series");
            let [names, rows] = series.split_once('\n').map(|(names, rows)| [names, rows]).expect("a header");
            assert!(names.ends_with("mean_temperature_k,heat_j"), "{names}");
            for row in rows.lines() {
                let cells: Vec<f64> = row.rsplit(',').take(2).map(|cell| cell.parse().expect("a number")).collect();
                let heat = 800.0 * (a + b) * mean;
                // 20 000 steps of round-off.
                assert!((cells[0] / heat - 1.0).abs() < 1e-12 && (cells[1] / mean - 1.0).abs() < 1e-12, "{row}");
            }
            let summary = std::fs::read_to_string(run.join("summary.json")).expect("a summary");
            assert!(summary.contains("\"conduction\": {\n      \"heat\": {"), "{summary}");
        }
    }

    #[test]
    fn heat_of_a_bed_is_conserved_while_grains_enter_and_collide() {
        let text = include_str!("../scenes/outside.ron").to_owned();
        let mut run = simulation("outside", text);
        assert_eq!(run.run(), End::TimeReached);
        let world = run.world_mut();
        let grains: Vec<_> =
            world.query::<(&Mass, &Temperature)>().iter(world).map(|(mass, t)| (mass.0, t.0)).collect();
        assert_eq!(grains.len(), 60);
        let masses: f64 = grains.iter().map(|(mass, _)| mass).sum();
        let mean = grains.iter().map(|(mass, temperature)| mass * temperature).sum::<f64>() / masses;
        let mut of_species = world.query::<(&Mass, &Species)>();
        let initial = of_species.iter(world).map(|(mass, species)| mass.0 * [400.0, 300.0][usize::from(species.0)]);
        assert!((mean / (initial.sum::<f64>() / masses) - 1.0).abs() < 1e-12);
        let difference = world.resource::<Differences>().0.last().map(|&(_, difference)| difference);
        assert!(difference.is_some_and(|difference| difference < 50.0), "{difference:?}");
    }
}
