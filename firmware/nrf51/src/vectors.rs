//! The vectors of the interrupts that the programs use.

/// The number of UART0's interrupt.
pub const UART0_NUMBER: usize = 2;
/// The number of TIMER0's interrupt.
pub const TIMER0_NUMBER: usize = 8;
/// The number of TIMER1's interrupt, which the controller does not use.
pub const TIMER1_NUMBER: usize = 9;

#[cfg(feature = "program")]
mod table {
    use super::{TIMER0_NUMBER, TIMER1_NUMBER, UART0_NUMBER};

    /// A vector.
    #[derive(Clone, Copy)]
    union Vector {
        handler: unsafe extern "C" fn(),
        none: u32,
    }

    unsafe extern "C" {
        fn UART0();
        fn TIMER0();
        fn TIMER1();
        fn DefaultHandler();
    }

    /// After the core's own vectors, where `link.x` puts them.
    #[unsafe(link_section = ".vector_table.interrupts")]
    #[unsafe(no_mangle)]
    static __INTERRUPTS: [Vector; 32] = {
        let mut table = [Vector { handler: DefaultHandler }; 32];
        table[UART0_NUMBER] = Vector { handler: UART0 };
        table[TIMER0_NUMBER] = Vector { handler: TIMER0 };
        table[TIMER1_NUMBER] = Vector { handler: TIMER1 };
        // Reserved.
        table[5] = Vector { none: 0 };
        table
    };
}
