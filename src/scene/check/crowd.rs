//! Stability limits of the time step in a crowd, where several contacts take part in one motion.
//!
//! A motion of mass m has the springs K_n of its normals, the springs K_t of its tangents (or of rolling and twisting), and the drag C of
//! all, each summed over the contacts with their weights. With k_n = K_n dt^2/m, k_t = K_t dt^2/m and c = C dt/m:
//!
//! * **Lagged drag** (`Verlet`, `SymplecticEuler`): the motion is that of one contact with these sums. It becomes unstable at
//!   lambda = -1, where k_n + k_t + 2 c = 4.
//! * **`Centred`**: forces see the velocity v_p(n+1) = v_h + r dt a_n with r = beta/2, beta = (1 - q)/(1 + q), q = b dt
//!   ([`siloflow_dem::contact::centred::velocity_prediction`]). b is the damping rate of one contact, along the normal for straight motions and along the tangent
//!   or in rolling for turns. The drag of other contacts lags, so the prediction is not implicit for them. Normal springs follow the
//!   positions. Tangential, rolling and twisting springs have two forms ([`siloflow_dem::contact::centred`]). In the first they follow
//!   the positions too; then k_n is the sum of all springs, and k_t = 0. In the second they follow the predicted velocities by the
//!   trapezoidal rule, s_(n+1) - s_n = dt (v_p(n+1) + v_p(n))/2. The motion x_n = lambda^n has
//!
//!   lambda (lambda - 1)^2 + k_n lambda^2 + (k_t (lambda + 1)/2 + c (lambda - 1)) ((1 + r) lambda - r) = 0.
//!
//!   With a = k_t/2 + c, b = k_t/2 - c and the coefficients a_2 = k_n - 2 + a (1 + r), a_1 = 1 + b (1 + r) - a r, a_0 = -b r, Jury's
//!   conditions are
//!
//!   k_n + 2 c (1 + 2 r) < 4 (from lambda = -1) and 1 - a_0^2 > |a_0 a_2 - a_1|.
//!
//!   The second condition follows from the first if k_t = 0, and for springs that follow predicted velocities if c >= k_t. Springs follow
//!   predicted velocities only then. `tests/physics/growth.rs` shows this by the eigenvalues of grains that move and turn between one to
//!   twelve others.
//!
//! So with strong drag `Centred` needs shorter steps than `Verlet` in a crowd, down to half where drag decides. For a single contact
//! `Centred` allows longer steps, because it includes the change of the spring force.

use crate::scene::check::step::limit;
use siloflow_dem::contact::centred::velocity_prediction::prediction_share;
use siloflow_dem::integrate::Integrator;

/// Contribution of contacts of one kind to a motion.
#[derive(Clone, Copy, Debug)]
pub struct Pull {
    /// Weight of a contact, times the number of contacts.
    pub weight: f64,
    /// k, N/m.
    pub k: f64,
    /// c, N s/m.
    pub c: f64,
    /// Mobility of the contact: acceleration per unit of its own force, 1/kg.
    pub mobility: f64,
    /// Whether the spring gathers velocities, as along tangents and in rolling.
    pub gathers: bool,
}

/// A motion of several contacts.
#[derive(Clone, Copy, Debug)]
pub struct Motion<'a> {
    /// The contacts.
    pub pulls: &'a [Pull],
    /// Mass, kg.
    pub mass: f64,
    /// Damping rate of one contact, b, 1/s.
    pub rate: f64,
}

