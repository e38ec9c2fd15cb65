//! Tables and plots for people: as text, as CSV, and as one HTML page that needs nothing beside itself.
//!
//! A number is rounded once, in [`Cell`], so every form shows the same digits.

mod html;
mod page;
mod plot;
mod shell;
mod table;
#[cfg(test)]
mod testing;

pub use html::{escape, with_code};
pub use page::{Document, Page, facts_to_html};
pub use plot::{Plot, Scale};
pub use shell::quoted;
pub use table::{Cell, Table};
