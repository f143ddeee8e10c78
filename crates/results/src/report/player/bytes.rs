//! Whole numbers as bytes: seven bits in each byte, the lowest first; the highest bit says that more follow.
//!
//! Signed numbers are written as 0, 1, 2, 3, 4 for 0, -1, 1, -2, 2.

/// Adds a number to `bytes`.
pub(super) fn put(bytes: &mut Vec<u8>, mut number: u32) {
    while number >= 0x80 {
        bytes.push(number.to_le_bytes()[0] | 0x80);
        number >>= 7;
    }
    bytes.push(number.to_le_bytes()[0]);
}

/// Adds a signed number to `bytes`.
pub(super) fn put_signed(bytes: &mut Vec<u8>, number: i32) {
    put(bytes, (number.cast_unsigned() << 1) ^ (number >> 31).cast_unsigned());
}

/// Returns a length as a number of 4 bytes. Frames with more rows would need more memory than there is.
pub(super) fn length(of: usize) -> u32 {
    u32::try_from(of).unwrap_or(u32::MAX)
}
