//! The macro that makes the shapes of walls from a list of their keys.
//!
//! In the text of a scene a wall is one value, `Cylinder(from: ..., to: ..., radius: ..., species: 1, name: "drum")`: keys of the shape,
//! and three keys that every wall has. [`Wall`](super::Wall) holds them apart. A parser that joins two structs, such as
//! `serde(flatten)`, loses the places of values and the lists of known keys that messages need. So the text is parsed into an enum `Written`
//! that has all keys, and is converted. The list gives each key once.

/// The keys that every wall has.
pub(super) struct CommonKeys {
    pub species: u8,
    pub name: Option<String>,
    pub door: bool,
}

/// Makes `WallShape`, `Written`, and the conversions between them. The attributes `serde` are those of the text.
macro_rules! wall_shapes {
    ($(
        $(#[doc = $doc:expr])+
        $(#[serde($($serde:tt)+)])?
        $Shape:ident {
            $(
                $(#[doc = $key_doc:expr])+
                $(#[serde($($key_serde:tt)+)])?
                $key:ident: $Type:ty,
            )+
        }
    )+) => {
        /// The shape of a wall of the scene, with the numbers of the scene.
        #[derive(Clone, Debug, PartialEq)]
        pub enum WallShape {
            $(
                $(#[doc = $doc])+
                $Shape {
                    $(
                        $(#[doc = $key_doc])+
                        $key: $Type,
                    )+
                },
            )+
        }

        /// A wall as the text of a scene gives it.
        #[derive(Deserialize, Serialize)]
        #[serde(rename = "Wall", deny_unknown_fields)]
        pub(super) enum Written {
            $(
                $(#[serde($($serde)+)])?
                $Shape {
                    $(
                        $(#[serde($($key_serde)+)])?
                        $key: $Type,
                    )+
                    #[serde(default)]
                    species: u8,
                    #[serde(default)]
                    name: Option<String>,
                    #[serde(default)]
                    door: bool,
                },
            )+
        }

        impl Written {
            /// Returns the keys of the shape and those that every wall has.
            pub(super) fn split(self) -> (WallShape, CommonKeys) {
                match self {
                    $(
                        Self::$Shape { $($key,)+ species, name, door } => {
                            (WallShape::$Shape { $($key),+ }, CommonKeys { species, name, door })
                        }
                    )+
                }
            }

            /// Returns the wall of a shape with these keys.
            pub(super) fn joined(shape: WallShape, CommonKeys { species, name, door }: CommonKeys) -> Self {
                match shape {
                    $(WallShape::$Shape { $($key),+ } => Self::$Shape { $($key,)+ species, name, door },)+
                }
            }
        }
    };
}

pub(super) use wall_shapes;
