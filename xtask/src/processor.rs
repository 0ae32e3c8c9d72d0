//! Processor time: that of a step says which one to make shorter, on a machine as busy as it may be.

use std::fs;
use std::time::Duration;

/// Of this process and of its children that have ended, as Linux tells it in `/proc/self/stat`; none
/// elsewhere.
pub fn time() -> Duration {
    let stat = fs::read_to_string("/proc/self/stat").unwrap_or_default();
    Duration::from_millis(10 * ticks(&stat).unwrap_or_default())
}

/// Hundredths of a second: the fields `utime`, `stime`, `cutime` and `cstime`.
fn ticks(stat: &str) -> Option<u64> {
    // The second field is a name in brackets, which may have any character; `utime` is the 14th.
    let (_, fields) = stat.rsplit_once(')')?;
    fields.split_whitespace().skip(11).take(4).map(|field| field.parse::<u64>().ok()).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn four_fields_behind_the_name_are_added() {
        let stat = "7 (a) b) S 1 7 7 0 -1 4194304 100 2000 0 0 3 20 100 4000 20 0 1 0 9 8 7";
        assert_eq!(ticks(stat), Some(4_123));
        assert_eq!(ticks(""), None);
        assert_eq!(ticks("7 (a) S 1"), Some(0));
    }
}
