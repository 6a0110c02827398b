//! Writes to standard output. A reader may close the pipe early (`| head`); unlike with
//! `println!`, that is not an error.

use crumple_proto::exit_code::{BAD_INPUT, COMPLETED};
use std::fmt::Arguments;
use std::io::Write;

/// Writes to standard output. Text that cannot be written is dropped, because the reader has
/// gone.
pub fn write(words: Arguments<'_>) {
    let mut out = std::io::stdout().lock();
    out.write_fmt(words).and_then(|()| out.flush()).unwrap_or_default();
}

/// Ends a command that has written files: prints its message, or the error on standard error.
/// Returns the exit code.
pub fn ended(result: Result<String, String>) -> u8 {
    match result {
        Ok(said) => {
            write(format_args!("{said}\n"));
            COMPLETED
        }
        Err(why) => {
            eprintln!("error: {why}");
            BAD_INPUT
        }
    }
}

/// Writes a line to standard output, formatted as by `println!`.
macro_rules! say {
    ($($words:tt)*) => {
        $crate::stdout::write(format_args!("{}\n", format_args!($($words)*)))
    };
}
pub(crate) use say;
