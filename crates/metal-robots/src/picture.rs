//! Pictures as bodies send them, brought to the 52×39 colour pixels that the mind's regions are cut from.

use crate::error::ProtocolError;
pub use metal_rl::environment::Picture;
use metal_worlds::highway::camera::{COLUMNS, ROWS};

/// Columns of the e-puck2's Wi-Fi picture.
pub const WIFI_COLUMNS: usize = 160;
/// Rows of the e-puck2's Wi-Fi picture.
pub const WIFI_ROWS: usize = 120;
/// Side of the blocks of Wi-Fi pixels that make one of ours.
const BLOCK: usize = 3;
/// Wi-Fi columns and rows left out on each side.
const MARGIN: [usize; 2] = [(WIFI_COLUMNS - BLOCK * COLUMNS) / 2, (WIFI_ROWS - BLOCK * ROWS) / 2];

/// `picture` with every channel rounded as RGB565 rounds it.
#[must_use]
pub fn as_565(picture: &Picture) -> Picture {
    let pixels = picture.pixels.iter().map(|&rgb| from_565(to_565(rgb))).collect();
    Picture { columns: picture.columns, pixels }
}

/// A colour in the two bytes of RGB565, the byte with the red first.
#[must_use]
pub fn to_565([r, g, b]: [u8; 3]) -> [u8; 2] {
    [(r & 0xF8) | (g >> 5), ((g & 0x1C) << 3) | (b >> 3)]
}

/// The colour of two bytes of RGB565; the low bits repeat the high ones, so that white stays white.
#[must_use]
pub fn from_565([first, second]: [u8; 2]) -> [u8; 3] {
    let red = first >> 3;
    let green = ((first & 0x07) << 3) | (second >> 5);
    let blue = second & 0x1F;
    [(red << 3) | (red >> 2), (green << 2) | (green >> 4), (blue << 3) | (blue >> 2)]
}

/// A picture as RGB565 bytes.
#[must_use]
pub fn encode_565(picture: &Picture) -> Vec<u8> {
    picture.pixels.iter().flat_map(|&rgb| to_565(rgb)).collect()
}

/// The picture in RGB565 bytes, `columns` wide.
///
/// # Errors
/// If the bytes do not make whole rows.
pub fn decode_565(columns: usize, bytes: &[u8]) -> Result<Picture, ProtocolError> {
    whole_rows(columns, 2, bytes)?;
    Ok(Picture { columns, pixels: bytes.chunks_exact(2).map(|p| from_565([p[0], p[1]])).collect() })
}

/// The picture in the blue, green, red, alpha bytes of Webots, `columns` wide.
///
/// # Errors
/// If the bytes do not make whole rows.
pub fn decode_bgra(columns: usize, bytes: &[u8]) -> Result<Picture, ProtocolError> {
    whole_rows(columns, 4, bytes)?;
    Ok(Picture { columns, pixels: bytes.chunks_exact(4).map(|p| [p[2], p[1], p[0]]).collect() })
}

/// A picture as Webots sends it.
#[must_use]
pub fn encode_bgra(picture: &Picture) -> Vec<u8> {
    picture.pixels.iter().flat_map(|&[r, g, b]| [b, g, r, 255]).collect()
}

fn whole_rows(columns: usize, depth: usize, bytes: &[u8]) -> Result<(), ProtocolError> {
    if columns > 0 && bytes.len().is_multiple_of(columns * depth) {
        return Ok(());
    }
    let size = bytes.len();
    Err(ProtocolError::Unexpected(format!("{size} bytes make no picture of {columns} columns")))
}

