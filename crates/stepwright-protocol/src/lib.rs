#![no_std]
//! The serial line, both sides.
