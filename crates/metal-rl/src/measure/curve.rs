//! Learning curves: moving average, accumulated reward, means of blocks. Figs. 8 and 11.

/// Mean of the last `window` values up to each value (of fewer at the beginning). Fig. 11 uses a window of 5.
///
/// # Panics
/// If `window` is 0.
#[must_use]
pub fn moving_average(values: &[f64], window: usize) -> Vec<f64> {
    assert!(window > 0, "a moving average needs a window");
    // Every window is added afresh: a running sum would carry the rounding of a large value along for ever.
    let mean = |part: &[f64]| part.iter().sum::<f64>() / part.len() as f64;
    (0..values.len()).map(|i| mean(&values[(i + 1).saturating_sub(window)..=i])).collect()
}

/// Sum of all values up to and including each value. Figs. 8 and 11.
#[must_use]
pub fn accumulated(values: &[f64]) -> Vec<f64> {
    values
        .iter()
        .scan(0.0, |sum, v| {
            *sum += v;
            Some(*sum)
        })
        .collect()
}

/// Means of consecutive blocks of `block` values; an incomplete last block counts with what it has.
///
/// # Panics
/// If `block` is 0.
#[must_use]
pub fn block_means(values: &[f64], block: usize) -> Vec<f64> {
    assert!(block > 0, "a block holds at least one value");
    values.chunks(block).map(|c| c.iter().sum::<f64>() / c.len() as f64).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_window_grows_until_it_is_full() {
        assert_eq!(moving_average(&[2.0, 4.0, 6.0, 8.0], 2), [2.0, 3.0, 5.0, 7.0]);
        assert_eq!(moving_average(&[1.0, 2.0, 6.0], 10), [1.0, 1.5, 3.0]);
    }

    #[test]
    fn a_large_value_leaves_no_trace_once_it_is_out_of_the_window() {
        assert_eq!(moving_average(&[1e17, 1.0, 3.0], 2)[2..], [2.0]);
    }

    #[test]
    fn rewards_add_up() {
        assert_eq!(accumulated(&[-1.0, -2.0, 0.5]), [-1.0, -3.0, -2.5]);
        assert!(accumulated(&[]).is_empty());
    }

    #[test]
    fn the_last_block_may_be_short() {
        assert_eq!(block_means(&[1.0, 3.0, 5.0], 2), [2.0, 5.0]);
    }
}
