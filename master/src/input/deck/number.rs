//! Numbers in decks: Fortran's forms, including `1.0D+3`, `1.5-3` and `.5`.

/// Parses an integer; `None` if the text is none. `3.` and `3.0` are integers.
pub fn integer(text: &[u8]) -> Option<i64> {
    let text = std::str::from_utf8(text).ok()?;
    match text.parse() {
        Ok(number) => Some(number),
        Err(_) => {
            let number = real(text.as_bytes())?;
            // Beyond 2^53 an f64 does not represent every integer.
            (number.fract() == 0.0 && number.abs() < 9.0e15).then_some(number as i64)
        }
    }
}

/// Parses a number; `None` if the text is no finite number.
pub fn real(text: &[u8]) -> Option<f64> {
    let plain = |b: &u8| matches!(b, b'0'..=b'9' | b'.' | b'+' | b'-' | b'e' | b'E');
    let text = std::str::from_utf8(text).ok()?;
    let number: f64 = match text.bytes().all(|b| plain(&b)).then(|| text.parse().ok()).flatten() {
        Some(number) => number,
        None => fortran(text)?.parse().ok()?,
    };
    number.is_finite().then_some(number)
}

/// Returns the number with an `e` before its exponent; `None` if a letter cannot belong to a
/// number.
fn fortran(text: &str) -> Option<String> {
    let mut plain = String::with_capacity(text.len() + 1);
    let mut exponent = false;
    for (at, c) in text.char_indices() {
        match c {
            '0'..='9' | '.' => plain.push(c),
            'e' | 'E' | 'd' | 'D' if !exponent && at > 0 => {
                exponent = true;
                plain.push('e');
            }
            '+' | '-' if at == 0 || plain.ends_with('e') => plain.push(c),
            '+' | '-' if !exponent => {
                exponent = true;
                plain.push('e');
                plain.push(c);
            }
            _ => return None,
        }
    }
    Some(plain)
}

/// Returns the shortest text of at most `width` characters that reads back as the same bits;
/// `None` if there is none.
pub fn shortest(number: f64, width: usize) -> Option<String> {
    let exponential = format!("{number:e}");
    let plain = format!("{number:?}");
    let plain = plain.strip_suffix(".0").map(|whole| format!("{whole}.")).unwrap_or(plain);
    // Fortran needs neither the zero before the point nor the letter of the exponent.
    let bare = plain.replacen("0.", ".", usize::from(number.abs() < 1.0));
    let letterless = exponential.replace("e-", "-");
    let choices = [plain, exponential, bare, letterless];
    choices.into_iter().find(|text| {
        text.len() <= width && real(text.as_bytes()).map(f64::to_bits) == Some(number.to_bits())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_all_forms() {
        for (text, number) in [
            ("1", 1.0),
            ("-.5", -0.5),
            ("1.", 1.0),
            ("7.83000E-6", 7.83e-6),
            ("1.00000E20", 1e20),
            ("1e+08", 1e8),
            ("1.5D+3", 1500.0),
            ("2d-3", 2e-3),
            ("1.5-3", 1.5e-3),
            ("-2.5+3", -2500.0),
            ("+4.0", 4.0),
        ] {
            assert_eq!(real(text.as_bytes()), Some(number), "{text}");
        }
        for text in [
            "", "-", "e5", "1e", "nan", "inf", "infinity", "1.2.3", "1e5e5", "0x10", "1 2",
            "1e999", "é",
        ] {
            assert_eq!(real(text.as_bytes()), None, "{text}");
        }
        assert_eq!(integer(b"12"), Some(12));
        assert_eq!(integer(b"12.0"), Some(12));
        assert_eq!(integer(b"12.5"), None);
        assert_eq!(integer(b"99999999999999999999"), None);
    }

    #[test]
    fn short_texts_keep_all_bits() {
        for number in [
            0.0,
            1.0,
            -0.5,
            7.85e-6,
            1.0 / 3.0,
            -1.0 / 3.0,
            13.4112,
            1e300,
            0.1 + 0.2,
            -1234.567890123456,
        ] {
            let text = shortest(number, 20).unwrap();
            assert!(text.len() <= 20 && real(text.as_bytes()) == Some(number), "{number:?} {text}");
        }
        assert_eq!(shortest(-1.2345678901234567e-10, 20), None);
    }
}
