//! The repository itself: ARCHITECTURE.md, links.

mod architecture;
mod links;
