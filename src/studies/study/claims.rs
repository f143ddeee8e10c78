//! The paper's claims about its parameters, expressed as statements about observables, and the test of these
//! statements.
//!
//! An ordering states that a quantity in one variant is larger than a factor times the quantity in another variant. It
//! is evaluated with the means over the seeds. An ordering *holds* or *fails* if the difference is at least two
//! combined standard errors, and is *unclear* otherwise.
//!
//! A claim can depend on the choice of the observable, so related observables are reported too. The first statements of
//! each claim are firm: a single seed is enough to decide them. Tests assert the firm statements that hold.

use crate::lattice_silo::observables::{QUANTITIES, Quantity};
use crate::studies::study::plan::Variant;
use crate::studies::study::results::Results;
use siloflow_figures::statistics::mean::Mean;
use siloflow_lattice::rules::Walls;

/// The result of testing a statement.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ClaimVerdict {
    /// The statement is true.
    Holds,
    /// The statement is false.
    Fails,
    /// The difference is less than two combined standard errors.
    Unclear,
    /// Two values that should be equal differ by less than two combined standard errors.
    NoDifference,
    /// The study did not run the variants of the statement, or the quantity is undefined in them.
    NotMeasured,
}

impl ClaimVerdict {
    /// Returns the verdict in words, as Markdown.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Holds => "holds",
            Self::Fails => "**fails**",
            Self::Unclear => "unclear",
            Self::NoDifference => "no difference found",
            Self::NotMeasured => "not measured",
        }
    }
}

/// A statement about the results of one silo.
#[derive(Clone, Copy, Debug)]
pub enum Statement {
    /// A quantity (by its symbol) in the first variant is larger than a factor times the quantity in the second
    /// variant.
    Larger(&'static str, Variant, Variant, f64),
    /// The spread of a quantity over the variants of all parameters except g is smaller at g = 0.95 than at g of the
    /// base case.
    SpreadFalls(&'static str),
    /// A quantity has equal values in both variants, within two combined standard errors.
    Same(&'static str, Variant, Variant),
}

/// A claim of the paper, and the statements that represent it.
#[derive(Clone, Copy, Debug)]
pub struct Claim {
    /// The claim in words.
    pub text: &'static str,
    /// Number of firm statements, at the start of `statements`: a single seed is enough to decide them.
    pub firm: usize,
    /// The statements that represent the claim.
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
/// Returns the variant with g = 0.95, which gives a sharp surface.
const fn at_large_g(variant: Variant) -> Variant {
    Variant { g: Some(0.95), ..variant }
}
/// Returns the variant with walls that scatter (the paper's first method).
const fn with_scattering_walls(variant: Variant) -> Variant {
    Variant { walls: Some(Walls::Scatter), ..variant }
}

use Statement::{Larger, Same, SpreadFalls};

/// All claims.
pub const CLAIMS: &[Claim] = &[
    Claim {
        text: "The outflow rate rises with g",
        firm: 2,
        statements: &[Larger("Q", BASE, g(0.05), 1.05), Larger("Q", g(0.95), BASE, 1.05)],
    },
    Claim {
        text: "At large g the other parameters have less influence",
        firm: 1,
        statements: &[SpreadFalls("rho0"), SpreadFalls("Q")],
    },
    Claim {
        text: "The density at the opening of the outlet rises with p and g and falls with q and k",
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
        text: "Dilatant zones are higher at small p",
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
        text: "Dilatant zones are narrower and nearer to the axis at large h",
        firm: 1,
        statements: &[
            Larger("za", h(0.0), h(0.8), 1.0 / 0.92),
            Larger("zw", h(0.0), h(0.8), 1.0),
            Larger("zc", h(0.8), h(0.0), 1.0),
        ],
    },
    Claim {
        text: "At small b dilatant zones are more horizontal in the mass-flow silo: the density on the axis is closer to the \
               density at the sides",
        firm: 0,
        statements: &[Larger("cs", b(0.0), b(0.8), 1.0), Larger("dip", b(0.8), b(0.0), 1.0)],
    },
    Claim {
        text: "The surface is flatter at small p, q and h",
        firm: 2,
        statements: &[
            Larger("incl", at_large_g(p(0.8)), at_large_g(p(0.0)), 1.3),
            Larger("incl", at_large_g(q(0.8)), at_large_g(q(0.0)), 1.0),
            Larger("incl", at_large_g(h(0.8)), at_large_g(h(0.0)), 1.0),
            Larger("incl", p(0.8), p(0.0), 1.0),
            Larger("incl", q(0.8), q(0.0), 1.0),
            Larger("incl", h(0.8), h(0.0), 1.0),
        ],
    },
    Claim {
        text: "The density is less uniform at large g, and more uniform at large p, q, h and k",
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
        text: "Walls that scatter particles (`walls: Scatter`, the paper's first method) leave the flow in a silo unchanged",
        firm: 0,
        statements: &[
            Same("Q", with_scattering_walls(b(0.8)), b(0.0)),
            Same("hz", with_scattering_walls(b(0.8)), b(0.0)),
            Same("cs", with_scattering_walls(b(0.8)), b(0.0)),
        ],
    },
];

/// The result of a statement for one silo.
#[derive(Clone, Debug)]
pub struct Finding {
    /// The statement, in symbols.
    pub statement: String,
    /// The values that are compared.
    pub figures: String,
    /// The verdict.
    pub verdict: ClaimVerdict,
}

/// Returns the quantity with a symbol; `None` if there is none.
#[must_use]
pub fn quantity(symbol: &str) -> Option<&'static Quantity> {
    QUANTITIES.iter().find(|quantity| quantity.symbol == symbol)
}

impl Statement {
    /// Tests the statement with the results of a silo.
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
                        ClaimVerdict::Holds => ClaimVerdict::Fails,
                        _ => ClaimVerdict::NoDifference,
                    }
                })
            }
            SpreadFalls(symbol) => {
                let statement = format!("spread of {symbol} at g = 0.95 < spread at g of the base case");
                let spread = |change: fn(Variant) -> Variant| spread(results, silo, symbol, change);
                compared(statement, spread(at_large_g), spread(|variant| variant), |large_g, base| {
                    larger(base.value - large_g.value, large_g.error.hypot(base.error))
                })
            }
        }
    }
}

