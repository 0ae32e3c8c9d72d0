//! The vectors of the interrupts that the programs use.

/// The number of the first PIO's first interrupt.
pub const PIO0_NUMBER: usize = 7;
/// The number of UART0's interrupt.
pub const UART0_NUMBER: usize = 20;

/// A vector.
#[derive(Clone, Copy)]
union Vector {
    handler: unsafe extern "C" fn(),
    none: u32,
}

unsafe extern "C" {
    fn PIO0_IRQ_0();
    fn UART0_IRQ();
    fn DefaultHandler();
}

/// After the core's own vectors, where `link.x` puts them.
#[unsafe(link_section = ".vector_table.interrupts")]
#[unsafe(no_mangle)]
static __INTERRUPTS: [Vector; 32] = {
    let mut table = [Vector { handler: DefaultHandler }; 32];
    (table[PIO0_NUMBER], table[UART0_NUMBER]) =
        (Vector { handler: PIO0_IRQ_0 }, Vector { handler: UART0_IRQ });
    // The chip has 26.
    let mut n = 26;
    while n < 32 {
        table[n] = Vector { none: 0 };
        n += 1;
    }
    table
};

/// The second stage of the boot loader, for the Pico's flash.
#[unsafe(link_section = ".boot2")]
#[used]
static BOOT2: [u8; 256] = rp2040_boot2::BOOT_LOADER_W25Q080;
