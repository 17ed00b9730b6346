//! How comments cite the paper: "Eq. (7)", "Eqs. (3, 4)", "Eqs. (13)-(26)", "Fig. 7a", "Table 2", "R60".

use std::collections::BTreeSet;

/// Numbers of all cited equations.
pub fn equations(text: &str) -> BTreeSet<u32> {
    let starts = ["Eq. (", "Eqs. ("];
    starts.iter().flat_map(|start| text.split(start).skip(1)).flat_map(equation_list).collect()
}

/// Reads `7)`, `3, 4)`, `13)-(26)`, `5), (6) and (7)` from the beginning of `text` (its first `(` is gone).
fn equation_list(text: &str) -> Vec<u32> {
    let mut numbers: Vec<u32> = Vec::new();
    let (mut range, mut rest) = (false, text);
    loop {
        let digits = rest.len() - rest.trim_start_matches(|c: char| c.is_ascii_digit()).len();
        let Ok(n) = rest[..digits].parse::<u32>() else { return numbers };
        let first = numbers.last().filter(|_| range).map_or(n, |&last| last + 1);
        numbers.extend(first..=n);
        rest = &rest[digits..];
        let Some((link, length)) = link(rest) else { return numbers };
        range = link;
        rest = &rest[length..];
    }
}

/// What joins two numbers at the beginning of `text`: whether it is a range, and its length.
fn link(text: &str) -> Option<(bool, usize)> {
    let ranges = [")-(", ")–(", "-", "–"];
    let lists = ["), (", ") and (", ", ", " and "];
    let find = |links: &[&str]| links.iter().find(|l| text.starts_with(**l)).map(|l| l.len());
    find(&ranges).map(|n| (true, n)).or_else(|| find(&lists).map(|n| (false, n)))
}

/// Numbers that follow one of `prefixes` (and those joined to them by "and", "," or "-").
pub fn numbered(text: &str, prefixes: &[&str]) -> BTreeSet<u32> {
    prefixes.iter().flat_map(|prefix| text.split(prefix).skip(1)).flat_map(equation_list).collect()
}

/// Numbers of all cited readings: the letter R and a number, as a word.
pub fn readings(text: &str) -> BTreeSet<u32> {
    text.split(|c: char| !c.is_alphanumeric())
        .filter_map(|word| word.strip_prefix('R')?.parse().ok())
        .collect()
}

#[test]
fn citations_are_read_in_all_their_forms() {
    let of = |text: &str| equations(text).into_iter().collect::<Vec<_>>();
    assert_eq!(of("Eq. (7), Fig. 4."), [7]);
    assert_eq!(of("Eqs. (3, 4). Then Eq. (11)"), [3, 4, 11]);
    assert_eq!(of("see Eqs. (8)-(11), Fig. 5"), [8, 9, 10, 11]);
    assert_eq!(of("Eqs. (5), (6) and (26)"), [5, 6, 26]);
    assert_eq!(of("nothing (7)"), [0; 0]);
    assert_eq!(numbered("Fig. 7a and Figs. 8 and 11.", &["Fig. ", "Figs. "]), [7, 8, 11].into());
    assert_eq!(readings("(reading R60), R2D2, Rng, R7."), [7, 60].into());
}
