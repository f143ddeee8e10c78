//! Peak memory of the process.

/// Returns the largest resident set of this process so far, bytes (`VmHWM` of Linux); `None` on other systems.
#[must_use]
pub fn peak_memory() -> Option<u64> {
    parse_status(&std::fs::read_to_string("/proc/self/status").ok()?)
}

/// Returns the peak in bytes from the text of `/proc/self/status`.
fn parse_status(status: &str) -> Option<u64> {
    let value = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kilobytes: u64 = value.trim().strip_suffix("kB")?.trim_end().parse().ok()?;
    Some(1024 * kilobytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_peak_of_the_resident_set_is_read() {
        assert_eq!(parse_status("VmPeak:\t  999 kB\nVmHWM:\t  1234 kB\nVmRSS:\t 1 kB\n"), Some(1_263_616));
        assert_eq!(parse_status("VmPeak:\t  999 kB\n"), None);
        assert_eq!(parse_status("VmHWM:\t  much\n"), None);
    }
}
