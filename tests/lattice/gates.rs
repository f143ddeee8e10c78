//! The paper's claims, where one seed resolves them, in both silos. The whole study with its standard errors is `siloflow
//! study`, its table docs/explanation/lattice-gas.md; claims that fail stand there as failing, and are not asserted here.

use std::path::Path;

use rayon::prelude::*;
use siloflow::lattice_study::claims::{CLAIMS, Verdict};
use siloflow::lattice_study::plan::Plan;
use siloflow::lattice_study::replica::Replica;
use siloflow::lattice_study::results::Results;

/// What does not come out of these rules, by one seed as by four: of hz in the mass-flow silo only the order holds, with a
/// factor of 1.09, not 1.1.
const FAILS: [(&str, &str); 1] = [("mass flow", "hz(p = 0) > 1.100 hz(p = 0.8)")];

#[test]
fn what_one_seed_resolves() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/studies/lattice-gas.ron");
    let (plan, cases) = Plan::read(&path).unwrap();
    let first = plan.seeds[0];
    let cases: Vec<_> = cases.into_iter().filter(|case| case.seed == first).collect();
    let replicas = cases.into_par_iter().with_max_len(1).map(|case| Replica::run(case, &[]).unwrap());
    let results = Results(replicas.collect());
    let mut judged = 0;
    for silo in plan.silos.keys() {
        for claim in CLAIMS {
            for statement in &claim.statements[..claim.firm] {
                let found = statement.judge(&results, silo);
                let fails = FAILS.contains(&(silo.as_str(), found.statement.as_str()));
                let expected = if fails { Verdict::Fails } else { Verdict::Holds };
                assert_eq!(found.verdict, expected, "{silo}, {}: {}: {}", claim.text, found.statement, found.figures);
                judged += 1;
            }
        }
    }
    assert_eq!(judged, 2 * 16);
}
