//! The functions that a page calls. There is one host, and a page has one thread.
//!
//! | function | what |
//! | --- | --- |
//! | `stepwright_room` | makes room for a text or bytes of this length, and returns its address |
//! | `stepwright_turn` | handles an event at a time in ms; returns in how many ms to call again |
//! | `stepwright_file` | makes a file of a record: the ending of its name, a line feed, the record |
//! | `stepwright_out`, `_out_len` | the results: 0 bytes for the board, 1 messages, 2 the file |
//!
//! | event | contents of the room |
//! | --- | --- |
//! | 0 time has passed | |
//! | 1 bytes have come | the bytes |
//! | 2 a request | `NUMBER NAME`, a line feed, the body |
//! | 3 a wire is open | the board's name |
//! | 4 no wire could be opened | the board's name, a line feed, the reason |
//! | 5 the wire is gone | the reason |
//! | 6 the page wants another board | |
//! | 7, 8 questions are to be reported, or not | |
//!
//! Messages are lines of JSON: those of `/api/live`, and `board`, `answer` and `closed`. Addresses stay valid
//! until the next call.

use std::cell::RefCell;

use stepwright_keeper::scope::{ScopeFile, ScopeRecord};

use crate::host::{Event, WasmHost};

#[derive(Default)]
struct Door {
    host: WasmHost,
    room: Vec<u8>,
    /// Bytes for the board, messages, a file.
    out: [Vec<u8>; 3],
}

thread_local! {
    static DOOR: RefCell<Door> = RefCell::default();
}

/// Makes room for `len` bytes, and returns its address.
#[unsafe(no_mangle)]
pub extern "C" fn stepwright_room(len: u32) -> *mut u8 {
    DOOR.with_borrow_mut(|door| {
        door.room.clear();
        door.room.resize(len as usize, 0);
        door.room.as_mut_ptr()
    })
}

/// Handles an event at time `now`, in ms. Returns in how many ms to call again if nothing happens; infinity if
/// there is no such time.
#[unsafe(no_mangle)]
pub extern "C" fn stepwright_turn(now: f64, event: u32) -> f64 {
    DOOR.with_borrow_mut(|door| {
        let Door { host, room, out: [bytes, messages, _] } = door;
        let text = String::from_utf8_lossy(room);
        let event = match event {
            1 => Event::Bytes(room),
            2 => Event::Ask(&text),
            3 => Event::Open(&text),
            4 => Event::Failed(&text),
            5 => Event::Gone(&text),
            6 => Event::Leave,
            7 => Event::Questions(true),
            8 => Event::Questions(false),
            _ => Event::Time,
        };
        let (said, due) = host.turn(now / 1000.0, event);
        (*bytes, *messages) = (said, host.take_messages().into_bytes());
        due.map_or(f64::INFINITY, |due| due * 1000.0)
    })
}

/// Makes a file of a record. Returns 1, or 0 if it can't.
#[unsafe(no_mangle)]
pub extern "C" fn stepwright_file() -> u32 {
    DOOR.with_borrow_mut(|door| {
        let text = String::from_utf8_lossy(&door.room);
        let made = text.split_once('\n').and_then(|(ending, record)| {
            let record: ScopeRecord = serde_json::from_str(record).ok()?;
            ScopeFile::named(ending)?.of(&record).ok()
        });
        let whole = made.is_some();
        door.out[2] = made.unwrap_or_default();
        whole.into()
    })
}

/// The address of a result of the last call: 0 bytes for the board, 1 messages, 2 the file.
#[unsafe(no_mangle)]
pub extern "C" fn stepwright_out(which: u32) -> *const u8 {
    DOOR.with_borrow(|door| door.out.get(which as usize).map_or(std::ptr::null(), Vec::as_ptr))
}

/// The length of that result.
#[unsafe(no_mangle)]
pub extern "C" fn stepwright_out_len(which: u32) -> u32 {
    DOOR.with_borrow(|door| door.out.get(which as usize).map_or(0, Vec::len)) as u32
}
