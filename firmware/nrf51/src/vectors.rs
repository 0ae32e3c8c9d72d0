//! The vectors of the interrupts that the programs have.

/// Number of UART0's interrupt.
pub const UART0_NUMBER: usize = 2;
/// Number of TIMER0's.
pub const TIMER0_NUMBER: usize = 8;

#[cfg(feature = "program")]
mod table {
    use super::{TIMER0_NUMBER, UART0_NUMBER};

    /// A vector.
    #[derive(Clone, Copy)]
    union Vector {
        handler: unsafe extern "C" fn(),
        none: u32,
    }

    unsafe extern "C" {
        fn UART0();
        fn TIMER0();
        fn DefaultHandler();
    }

    /// Behind the core's own vectors: `link.x` puts it there.
    #[unsafe(link_section = ".vector_table.interrupts")]
    #[unsafe(no_mangle)]
    static __INTERRUPTS: [Vector; 32] = {
        let mut table = [Vector { handler: DefaultHandler }; 32];
        (table[UART0_NUMBER], table[TIMER0_NUMBER]) =
            (Vector { handler: UART0 }, Vector { handler: TIMER0 });
        // Reserved.
        table[5] = Vector { none: 0 };
        table
    };
}
