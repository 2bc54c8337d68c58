//! `v`, `vn`, `vt`: lists of numbers.

use super::Parser;
use crate::load::obj::block::{Fatal, residual};
use crate::load::obj::memory::push;
use crate::load::obj::notes::Kind;
use crate::load::obj::number::{Number, number};

/// Magnitude beyond which coordinates are refused (rays could not reach them: [`crate::accel::LARGEST`]).
const LARGEST: f64 = 1e18;

impl Parser<'_, '_> {
    /// The next word as a number; `None` (and no step ahead) when it is none.
    #[inline(always)]
    fn next_number(&mut self) -> Option<Number> {
        self.skip_blanks();
        let number = number(self.text, self.at)?;
        if !self.word_ends(number.end - self.at) && !self.comment_follows(number.end) {
            return None;
        }
        self.at = number.end;
        Some(number)
    }

    /// Whether a comment touches the number before it; `1.#INF`, an old C library's infinity, is none.
    #[cold]
    fn comment_follows(&self, end: usize) -> bool {
        self.text.get(end) == Some(&b'#') && self.text.get(end.wrapping_sub(1)) != Some(&b'.')
    }

    /// Three numbers, each as f64 and f32.
    #[inline(always)]
    fn three_numbers(&mut self) -> Option<[(f64, f32); 3]> {
        let mut three = [(0.0, 0.0); 3];
        for one in &mut three {
            let number = self.next_number()?;
            *one = (number.value, number.to_f32(self.text));
        }
        Some(three)
    }

    #[inline(always)]
    pub(super) fn vertex(&mut self, line: u64) -> Result<(), Fatal> {
        let mut position = [f32::NAN; 3];
        let mut residuals = [0; 3];
        match self.three_numbers() {
            Some(three) if three.iter().all(|n| n.0.abs() <= LARGEST) => {
                position = three.map(|n| n.1);
                residuals = three.map(|n| residual(n.0, n.1));
            }
            three => self.unusable_vertex(line, three.is_some()),
        }
        push(&mut self.block.positions, position)?;
        push(&mut self.block.residuals, residuals)?;
        Ok(())
    }

    /// Says why a vertex cannot be used: not finite or too large (`nan` and `inf` included), or no numbers.
    #[cold]
    fn unusable_vertex(&mut self, line: u64, numbers: bool) {
        let kind = if numbers || self.not_finite() { Kind::VertexTooLarge } else { Kind::VertexUnreadable };
        self.block.notes.add(kind, line, self.block.positions.len() as i64 + 1);
        self.block.unusable[0] = true;
    }

    /// Whether the next word is one of `str::parse`'s words for what is not finite.
    fn not_finite(&self) -> bool {
        let rest = self.text.get(self.at..).unwrap_or_default();
        let length = (0..).position(|k| self.word_ends(k)).unwrap_or(0);
        let word = rest.get(..length).and_then(|w| std::str::from_utf8(w).ok());
        word.and_then(|w| w.parse::<f64>().ok()).is_some_and(|v| !v.is_finite())
    }

    #[inline(always)]
    pub(super) fn normal(&mut self, line: u64) -> Result<(), Fatal> {
        let values = self.three_numbers();
        let mut normal = values.map_or([0.0; 3], |three| three.map(|n| n.1));
        // Normals are directions: any magnitude will do, as long as its square is finite and not zero.
        let length2 = normal.iter().map(|&x| f64::from(x) * f64::from(x)).sum::<f64>();
        if !(length2 > 0.0 && length2.is_finite()) {
            let kind =
                if values.is_some() || self.not_finite() { Kind::NormalZero } else { Kind::NormalUnreadable };
            self.block.notes.add(kind, line, self.block.normals.len() as i64 + 1);
            self.block.unusable[1] = true;
            normal = [0.0; 3];
        }
        push(&mut self.block.normals, normal)?;
        Ok(())
    }

    /// One to three numbers; the third (a depth) is not used.
    #[inline(always)]
    pub(super) fn uv(&mut self, line: u64) -> Result<(), Fatal> {
        let mut uv = [f32::NAN; 2];
        if let Some(u) = self.next_number() {
            uv = [u.to_f32(self.text), 0.0];
            self.skip_blanks();
            if !(self.word_ends(0) || self.peek(0) == Some(b'#')) {
                uv[1] = self.next_number().map_or(f32::NAN, |v| v.to_f32(self.text));
            }
        }
        if !uv.iter().all(|x| f64::from(x.abs()) <= LARGEST) {
            self.block.notes.add(Kind::UvUnreadable, line, self.block.uvs.len() as i64 + 1);
            self.block.unusable[2] = true;
            uv = [f32::NAN; 2];
        }
        push(&mut self.block.uvs, uv)?;
        Ok(())
    }
}
