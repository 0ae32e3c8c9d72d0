//! The vectors of the interrupts that the programs have.

/// Number of the line's interrupt.
pub const UART_NUMBER: usize = 8;
/// Number of that of the first channel of timer 0.
pub const TC0_NUMBER: usize = 27;

unsafe extern "C" {
    fn UART();
    fn TC0();
    fn DefaultHandler();
}

/// Behind the core's own vectors: `link.x` puts it there.
#[unsafe(link_section = ".vector_table.interrupts")]
#[unsafe(no_mangle)]
static __INTERRUPTS: [unsafe extern "C" fn(); 45] = {
    let mut table = [DefaultHandler as unsafe extern "C" fn(); 45];
    (table[UART_NUMBER], table[TC0_NUMBER]) = (UART, TC0);
    table
};
