//! Scripts that run a sweep as a job array: for Slurm, GNU parallel and HyperQueue.
//!
//! Job I of N does each N-th run, beginning with the I-th, one after the other. So N jobs do all runs, each once, for any N: short runs are
//! packed into few jobs.

use std::path::Path;

use crate::studies::sweep::Task;

/// A program that runs job arrays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scheduler {
    /// Slurm: `sbatch`.
    Slurm,
    /// GNU parallel, on this machine.
    Parallel,
    /// HyperQueue: `hq`.
    HyperQueue,
}

impl Scheduler {
    /// All, by their names.
    pub const ALL: [(&'static str, Self); 3] =
        [("slurm", Self::Slurm), ("parallel", Self::Parallel), ("hyperqueue", Self::HyperQueue)];
}

/// A part of a sweep: job `number` of `count`, counted from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Part {
    /// Number of the job.
    pub number: usize,
    /// Number of jobs.
    pub count: usize,
}

impl Part {
    /// Reads `I/N`.
    ///
    /// # Errors
    /// If the text is none.
    pub fn parse(text: &str) -> Result<Self, String> {
        let numbers = text.split_once('/').and_then(|(i, n)| Some((i.trim().parse().ok()?, n.trim().parse().ok()?)));
        match numbers {
            Some((number, count)) if (1..=count).contains(&number) => Ok(Self { number, count }),
            _ => Err("expected I/N with I from 1 to N, for example 3/8".to_owned()),
        }
    }

    /// Returns the runs of this part.
    #[must_use]
    pub fn of(self, tasks: &[Task]) -> Vec<Task> {
        tasks.iter().skip(self.number - 1).step_by(self.count).copied().collect()
    }
}

/// The calls of a script.
#[derive(Clone, Debug)]
pub struct Calls<'a> {
    /// The program.
    pub program: &'a Path,
    /// The sweep file, an absolute path.
    pub sweep: &'a Path,
    /// The sweep directory, an absolute path.
    pub directory: &'a Path,
    /// Name of the sweep.
    pub name: &'a str,
    /// Number of runs.
    pub runs: usize,
    /// Number of jobs.
    pub jobs: usize,
}

/// Returns a text as one word of a shell.
fn quoted(text: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "/._-+,:=@".contains(c);
    if !text.is_empty() && text.chars().all(is_plain) {
        return text.to_owned();
    }
    format!("'{}'", text.replace('\'', r"'\''"))
}

impl Calls<'_> {
    /// Returns the script.
    #[must_use]
    pub fn script(&self, scheduler: Scheduler) -> String {
        let path = |path: &Path| quoted(&path.display().to_string());
        let call = format!("{} -q sweep {} --out {}", path(self.program), path(self.sweep), path(self.directory));
        let runs = self.runs;
        let jobs = self.jobs;
        // A name is at most a word, so that it is safe in every comment and option.
        let name: String = self.name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '-' }).collect();
        match scheduler {
            Scheduler::Slurm => format!(
                "#!/bin/sh\n\
                 #SBATCH --job-name={name}\n\
                 #SBATCH --array=1-{jobs}\n\
                 #SBATCH --ntasks=1\n\
                 #SBATCH --cpus-per-task=1\n\
                 # {runs} runs in {jobs} jobs. A time limit (--time), a partition and an account may be added above.\n\
                 #   job=$(sbatch --parsable THIS_FILE)\n\
                 #   sbatch --array=1 --dependency=afterany:$job THIS_FILE gather\n\
                 # A job that is stopped continues where it was when this file is submitted again.\n\
                 if [ \"$1\" = gather ]; then\n    exec {call} --gather\nfi\n\
                 exec {call} --task \"$SLURM_ARRAY_TASK_ID/{jobs}\"\n"
            ),
            Scheduler::Parallel => format!(
                "#!/bin/sh\n\
                 # {runs} runs in {jobs} jobs, as many at a time as this machine has cores. GNU parallel distributes them over machines\n\
                 # that share this directory with --sshlogin.\n\
                 seq {jobs} | parallel --quote {call} --task '{{}}/{jobs}'\n\
                 exec {call} --gather\n"
            ),
            Scheduler::HyperQueue => format!(
                "#!/bin/sh\n\
                 # {runs} runs in {jobs} jobs of one core. A server (hq server start) and workers (hq worker start) must run.\n\
                 hq submit --name {name} --array 1-{jobs} --cpus 1 --wait -- \\\n    \
                 sh -c 'exec \"$@\" --task \"$HQ_TASK_ID/{jobs}\"' sh {call}\n\
                 exec {call} --gather\n"
            ),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_do_each_run_once() {
        for (runs, count) in [(15, 4), (3, 8), (1, 1), (100, 7)] {
            let tasks: Vec<_> = (0..runs).map(|point| Task { point, seed: 1 }).collect();
            let parts: Vec<_> = (1..=count).map(|number| Part { number, count }.of(&tasks)).collect();
            let mut all: Vec<_> = parts.iter().flatten().map(|task| task.point).collect();
            all.sort_unstable();
            assert_eq!(all, (0..runs).collect::<Vec<_>>());
            let lengths = || parts.iter().map(Vec::len);
            assert!(lengths().max().unwrap() - lengths().min().unwrap() <= 1);
        }
        assert_eq!(Part::parse("3/8"), Ok(Part { number: 3, count: 8 }));
        for wrong in ["0/8", "9/8", "3", "a/b", "3/8/9", "/", "-1/2"] {
            assert!(Part::parse(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn paths_are_one_word_each() {
        assert_eq!(quoted("/a/b-1.ron"), "/a/b-1.ron");
        assert_eq!(quoted("/it's $HOME"), r"'/it'\''s $HOME'");
    }
}
