//! touchref as a WebAssembly module.
//!
//! It exports the C interface as `touchref.h` has it, and memory of the module for a host to write texts and structures to.
//! `touchref.mjs` beside it calls them from JavaScript. There are no threads and no files here: a measurement lists its
//! touches, and a fault ends in a trap instead of an error, after which the module is to be loaded anew.
#![allow(unsafe_code)] // For `#[unsafe(no_mangle)]`.

// Puts every function of `touchref.h` into the module.
use touchref_c as _;

/// Memory of the module that a host writes to.
#[derive(Debug)]
pub struct Buffer(Vec<u64>);

/// Makes a buffer of so many bytes, zeros, aligned for every structure of the C interface.
#[unsafe(no_mangle)]
pub extern "C" fn touchref_buffer_new(size: usize) -> Box<Buffer> {
    Box::new(Buffer(vec![0; size.div_ceil(size_of::<u64>())]))
}

/// Where its bytes are.
#[unsafe(no_mangle)]
pub extern "C" fn touchref_buffer_bytes(buffer: Option<&mut Buffer>) -> *mut u64 {
    buffer.map_or(std::ptr::null_mut(), |buffer| buffer.0.as_mut_ptr())
}

/// Frees it.
#[unsafe(no_mangle)]
pub extern "C" fn touchref_buffer_free(buffer: Option<Box<Buffer>>) {
    drop(buffer);
}
