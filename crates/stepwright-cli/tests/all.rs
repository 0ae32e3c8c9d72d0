//! All tests of this crate, but for golden.rs and guide.rs, in one program, which is built and linked once.

mod common;
#[path = "common/served.rs"]
mod served;

mod apart;
mod change;
mod cycle;
mod cycle_faults;
mod false_door;
mod flash;
mod gcode;
mod gcode_laser;
mod grbl;
mod grbl_port;
mod help;
mod hints;
mod home;
mod host_library;
mod interrupt;
mod jog;
mod lease;
mod machine;
mod machine_everywhere;
mod orders;
mod plan;
mod progress;
mod pty;
mod readme;
mod second_terminal;
mod selftest;
mod serve;
mod serve_crowd;
mod serve_home;
mod serve_jobs;
mod serve_line;
mod serve_paths;
mod settings;
mod signals;
mod status;
mod statuses;
mod stdio;
mod strangers;
mod streamed;
#[cfg(unix)]
mod streamed_laser;
mod streams;
mod timed;
mod typed;
mod units;
