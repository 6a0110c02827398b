//! Examples of the manual: its commands run, its jobs fit the schema, its code is code that is
//! compiled, and its reference is that of the program.

mod code;
mod commands;
mod jobs;
mod reference;
