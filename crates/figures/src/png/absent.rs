//! PNG in a build without the feature `png`.

use std::time::Duration;

use super::Pixels;

const REASON: &str = "this program was built without the feature `png`";

/// Draws nothing.
///
/// # Errors
/// Always.
pub fn encode(_: &str) -> Result<Vec<u8>, String> {
    Err(REASON.to_owned())
}

/// Draws nothing.
///
/// # Errors
/// Always.
pub fn encode_within(_: String, _: Duration) -> Result<Vec<u8>, String> {
    Err(REASON.to_owned())
}

/// Draws nothing.
///
/// # Errors
/// Always.
pub fn pixels(_: &str) -> Result<Pixels, String> {
    Err(REASON.to_owned())
}
