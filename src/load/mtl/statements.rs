//! What each statement of a library means: values in their range, or a finding.

use super::{At, MtlFile, MtlMaterial, Texture, whole_number, words};
use crate::error::{Finding, Severity};
use std::path::Path;

/// Statements that belong to MTL and mean nothing to us.
const IGNORED: &[&[u8]] = &[
    b"ka",
    b"map_ka",
    b"sharpness",
    b"decal",
    b"refl",
    b"map_refl",
    b"map_aat",
    b"map_pc",
    b"map_pcr",
    b"map_tr",
    b"map_tf",
    b"map_ni",
    b"map_aniso",
    b"map_anisor",
];

/// Reads statements into a library.
pub(super) struct Reader<'a> {
    path: &'a Path,
    line: u64,
    out: MtlFile,
}

impl<'a> Reader<'a> {
    pub fn new(path: &'a Path) -> Self {
        Reader { path, line: 0, out: MtlFile::default() }
    }

    /// The library, when there are no more statements.
    pub fn finish(mut self) -> MtlFile {
        if self.out.materials.is_empty() {
            self.line = 0;
            self.note("mtl-without-materials", Severity::Warning, "the library defines no material");
        }
        self.out
    }

    fn note(&mut self, kind: &'static str, severity: Severity, message: &str) {
        let finding = Finding {
            file: self.path.to_path_buf(),
            line: self.line,
            kind,
            message: message.to_string(),
            severity,
        };
        self.out.findings.push(finding);
    }

    /// Reads the statement that `text`, the logical line at `line`, holds.
    pub fn statement(&mut self, line: u64, text: &[u8]) {
        self.line = line;
        let text = text.trim_ascii();
        if text.is_empty() || text.starts_with(b"#") {
            return;
        }
        let length = text.iter().position(|b| matches!(b, b' ' | b'\t')).unwrap_or(text.len());
        let (key, rest) = text.split_at(length);
        let (key, rest) = (key.to_ascii_lowercase(), rest.trim_ascii());
        if key == b"newmtl" {
            let material = MtlMaterial {
                name: rest.to_vec(),
                line: self.line,
                library: self.path.to_path_buf(),
                ..MtlMaterial::default()
            };
            self.out.materials.push(material);
        } else if self.out.materials.is_empty() {
            self.note(
                "mtl-before-newmtl",
                Severity::Warning,
                "a statement before the first newmtl was ignored",
            );
        } else {
            self.property(&key, rest);
        }
    }

    #[rustfmt::skip] // a table
    fn property(&mut self, key: &[u8], rest: &[u8]) {
        match key {
            b"kd" => self.color("Kd", rest, 1.0, |m| &mut m.kd),
            b"ks" => self.color("Ks", rest, 1.0, |m| &mut m.ks),
            b"ke" => self.color("Ke", rest, 1e9, |m| &mut m.ke),
            b"tf" => self.color("Tf", rest, 1.0, |m| &mut m.tf),
            b"ns" => self.scalar("Ns", rest, [0.0, 1e6], |m| &mut m.ns),
            b"ni" => self.scalar("Ni", rest, [1.0, 10.0], |m| &mut m.ni),
            b"d" => self.scalar("d", rest, [0.0, 1.0], |m| &mut m.d),
            b"tr" => self.transparency(rest),
            b"illum" => self.illumination(rest),
            b"pr" => self.scalar("Pr", rest, [0.0, 1.0], |m| &mut m.pr),
            b"pm" => self.scalar("Pm", rest, [0.0, 1.0], |m| &mut m.pm),
            b"ps" => self.scalar("Ps", rest, [0.0, 1.0], |m| &mut m.ps),
            b"pc" => self.scalar("Pc", rest, [0.0, 1.0], |m| &mut m.pc),
            b"pcr" => self.scalar("Pcr", rest, [0.0, 1.0], |m| &mut m.pcr),
            b"aniso" => self.scalar("aniso", rest, [-1.0, 1.0], |m| &mut m.aniso),
            b"anisor" => self.scalar("anisor", rest, [0.0, 1.0], |m| &mut m.anisor),
            b"map_kd" => self.texture("map_Kd", rest, |m| &mut m.map_kd),
            b"map_ks" => self.texture("map_Ks", rest, |m| &mut m.map_ks),
            b"map_ke" => self.texture("map_Ke", rest, |m| &mut m.map_ke),
            b"map_ns" => self.texture("map_Ns", rest, |m| &mut m.map_ns),
            b"map_d" => self.texture("map_d", rest, |m| &mut m.map_d),
            b"bump" | b"map_bump" => self.texture("bump", rest, |m| &mut m.bump),
            b"norm" | b"map_norm" => self.texture("norm", rest, |m| &mut m.norm),
            b"map_pr" => self.texture("map_Pr", rest, |m| &mut m.map_pr),
            b"map_pm" => self.texture("map_Pm", rest, |m| &mut m.map_pm),
            b"map_ps" => self.texture("map_Ps", rest, |m| &mut m.map_ps),
            b"disp" | b"map_disp" => self.texture("disp", rest, |m| &mut m.disp),
            _ if IGNORED.contains(&key) => {}
            _ => self.note("mtl-unknown-statement", Severity::Note, "a statement that MTL does not have was ignored"),
        }
    }

