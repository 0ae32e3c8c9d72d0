//! The vectors of the interrupts that the programs use.

/// The number of the line's interrupt.
pub const UART_NUMBER: usize = 8;
/// The number of the interrupt of timer 0's first channel.
pub const TC0_NUMBER: usize = 27;

unsafe extern "C" {
    fn UART();
    fn TC0();
    fn DefaultHandler();
}

/// After the core's own vectors, where `link.x` puts them.
#[unsafe(link_section = ".vector_table.interrupts")]
#[unsafe(no_mangle)]
static __INTERRUPTS: [unsafe extern "C" fn(); 45] = {
    let mut table = [DefaultHandler as unsafe extern "C" fn(); 45];
    (table[UART_NUMBER], table[TC0_NUMBER]) = (UART, TC0);
    table
};