impl Motion<'_> {
    /// Returns the largest stable step, s. In steps longer than `exact_from`, s, all springs follow the positions.
    #[must_use]
    pub fn limit(&self, scheme: Integrator, exact_from: f64) -> f64 {
        let total = |figure: fn(&Pull) -> f64| self.pulls.iter().map(|pull| pull.weight * figure(pull)).sum::<f64>();
        let [springs, drags] = [total(|pull| pull.k), total(|pull| pull.c)];
        if scheme != Integrator::Centred {
            return limit(scheme, springs, drags, self.mass);
        }
        let fastest = (springs / self.mass).sqrt().max(drags / self.mass);
        if fastest <= 0.0 {
            return f64::INFINITY;
        }
        let gathering = total(|pull| if pull.gathers { pull.k } else { 0.0 });
        let is_stable = |dt: f64| {
            let springs = if dt > exact_from { [springs, 0.0] } else { [springs - gathering, gathering] };
            self.is_stable_centred(springs, drags, dt)
        };
        // Every motion is stable at first, and unstable where a spring alone changes the velocity by four times itself.
        let mut low = 0.0;
        let mut high = 0.05 / fastest;
        while is_stable(high) {
            (low, high) = (high, 1.05 * high);
        }
        for _ in 0..50 {
            let middle = 0.5 * (low + high);
            if is_stable(middle) { low = middle } else { high = middle }
        }
        high
    }

    /// Jury's conditions with the sums K_n, K_t (N/m) and C (N s/m).
    fn is_stable_centred(&self, springs: [f64; 2], drags: f64, dt: f64) -> bool {
        let [kn, kt] = springs.map(|k| k * dt * dt / self.mass);
        let c = drags * dt / self.mass;
        let r = 0.5 * prediction_share(self.rate, dt);
        let [a, b] = [0.5 * kt + c, 0.5 * kt - c];
        let [a2, a1, a0] = [kn - 2.0 + a * (1.0 + r), 1.0 + b * (1.0 + r) - a * r, -b * r];
        // Without drag a motion keeps its amplitude, which rounding must not make unstable.
        kn + 2.0 * c * (1.0 + 2.0 * r) < 4.0 && 1.0 - a0 * a0 > (a0 * a2 - a1).abs() - 1e-12
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Contacts of a motion of mass 1 in units of w0 = 1: `n` along normals with the damping ratio `zeta`, and `m` along tangents
    /// with the spring `kt` and the drag `ct`, each with the damping rate `zeta`.
    #[derive(Clone, Copy, Debug)]
    struct Crowd {
        n: f64,
        zeta: f64,
        m: f64,
        kt: f64,
        ct: f64,
        /// Whether tangential springs follow the positions.
        exact: bool,
    }

    impl Crowd {
        fn limit(self, scheme: Integrator) -> f64 {
            let Self { n, zeta, m, kt, ct, exact } = self;
            let normal = Pull { weight: n, k: 1.0, c: 2.0 * zeta, mobility: 1.0, gathers: false };
            let tangential = Pull { weight: m, k: kt, c: ct, mobility: 1.0, gathers: true };
            let exact_from = if exact { 0.0 } else { f64::INFINITY };
            Motion { pulls: &[normal, tangential], mass: 1.0, rate: zeta }.limit(scheme, exact_from)
        }

        /// Growth of the motion per step, by simulation of the scheme itself, rescaled on the way.
        fn growth(self, dt: f64) -> f64 {
            let Self { n, zeta, m, kt, ct, exact } = self;
            let beta = (1.0 - zeta * dt) / (1.0 + zeta * dt);
            let [mut x, mut s, mut v, mut a, mut predicted] = [1.0f64, -0.7, 0.4, 0.1, 0.2];
            let mut log = 0.0;
            let steps = 40_000;
            for _ in 0..steps {
                let now = v + 0.5 * dt * beta * a;
                x += dt * v;
                s += 0.5 * dt * (now + predicted);
                predicted = now;
                let stretch = if exact { x } else { s };
                a = -(n * (x + 2.0 * zeta * now) + m * (kt * stretch + ct * now));
                v += dt * a;
                let size = [x, s, v, a, predicted].iter().fold(0.0f64, |size, y| size.max(y.abs()));
                [x, s, v, a, predicted] = [x, s, v, a, predicted].map(|y| y / size);
                log += size.ln();
            }
            (log / f64::from(steps)).exp()
        }
    }

    #[test]
    fn at_the_limit_of_centred_the_motion_begins_to_grow() {
        for zeta in [0.01, 0.1, 0.3, 0.5, 1.0, 3.0] {
            // Normals alone; normals and tangents; the same with little tangential drag; tangents alone.
            for crowd in [
                (1.0, 0.0, 0.0, 0.0),
                (3.0, 0.0, 0.0, 0.0),
                (3.0, 3.0, 0.3, 0.5),
                (2.0, 4.0, 1.0, 0.1),
                (0.0, 12.0, 0.3, 0.5),
                (3.0, 3.0, 0.3, 0.0),
            ]
            .into_iter()
            .flat_map(|case| [(case, true), (case, false)])
            // Springs follow predicted velocities only with a dashpot.
            .filter(|((.., share), exact)| *exact || *share > 0.0)
            .map(|((n, m, kt, share), exact)| Crowd { n, zeta, m, kt, ct: 2.0 * zeta * share, exact })
            {
                let limit = crowd.limit(Integrator::Centred);
                let [below, above] = [0.99, 1.01].map(|share| crowd.growth(share * limit));
                // The start alone changes the mean by 1/40,000.
                assert!(below < 1.0 + 5e-5 && above > 1.0 + 5e-5, "{crowd:?}: {below} {above}");
            }
        }
    }

    #[test]
    fn with_normals_alone_the_limit_is_the_closed_form() {
        for n in [1.0, 2.0, 3.0, 6.0] {
            for zeta in [0.01, 0.1, 0.5, 1.0, 3.0] {
                let crowd = Crowd { n, zeta, m: 0.0, kt: 0.0, ct: 0.0, exact: false };
                let x = crowd.limit(Integrator::Centred);
                let load = n * (x * x + 8.0 * zeta * x / (1.0 + zeta * x));
                assert!((load - 4.0).abs() < 1e-9, "{n} contacts, zeta {zeta}: {load}");
                assert!(x < crowd.limit(Integrator::Verlet), "{n} contacts, zeta {zeta}");
            }
        }
        // Without drag both keep their amplitude up to 2/w.
        let springs = Crowd { n: 1.0, zeta: 0.0, m: 3.0, kt: 1.0, ct: 0.0, exact: true };
        for scheme in [Integrator::Centred, Integrator::Verlet] {
            assert!((springs.limit(scheme) - 1.0).abs() < 1e-9);
        }
    }

    #[test]
    fn a_spring_that_follows_predicted_velocities_needs_a_dashpot() {
        let of = |ct: f64, exact: bool| Crowd { n: 0.0, zeta: 0.0, m: 1.0, kt: 1.0, ct, exact };
        // The amplitude grows by x^4/8 in each step, and a dashpot c takes c x/2 of it.
        for x in [0.1f64, 0.2] {
            let limit = of(0.25 * x.powi(3), false).limit(Integrator::Centred);
            assert!((limit / x - 1.0).abs() < x * x, "{x}: {limit}");
            // A spring that follows the positions needs none.
            assert!((of(0.0, true).limit(Integrator::Centred) - 2.0).abs() < 1e-9);
        }
        assert!(Crowd { m: 0.0, ..of(1.0, false) }.limit(Integrator::Centred).is_infinite());
        assert!(Crowd { m: 0.0, ..of(1.0, false) }.limit(Integrator::Verlet).is_infinite());
    }
}
