//! The MTL reader: values leave it finite and in their range, and no message quotes the library.

use drt::load::mtl::{At, parse};
use std::path::Path;

/// The bytes are the library.
pub fn run(text: &[u8]) {
    let file = parse(text, Path::new("fuzz.mtl"));
    let share = |x: f32| (0.0..=1.0).contains(&x);
    let number = |stated: &Option<At<f32>>, range: std::ops::RangeInclusive<f32>| {
        assert!(stated.as_ref().is_none_or(|at| range.contains(&at.value)), "{stated:?}");
    };
    for m in &file.materials {
        for color in [&m.kd, &m.ks, &m.tf].into_iter().flatten() {
            assert!(color.value.iter().all(|x| share(*x)), "{color:?}");
        }
        assert!(m.ke.as_ref().is_none_or(|ke| ke.value.iter().all(|x| (0.0..=1e9).contains(x))));
        for stated in [&m.d, &m.pr, &m.pm, &m.ps, &m.pc, &m.pcr, &m.anisor] {
            number(stated, 0.0..=1.0);
        }
        number(&m.aniso, -1.0..=1.0);
        number(&m.ns, 0.0..=1e6);
        number(&m.ni, 1.0..=10.0);
        assert!(m.illum.as_ref().is_none_or(|illum| illum.value <= 10));
        for (key, texture) in m.textures() {
            let o = &texture.value.options;
            let all = [o.offset, o.scale, o.turbulence].into_iter().flatten();
            let all = all.chain([o.bump_multiplier, o.boost, o.resolution]).chain(o.base_gain);
            assert!(all.into_iter().all(f32::is_finite), "{key}: {o:?}");
        }
    }
    // Long words of the library; key words are shorter.
    let words = text.split(|b| b.is_ascii_whitespace()).filter(|word| word.len() > 24);
    let words: Vec<&str> = words.filter_map(|word| std::str::from_utf8(word).ok()).take(4).collect();
    for finding in file.findings.kept() {
        assert!(words.iter().all(|word| !finding.message.contains(word)), "{} is quoted", finding.message);
    }
}
