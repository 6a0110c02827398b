//! One kernel, done a few times under an instruction counter: `deploy/instructions.sh` counts what happens in `counted`.
//!
//! `instructions NAME TIMES` does the kernel; `instructions` alone lists kernels as `NAME COUNT WHAT`.

mod work;

use work::{KERNELS, Work};

/// What the counter looks for: its name is found among the program's symbols.
#[inline(never)]
fn counted(work: &mut Work, times: usize) {
    (0..times).for_each(|_| work());
}

fn main() {
    // `cargo bench` and `cargo test --benches` add flags of their own.
    let words: Vec<String> = std::env::args().skip(1).filter(|word| !word.starts_with("--")).collect();
    let Some(name) = words.first() else {
        KERNELS.iter().for_each(|k| println!("{} {} {}", k.name, k.of.1, k.of.0));
        return;
    };
    let Some(kernel) = KERNELS.iter().find(|k| k.name == name) else {
        eprintln!("error: there is no kernel '{name}'; `instructions` alone lists them");
        std::process::exit(2);
    };
    let mut work = (kernel.ready)();
    // Once before: buffers have their size then.
    work();
    counted(&mut work, words.get(1).and_then(|times| times.parse().ok()).unwrap_or(1));
}
