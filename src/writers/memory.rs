//! Memory of the process and of the machine.

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

/// Returns the memory that is available for a process, bytes: `MemAvailable` of Linux, or what is left of the limit of its
/// control group, if that is less; `None` on other systems.
/// Where addresses have 32 bits, at most the limit of the address space.
#[must_use]
pub fn available_memory() -> Option<u64> {
    if cfg!(target_pointer_width = "32") {
        return Some(of_machine().map_or(ADDRESSABLE, |bytes| bytes.min(ADDRESSABLE)));
    }
    of_machine()
}

/// Memory that a program with addresses of 32 bits has for its data, bytes: a browser gives less than the 4 GB that it can address, and
/// growing buffers are copied.
const ADDRESSABLE: u64 = 2_000_000_000;

/// Returns the available memory of Linux, bytes.
fn of_machine() -> Option<u64> {
    let read = |path: &str| std::fs::read_to_string(path).ok();
    let machine = parse_available(&read("/proc/meminfo")?)?;
    let number = |path: &str| read(path)?.trim().parse::<u64>().ok();
    let limit = number("/sys/fs/cgroup/memory.max");
    let left = limit.map(|limit| limit.saturating_sub(number("/sys/fs/cgroup/memory.current").unwrap_or(0)));
    Some(left.map_or(machine, |left| left.min(machine)))
}

/// Returns the available bytes from the text of `/proc/meminfo`.
fn parse_available(meminfo: &str) -> Option<u64> {
    let value = meminfo.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    Some(1024 * value.trim().strip_suffix("kB")?.trim_end().parse::<u64>().ok()?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn available_memory_is_read() {
        assert_eq!(parse_available("MemTotal: 9 kB\nMemFree: 1 kB\nMemAvailable:    4 kB\n"), Some(4096));
        assert_eq!(parse_available("MemTotal: 9 kB\n"), None);
    }

    #[test]
    fn only_the_peak_of_the_resident_set_is_read() {
        assert_eq!(parse_status("VmPeak:\t  999 kB\nVmHWM:\t  1234 kB\nVmRSS:\t 1 kB\n"), Some(1_263_616));
        assert_eq!(parse_status("VmPeak:\t  999 kB\n"), None);
        assert_eq!(parse_status("VmHWM:\t  much\n"), None);
    }
}
