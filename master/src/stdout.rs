//! Writes to standard output. A reader may close the pipe early (`| head`); unlike with
//! `println!`, that is not an error.

use crumple_proto::exit_code::{BAD_INPUT, COMPLETED};
use std::fmt::Arguments;
use std::io::Write;
use std::path::Path;

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

/// Returns a path as one word of a command line, in quotes if a shell would divide or change it.
pub fn shell_word(path: &Path) -> String {
    let text = path.display().to_string();
    let is_plain = |c: char| c.is_alphanumeric() || "/._-+,:@%=~".contains(c);
    match !text.is_empty() && text.chars().all(is_plain) {
        true => text,
        false => format!("'{}'", text.replace('\'', "'\\''")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_one_word_of_a_shell() {
        let word = |text| shell_word(Path::new(text));
        assert_eq!(word("out/tube-1.toml"), "out/tube-1.toml");
        assert_eq!(word("my jobs/tube"), "'my jobs/tube'");
        assert_eq!(word("it's"), r"'it'\''s'");
    }
}
