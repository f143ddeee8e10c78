//! The step of the automaton: its stages, and the place of each in the phases of a [`Step`].
//!
//! The lattice gas runs in the schedule of grains, so that behaviours, outputs and ends of runs have one schedule. The names of its
//! phases are those of velocity Verlet; this table gives their meaning for the gas:
//!
//! | stage | systems | phase of the step |
//! |---|---|---|
//! | [`Enter`](LatticeStage::Enter) | particles are poured in | [`Phase::Spawn`] |
//! | | the clock advances | [`Phase::Drift`] |
//! | [`Collide`](LatticeStage::Collide) | movers stop, stopped ones are placed, the rest collide | [`ForceStage::Contacts`] |
//! | [`Rub`](LatticeStage::Rub) | movers stop at rough walls | [`ForceStage::Contacts`], after `Collide` |
//! | [`Trickle`](LatticeStage::Trickle) | resting particles move down | [`ForceStage::Gravity`] |
//! | | behaviours change the outgoing particles | [`ForceStage::Added`] |
//! | [`Propagate`](LatticeStage::Propagate) | particles move to the next sites | [`Phase::Kick`] |
//! | | rest is detected, the door opens | [`Phase::Control`] |
//! | | ends of the run | [`Phase::Cull`] |
//! | | outputs | [`Phase::Observe`] |
//!
//! In step zero no stage runs. Between `Collide` and `Propagate`, systems find the outgoing particles in
//! [`Gas::movers`](siloflow_lattice::gas::Gas::movers) and [`Gas::resting`](siloflow_lattice::gas::Gas::resting).

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;

use siloflow_dem::step::{ForceStage, Phase, Step, time_moves};

/// The stages of a step of the automaton, in their order.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum LatticeStage {
    /// Particles enter.
    Enter,
    /// Particles collide on each site.
    Collide,
    /// Particles stop at rough walls.
    Rub,
    /// Resting particles move down.
    Trickle,
    /// Particles move to the next sites.
    Propagate,
}

/// Places the stages in the phases of a step.
pub(super) struct LatticeStagesPlugin;

impl Plugin for LatticeStagesPlugin {
    fn build(&self, app: &mut App) {
        let stages = (
            LatticeStage::Enter.in_set(Phase::Spawn),
            LatticeStage::Collide.in_set(ForceStage::Contacts),
            LatticeStage::Rub.in_set(ForceStage::Contacts).after(LatticeStage::Collide),
            LatticeStage::Trickle.in_set(ForceStage::Gravity),
            LatticeStage::Propagate.in_set(Phase::Kick),
        );
        app.configure_sets(Step, stages.run_if(time_moves));
    }
}
