//! `crumple schema`: what a job may say, for editors as a JSON Schema and for people as a page.
//!
//! - `schema.rs`: the schema of the job's types, with the names and parameters of the worker's
//!   tables and the generators
//! - `page.rs`: the same as Markdown, which is committed as `cases/REFERENCE.md`

mod page;
mod schema;

pub use page::page;
pub use schema::schema;

use crate::cli::SchemaArgs;

/// Prints the schema, or the page. Returns the exit code.
pub fn run(args: &SchemaArgs) -> u8 {
    match args.reference {
        true => crate::run::stdout::write(format_args!("{}", page())),
        false => crate::run::stdout::write(format_args!("{:#}\n", schema())),
    }
    0
}
