//! Pictures as PNG, stored without compression, so that no library is needed: of four colours in two bits a pixel, or in
//! full colours.

/// Most bytes of one stored block.
const BLOCK: usize = 65_535;

/// The bytes of a picture of `size` columns and rows; `index` gives each pixel's place in the palette, 0 to 3.
#[must_use]
pub fn encode(
    [columns, rows]: [usize; 2],
    palette: [[u8; 3]; 4],
    index: impl Fn(usize, usize) -> u8,
) -> Vec<u8> {
    let mut lines = Vec::with_capacity(rows * (1 + columns.div_ceil(4)));
    for row in 0..rows {
        lines.push(0);
        for first in (0..columns).step_by(4) {
            let bits = |k: usize| if first + k < columns { index(first + k, row) & 3 } else { 0 };
            lines.push((0..4).fold(0, |byte, k| byte << 2 | bits(k)));
        }
    }
    file([columns, rows], [2, 3], palette.as_flattened(), &lines)
}

/// The bytes of a picture of `columns`, red, green and blue of each pixel row by row.
#[must_use]
pub fn encode_rgb(columns: usize, rgb: &[u8]) -> Vec<u8> {
    let width = (3 * columns).max(1);
    let lines: Vec<u8> = rgb.chunks_exact(width).flat_map(|row| [&[0], row].concat()).collect();
    file([columns, rgb.len() / width], [8, 2], &[], &lines)
}

/// The file around lines of pixels of a format: bits of a sample, and kind of colours.
fn file([columns, rows]: [usize; 2], format: [u8; 2], palette: &[u8], lines: &[u8]) -> Vec<u8> {
    let mut png = b"\x89PNG\r\n\x1a\n".to_vec();
    let mut header = [(columns as u32).to_be_bytes(), (rows as u32).to_be_bytes()].concat();
    header.extend(format);
    header.extend([0, 0, 0]);
    chunk(&mut png, b"IHDR", &header);
    if !palette.is_empty() {
        chunk(&mut png, b"PLTE", palette);
    }
    chunk(&mut png, b"IDAT", &stored(lines));
    chunk(&mut png, b"IEND", &[]);
    png
}

fn chunk(png: &mut Vec<u8>, name: &[u8; 4], data: &[u8]) {
    png.extend((data.len() as u32).to_be_bytes());
    let start = png.len();
    png.extend(name);
    png.extend(data);
    let check = crc(&png[start..]);
    png.extend(check.to_be_bytes());
}

/// A zlib stream of stored blocks.
fn stored(data: &[u8]) -> Vec<u8> {
    let mut out = vec![0x78, 0x01];
    let mut blocks = data.chunks(BLOCK).peekable();
    while let Some(block) = blocks.next() {
        let length = block.len() as u16;
        out.push(u8::from(blocks.peek().is_none()));
        out.extend(length.to_le_bytes());
        out.extend((!length).to_le_bytes());
        out.extend(block);
    }
    out.extend(adler(data).to_be_bytes());
    out
}

fn adler(data: &[u8]) -> u32 {
    let (a, b) = data.iter().fold((1_u32, 0_u32), |(a, b), &byte| {
        let a = (a + u32::from(byte)) % 65_521;
        (a, (b + a) % 65_521)
    });
    b << 16 | a
}

fn crc(data: &[u8]) -> u32 {
    !data.iter().fold(u32::MAX, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |c, _| if c & 1 == 1 { c >> 1 ^ 0xEDB8_8320 } else { c >> 1 })
    })
}

/// What [`decode_stored`] finds.
#[cfg(test)]
pub struct Decoded {
    pub columns: usize,
    pub palette: Vec<[u8; 3]>,
    pub indices: Vec<u8>,
}

/// Reads a picture that [`encode`] wrote, by the letter of the format.
#[cfg(test)]
pub fn decode_stored(png: &[u8]) -> Decoded {
    assert_eq!(&png[..8], b"\x89PNG\r\n\x1a\n");
    let (mut at, mut columns, mut palette, mut zlib) = (8, 0, Vec::new(), Vec::new());
    while at < png.len() {
        let length = u32::from_be_bytes(png[at..at + 4].try_into().unwrap()) as usize;
        let (name, data) = (&png[at + 4..at + 8], &png[at + 8..at + 8 + length]);
        let check = u32::from_be_bytes(png[at + 8 + length..at + 12 + length].try_into().unwrap());
        assert_eq!(crc(&png[at + 4..at + 8 + length]), check);
        match name {
            b"IHDR" => columns = u32::from_be_bytes(data[..4].try_into().unwrap()) as usize,
            b"PLTE" => palette = data.as_chunks::<3>().0.to_vec(),
            b"IDAT" => zlib.extend_from_slice(data),
            _ => {}
        }
        at += 12 + length;
    }
    let (mut lines, mut at, mut last) = (Vec::new(), 2, false);
    while !last {
        last = zlib[at] == 1;
        let length = usize::from(u16::from_le_bytes([zlib[at + 1], zlib[at + 2]]));
        lines.extend_from_slice(&zlib[at + 5..at + 5 + length]);
        at += 5 + length;
    }
    let stride = 1 + columns.div_ceil(4);
    let indices = lines
        .chunks(stride)
        .flat_map(|line| (0..columns).map(|c| line[1 + c / 4] >> (6 - 2 * (c % 4)) & 3).collect::<Vec<u8>>());
    Decoded { columns, palette, indices: indices.collect() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn checksums_are_the_well_known_ones() {
        assert_eq!(crc(b"IEND"), 0xAE42_6082);
        assert_eq!(adler(b"Wikipedia"), 0x11E6_0398);
    }

    #[test]
    fn every_pixel_comes_back_across_blocks() {
        let index = |column: usize, row: usize| ((column * 7 + row * 3) % 4) as u8;
        let palette = [[1, 2, 3], [4, 5, 6], [7, 8, 9], [10, 11, 12]];
        let decoded = decode_stored(&encode([1001, 400], palette, index));
        assert_eq!((decoded.columns, decoded.palette.len()), (1001, 4));
        assert!((0..400).all(|r| (0..1001).all(|c| decoded.indices[r * 1001 + c] == index(c, r))));
    }
}
