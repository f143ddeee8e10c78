//! The 64-bit FNV-1a hash, which has the same value on every machine.

use std::io::{self, Read};

/// A 64-bit FNV-1a hash in progress.
pub struct Fnv(u64);

impl Default for Fnv {
    fn default() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }
}

impl Fnv {
    /// Returns a hash that continues after bytes whose hash is `value`.
    #[must_use]
    pub fn continued(value: u64) -> Self {
        Self(value)
    }

    /// Returns the hash of all bytes so far.
    #[must_use]
    pub fn value(&self) -> u64 {
        self.0
    }

    /// Adds all bytes of a file.
    ///
    /// # Errors
    /// If it cannot be read.
    pub fn update_from(&mut self, mut file: impl Read) -> io::Result<()> {
        let mut buffer = vec![0; 1 << 16];
        loop {
            match file.read(&mut buffer)? {
                0 => return Ok(()),
                length => self.update(&buffer[..length]),
            }
        }
    }

    /// Adds `bytes` to the hash.
    pub fn update(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hash_has_its_published_values() {
        for (text, expected) in
            [("", 0xcbf2_9ce4_8422_2325), ("a", 0xaf63_dc4c_8601_ec8c), ("foobar", 0x8594_4171_f739_67e8)]
        {
            let mut hash = Fnv::default();
            hash.update(text.as_bytes());
            assert_eq!(hash.0, expected);
        }
    }
}
