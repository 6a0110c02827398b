//! What is particular to the stabilised shell.
