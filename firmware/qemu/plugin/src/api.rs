//! QEMU's interface for plugins, according to its documentation of TCG plugins (version 1).

use std::ffi::{c_char, c_int, c_uint, c_void};
use std::marker::{PhantomData, PhantomPinned};

/// QEMU's number for a plugin.
pub type PluginId = u64;

/// A block of translated code.
#[repr(C)]
pub struct Block(PhantomData<(*mut u8, PhantomPinned)>, [u8; 0]);

/// An instruction in a block.
#[repr(C)]
pub struct Instruction(PhantomData<(*mut u8, PhantomPinned)>, [u8; 0]);

/// The callback uses no register.
pub const NO_REGISTERS: c_int = 0;
/// An operation in the translated code: an addition.
pub const ADD_U64: c_int = 0;
/// The stores among the accesses to memory.
pub const WRITES: c_int = 2;

unsafe extern "C" {
    pub fn qemu_plugin_register_vcpu_tb_trans_cb(
        id: PluginId,
        call: unsafe extern "C" fn(PluginId, *mut Block),
    );
    pub fn qemu_plugin_tb_n_insns(block: *const Block) -> usize;
    pub fn qemu_plugin_tb_get_insn(block: *const Block, n: usize) -> *mut Instruction;
    pub fn qemu_plugin_insn_data(instruction: *const Instruction) -> *const c_void;
    pub fn qemu_plugin_insn_size(instruction: *const Instruction) -> usize;
    pub fn qemu_plugin_insn_vaddr(instruction: *const Instruction) -> u64;
    pub fn qemu_plugin_register_vcpu_tb_exec_cb(
        block: *mut Block,
        call: unsafe extern "C" fn(c_uint, *mut c_void),
        flags: c_int,
        data: *mut c_void,
    );
    pub fn qemu_plugin_register_vcpu_insn_exec_cb(
        instruction: *mut Instruction,
        call: unsafe extern "C" fn(c_uint, *mut c_void),
        flags: c_int,
        data: *mut c_void,
    );
    pub fn qemu_plugin_register_vcpu_insn_exec_inline(
        instruction: *mut Instruction,
        operation: c_int,
        place: *mut c_void,
        value: u64,
    );
    pub fn qemu_plugin_register_vcpu_mem_cb(
        instruction: *mut Instruction,
        call: unsafe extern "C" fn(c_uint, u32, u64, *mut c_void),
        flags: c_int,
        accesses: c_int,
        data: *mut c_void,
    );
    pub fn qemu_plugin_outs(text: *const c_char);
}
