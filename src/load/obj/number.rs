//! Decimal numbers, exactly.
//!
//! The grammar is that of `str::parse` without its words: `[+-] (digits [. digits] | . digits) [(e|E) [+-] digits]`.
//! The value is the f64 nearest to the decimal, and its f32 is the f32 nearest to the *decimal* (not to
//! the f64): both agree bit for bit with `str::parse`.
//!
//! Clinger, "How to read floating point numbers accurately" (1990): when the digits fit into 53 bits and
//! the power of ten is at most 10²², both are exact f64s and one multiplication or division rounds once.
//! Everything else goes to `str::parse`.

/// The powers of ten that f64 holds exactly.
#[rustfmt::skip]
const POWERS_OF_TEN: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11,
    1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22,
];

/// A number in a text.
#[derive(Clone, Copy, Debug)]
pub(in crate::load) struct Number {
    /// The f64 nearest to the decimal.
    pub value: f64,
    /// Where its text starts.
    pub start: usize,
    /// The first byte after it.
    pub end: usize,
}

/// Reads the number that starts at `start`; `None` when there is none.
#[inline]
pub(in crate::load) fn number(text: &[u8], start: usize) -> Option<Number> {
    let mut at = start;
    let negative = match text.get(at)? {
        b'-' => {
            at += 1;
            true
        }
        b'+' => {
            at += 1;
            false
        }
        _ => false,
    };
    let mut digits = 0u64;
    let integer = at;
    (digits, at) = take_digits(text, at, digits);
    let mut count = at - integer;
    let mut exponent = 0i64;
    if text.get(at) == Some(&b'.') {
        let fraction = at + 1;
        (digits, at) = take_digits(text, fraction, digits);
        count += at - fraction;
        exponent = -((at - fraction) as i64);
    }
    if count == 0 {
        return None;
    }
    if let Some(b'e' | b'E') = text.get(at) {
        let (power, end) = take_exponent(text, at + 1)?;
        exponent = exponent.saturating_add(power);
        at = end;
    }
    // 19 digits never overflow a u64; what they would lose beyond 2^53 goes the exact way.
    let value = if count <= 19 && digits <= 1 << 53 && exponent.unsigned_abs() <= 22 {
        let power = POWERS_OF_TEN[exponent.unsigned_abs() as usize];
        let magnitude = if exponent < 0 { digits as f64 / power } else { digits as f64 * power };
        if negative { -magnitude } else { magnitude }
    } else {
        parse_exactly::<f64>(text.get(start..at)?)?
    };
    Some(Number { value, start, end: at })
}

#[inline(always)]
fn take_digits(text: &[u8], mut at: usize, mut value: u64) -> (u64, usize) {
    while let Some(byte) = text.get(at) {
        let digit = byte.wrapping_sub(b'0');
        if digit > 9 {
            break;
        }
        value = value.wrapping_mul(10).wrapping_add(u64::from(digit));
        at += 1;
    }
    (value, at)
}

#[cold]
fn take_exponent(text: &[u8], start: usize) -> Option<(i64, usize)> {
    let signed = usize::from(matches!(text.get(start), Some(b'+' | b'-')));
    let mut at = start + signed;
    let mut power = 0i64;
    while let Some(digit @ b'0'..=b'9') = text.get(at) {
        power = power.saturating_mul(10).saturating_add(i64::from(digit - b'0'));
        at += 1;
    }
    if at == start + signed {
        return None;
    }
    Some((if text.get(start) == Some(&b'-') { -power } else { power }, at))
}

#[cold]
fn parse_exactly<T: std::str::FromStr>(text: &[u8]) -> Option<T> {
    std::str::from_utf8(text).ok()?.parse().ok()
}

impl Number {
    /// The f32 nearest to the decimal.
    ///
    /// Rounding the f64 again goes wrong only where that f64 lies exactly half-way between two f32s (the
    /// decimal itself may lie on either side), or where f32 has fewer bits than its usual 24: those few
    /// are parsed once more.
    #[inline]
    pub fn to_f32(self, text: &[u8]) -> f32 {
        const BELOW_F32: u64 = (1 << 29) - 1;
        const HALF_WAY: u64 = 1 << 28;
        let half_way = self.value.to_bits() & BELOW_F32 == HALF_WAY;
        let subnormal = self.value.abs() < f64::from(f32::MIN_POSITIVE) && self.value != 0.0;
        if half_way || subnormal {
            return self.parse_f32(text);
        }
        self.value as f32
    }

