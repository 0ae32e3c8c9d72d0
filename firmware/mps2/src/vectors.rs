//! The vector of the interrupt that the programs use.

/// The number of the dual timer's interrupt.
pub const DUALTIMER_NUMBER: usize = 10;

unsafe extern "C" {
    fn DUALTIMER();
    fn DefaultHandler();
}

/// After the core's own vectors, where `link.x` puts them.
#[unsafe(link_section = ".vector_table.interrupts")]
#[unsafe(no_mangle)]
static __INTERRUPTS: [unsafe extern "C" fn(); 32] = {
    let mut table = [DefaultHandler as unsafe extern "C" fn(); 32];
    table[DUALTIMER_NUMBER] = DUALTIMER;
    table
};