/// The middle 156×117 of a Wi-Fi picture, blocks of 3×3 averaged: 52×39.
///
/// # Errors
/// If the picture has another size than 160×120.
pub fn shrink(wifi: &Picture) -> Result<Picture, ProtocolError> {
    if wifi.columns != WIFI_COLUMNS || wifi.rows() != WIFI_ROWS {
        let size = format!("a picture of {}×{}, not 160×120", wifi.columns, wifi.rows());
        return Err(ProtocolError::Unexpected(size));
    }
    let block = |i: usize| {
        let (row, column) = (MARGIN[1] + BLOCK * (i / COLUMNS), MARGIN[0] + BLOCK * (i % COLUMNS));
        let mut sum = [0_u16; 3];
        for k in 0..BLOCK * BLOCK {
            let pixel = wifi.pixels[(row + k / BLOCK) * WIFI_COLUMNS + column + k % BLOCK];
            sum.iter_mut().zip(pixel).for_each(|(s, c)| *s += u16::from(c));
        }
        sum.map(|s| ((s + 4) / 9) as u8)
    };
    Ok(Picture { columns: COLUMNS, pixels: (0..ROWS * COLUMNS).map(block).collect() })
}

/// A Wi-Fi picture that [`shrink`] turns into `picture`; its edge repeats itself outwards.
///
/// # Panics
/// If `picture` is not 52×39.
#[must_use]
pub fn enlarge(picture: &Picture) -> Picture {
    assert!(picture.columns == COLUMNS && picture.rows() == ROWS, "only the mind's own picture is enlarged");
    let ours = |wifi: usize, margin: usize, most: usize| (wifi.saturating_sub(margin) / BLOCK).min(most - 1);
    let pixel = |i: usize| {
        let row = ours(i / WIFI_COLUMNS, MARGIN[1], ROWS);
        picture.pixels[row * COLUMNS + ours(i % WIFI_COLUMNS, MARGIN[0], COLUMNS)]
    };
    Picture { columns: WIFI_COLUMNS, pixels: (0..WIFI_ROWS * WIFI_COLUMNS).map(pixel).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn colours_have_the_bytes_of_the_camera() {
        assert_eq!(to_565([255, 0, 0]), [0xF8, 0x00]);
        assert_eq!(to_565([0, 255, 0]), [0x07, 0xE0]);
        assert_eq!(to_565([0, 0, 255]), [0x00, 0x1F]);
        // Green does not get the blue bits, as it does in Webots' own converter.
        assert_eq!(from_565([0x00, 0x1F]), [0, 0, 255]);
        assert_eq!(from_565([0xFF, 0xFF]), [255, 255, 255]);
        assert_eq!(encode_bgra(&Picture { columns: 1, pixels: vec![[1, 2, 3]] }), [3, 2, 1, 255]);
    }

    #[test]
    fn incomplete_rows_are_refused() {
        assert!(decode_565(52, &[0; 51]).is_err());
        assert!(decode_bgra(52, &[0; 52]).is_err());
        assert!(shrink(&Picture { columns: 52, pixels: vec![[0; 3]; 52 * 39] }).is_err());
    }

    proptest! {
        #[test]
        fn the_mind_sees_through_wifi_what_the_camera_saw(
            pixels in proptest::collection::vec(any::<[u8; 3]>(), ROWS * COLUMNS),
        ) {
            let picture = Picture { columns: COLUMNS, pixels };
            prop_assert_eq!(shrink(&enlarge(&picture)).unwrap(), picture.clone());
            let wire = encode_565(&enlarge(&picture));
            prop_assert_eq!(wire.len(), 38_400);
            prop_assert_eq!(shrink(&decode_565(WIFI_COLUMNS, &wire).unwrap()).unwrap(), as_565(&picture));
            prop_assert_eq!(decode_bgra(COLUMNS, &encode_bgra(&picture)).unwrap(), picture);
        }

        #[test]
        fn rgb565_is_its_own_fixed_point(rgb: [u8; 3]) {
            let once = from_565(to_565(rgb));
            prop_assert_eq!(from_565(to_565(once)), once);
            prop_assert!(once.iter().zip(rgb).all(|(&a, b)| a.abs_diff(b) < 8));
        }
    }
}
