//! Numbers of restored state: floats that are finite, and whole numbers with which a run can go on counting.
//!
//! A checkpoint may come from somebody else. The numbers of a value are found by serialising it, so that no type has to list its own.

use std::fmt::{self, Display};

use serde::ser::{self, Serialize, Serializer};

use crate::persist::Problem;

/// Largest count: every float beyond stands for several whole numbers.
const MOST: u64 = 1 << 53;

/// Refuses a value that holds a float that is not finite, or a whole number of 64 bits beyond 2^53.
///
/// # Errors
/// It names the number.
pub fn check<T: Serialize + ?Sized>(value: &T) -> Result<(), Problem> {
    value.serialize(Check).map_err(|refused| refused.0)
}

/// A serialiser that writes nothing.
#[derive(Clone, Copy)]
struct Check;

/// Why a number is refused.
#[derive(Debug)]
struct Refused(Problem);

impl Display for Refused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Refused {}

impl ser::Error for Refused {
    fn custom<T: Display>(message: T) -> Self {
        Self(message.to_string())
    }
}

type Checked = Result<(), Refused>;

fn float(number: f64) -> Checked {
    if number.is_finite() { Ok(()) } else { Err(Refused(format!("it holds the number {number}, which is not finite"))) }
}

fn whole(number: u64) -> Checked {
    if number <= MOST {
        Ok(())
    } else {
        Err(Refused(format!("it holds the whole number {number}, which is beyond 2^53")))
    }
}

/// Methods for values that hold no number that is refused.
macro_rules! nothing_to_check {
    ($($method:ident($value:ty))*) => {
        $(fn $method(self, _: $value) -> Checked {
            Ok(())
        })*
    };
}

/// Values that consist of parts: each part is checked.
macro_rules! parts {
    ($($whole:ident $part:ident($($name:ty)?))*) => {
        $(impl ser::$whole for Check {
            type Ok = ();
            type Error = Refused;

            fn $part<T: Serialize + ?Sized>(&mut self, $(_: $name,)? part: &T) -> Checked {
                part.serialize(*self)
            }

            fn end(self) -> Checked {
                Ok(())
            }
        })*
    };
}

impl Serializer for Check {
    type Ok = ();
    type Error = Refused;
    type SerializeSeq = Self;
    type SerializeTuple = Self;
    type SerializeTupleStruct = Self;
    type SerializeTupleVariant = Self;
    type SerializeMap = Self;
    type SerializeStruct = Self;
    type SerializeStructVariant = Self;

    fn is_human_readable(&self) -> bool {
        false
    }

    fn serialize_f32(self, number: f32) -> Checked {
        float(number.into())
    }

    fn serialize_f64(self, number: f64) -> Checked {
        float(number)
    }

    fn serialize_u64(self, number: u64) -> Checked {
        whole(number)
    }

    fn serialize_i64(self, number: i64) -> Checked {
        whole(number.unsigned_abs())
    }

    fn serialize_some<T: Serialize + ?Sized>(self, value: &T) -> Checked {
        value.serialize(self)
    }

    fn serialize_newtype_struct<T: Serialize + ?Sized>(self, _: &'static str, value: &T) -> Checked {
        value.serialize(self)
    }

    fn serialize_newtype_variant<T: Serialize + ?Sized>(
        self,
        _: &'static str,
        _: u32,
        _: &'static str,
        value: &T,
    ) -> Checked {
        value.serialize(self)
    }

    fn serialize_seq(self, _: Option<usize>) -> Result<Self, Refused> {
        Ok(self)
    }

    fn serialize_tuple(self, _: usize) -> Result<Self, Refused> {
        Ok(self)
    }

    fn serialize_tuple_struct(self, _: &'static str, _: usize) -> Result<Self, Refused> {
        Ok(self)
    }

    fn serialize_tuple_variant(self, _: &'static str, _: u32, _: &'static str, _: usize) -> Result<Self, Refused> {
        Ok(self)
    }

    fn serialize_map(self, _: Option<usize>) -> Result<Self, Refused> {
        Ok(self)
    }

    fn serialize_struct(self, _: &'static str, _: usize) -> Result<Self, Refused> {
        Ok(self)
    }

    fn serialize_struct_variant(self, _: &'static str, _: u32, _: &'static str, _: usize) -> Result<Self, Refused> {
        Ok(self)
    }

    fn collect_str<T: Display + ?Sized>(self, _: &T) -> Checked {
        Ok(())
    }

    nothing_to_check! {
        serialize_bool(bool) serialize_i8(i8) serialize_i16(i16) serialize_i32(i32)
        serialize_u8(u8) serialize_u16(u16) serialize_u32(u32) serialize_char(char) serialize_str(&str) serialize_bytes(&[u8])
        serialize_unit_struct(&'static str)
    }

    fn serialize_none(self) -> Checked {
        Ok(())
    }

    fn serialize_unit(self) -> Checked {
        Ok(())
    }

    fn serialize_unit_variant(self, _: &'static str, _: u32, _: &'static str) -> Checked {
        Ok(())
    }
}

parts! {
    SerializeSeq serialize_element() SerializeTuple serialize_element() SerializeTupleStruct serialize_field()
    SerializeTupleVariant serialize_field() SerializeStruct serialize_field(&'static str)
    SerializeStructVariant serialize_field(&'static str)
}

impl ser::SerializeMap for Check {
    type Ok = ();
    type Error = Refused;

    fn serialize_key<T: Serialize + ?Sized>(&mut self, key: &T) -> Checked {
        key.serialize(*self)
    }

    fn serialize_value<T: Serialize + ?Sized>(&mut self, value: &T) -> Checked {
        value.serialize(*self)
    }

    fn end(self) -> Checked {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use serde::Serialize;

    use super::*;

    #[derive(Serialize)]
    enum Part {
        Of(f64),
        Both { number: f32, count: u64 },
    }

    #[test]
    fn numbers_are_found_wherever_they_stand() {
        let words = |problem: Result<(), Problem>| problem.err().unwrap_or_default();
        let good = (
            1.0,
            [u64::MAX >> 11; 2],
            "nan",
            Some(vec![Part::Of(0.5), Part::Both { number: 1.0, count: 3 }]),
            u32::MAX,
        );
        assert_eq!(check(&good), Ok(()));
        for wrong in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert!(words(check(&Some((1, vec![[0.0, wrong]])))).contains("not finite"));
            assert!(words(check(&Part::Of(wrong))).contains("not finite"));
            assert!(words(check(&BTreeMap::from([(1, wrong)]))).contains("not finite"));
        }
        assert!(words(check(&Part::Both { number: f32::NAN, count: 3 })).contains("NaN"));
        assert!(words(check(&Part::Both { number: 0.0, count: MOST + 1 })).contains("beyond 2^53"));
        assert!(words(check(&(i64::MIN, "a"))).contains("beyond 2^53"));
    }
}
