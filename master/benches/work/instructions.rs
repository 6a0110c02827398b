//! A kernel under an instruction counter: `deploy/instructions.sh` counts what happens in
//! `counted`.

use super::{KERNELS, Work};

/// Runs a kernel. The counter finds this function by its name among the program's symbols.
#[inline(never)]
fn counted(work: &mut Work, times: usize) {
    (0..times).for_each(|_| work());
}

/// Does a kernel so many times; without a name lists kernels, as `NAME COUNT WHAT`. Returns the
/// exit code.
pub fn run(name: Option<&str>, times: usize) -> i32 {
    let Some(name) = name else {
        KERNELS.iter().for_each(|k| println!("{} {} {}", k.name, k.of.1, k.of.0));
        return 0;
    };
    let Some(kernel) = KERNELS.iter().find(|k| k.name == name) else {
        eprintln!("error: there is no kernel '{name}'; `count` alone lists them");
        return 2;
    };
    let mut work = (kernel.ready)();
    // Once before: buffers have their size then.
    work();
    counted(&mut work, times);
    0
}
