//! Writes a movie as an animated PNG, frame by frame, so that one frame is in memory.
//!
//! An animated PNG is a PNG whose first frame any program shows; browsers and presentation programs play it. Each frame holds only
//! the rectangle in which it differs from the frame before. Colours are exact. The movie repeats for ever.

use std::io::Write;

use ::png::{ColorType, Compression, Encoder, EncodingError, Writer};

/// A movie that is being written.
pub struct MovieWriter<W: Write> {
    writer: Writer<W>,
    width: usize,
    last: Option<Vec<u8>>,
}

impl<W: Write> MovieWriter<W> {
    /// Starts a movie of `count` frames of `width` times `height` pixels, each of which is shown for `delay_ms`.
    ///
    /// # Errors
    /// If it cannot be written, or has no frame.
    pub fn new(file: W, [width, height]: [u32; 2], count: u32, delay_ms: u16) -> Result<Self, EncodingError> {
        let mut encoder = Encoder::new(file, width, height);
        encoder.set_color(ColorType::Rgb);
        encoder.set_compression(Compression::Balanced);
        encoder.set_animated(count, 0)?;
        encoder.set_frame_delay(delay_ms, 1000)?;
        Ok(Self { writer: encoder.write_header()?, width: width as usize, last: None })
    }

    /// Adds a frame: red, green and blue of every pixel, by rows from above.
    ///
    /// # Errors
    /// If it cannot be written, or has another size.
    pub fn add(&mut self, pixels: Vec<u8>) -> Result<(), EncodingError> {
        let Some(last) = &self.last else {
            self.writer.write_image_data(&pixels)?;
            self.last = Some(pixels);
            return Ok(());
        };
        let [left, top, width, height] = changed(last, &pixels, self.width);
        let row = |y: usize| &pixels[3 * (y * self.width + left)..3 * (y * self.width + left + width)];
        let part: Vec<u8> = (top..top + height).flat_map(row).copied().collect();
        #[expect(clippy::cast_possible_truncation, reason = "inside a picture whose sides are u32")]
        let [left, top, width, height] = [left, top, width, height].map(|number| number as u32);
        // A rectangle is checked against the place of the one before.
        self.writer.set_frame_position(0, 0)?;
        self.writer.set_frame_dimension(width, height)?;
        self.writer.set_frame_position(left, top)?;
        self.writer.write_image_data(&part)?;
        self.last = Some(pixels);
        Ok(())
    }

    /// Ends the movie.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn finish(self) -> Result<(), EncodingError> {
        self.writer.finish()
    }
}

/// Returns left, top, width and height of the smallest rectangle that holds all pixels that differ; one pixel if none does.
fn changed(last: &[u8], now: &[u8], width: usize) -> [usize; 4] {
    let rows = last.chunks(3 * width).zip(now.chunks(3 * width)).enumerate().filter(|(_, (last, now))| last != now);
    let mut top = usize::MAX;
    let mut bottom = 0;
    let mut left = usize::MAX;
    let mut right = 0;
    for (y, (last, now)) in rows {
        (top, bottom) = (top.min(y), bottom.max(y + 1));
        let differs = |(last, now): (&[u8], &[u8])| last != now;
        let mut pixels = last.chunks(3).zip(now.chunks(3));
        let first = pixels.position(differs).unwrap_or(0);
        let end = last.chunks(3).zip(now.chunks(3)).rposition(differs).unwrap_or(0) + 1;
        (left, right) = (left.min(first), right.max(end));
    }
    if top == usize::MAX { [0, 0, 1, 1] } else { [left, top, right - left, bottom - top] }
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use super::*;

    #[test]
    fn frames_are_read_back_with_their_delays() {
        let blank = vec![255_u8; 3 * 5 * 4];
        let mut dot = blank.clone();
        dot[3 * (2 * 5 + 3)] = 0;
        let mut line = dot.clone();
        line[3 * (5 + 1) + 2] = 7;
        let frames = [blank, dot.clone(), dot, line];
        let mut file = Vec::new();
        let mut movie = MovieWriter::new(&mut file, [5, 4], 4, 40).unwrap();
        for frame in &frames {
            movie.add(frame.clone()).unwrap();
        }
        movie.finish().unwrap();

        let mut reader = ::png::Decoder::new(Cursor::new(&file)).read_info().unwrap();
        assert_eq!(reader.info().animation_control().unwrap().num_frames, 4);
        let mut screen = vec![0; 3 * 5 * 4];
        for (number, frame) in frames.iter().enumerate() {
            let mut buffer = vec![0; reader.output_buffer_size().unwrap()];
            let info = reader.next_frame(&mut buffer).unwrap();
            let control = *reader.info().frame_control().unwrap();
            assert_eq!((control.delay_num, control.delay_den), (40, 1000));
            for y in 0..control.height as usize {
                let row = &buffer[y * info.line_size..][..3 * control.width as usize];
                let at = 3 * ((control.y_offset as usize + y) * 5 + control.x_offset as usize);
                screen[at..at + row.len()].copy_from_slice(row);
            }
            assert!(screen == *frame, "frame {number}");
            assert_eq!([20, 1, 1, 1][number], control.width * control.height, "frame {number}");
        }
    }

    #[test]
    fn a_movie_without_frames_is_an_error() {
        assert!(MovieWriter::new(Vec::new(), [5, 4], 0, 40).is_err());
    }
}