    #[cold]
    fn parse_f32(self, text: &[u8]) -> f32 {
        text.get(self.start..self.end).and_then(parse_exactly).unwrap_or(self.value as f32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(text: &str) {
        let ours = number(text.as_bytes(), 0).unwrap_or_else(|| panic!("{text} is a number"));
        assert_eq!(ours.end, text.len(), "{text}");
        assert_eq!(ours.value.to_bits(), text.parse::<f64>().unwrap().to_bits(), "f64 of {text}");
        assert_eq!(
            ours.to_f32(text.as_bytes()).to_bits(),
            text.parse::<f32>().unwrap().to_bits(),
            "f32 of {text}"
        );
    }

    /// Row A4: finite numbers are exactly what `str::parse` makes of them.
    #[test]
    fn a4_spellings_agree_with_str_parse() {
        #[rustfmt::skip]
        let spellings = [
            "0", "-0", "+0", "00", "1", "-1", "+3", "007", ".5", "5.", "-.5", "+.5", "-5.", "0.1", "0.2", "0.3",
            "1e5", "1E5", "1e+05", "1e-05", "1.5e3", ".5e1", "5.e1", "1e0", "1e-0", "123456789", "1234567890123456789",
            "12345678901234567890", "0.1234567890123456789", "0.00000000000000000000001", "1e22", "1e23", "1e-22", "1e-23",
            "1e38", "1e39", "1e308", "1e309", "-1e400", "1e-46", "1e-45", "7e-46", "1.1754942e-38", "1.17549435e-38",
            "4.9e-324", "1e-400", "9007199254740992", "9007199254740993", "16777217", "16777219", "3.4028235e38",
            "3.4028236e38", "0.000001", "999999.999999", "8388608.5", "1e99999999999999999999", "0e99999999999999999999",
            // Double rounding: the f64 nearest to each is half-way between two f32s, the decimal is not.
            "1.00000017881393432617187499", "1.00000017881393432617187501", "1.000000178813934326171875",
            "16777217.0000000001", "16777216.9999999999", "-16777217.0000000001",
        ];
        for text in spellings {
            check(text);
        }
    }

    #[test]
    fn a4_what_is_no_number() {
        for text in [
            "", "+", "-", ".", "e5", ".e5", "nan", "inf", "-inf", "infinity", "x", "--1", "+-1", "1e", "1e+",
            "1e-",
        ] {
            assert!(number(text.as_bytes(), 0).is_none(), "{text}");
        }
        for (text, end) in
            [("1,5", 1), ("0x10", 1), ("1.#INF", 2), ("1.5.2", 3), ("1_000", 1), ("1 2", 1), ("1f", 1)]
        {
            assert_eq!(number(text.as_bytes(), 0).unwrap().end, end, "{text}");
        }
    }

    proptest::proptest! {
        #[test]
        fn random_numbers_agree_with_str_parse(
            sign in "[+-]?", whole in "[0-9]{0,22}", fraction in "[0-9]{0,22}", exponent in proptest::option::of(-60i32..60)
        ) {
            let mut text = format!("{sign}{whole}.{fraction}");
            if whole.is_empty() && fraction.is_empty() { text.push('0'); }
            if let Some(e) = exponent { text += &format!("e{e}"); }
            check(&text);
        }

        #[test]
        fn decimals_near_half_way_between_two_f32s(bits in 0u32..0x7f00_0000, nudge in -3i64..=3, digits in 8usize..26) {
            let below = f64::from(f32::from_bits(bits));
            let half_way = f64::from_bits((below.to_bits() + (1 << 28)).wrapping_add_signed(nudge));
            check(&format!("{half_way:e}"));
            check(&format!("{half_way:.digits$e}"));
        }
    }
}
