#![no_std]
//! Real-time motion for stepper motors.
