//! What people read and type: commands, messages, pictures, reports, exports, documents and the code itself.

#[path = "../common/mod.rs"]
mod common;

mod at_a_terminal;
mod build_script;
mod command_line;
mod command_reference;
mod documents;
mod exports;
mod first_steps;
mod job_specs;
mod licences;
mod messages;
mod parameter_table;
mod plots;
mod readers;
mod reference;
mod reports;
mod slips;
mod structure;
mod terminal;
