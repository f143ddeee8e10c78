//! The figures of the paper, drawn from the code's own tables and runs: each a function that returns an SVG document.
//!
//! After J. Kozicki and J. Tejchman, Simulations of flow patterns in silos with a cellular automaton, part 2, TASK Quarterly
//! 9(1), 2005: [`vectors`] is its figure 1, [`resultants`] figure 2, [`collisions`] figure 3, [`thrown`] figure 4, and
//! [`sheet`] lays out density pictures as its figures 5 to 18 do.
//!
//! Limits. They show what the paper's figures show and are no copies of them: which collisions the paper draws is its own
//! choice, here a rule says which.

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

#[cfg(test)]
fn renders(svg: &str) {
    let png = crate::writers::png::encode(svg).unwrap();
    assert!(png.len() > 1000, "an empty picture");
}
