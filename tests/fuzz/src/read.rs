//! The fuzzer's program. `FUZZ_TARGET` names the input, which may take 16 times its bytes and 64
//! MiB. With `FUZZ_SEEDS` and `FUZZ_PROGRAM` it writes seeds of all targets into a folder instead.

#![no_main]

use std::alloc::System;
use std::sync::OnceLock;

use cap::Cap;
use libfuzzer_sys::fuzz_target;
use modalign_fuzz::{Target, names, write_seeds};

/// What takes more ends the process, where the library does not ask for it as `--max-memory` does.
#[global_allocator]
static MEMORY: Cap<System> = Cap::new(System, usize::MAX);

static TARGET: OnceLock<Target> = OnceLock::new();

fn prepare() {
    // The fuzzer sees the branches of this thread alone, and the limit of memory holds at once.
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .use_current_thread();
    pool.build_global().unwrap();
    let [folder, program] = ["FUZZ_SEEDS", "FUZZ_PROGRAM"].map(std::env::var_os);
    if let (Some(folder), Some(program)) = (folder, program) {
        write_seeds(folder.as_ref(), program.as_ref());
        std::process::exit(0);
    }
    let name = std::env::var("FUZZ_TARGET").unwrap_or_default();
    let target = Target::named(&name);
    let target = target
        .unwrap_or_else(|| panic!("FUZZ_TARGET: got {name:?}, expected one of {:?}", names()));
    assert!(TARGET.set(target).is_ok());
}

fuzz_target!(init: prepare(), |input: &[u8]| {
    let limit = MEMORY.allocated() + 16 * input.len() + (64 << 20);
    MEMORY.set_limit(limit).unwrap();
    TARGET.get().unwrap().run(input);
    MEMORY.set_limit(usize::MAX).unwrap();
});
