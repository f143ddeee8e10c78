//! The margins of a picture: header and legend above the view; key, axes and scale bar below it.

use super::ticks::{rounded, ticks};
use super::{BOTTOM, LETTER, Legend, Paper};
use crate::colour::{Rgb, hex};
use siloflow_dem::space::Vector;

/// Largest part of the width that a legend of classes takes.
const LEGEND: f64 = 0.42;

/// Part of the width that a colour scale takes.
const SCALE: f64 = 0.36;

impl Paper<'_> {
    pub(super) fn margins(&mut self) {
        // White rectangles cover shapes that extend into the margins. Clipping them would take three times as long.
        let width = self.picture.width;
        let [top, bottom] = self.view;
        for (y, height) in [(0.0, top), (bottom, BOTTOM * self.text + 1.0)] {
            self.put(format_args!(r##"<rect y="{y:.2}" width="{width:.2}" height="{height:.2}" fill="#ffffff"/>"##));
        }
        let legend = self.legend();
        self.header(width - legend - 1.2 * self.text);
        let key = self.key();
        self.axes(key);
        self.scale_bar();
    }

    fn header(&mut self, width: f64) {
        let mut y = 1.35 * self.text;
        for line in &self.picture.header {
            self.fitted((0.6 * self.text, y), width, "start", line);
            y += 1.35 * self.text;
        }
    }

    /// Draws the legend and returns its width with the space to its left, px.
    fn legend(&mut self) -> f64 {
        let width = self.picture.width;
        let text = self.text;
        match &self.picture.legend {
            Legend::None => 0.0,
            Legend::Classes(classes) => self.classes(classes),
            Legend::Scale { from, to, title, map } => {
                self.colour_scale((*from, *to), title, *map);
                SCALE * width + 1.2 * text
            }
        }
    }

    fn classes(&mut self, classes: &[(String, Rgb)]) -> f64 {
        let width = self.picture.width;
        let text = self.text;
        let right = width - 0.6 * text;
        let longest = classes.iter().map(|(name, _)| name.chars().count()).max().unwrap_or(0);
        #[expect(clippy::cast_precision_loss, reason = "the length of a name")]
        let room = (longest as f64 * LETTER * text).min(LEGEND * width);
        let mut y = 1.35 * text;
        for (name, colour) in classes {
            self.fitted((right - 1.2 * text, y), room, "end", name);
            let x = right - 0.4 * text;
            let y_middle = y - 0.35 * text;
            let r = 0.4 * text;
            self.put(format_args!(r#"<circle cx="{x:.2}" cy="{y_middle:.2}" r="{r:.2}" fill="{}"/>"#, hex(*colour)));
            y += 1.35 * text;
        }
        room + 2.6 * text
    }

    /// Draws a colour scale: title, bar, ticks with numbers.
    fn colour_scale(&mut self, (from, to): (f64, f64), title: &str, map: fn(f64) -> Rgb) {
        let text = self.text;
        let all = self.picture.width;
        let width = SCALE * all - 2.0 * text;
        let left = all - 1.6 * text - width;
        let top = 1.75 * text;
        let height = 0.75 * text;
        self.fitted((left + 0.5 * width, 1.3 * text), width + 2.0 * text, "middle", title);
        self.put(format_args!(r#"<linearGradient id="scale">"#));
        for stop in 0..=20u8 {
            let share = f64::from(stop) / 20.0;
            let fill = hex(map(share));
            self.put(format_args!(r#"<stop offset="{share}" stop-color="{fill}"/>"#));
        }
        self.put(format_args!("</linearGradient>"));
        self.put(format_args!(
            r#"<rect x="{left:.2}" y="{top:.2}" width="{width:.2}" height="{height:.2}" fill="url(#scale)"/>"#
        ));
        let below = top + height;
        for value in ticks(from, to, width / (0.85 * LETTER * text)) {
            let x = left + (value - from) / (to - from) * width;
            self.stroke([Vector::new(x, below), Vector::new(x, below + 0.3 * text)], 0.08 * text, None);
            self.text(x, below + 1.2 * text, 0.85 * text, "middle", &rounded(value));
        }
    }

    /// Explains the bonds and returns where the explanation ends, px.
    fn key(&mut self) -> f64 {
        let text = self.text;
        let y = self.view[1] + 1.6 * text;
        let mut x = 0.6 * text;
        for (width, colour, words) in &self.picture.key {
            let width = (width * self.scale).clamp(0.15 * text, 0.9 * text);
            let middle = y - 0.32 * text;
            self.stroke([Vector::new(x, middle), Vector::new(x + 1.6 * text, middle)], width, Some(*colour));
            self.text(x + 2.0 * text, y, text, "start", words);
            #[expect(clippy::cast_precision_loss, reason = "the length of a line")]
            let length = words.chars().count() as f64 * LETTER * text;
            x += 3.2 * text + length;
        }
        x
    }

    /// Draws the axes of space from `left` px.
    fn axes(&mut self, left: f64) {
        let text = self.text;
        let origin = Vector::new(left + 1.4 * text, self.view[1] + 1.45 * text);
        for (name, direction) in &self.picture.axes {
            let tip = Vector::new(direction.x, -direction.y);
            // An axis along the direction of looking is a point.
            if tip.length() > 0.2 {
                self.stroke([origin, origin + 0.9 * text * tip], 0.12 * text, None);
                let at = origin + (0.9 * tip + 0.4 * tip.normalize()) * text;
                self.text(at.x, at.y + 0.2 * text, 0.7 * text, "middle", name);
            }
        }
    }

    /// Draws a scale bar of 1, 2 or 5 times a power of ten metres, at most a quarter of the width.
    fn scale_bar(&mut self) {
        let text = self.text;
        let limit = 0.25 * self.picture.width / self.scale;
        let power = 10f64.powf(limit.log10().floor());
        let metres = [5.0, 2.0, 1.0].into_iter().map(|m| m * power).find(|&m| m <= limit).unwrap_or(power);
        let right = self.picture.width - text;
        let y = self.view[1] + 1.95 * text;
        let left = right - metres * self.scale;
        self.stroke([Vector::new(left, y), Vector::new(right, y)], 0.12 * text, None);
        for x in [left, right] {
            self.stroke([Vector::new(x, y - 0.25 * text), Vector::new(x, y + 0.25 * text)], 0.12 * text, None);
        }
        self.text(0.5 * (left + right), y - 0.5 * text, text, "middle", &format!("{} m", rounded(metres)));
    }
}
