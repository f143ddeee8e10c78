//! Grains of several spheres as rigid bodies of LAMMPS: `fix rigid/small`, in solid space.
//!
//! A body is a molecule whose number is the id of the grain. The sphere nearest to the centre of mass has that id as an atom too, and the mass of
//! the grain, so that counts and sums over the atoms of the group `counted` are those of grains. The other spheres have ids behind all others.
//! The file [`BODIES`](super::BODIES) has mass, centre, moments of inertia about the axes of space, velocity and angular momentum of each body; the
//! masses of its atoms do not enter its motion, nor its contacts.
//!
//! LAMMPS 29 Sep 2021 turns bodies by Richardson's iteration of the quaternion, of second order as in siloflow.

use std::fmt::Write as _;

use crate::grains::file::GrainRow;
use crate::lammps::{BODIES, number, vector};
use crate::scene::loaded::Loaded;
use siloflow_dem::bodies::RigidShape;
use siloflow_dem::space::{Quaternion, Rotor as _, Solid};

/// A sphere of a body.
pub(super) struct SphereAtom {
    pub id: usize,
    /// The number of the molecule: the id of the grain.
    pub molecule: u32,
    pub species: usize,
    pub radius: f64,
    pub mass: f64,
    pub position: Solid,
    pub velocity: Solid,
    pub spin: Solid,
}

/// The bodies of a scene.
#[derive(Default)]
pub(super) struct Bodies {
    /// All spheres.
    pub spheres: Vec<SphereAtom>,
    /// Content of the file of bodies.
    pub file: String,
    /// Number of bodies.
    count: usize,
    /// Radius of the smallest sphere about the centre that holds any body, m.
    reach: f64,
}

impl Bodies {
    /// Collects the bodies among the grains at the start. Spheres beyond the first of each have ids from `next` on.
    pub(super) fn of(loaded: &Loaded, next: usize) -> Self {
        let shapes = loaded.shapes.rigid::<Solid>();
        let mut bodies = Self::default();
        let mut next = next;
        let mut rows = String::new();
        for grain in &loaded.grains {
            let Some(posture) = grain.posture else { continue };
            let Some(shape) = shapes.get(posture.shape.index()) else { continue };
            bodies.reach = bodies.reach.max(posture.reach);
            let inertia = Inertia::of(grain, shape);
            rows += &inertia.row(grain);
            bodies.count += 1;
            let spheres = loaded.shapes.spheres_of::<Solid>(&posture, grain.radius);
            let central = (0..spheres.len()).min_by(|&a, &b| {
                let [a, b] = [a, b].map(|number| spheres[number].0.length_squared());
                a.total_cmp(&b)
            });
            for (number, (arm, radius)) in spheres.into_iter().enumerate() {
                let is_central = Some(number) == central;
                let id = if is_central { grain.id.number() as usize } else { next };
                next += usize::from(!is_central);
                bodies.spheres.push(SphereAtom {
                    id,
                    molecule: grain.id.number(),
                    species: usize::from(grain.species.0),
                    radius,
                    mass: grain.mass,
                    position: grain.position + arm,
                    velocity: grain.velocity + grain.spin.cross(arm),
                    spin: grain.spin,
                });
            }
        }
        bodies.file = format!("{}\n{rows}", bodies.count);
        bodies
    }

    pub(super) fn is_empty(&self) -> bool {
        self.spheres.is_empty()
    }

    /// Number of spheres whose ids come behind those of grains and fixed atoms.
    pub(super) fn behind(&self) -> usize {
        self.spheres.len() - self.count
    }

    /// The group whose atoms are the grains, for counts and sums.
    pub(super) fn counted(&self) -> &'static str {
        if self.is_empty() { "grains" } else { "counted" }
    }

    /// Commands before the data file is read.
    pub(super) fn before_reading(&self) -> &'static str {
        if self.is_empty() { "" } else { "atom_modify map array\nfix molecules all property/atom mol ghost yes\n" }
    }

    /// The end of the command that reads the data file.
    pub(super) fn reading(&self) -> &'static str {
        if self.is_empty() { "" } else { " fix molecules NULL Molecules" }
    }

    /// Groups, after those of all grains. Ids of grains are below `first_fixed`.
    pub(super) fn groups(&self, first_fixed: u32) -> String {
        if self.is_empty() {
            return String::new();
        }
        // A sphere of a body reaches its neighbours, and the centre of its body.
        let cutoff = number(4.0 * self.reach);
        format!(
            "group bodies molecule > 0\ngroup single subtract grains bodies\ngroup of_ids id < {first_fixed}\n\
             group counted intersect of_ids grains\nneigh_modify exclude molecule/intra bodies\ncomm_modify cutoff {cutoff}\n"
        )
    }

    /// The section of the data file that gives each sphere its body; fixed atoms and single grains have none.
    pub(super) fn molecules(&self, others: impl Iterator<Item = usize>) -> String {
        let mut text = String::new();
        if self.is_empty() {
            return text;
        }
        text.push_str("\nMolecules\n\n");
        for sphere in &self.spheres {
            let _ = writeln!(text, "{} {}", sphere.id, sphere.molecule);
        }
        for id in others {
            let _ = writeln!(text, "{id} 0");
        }
        text
    }

    /// The fixes that move bodies with this gravity, m/s^2.
    pub(super) fn motion(&self, gravity: Solid) -> String {
        if self.is_empty() {
            return String::new();
        }
        // The temperature, which LAMMPS prints by default, needs more degrees of freedom than a few bodies have.
        let mut text = String::from("thermo_style custom step atoms\n");
        let mut weight = "";
        if gravity != Solid::ZERO {
            let _ = writeln!(
                text,
                "fix weight_of_bodies bodies gravity {} vector {} disable",
                number(gravity.length()),
                vector(gravity)
            );
            weight = " gravity weight_of_bodies";
        }
        let _ = writeln!(text, "fix bodies bodies rigid/small molecule infile {BODIES} reinit no{weight}");
        text
    }
}

/// The moments of inertia of a body about the axes of space, kg m^2, and its angular momentum, kg m^2/s.
struct Inertia {
    /// xx, yy, zz, xy, xz, yz.
    moments: [f64; 6],
    momentum: Solid,
}

impl Inertia {
    fn of(grain: &GrainRow, shape: &RigidShape<Solid>) -> Self {
        let inverse = shape.inverse_inertia(grain.mass, shape.scale(grain.radius));
        let rotor = grain.posture.map_or(Quaternion::IDENTITY, |posture| posture.rotor);
        let axes = [Solid::X, Solid::Y, Solid::Z].map(|axis| rotor.turn(axis));
        let principal = inverse.to_array().map(|inverse| 1.0 / inverse);
        let moment = |i: usize, j: usize| (0..3).map(|k| principal[k] * axes[k][i] * axes[k][j]).sum::<f64>();
        Self {
            moments: [moment(0, 0), moment(1, 1), moment(2, 2), moment(0, 1), moment(0, 2), moment(1, 2)],
            momentum: rotor.momentum(grain.spin, inverse),
        }
    }

    /// The row of the file of bodies. The last three numbers are the box that the centre is in.
    fn row(&self, grain: &GrainRow) -> String {
        format!(
            "{} {} {} {} {} {} 0 0 0\n",
            grain.id.number(),
            number(grain.mass),
            vector(grain.position),
            self.moments.map(number).join(" "),
            vector(grain.velocity),
            vector(self.momentum)
        )
    }
}
