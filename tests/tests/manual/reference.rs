//! `docs/reference/commands.md` is made from the command line of the program.

use clap_markdown::{MarkdownOptions, help_markdown_custom};
use crumple::cli::Cli;
use crumple_tests::program::root;

/// With `UPDATE_EXPECT=1` the test writes the page.
#[test]
fn the_reference_of_commands_is_that_of_the_program() {
    let options = MarkdownOptions::new()
        .title("Commands and options".to_string())
        .show_footer(false)
        .show_table_of_contents(false);
    let page = help_markdown_custom::<Cli>(&options);
    let path = root().join("docs/reference/commands.md");
    expect_test::expect_file![path].assert_eq(&page);
}
