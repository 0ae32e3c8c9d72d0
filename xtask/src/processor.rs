//! Processor time. It tells which step to make shorter, however busy the machine is.

use std::fs;
use std::time::Duration;

/// The processor time of this process and of its ended children, from `/proc/self/stat` on Linux; 0
/// elsewhere.
pub fn time() -> Duration {
    let stat = fs::read_to_string("/proc/self/stat").unwrap_or_default();
    Duration::from_millis(10 * ticks(&stat).unwrap_or_default())
}

/// Hundredths of a second: the fields `utime`, `stime`, `cutime` and `cstime`.
fn ticks(stat: &str) -> Option<u64> {
    // The second field is a name in brackets with any characters; `utime` is the 14th field.
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
