//! Writes to standard output. A reader may close the pipe early (`| head`); unlike with
//! `println!`, that is not an error.

use std::fmt::Arguments;
use std::io::Write;

/// Writes to standard output. Text that cannot be written is dropped, because the reader has
/// gone.
pub fn write(words: Arguments<'_>) {
    let mut out = std::io::stdout().lock();
    out.write_fmt(words).and_then(|()| out.flush()).unwrap_or_default();
}

/// Writes a line to standard output, formatted as by `println!`.
macro_rules! say {
    ($($words:tt)*) => {
        $crate::stdout::write(format_args!("{}\n", format_args!($($words)*)))
    };
}
pub(crate) use say;
