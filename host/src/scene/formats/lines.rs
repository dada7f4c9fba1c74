//! Lines of a text, with the line ends of all systems.

/// Splits a text into lines, which end in `\n` (Unix), `\r\n` (Windows) or `\r` (old Macintoshes).
pub(super) fn lines(text: &str) -> impl Iterator<Item = &str> {
    let mut rest = text;
    std::iter::from_fn(move || {
        if rest.is_empty() {
            return None;
        }
        let end = memchr::memchr2(b'\n', b'\r', rest.as_bytes());
        let (line, ending) = rest.split_at(end.unwrap_or(rest.len()));
        let after = ending.strip_prefix("\r\n").or(ending.get(1..));
        rest = after.unwrap_or_default();
        Some(line)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_ending_counts_once() {
        let text = "a\n\nb\r\nc\r\rd";
        assert_eq!(lines(text).collect::<Vec<_>>(), ["a", "", "b", "c", "", "d"]);
        assert_eq!(lines("a\r").count() + lines("").count(), 1);
    }
}
