//! What goes to standard output. Whoever reads it may stop reading (`| head`); that is no fault,
//! unlike with `println!`.

use std::fmt::Arguments;
use std::io::Write;

/// Writes to standard output; what cannot be written is dropped, as nobody reads it.
pub fn write(words: Arguments<'_>) {
    let mut out = std::io::stdout().lock();
    out.write_fmt(words).and_then(|()| out.flush()).unwrap_or_default();
}

/// A line to standard output, formatted as by `println!`.
macro_rules! say {
    ($($words:tt)*) => { $crate::run::stdout::write(format_args!("{}\n", format_args!($($words)*))) };
}
pub(crate) use say;
