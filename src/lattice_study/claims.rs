//! The paper's claims about its parameters, as orderings of observables, and what becomes of them.
//!
//! An ordering says that a quantity is larger by more than a factor in one variant than in another. It *holds* or *fails* by
//! the means over the seeds; where they differ from it by less than two of their combined standard errors, it is *unclear*. What a claim that hangs on one statistic says, its neighbours need not: they are reported too. The
//! statements that one seed is enough for are the first of each claim; tests assert those that hold.

use crate::lattice::observables::{QUANTITIES, Quantity};
use crate::lattice::rules::Walls;
use crate::lattice_study::plan::Variant;
use crate::lattice_study::results::{Mean, Results};

/// What has become of a statement.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// It is so.
    Holds,
    /// It is not so.
    Fails,
    /// The difference is within two combined standard errors.
    Unclear,
    /// Two figures that should be the same differ by less than two combined standard errors.
    NoDifference,
    /// The study did not run what it needs, or has nothing to measure.
    NotMeasured,
}

impl Verdict {
    /// In a word.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Holds => "holds",
            Self::Fails => "**fails**",
            Self::Unclear => "unclear",
            Self::NoDifference => "no difference seen",
            Self::NotMeasured => "not measured",
        }
    }
}

/// A statement on one silo.
#[derive(Clone, Copy, Debug)]
pub enum Statement {
    /// A quantity in the first variant is more than so many times that in the second.
    Larger(&'static str, Variant, Variant, f64),
    /// The spread of a quantity over the variants of all other parameters is smaller at g = 0.95 than at the base's g.
    SpreadFalls(&'static str),
    /// A quantity is the same in both variants, within two combined standard errors.
    Same(&'static str, Variant, Variant),
}

/// A claim of the paper, and the statements that it is taken for.
#[derive(Clone, Copy, Debug)]
pub struct Claim {
    /// In the paper's sense.
    pub text: &'static str,
    /// How many of the statements, from the first, one seed is enough for.
    pub firm: usize,
    /// What it is taken for.
    pub statements: &'static [Statement],
}

const BASE: Variant = Variant::BASE;

const fn p(p: f64) -> Variant {
    Variant { p: Some(p), ..BASE }
}
const fn q(q: f64) -> Variant {
    Variant { q: Some(q), ..BASE }
}
const fn b(b: f64) -> Variant {
    Variant { b: Some(b), ..BASE }
}
const fn k(k: f64) -> Variant {
    Variant { k: Some(k), ..BASE }
}
const fn g(g: f64) -> Variant {
    Variant { g: Some(g), ..BASE }
}
const fn h(h: f64) -> Variant {
    Variant { h: Some(h), ..BASE }
}
/// The same with sharp surfaces.
const fn heavy(variant: Variant) -> Variant {
    Variant { g: Some(0.95), ..variant }
}
const fn scattering(variant: Variant) -> Variant {
    Variant { walls: Some(Walls::Scatter), ..variant }
}

use Statement::{Larger, Same, SpreadFalls};

/// The claims.
pub const CLAIMS: &[Claim] = &[
    Claim {
        text: "the outflow rises with g",
        firm: 2,
        statements: &[Larger("Q", BASE, g(0.05), 1.05), Larger("Q", g(0.95), BASE, 1.05)],
    },
    Claim {
        text: "at large g the other parameters matter less",
        firm: 1,
        statements: &[SpreadFalls("rho0"), SpreadFalls("Q")],
    },
    Claim {
        text: "the density at onset rises with p and g, falls with q and k",
        firm: 5,
        statements: &[
            Larger("rho0", BASE, g(0.05), 1.0),
            Larger("rho0", g(0.95), BASE, 1.0),
            Larger("rho0", BASE, q(0.8), 1.0 / 0.75),
            Larger("rho0", BASE, k(0.8), 1.0 / 0.75),
            Larger("rho0", BASE, p(0.0), 1.0),
            Larger("rho0", p(0.8), BASE, 1.0),
            Larger("rhob", p(0.8), p(0.0), 1.0),
            Larger("rhob", q(0.0), q(0.8), 1.0),
            Larger("rhob", k(0.0), k(0.8), 1.0),
        ],
    },
    Claim {
        text: "dilatant zones are higher at small p",
        firm: 1,
        statements: &[
            Larger("hz", p(0.0), p(0.8), 1.1),
            Larger("hz", p(0.0), BASE, 1.0),
            Larger("hz", BASE, p(0.8), 1.0),
            Larger("zh80", p(0.0), p(0.8), 1.0),
            Larger("zh", p(0.0), p(0.8), 1.0),
        ],
    },
    Claim {
        text: "dilatant zones are narrower and central at large h",
        firm: 1,
        statements: &[
            Larger("za", h(0.0), h(0.8), 1.0 / 0.92),
            Larger("zw", h(0.0), h(0.8), 1.0),
            Larger("zc", h(0.8), h(0.0), 1.0),
        ],
    },
    Claim {
        text: "at small b the zones are more horizontal (mass-flow silo): density in the middle nearer to that at the sides",
        firm: 0,
        statements: &[Larger("cs", b(0.0), b(0.8), 1.0), Larger("dip", b(0.8), b(0.0), 1.0)],
    },
    Claim {
        text: "the surface is flatter at small p, q and h",
        firm: 2,
        statements: &[
            Larger("incl", heavy(p(0.8)), heavy(p(0.0)), 1.3),
            Larger("incl", heavy(q(0.8)), heavy(q(0.0)), 1.0),
            Larger("incl", heavy(h(0.8)), heavy(h(0.0)), 1.0),
            Larger("incl", p(0.8), p(0.0), 1.0),
            Larger("incl", q(0.8), q(0.0), 1.0),
            Larger("incl", h(0.8), h(0.0), 1.0),
        ],
    },
    Claim {
        text: "the density is less uniform at large g, more at large p, q, h and k",
        firm: 4,
        statements: &[
            Larger("cvg", BASE, g(0.05), 1.0),
            Larger("cvg", g(0.95), BASE, 1.0),
            Larger("cvg", k(0.0), k(0.8), 1.0 / 0.75),
            Larger("cvg", q(0.0), q(0.8), 1.0 / 0.75),
            Larger("cvg", p(0.0), p(0.8), 1.0),
            Larger("cvg", h(0.0), h(0.8), 1.0),
            Larger("cvr", g(0.95), g(0.05), 1.0),
            Larger("cvr", p(0.0), p(0.8), 1.0),
            Larger("cvr", q(0.0), q(0.8), 1.0),
            Larger("cvr", h(0.0), h(0.8), 1.0),
            Larger("cvr", k(0.0), k(0.8), 1.0),
        ],
    },
    Claim {
        text: "walls that scatter (the first method) do not change the flow in a silo",
        firm: 0,
        statements: &[
            Same("Q", scattering(b(0.8)), b(0.0)),
            Same("hz", scattering(b(0.8)), b(0.0)),
            Same("cs", scattering(b(0.8)), b(0.0)),
        ],
    },
];

/// What was found of a statement in a silo.
#[derive(Clone, Debug)]
pub struct Finding {
    /// The statement, in symbols.
    pub statement: String,
    /// The figures behind it.
    pub figures: String,
    /// What has become of it.
    pub verdict: Verdict,
}

/// A quantity by its symbol.
#[must_use]
pub fn quantity(symbol: &str) -> Option<&'static Quantity> {
    QUANTITIES.iter().find(|quantity| quantity.symbol == symbol)
}

impl Statement {
    /// Compares it with the results of a silo.
    #[must_use]
    pub fn judge(&self, results: &Results, silo: &str) -> Finding {
        let mean = |symbol: &str, of: &Variant| results.mean(silo, of, quantity(symbol)?);
        match *self {
            Larger(symbol, large, small, factor) => {
                let times = if (factor - 1.0).abs() < 1e-12 { String::new() } else { format!("{factor:.3} ") };
                let statement = format!("{symbol}({large}) > {times}{symbol}({small})");
                compared(statement, mean(symbol, &large), mean(symbol, &small), |a, b| {
                    larger(a.value - factor * b.value, a.error.hypot(factor * b.error))
                })
            }
            Same(symbol, one, other) => {
                let statement = format!("{symbol}({one}) = {symbol}({other})");
                compared(statement, mean(symbol, &one), mean(symbol, &other), |a, b| {
                    match larger((a.value - b.value).abs(), a.error.hypot(b.error)) {
                        Verdict::Holds => Verdict::Fails,
                        _ => Verdict::NoDifference,
                    }
                })
            }
            SpreadFalls(symbol) => {
                let statement = format!("spread of {symbol} at g = 0.95 < at the base's g");
                let spread = |change: fn(Variant) -> Variant| spread(results, silo, symbol, change);
                compared(statement, spread(heavy), spread(|variant| variant), |heavy, base| {
                    larger(base.value - heavy.value, heavy.error.hypot(base.error))
                })
            }
        }
    }
}

/// Whether a difference is larger than zero, for its standard error.
fn larger(difference: f64, error: f64) -> Verdict {
    if difference.abs() < 2.0 * error {
        Verdict::Unclear
    } else if difference > 0.0 {
        Verdict::Holds
    } else {
        Verdict::Fails
    }
}

fn compared(statement: String, a: Option<Mean>, b: Option<Mean>, judge: impl Fn(Mean, Mean) -> Verdict) -> Finding {
    match a.zip(b) {
        Some((a, b)) => Finding { statement, figures: format!("{}; {}", shown(a), shown(b)), verdict: judge(a, b) },
        None => Finding { statement, figures: String::new(), verdict: Verdict::NotMeasured },
    }
}

/// A mean and, if it has one, its standard error with as many digits as say something.
#[must_use]
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
pub fn shown(Mean { value, error }: Mean) -> String {
    let scale = if error > 0.0 { error } else { 0.01 * value.abs().max(1e-6) };
    let decimals = (1.0 - scale.log10().floor()).clamp(0.0, 6.0) as usize;
    if error > 0.0 { format!("{value:.decimals$} ± {error:.decimals$}") } else { format!("{value:.decimals$}") }
}

/// Standard deviation of a quantity over the base and all variants of one other parameter than g, each changed; of every
/// seed by itself, and then the mean over the seeds.
fn spread(results: &Results, silo: &str, symbol: &str, change: fn(Variant) -> Variant) -> Option<Mean> {
    let others = [BASE, p(0.8), p(0.0), q(0.8), q(0.0), b(0.8), b(0.0), k(0.8), k(0.0), h(0.8), h(0.0)];
    let quantity = quantity(symbol)?;
    let by_variant: Vec<Vec<f64>> = others.iter().map(|&one| results.values(silo, &change(one), quantity)).collect();
    let seeds = by_variant.iter().map(Vec::len).min()?;
    let spread_of = |seed: usize| {
        let values: Vec<f64> = by_variant.iter().map(|values| values[seed]).collect();
        // The standard deviation is that of the mean times the root of their number.
        Mean::of(&values).map(|mean| mean.error * 11f64.sqrt())
    };
    Mean::of(&(0..seeds).filter_map(spread_of).collect::<Vec<_>>())
}
