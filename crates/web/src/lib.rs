//! siloflow for a web page: functions that its script calls, with numbers alone.
//!
//! Texts pass through files of the page's own file system (WASI): the script writes scenes to `/scene` and what it asks for to `/request`. Each
//! answer is a text or bytes in a buffer, at [`answer_address`] and [`answer_length`]; a function returns 1 if it has done what it was asked for,
//! and 0 if the answer tells why not. A run writes its directory to `/run`.
//!
//! | part | content |
//! |---|---|
//! | `examination.rs` | is a scene right, and small enough for a page? |
//! | `running.rs` | a run in slices |
//! | `picture.rs` | the present state for the player |
//! | `sample.rs` | the present numbers for curves |
//! | `shipped.rs` | scenes that come with the program |
//!
//! Limit: one run at a time, on one thread.

mod examination;
mod picture;
mod running;
mod sample;
mod shipped;

use std::cell::RefCell;
use std::fs;

use serde::Serialize;
use siloflow::text::fault::Fault;

use crate::examination::Trouble;
use crate::running::Run;

/// The path of the file with the request of the page.
const REQUEST: &str = "/request";

#[derive(Default)]
struct Page {
    answer: Vec<u8>,
    run: Option<Run>,
}

thread_local! {
    static PAGE: RefCell<Page> = RefCell::default();
}

fn request() -> Result<String, Fault> {
    fs::read_to_string(REQUEST)
        .map_err(|error| Fault::new("page::request", format!("could not read the request: {error}")))
}

/// Answers with bytes, or with the trouble as JSON.
fn answer(act: impl FnOnce(&mut Option<Run>) -> Result<Vec<u8>, Fault>) -> u32 {
    PAGE.with_borrow_mut(|page| {
        let result = act(&mut page.run);
        let is_done = result.is_ok();
        page.answer = result.unwrap_or_else(|fault| json(&Trouble::of(&fault)));
        is_done.into()
    })
}

/// A value as JSON. The values here can be written.
fn json(value: &impl Serialize) -> Vec<u8> {
    serde_json::to_vec(value).unwrap_or_default()
}

fn no_run() -> Fault {
    Fault::new("page::no_run", "no run has been started")
}

/// The address of the last answer.
#[unsafe(no_mangle)]
pub extern "C" fn answer_address() -> usize {
    PAGE.with_borrow(|page| page.answer.as_ptr() as usize)
}

/// The number of bytes of the last answer.
#[unsafe(no_mangle)]
pub extern "C" fn answer_length() -> usize {
    PAGE.with_borrow(|page| page.answer.len())
}

/// Lists the shipped scenes: name and line of each.
#[unsafe(no_mangle)]
pub extern "C" fn shipped() -> u32 {
    answer(|_| Ok(json(&shipped::list())))
}

/// Copies the shipped scene whose name is the request, and the file that it names, to `/scene`. Answers with its text.
#[unsafe(no_mangle)]
pub extern "C" fn copy() -> u32 {
    answer(|_| shipped::copy(&request()?).map(String::into_bytes))
}

/// Examines the scene at the path of the request.
#[unsafe(no_mangle)]
pub extern "C" fn examine() -> u32 {
    answer(|_| examination::examine(&request()?).map(|found| json(&found)))
}

/// Sets a parameter of a scene. The lines of the request are its path, the name, and the value. Answers with the text of the scene.
#[unsafe(no_mangle)]
pub extern "C" fn set() -> u32 {
    answer(|_| examination::set(&request()?).map(String::into_bytes))
}

/// Starts a run of the scene at the path of the request. An earlier run is dropped.
#[unsafe(no_mangle)]
pub extern "C" fn start() -> u32 {
    answer(|run| {
        *run = None;
        *run = Some(Run::start(&request()?)?);
        Ok(Vec::new())
    })
}

/// Steps for at most this many milliseconds, and not beyond a time of the clock (s; steps of the lattice gas). With `to_event` 1 it stops after the
/// step in which grains come to rest, a door opens, or the first grain leaves. Answers with the present numbers.
#[unsafe(no_mangle)]
pub extern "C" fn advance(milliseconds: f64, until: f64, to_event: u32) -> u32 {
    answer(|run| {
        let run = run.as_mut().ok_or_else(no_run)?;
        run.advance(milliseconds, until, to_event == 1);
        Ok(json(&run.sample()))
    })
}

/// Answers with the present numbers.
#[unsafe(no_mangle)]
pub extern "C" fn sample() -> u32 {
    answer(|run| Ok(json(&run.as_mut().ok_or_else(no_run)?.sample())))
}

/// The present state for the player, with contacts if `contacts` is 1.
#[unsafe(no_mangle)]
pub extern "C" fn picture(contacts: u32) -> u32 {
    answer(|run| run.as_mut().ok_or_else(no_run)?.picture(contacts == 1))
}

/// Ends the run, and writes its state and its summary. Answers with the summary in words.
#[unsafe(no_mangle)]
pub extern "C" fn finish() -> u32 {
    answer(|run| Ok(run.take().ok_or_else(no_run)?.finish().into_bytes()))
}

/// Answers with the report of the run that has been finished, an HTML page.
#[unsafe(no_mangle)]
pub extern "C" fn report() -> u32 {
    answer(|_| running::report().map(String::into_bytes))
}
