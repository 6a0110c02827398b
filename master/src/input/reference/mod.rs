//! `crumple schema`: reference of the job format, as a JSON Schema for editors and as a page.
//!
//! - `schema.rs`: the schema of the job's types, with the names and parameters of the worker's
//!   tables and of the generators
//! - `page.rs`: the schema as Markdown, committed as `cases/REFERENCE.md`

mod page;
mod schema;

pub use page::page;
pub use schema::{INLINE_SET, job_schema, schema};

use crate::cli::SchemaArgs;

/// Prints the schema or the page, and returns the exit code.
pub fn run(args: &SchemaArgs) -> u8 {
    match args.reference {
        true => crate::stdout::write(format_args!("{}", page())),
        false => crate::stdout::write(format_args!("{:#}\n", schema())),
    }
    0
}
