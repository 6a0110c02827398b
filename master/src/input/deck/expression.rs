//! Formulas of `*PARAMETER_EXPRESSION`: + - * / ** and functions. Integers stay integers (2/5 is
//! 0).

use super::number;
use super::parameters::Parameter;

/// Maximum depth of nested brackets.
const DEEPEST: usize = 100;

#[derive(Clone, Copy, Debug)]
enum Number {
    Whole(i64),
    Real(f64),
}

impl Number {
    fn real(self) -> f64 {
        match self {
            Number::Whole(i) => i as f64,
            Number::Real(x) => x,
        }
    }
}

/// Returns the value of a formula; `names` returns the values of parameters.
pub fn evaluate(
    text: &str,
    names: &dyn Fn(&str) -> Option<Parameter>,
) -> Result<Parameter, String> {
    let mut parser = Parser { rest: text.trim(), names, depth: 0 };
    let value = parser.sum()?;
    if !parser.rest.is_empty() {
        return Err(format!("unexpected `{}`", parser.rest));
    }
    match value {
        Number::Whole(i) => Ok(Parameter::Integer(i)),
        Number::Real(x) if x.is_finite() => Ok(Parameter::Real(x)),
        Number::Real(x) => Err(format!("its value is {x}")),
    }
}

struct Parser<'t> {
    rest: &'t str,
    names: &'t dyn Fn(&str) -> Option<Parameter>,
    depth: usize,
}

type Parsed = Result<Number, String>;

impl<'t> Parser<'t> {
    fn accept(&mut self, sign: &str) -> bool {
        match self.rest.strip_prefix(sign) {
            Some(rest) => {
                self.rest = rest.trim_start();
                true
            }
            None => false,
        }
    }

    fn sum(&mut self) -> Parsed {
        self.depth += 1;
        if self.depth > DEEPEST {
            return Err("brackets are nested too deeply".into());
        }
        let mut value = self.product()?;
        loop {
            if self.accept("+") {
                value = apply(value, self.product()?, i64::checked_add, |a, b| a + b);
            } else if self.accept("-") {
                value = apply(value, self.product()?, i64::checked_sub, |a, b| a - b);
            } else {
                self.depth -= 1;
                return Ok(value);
            }
        }
    }

    fn product(&mut self) -> Parsed {
        let mut value = self.signed()?;
        loop {
            if !self.rest.starts_with("**") && self.accept("*") {
                value = apply(value, self.signed()?, i64::checked_mul, |a, b| a * b);
            } else if self.accept("/") {
                let by = self.signed()?;
                if by.real() == 0.0 {
                    return Err("division by zero".into());
                }
                value = apply(value, by, i64::checked_div, |a, b| a / b);
            } else {
                return Ok(value);
            }
        }
    }

    fn signed(&mut self) -> Parsed {
        let mut minus = false;
        loop {
            if self.accept("-") {
                minus = !minus;
            } else if !self.accept("+") {
                break;
            }
        }
        let value = self.power()?;
        Ok(match (minus, value) {
            (false, value) => value,
            (true, Number::Whole(i)) => {
                i.checked_neg().map_or(Number::Real(-(i as f64)), Number::Whole)
            }
            (true, Number::Real(x)) => Number::Real(-x),
        })
    }

    fn power(&mut self) -> Parsed {
        let base = self.atom()?;
        if !(self.accept("**") || self.accept("^")) {
            return Ok(base);
        }
        self.depth += 1;
        if self.depth > DEEPEST {
            return Err("powers are nested too deeply".into());
        }
        let exponent = self.signed()?;
        self.depth -= 1;
        let whole = |a: i64, b: i64| u32::try_from(b).ok().and_then(|b| a.checked_pow(b));
        Ok(apply(base, exponent, whole, f64::powf))
    }

    fn atom(&mut self) -> Parsed {
        if self.accept("(") {
            let value = self.sum()?;
            return if self.accept(")") {
                Ok(value)
            } else {
                Err("a bracket is not closed".into())
            };
        }
        let marked = self.accept("&");
        let first = self.rest.chars().next().ok_or("the formula ends too early")?;
        if first.is_alphabetic() || first == '_' {
            let end = self
                .rest
                .find(|c: char| !c.is_alphanumeric() && c != '_')
                .unwrap_or(self.rest.len());
            let (name, rest) = self.rest.split_at(end);
            self.rest = rest.trim_start();
            return if !marked && self.accept("(") { self.function(name) } else { self.name(name) };
        }
        self.literal()
    }

    fn name(&mut self, name: &str) -> Parsed {
        match ((self.names)(name), name.to_ascii_lowercase().as_str()) {
            (Some(Parameter::Integer(i)), _) => Ok(Number::Whole(i)),
            (Some(Parameter::Real(x)), _) => Ok(Number::Real(x)),
            (Some(Parameter::Text(_)), _) => Err(format!("`{name}` is text")),
            (None, "pi") => Ok(Number::Real(std::f64::consts::PI)),
            (None, _) => Err(format!("there is no parameter `{name}` yet")),
        }
    }

