//! Moments of a run: a time, or a time after an event that nobody knows beforehand.
//!
//! | written | moment |
//! |---|---|
//! | `1.5` | 1.5 s of simulated time |
//! | `AfterDoor(0.1)` | 0.1 s after the first door began to open |
//! | `AfterRest(0.1)` | 0.1 s after the bed came to rest |
//! | `Out(0.2)` | a fifth of all grains that enter are out; known at the end of the run |

use std::fmt::{self, Display, Formatter};

use ron::value::RawValue;
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize};

use crate::door::DoorState;
use crate::rest::RestDetector;
use siloflow_dem::values::{NonNegative, Share};

/// A moment of a run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub enum Moment {
    /// At a time, s.
    At(NonNegative),
    /// A time after the first door began to open, s.
    AfterDoor(NonNegative),
    /// A time after the bed came to rest, s.
    AfterRest(NonNegative),
    /// When this share of the grains that enter are out.
    Out(Share),
}

/// The times of the events that moments follow, s; `None` before an event.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Events {
    /// When the first door began to open.
    pub door: Option<f64>,
    /// When the bed came to rest.
    pub rest: Option<f64>,
}

impl Events {
    /// The events of a run so far, of which its first door and its detector of rest know.
    #[must_use]
    pub fn of(door: Option<&DoorState>, rest: Option<&RestDetector>) -> Self {
        Self { door: door.and_then(DoorState::open_time), rest: rest.and_then(|rest| rest.rest_time) }
    }
}

impl Moment {
    /// The time, s, if it is known beforehand.
    #[must_use]
    pub fn fixed(self) -> Option<f64> {
        match self {
            Self::At(time) => Some(time.get()),
            _ => None,
        }
    }

    /// The time, s; `None` before the event, and for a share of the grains.
    #[must_use]
    pub fn after(self, events: Events) -> Option<f64> {
        match self {
            Self::At(time) => Some(time.get()),
            Self::AfterDoor(delay) => Some(events.door? + delay.get()),
            Self::AfterRest(delay) => Some(events.rest? + delay.get()),
            Self::Out(_) => None,
        }
    }

    /// The time, s, of a run that is over. `exit` returns when this share of the grains was out.
    pub fn time(self, events: Events, exit: impl Fn(f64) -> Option<f64>) -> Option<f64> {
        match self {
            Self::Out(share) => exit(share.get()),
            _ => self.after(events),
        }
    }

    /// Reads a moment as a scene or a call writes it, with or without the unit s.
    ///
    /// # Errors
    /// The forms of a moment, in words, if the text has none of them.
    pub fn parse(text: &str) -> Result<Self, String> {
        #[derive(Deserialize)]
        enum Event {
            AfterDoor(NonNegative),
            AfterRest(NonNegative),
            Out(Share),
        }
        let text = text.trim();
        if let Ok(time) = text.strip_suffix('s').unwrap_or(text).trim_end().parse::<f64>() {
            return NonNegative::try_from(time).map(Self::At);
        }
        let event = ron::from_str(text).map_err(|error| {
            format!(
                "expected a time in s, `AfterDoor(s)`, `AfterRest(s)` or `Out(share)`, found `{text}` ({})",
                error.code
            )
        })?;
        Ok(match event {
            Event::AfterDoor(delay) => Self::AfterDoor(delay),
            Event::AfterRest(delay) => Self::AfterRest(delay),
            Event::Out(share) => Self::Out(share),
        })
    }
}

impl<'de> Deserialize<'de> for Moment {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let raw = Box::<RawValue>::deserialize(deserializer)?;
        Self::parse(raw.trim().get_ron()).map_err(D::Error::custom)
    }
}

impl Display for Moment {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::At(time) => write!(f, "{} s", time.get()),
            Self::AfterDoor(delay) => write!(f, "{} s after the door opens", delay.get()),
            Self::AfterRest(delay) => write!(f, "{} s after rest", delay.get()),
            Self::Out(share) => write!(f, "{} % out", 100.0 * share.get()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_are_times_or_follow_events() {
        let number = |x: f64| NonNegative::try_from(x).unwrap();
        assert_eq!(Moment::parse(" 1.5 s"), Ok(Moment::At(number(1.5))));
        assert_eq!(Moment::parse("AfterDoor(0.1)"), Ok(Moment::AfterDoor(number(0.1))));
        assert_eq!(ron::from_str::<[Moment; 1]>("(AfterRest(2))"), Ok([Moment::AfterRest(number(2.0))]));
        for wrong in ["", "soon", "Out(2)", "AfterDoor(-1)", "AfterDoor(1", "After(1)", "inf", "-1", "0.1 m"] {
            assert!(Moment::parse(wrong).is_err(), "{wrong}");
        }
        let events = Events { door: Some(3.0), rest: None };
        assert_eq!(Moment::parse("AfterDoor(0.5)").unwrap().after(events), Some(3.5));
        assert_eq!(Moment::parse("AfterRest(0.5)").unwrap().after(events), None);
        assert_eq!(Moment::parse("Out(0.5)").unwrap().time(events, |share| Some(10.0 * share)), Some(5.0));
    }
}