    /// Stores a value; a second one in the same material replaces the first.
    fn set<T>(&mut self, field: impl Fn(&mut MtlMaterial) -> &mut Option<At<T>>, value: T) {
        let line = self.line;
        if let Some(material) = self.out.materials.last_mut() {
            *field(material) = Some(At { value, line });
        }
    }

    fn ignored(&mut self, key: &str, why: &str) {
        self.note("mtl-value-ignored", Severity::Warning, &format!("{key} was ignored: {why}"));
    }

    /// The value within the range, with a finding when it was not; `None` for what is not finite.
    fn in_range(&mut self, key: &str, value: f64, [low, high]: [f64; 2]) -> Option<f32> {
        if !value.is_finite() {
            self.ignored(key, "its value is not finite");
            return None;
        }
        if !(low..=high).contains(&value) {
            let message = format!("{key} was clamped to its range, {low} to {high}");
            self.note("mtl-value-clamped", Severity::Warning, &message);
        }
        Some(value.clamp(low, high) as f32)
    }

    /// `r g b`, or one number for all three.
    fn color(
        &mut self,
        key: &str,
        rest: &[u8],
        high: f64,
        field: impl Fn(&mut MtlMaterial) -> &mut Option<At<[f32; 3]>>,
    ) {
        if let Some(b"spectral" | b"xyz") = words(rest).next() {
            return self.ignored(key, "only RGB colours are supported");
        }
        let numbers: Vec<f64> = words(rest).map_while(whole_number).take(3).collect();
        let rgb = match *numbers.as_slice() {
            [grey] => [grey; 3],
            [r, g, b] => [r, g, b],
            _ => return self.ignored(key, "it needs one or three numbers"),
        };
        if let Some(bad) = rgb.into_iter().find(|c| !c.is_finite()) {
            self.in_range(key, bad, [0.0, high]);
            return;
        }
        // One finding a statement, not one a channel.
        let worst = rgb.into_iter().find(|c| !(0.0..=high).contains(c)).unwrap_or(0.0);
        self.in_range(key, worst, [0.0, high]);
        self.set(field, rgb.map(|c| c.clamp(0.0, high) as f32));
    }

    fn number_of(&mut self, key: &str, rest: &[u8]) -> Option<f64> {
        // `d -halo 0.5`: transparent in the middle; taken as an even opacity.
        let value = words(rest).find(|w| !w.eq_ignore_ascii_case(b"-halo")).and_then(whole_number);
        if value.is_none() {
            self.ignored(key, "it needs a number");
        }
        value
    }

    fn scalar(
        &mut self,
        key: &str,
        rest: &[u8],
        range: [f64; 2],
        field: impl Fn(&mut MtlMaterial) -> &mut Option<At<f32>>,
    ) {
        if let Some(value) = self.number_of(key, rest)
            && let Some(value) = self.in_range(key, value, range)
        {
            self.set(field, value);
        }
    }

    fn transparency(&mut self, rest: &[u8]) {
        if let Some(value) = self.number_of("Tr", rest)
            && let Some(value) = self.in_range("Tr", value, [0.0, 1.0])
        {
            self.set(|m| &mut m.d, 1.0 - value);
        }
    }

    fn illumination(&mut self, rest: &[u8]) {
        match self.number_of("illum", rest) {
            Some(model) if (0.0..=10.0).contains(&model) && model.fract() == 0.0 => {
                self.set(|m| &mut m.illum, model as u8);
            }
            Some(_) => self.ignored("illum", "the models are 0 to 10"),
            None => {}
        }
    }

    fn texture(
        &mut self,
        key: &str,
        rest: &[u8],
        field: impl Fn(&mut MtlMaterial) -> &mut Option<At<Texture>>,
    ) {
        match Texture::parse(rest) {
            Some(texture) => self.set(field, texture),
            None => self.ignored(key, "it names no file"),
        }
    }
}
