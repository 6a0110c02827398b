//! Entry points of the device.

use super::{Direct, Mesh, SAFETY, STEPS, Sheet, Step, element, node};
use crumple_fem::elements::thread_shell::ThreadShell;
use std::arch::asm;
use std::sync::atomic::{AtomicUsize, Ordering};

unsafe extern "C" {
    #[link_name = "llvm.nvvm.read.ptx.sreg.tid.x"]
    fn thread_index() -> i32;
    #[link_name = "llvm.nvvm.read.ptx.sreg.ntid.x"]
    fn block_size() -> i32;
    #[link_name = "llvm.nvvm.read.ptx.sreg.ctaid.x"]
    fn block_index() -> i32;
    #[link_name = "llvm.trap"]
    fn trap() -> !;
}

/// Returns the index of this thread over all blocks.
fn index() -> usize {
    // SAFETY: these only read registers.
    unsafe { block_index() as usize * block_size() as usize + thread_index() as usize }
}

/// Builds the shells at `place`, which has room for `room` bytes; one thread.
///
/// # Safety
/// `place` is valid for these bytes and aligned.
#[unsafe(no_mangle)]
pub unsafe extern "ptx-kernel" fn build(
    sheet: &Sheet,
    place: *mut ThreadShell,
    columns: &mut u64,
    room: u32,
) {
    if size_of::<ThreadShell>() <= room as usize {
        let shell = sheet.shell();
        *columns = shell.columns() as u64;
        // SAFETY: as the caller promises.
        unsafe { place.write(shell) };
    }
}

/// Returns the least number of the threads of a warp.
fn least_of_warp(value: f64) -> f64 {
    let mut least = value;
    for distance in [16u32, 8, 4, 2, 1] {
        let bits = least.to_bits();
        let (low, high) = (bits as u32, (bits >> 32) as u32);
        let (other_low, other_high): (u32, u32);
        // SAFETY: all threads of the warp take part: blocks have whole warps, and none returns
        // before.
        unsafe {
            asm!("shfl.sync.bfly.b32 {0}, {1}, {2}, 0x1f, 0xffffffff;",
                out(reg32) other_low, in(reg32) low, in(reg32) distance);
            asm!("shfl.sync.bfly.b32 {0}, {1}, {2}, 0x1f, 0xffffffff;",
                out(reg32) other_high, in(reg32) high, in(reg32) distance);
        }
        let other = f64::from_bits(u64::from(other_high) << 32 | u64::from(other_low));
        if other < least {
            least = other;
        }
    }
    least
}

macro_rules! elements {
    ($name:ident, $scalar:ty) => {
        /// Computes all elements, in blocks of whole warps.
        ///
        /// # Safety
        /// As for [`element`].
        #[unsafe(no_mangle)]
        pub unsafe extern "ptx-kernel" fn $name(shell: &ThreadShell, mesh: &Mesh, step: &Step) {
            // SAFETY: as the caller promises; each thread has an element of its own.
            unsafe {
                let i = index();
                let mut stable_dt = f64::INFINITY;
                if i < mesh.count {
                    stable_dt = element::<$scalar>(shell, mesh, i, step.dt);
                }
                let least = least_of_warp(stable_dt);
                if thread_index() % 32 == 0 {
                    step.least.fetch_min(least.to_bits(), Ordering::Relaxed);
                }
            }
        }
    };
}
elements!(elements_direct, Direct);
elements!(elements_table, f64);

/// Assembles and moves all nodes, and prepares the next step.
///
/// # Safety
/// As for [`node`]; `steps` are [`STEPS`] steps.
#[unsafe(no_mangle)]
pub unsafe extern "ptx-kernel" fn nodes(mesh: &Mesh, steps: *mut Step, now: u32) {
    // SAFETY: as the caller promises; each thread has a node of its own, and only one writes the
    // next step, which no thread reads.
    unsafe {
        let i = index();
        let step = &*steps.add((now % STEPS) as usize);
        let last = step.dt;
        let dt = SAFETY * f64::from_bits(step.least.load(Ordering::Relaxed));
        if i < mesh.nodes {
            node(mesh, i, 0.5 * (last + dt), dt);
        }
        if i == 0 {
            let next = &mut *steps.add(((now + 1) % STEPS) as usize);
            *next = Step::new(dt);
        }
    }
}

/// Memory of the shells, which is never freed.
#[repr(align(16))]
struct Heap {
    _bytes: [u8; HEAP_BYTES],
}
const HEAP_BYTES: usize = 1 << 20;
static mut HEAP: Heap = Heap { _bytes: [0; HEAP_BYTES] };
static USED: AtomicUsize = AtomicUsize::new(0);

#[unsafe(no_mangle)]
extern "C" fn sys_alloc_aligned(bytes: usize, align: usize) -> *mut u8 {
    let room = bytes + align;
    let first = USED.fetch_add(room, Ordering::Relaxed);
    if first + room > HEAP_BYTES {
        return std::ptr::null_mut();
    }
    // SAFETY: each call has a part of its own.
    unsafe {
        let at = (&raw mut HEAP).cast::<u8>().add(first);
        at.add(at.align_offset(align))
    }
}

macro_rules! absent {
    ($($name:ident($($arg:ident: $of:ty),*) -> $out:ty;)*) => {$(
        #[unsafe(no_mangle)]
        extern "C" fn $name($($arg: $of),*) -> $out {
            $(let _ = $arg;)*
            // SAFETY: it ends the kernel.
            unsafe { trap() }
        }
    )*};
}
// The standard library asks these of its system. A device has none of them.
absent! {
    sys_halt() -> ();
    sys_rand(buffer: *mut u32, words: usize) -> ();
    sys_panic(message: *const u8, length: usize) -> ();
    sys_log(message: *const u8, length: usize) -> ();
    sys_read(file: u32, buffer: *mut u8, length: usize) -> usize;
    sys_write(file: u32, buffer: *const u8, length: usize) -> ();
    sys_getenv(buffer: *mut u32, words: usize, name: *const u8, length: usize) -> usize;
    sys_argc() -> usize;
    sys_argv(words: *mut u32, length: usize, index: usize) -> usize;
    sys_alloc_words(words: usize) -> *mut u32;
}

/// Compares bytes; the standard library expects it of its system.
#[unsafe(no_mangle)]
unsafe extern "C" fn memcmp(a: *const u8, b: *const u8, length: usize) -> i32 {
    for i in 0..length {
        // SAFETY: the caller gives two places of this length. Without volatile reads the compiler
        // would make a call of this function of the loop.
        let (x, y) = unsafe { (a.add(i).read_volatile(), b.add(i).read_volatile()) };
        if x != y {
            return i32::from(x) - i32::from(y);
        }
    }
    0
}
