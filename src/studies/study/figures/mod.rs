//! The figures of the paper, drawn from the tables and runs of this program. Each function returns an SVG document.
//!
//! Source: J. Kozicki and J. Tejchman, Simulations of flow patterns in silos with a cellular automaton, part 2, TASK
//! Quarterly 9(1), 2005. [`vectors`] is its figure 1, [`resultants`] figure 2, [`collisions`] figure 3 and [`thrown`]
//! figure 4. [`sheet`] arranges density pictures as in its figures 5 to 18.
//!
//! Limits. The figures show the content of the paper's figures but do not copy them. The paper does not say how it
//! chose its example collisions; here a rule selects them.

mod collisions;
mod examples;
mod flights;
mod paper;
mod plot;
mod resultants;
mod shading;
mod sheet;
mod site;
mod thrown;
mod vectors;

pub use collisions::collisions;
pub use flights::Flights;
pub use resultants::resultants;
pub use sheet::{Panel, SheetRow, sheet};
pub use thrown::thrown;
pub use vectors::vectors;

/// Asserts that an SVG document renders to a non-empty picture.
#[cfg(test)]
fn renders(svg: &str) {
    let png = siloflow_figures::png::encode(svg).unwrap();
    assert!(png.len() > 1000, "an empty picture");
}
