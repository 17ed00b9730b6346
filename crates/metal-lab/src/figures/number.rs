//! Numbers as people read them: sensible digits, a real minus sign, intervals with their n.

use crate::results::Estimate;

/// `value` with `digits` decimals and the minus sign U+2212; a value that rounds to zero has no sign.
#[must_use]
pub fn fixed(value: f64, digits: usize) -> String {
    if !value.is_finite() {
        return "–".to_owned();
    }
    let text = format!("{:.digits$}", value.abs());
    let is_zero = text.bytes().all(|b| b == b'0' || b == b'.');
    if value < 0.0 && !is_zero { format!("\u{2212}{text}") } else { text }
}

/// Decimals that suit a number of this size: three significant digits, at most three decimals.
#[must_use]
pub fn digits_for(value: f64) -> usize {
    match value.abs() {
        v if v >= 100.0 => 0,
        v if v >= 10.0 => 1,
        v if v >= 1.0 => 2,
        _ => 3,
    }
}

/// `mean [lo, hi] (n = …)`; without an interval `mean (n = …)`.
#[must_use]
pub fn estimate(estimate: &Estimate, digits: usize) -> String {
    let interval = interval(estimate, digits).map(|i| format!(" {i}")).unwrap_or_default();
    format!("{}{interval} (n\u{a0}=\u{a0}{})", fixed(estimate.mean, digits), estimate.n)
}

/// `[lo, hi]`, if the interval is known.
#[must_use]
pub fn interval(estimate: &Estimate, digits: usize) -> Option<String> {
    let (lo, hi) = estimate.band()?;
    Some(format!("[{}, {}]", fixed(lo, digits), fixed(hi, digits)))
}

/// A share as per cent.
#[must_use]
pub fn percent(share: f64) -> String {
    format!("{}\u{a0}%", fixed(share * 100.0, if share.abs() < 0.0995 { 1 } else { 0 }))
}

/// A probability: plain if it is not tiny, otherwise with a power of ten.
#[must_use]
pub fn probability(p: f64) -> String {
    if p == 0.0 {
        return "0".to_owned();
    }
    if p >= 1e-3 {
        return fixed(p, 4);
    }
    let text = format!("{p:.2e}");
    match text.split_once('e') {
        Some((mantissa, exponent)) => format!("{mantissa}\u{202f}×\u{202f}10{}", superscript(exponent)),
        None => text,
    }
}

/// A tick's label: as many decimals as the distance between `marks` needs, thousands set apart.
#[must_use]
pub fn tick(value: f64, marks: &[f64]) -> String {
    let step = match marks {
        [first, second, ..] => (second - first).abs(),
        _ => 1.0,
    };
    let digits = if step >= 0.999 {
        0
    } else if step >= 0.0999 {
        1
    } else {
        2
    };
    thousands(&fixed(value, digits))
}

fn thousands(text: &str) -> String {
    let whole = text.split('.').next().unwrap_or(text);
    let digits = whole.chars().filter(char::is_ascii_digit).count();
    if digits < 5 {
        return text.to_owned();
    }
    let mut left = digits;
    let mut out = String::new();
    for c in text.chars() {
        out.push(c);
        if c.is_ascii_digit() && left > 0 {
            left -= 1;
            if left > 0 && left % 3 == 0 {
                out.push('\u{202f}');
            }
        }
    }
    out
}

fn superscript(exponent: &str) -> String {
    let digits = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    exponent
        .chars()
        .map(|c| match c.to_digit(10) {
            Some(d) => digits[d as usize],
            None => '⁻',
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_a_real_minus_and_never_minus_zero() {
        assert_eq!(fixed(-12.345, 1), "\u{2212}12.3");
        assert_eq!(fixed(-0.04, 1), "0.0");
        assert_eq!(fixed(f64::NAN, 1), "–");
        assert_eq!(
            estimate(&Estimate::interval(-1.0, -2.0, 0.5, 7), 1),
            "−1.0 [−2.0, 0.5] (n\u{a0}=\u{a0}7)"
        );
        assert_eq!(estimate(&Estimate::point(2.0, 1), 2), "2.00 (n\u{a0}=\u{a0}1)");
    }

    #[test]
    fn small_probabilities_are_powers_of_ten() {
        assert_eq!(probability(0.1234), "0.1234");
        assert_eq!(probability(9.71e-8), "9.71\u{202f}×\u{202f}10⁻⁸");
    }

    #[test]
    fn shares_and_ticks_read_well() {
        assert_eq!(percent(0.5), "50\u{a0}%");
        assert_eq!(percent(0.0213), "2.1\u{a0}%");
        assert_eq!(tick(-120_000.0, &[-120_000.0, -100_000.0]), "−120\u{202f}000");
        assert_eq!(tick(0.5, &[0.0, 0.5]), "0.5");
    }
}