    fn literal(&mut self) -> Parsed {
        let bytes = self.rest.as_bytes();
        let mut end = 0;
        while end < bytes.len() {
            let exponent = end > 0 && matches!(bytes[end - 1], b'e' | b'E' | b'd' | b'D');
            match bytes[end] {
                b'0'..=b'9' | b'.' | b'e' | b'E' | b'd' | b'D' => end += 1,
                b'+' | b'-' if exponent => end += 1,
                _ => break,
            }
        }
        let (text, rest) = self.rest.split_at(end);
        self.rest = rest.trim_start();
        let whole = text.bytes().all(|b| b.is_ascii_digit());
        match (
            whole.then(|| number::integer(text.as_bytes())).flatten(),
            number::real(text.as_bytes()),
        ) {
            (Some(i), _) => Ok(Number::Whole(i)),
            (None, Some(x)) => Ok(Number::Real(x)),
            _ => {
                Err(format!("`{}` cannot be read", if text.is_empty() { self.rest } else { text }))
            }
        }
    }

    fn function(&mut self, name: &str) -> Parsed {
        let mut arguments = vec![self.sum()?];
        while self.accept(",") {
            arguments.push(self.sum()?);
        }
        if !self.accept(")") {
            return Err(format!("the bracket of `{name}` is not closed"));
        }
        let name = name.to_ascii_lowercase();
        let one = |f: fn(f64) -> f64| match arguments.as_slice() {
            [x] => Ok(Number::Real(f(x.real()))),
            _ => Err(format!("`{name}` takes one argument")),
        };
        let fold = |whole: fn(i64, i64) -> i64, real: fn(f64, f64) -> f64| {
            let first = arguments[0];
            let both = |a, &b| apply(a, b, |a, b| Some(whole(a, b)), real);
            Ok(arguments[1..].iter().fold(first, both))
        };
        match name.as_str() {
            "abs" => match arguments.as_slice() {
                [Number::Whole(i)] => {
                    Ok(i.checked_abs().map_or(Number::Real((*i as f64).abs()), Number::Whole))
                }
                _ => one(f64::abs),
            },
            "sqrt" => one(f64::sqrt),
            "exp" => one(f64::exp),
            "log" | "ln" => one(f64::ln),
            "log10" => one(f64::log10),
            "sin" => one(f64::sin),
            "cos" => one(f64::cos),
            "tan" => one(f64::tan),
            "asin" => one(f64::asin),
            "acos" => one(f64::acos),
            "atan" => one(f64::atan),
            "sinh" => one(f64::sinh),
            "cosh" => one(f64::cosh),
            "tanh" => one(f64::tanh),
            "float" => one(|x| x),
            "int" | "aint" | "nint" | "anint" => {
                let cut = if name.contains('n') && name != "int" && name != "aint" {
                    f64::round
                } else {
                    f64::trunc
                };
                match one(cut)? {
                    Number::Real(x) if !name.starts_with('a') && x.abs() < 9.0e15 => {
                        Ok(Number::Whole(x as i64))
                    }
                    value => Ok(value),
                }
            }
            "min" => fold(i64::min, f64::min),
            "max" => fold(i64::max, f64::max),
            "atan2" | "mod" | "sign" => match arguments.as_slice() {
                [a, b] if name == "atan2" => Ok(Number::Real(a.real().atan2(b.real()))),
                [a, b] if name == "sign" => Ok(Number::Real(a.real().abs().copysign(b.real()))),
                [a, b] => Ok(apply(*a, *b, i64::checked_rem, |a, b| a % b)),
                _ => Err(format!("`{name}` takes two arguments")),
            },
            _ => Err(format!("there is no function `{name}`")),
        }
    }
}

/// Applies an operator. The result of two integers is an integer unless that overflows, otherwise
/// a real number.
fn apply(
    a: Number,
    b: Number,
    whole: impl Fn(i64, i64) -> Option<i64>,
    real: impl Fn(f64, f64) -> f64,
) -> Number {
    match (a, b) {
        (Number::Whole(i), Number::Whole(j)) => match whole(i, j) {
            Some(k) => Number::Whole(k),
            None => Number::Real(real(i as f64, j as f64)),
        },
        _ => Number::Real(real(a.real(), b.real())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(text: &str) -> Result<Parameter, String> {
        let names = |name: &str| match name {
            "n" => Some(Parameter::Integer(4)),
            "x" => Some(Parameter::Real(2.5)),
            _ => None,
        };
        evaluate(text, &names)
    }

    #[test]
    fn formulas() {
        for (text, real) in [
            ("2.0/5", 0.4),
            ("&x*2", 5.0),
            ("-x**2", -6.25),
            ("sqrt(16.0)+max(1,2.5)", 6.5),
            ("2*(3.0+&n)", 14.0),
            ("1.5e-3*2", 3e-3),
            ("cos(pi)", -1.0),
        ] {
            assert_eq!(value(text), Ok(Parameter::Real(real)), "{text}");
        }
        assert_eq!(value("2/5"), Ok(Parameter::Integer(0)));
        assert_eq!(value("&n+1"), Ok(Parameter::Integer(5)));
        assert_eq!(value("-2**2"), Ok(Parameter::Integer(-4)));
    }

    #[test]
    fn invalid_formulas_are_reported() {
        for text in [
            "",
            "1+",
            "(1",
            "sqrt(1",
            "nope(1)",
            "&y",
            "1/0",
            "sqrt(-1.0)",
            "1 2",
            "**",
            "é",
            "9**99**99",
            "mod(1,0)",
        ] {
            assert!(value(text).is_err(), "{text} {:?}", value(text));
        }
        assert!(value(&"(".repeat(10_000)).is_err());
        assert!(value(&format!("1{}", "**1".repeat(10_000))).is_err());
        assert!(value(&format!("{}1", "-".repeat(100_000))).is_ok());
    }
}
