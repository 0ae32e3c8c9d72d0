//! The vectors of the interrupts that the programs have.

/// Number of UART0's interrupt.
pub const UART0_NUMBER: usize = 2;
/// Number of TIMER0's.
pub const TIMER0_NUMBER: usize = 8;
/// Number of TIMER1's, which the controller leaves to others.
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

    /// Behind the core's own vectors: `link.x` puts it there.
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
