//! The most memory that a run has held.

/// The largest resident set of this process so far, bytes: `VmHWM` of Linux; nothing where the system does not tell.
#[must_use]
pub fn peak_memory() -> Option<u64> {
    of_status(&std::fs::read_to_string("/proc/self/status").ok()?)
}

fn of_status(status: &str) -> Option<u64> {
    let value = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kilobytes: u64 = value.trim().strip_suffix("kB")?.trim_end().parse().ok()?;
    Some(1024 * kilobytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_high_water_mark_is_read_and_nothing_else() {
        assert_eq!(of_status("VmPeak:\t  999 kB\nVmHWM:\t  1234 kB\nVmRSS:\t 1 kB\n"), Some(1_263_616));
        assert_eq!(of_status("VmPeak:\t  999 kB\n"), None);
        assert_eq!(of_status("VmHWM:\t  much\n"), None);
    }
}
