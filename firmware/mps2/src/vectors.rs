//! The vector of the interrupt that the programs have.

/// Number of the dual timer's interrupt.
pub const DUALTIMER_NUMBER: usize = 10;

unsafe extern "C" {
    fn DUALTIMER();
    fn DefaultHandler();
}

/// Behind the core's own vectors: `link.x` puts it there.
#[unsafe(link_section = ".vector_table.interrupts")]
#[unsafe(no_mangle)]
static __INTERRUPTS: [unsafe extern "C" fn(); 32] = {
    let mut table = [DefaultHandler as unsafe extern "C" fn(); 32];
    table[DUALTIMER_NUMBER] = DUALTIMER;
    table
};
