//! Values as bytes of postcard, the binary format of `frames.bin`.

use serde::Serialize;
use serde::de::DeserializeOwned;

/// Encodes a value.
///
/// # Errors
/// If it has no such form.
pub fn encode<T: Serialize>(value: &T) -> Result<Vec<u8>, String> {
    postcard::to_allocvec(value).map_err(|error| error.to_string())
}

/// Decodes a value; all bytes must be used.
///
/// # Errors
/// If the bytes are not those of such a value.
pub fn decode<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, String> {
    match postcard::take_from_bytes(bytes) {
        Ok((value, [])) => Ok(value),
        Ok(_) => Err("there are more bytes than the value has".to_owned()),
        Err(error) => Err(error.to_string()),
    }
}