/// Tests whether a difference with the standard error `error` is larger than zero.
fn larger(difference: f64, error: f64) -> ClaimVerdict {
    if difference.abs() < 2.0 * error {
        ClaimVerdict::Unclear
    } else if difference > 0.0 {
        ClaimVerdict::Holds
    } else {
        ClaimVerdict::Fails
    }
}

/// Returns the finding for two values, or [`ClaimVerdict::NotMeasured`] if one of them is missing.
fn compared(
    statement: String,
    a: Option<Mean>,
    b: Option<Mean>,
    judge: impl Fn(Mean, Mean) -> ClaimVerdict,
) -> Finding {
    match a.zip(b) {
        Some((a, b)) => Finding { statement, figures: format!("{}; {}", shown(a), shown(b)), verdict: judge(a, b) },
        None => Finding { statement, figures: String::new(), verdict: ClaimVerdict::NotMeasured },
    }
}

/// Formats a mean and its standard error (if not 0) with as many decimals as the error makes meaningful.
#[must_use]
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
pub fn shown(Mean { value, error }: Mean) -> String {
    let scale = if error > 0.0 { error } else { 0.01 * value.abs().max(1e-6) };
    let decimals = (1.0 - scale.log10().floor()).clamp(0.0, 6.0) as usize;
    if error > 0.0 { format!("{value:.decimals$} ± {error:.decimals$}") } else { format!("{value:.decimals$}") }
}

/// Returns the spread of a quantity: its standard deviation over the base case and all variants that differ from it in
/// one parameter other than g. `change` is applied to all of these variants. The spread is computed for each seed, then
/// averaged over the seeds. A seed is left out if the quantity is undefined in one of the variants.
fn spread(results: &Results, silo: &str, symbol: &str, change: fn(Variant) -> Variant) -> Option<Mean> {
    let variants = [BASE, p(0.8), p(0.0), q(0.8), q(0.0), b(0.8), b(0.0), k(0.8), k(0.0), h(0.8), h(0.0)];
    let quantity = quantity(symbol)?;
    let spread_of = |seed: u64| {
        let values = variants.iter().map(|&one| results.value(silo, &change(one), seed, quantity));
        // The standard deviation is the standard error of the mean times the square root of the number of values, 11.
        Mean::of(&values.collect::<Option<Vec<_>>>()?).map(|mean| mean.error * 11f64.sqrt())
    };
    Mean::of(&results.seeds().into_iter().filter_map(spread_of).collect::<Vec<_>>())
}
