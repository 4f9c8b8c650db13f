//! Independent tasks on several threads: results in the order of the inputs, the same bits for any number of threads.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

/// Stack of a thread, bytes: that of the main thread on Linux.
const STACK_BYTES: usize = 8 << 20;

/// Requested number of threads; zero for one on each core.
static REQUESTED: AtomicUsize = AtomicUsize::new(0);

/// Started by the first work that uses it: most commands are done before threads would be.
static POOL: OnceLock<Option<ThreadPool>> = OnceLock::new();

/// Sets the number of threads of the process, by default one for each core. It holds from the first work on several threads on;
/// after that, one thread can still be requested.
pub fn set_threads(threads: usize) {
    REQUESTED.store(threads, Ordering::Relaxed);
}

/// Number of threads that work.
pub fn threads() -> usize {
    static CORES: OnceLock<usize> = OnceLock::new();
    match REQUESTED.load(Ordering::Relaxed) {
        0 => *CORES.get_or_init(|| std::thread::available_parallelism().map_or(1, usize::from)),
        requested => requested,
    }
}

/// The threads, where several tasks are to share several of them.
fn pool(tasks: usize) -> Option<&'static ThreadPool> {
    if tasks < 2 || threads() == 1 {
        return None;
    }
    let start = || {
        let builder = ThreadPoolBuilder::new()
            .num_threads(threads())
            .stack_size(STACK_BYTES);
        // Where the system starts no threads, the caller's does the work.
        builder.build().ok()
    };
    POOL.get_or_init(start).as_ref()
}

/// `f` of every item, in their order.
pub fn map<T: Sync, R: Send>(items: &[T], f: impl Fn(&T) -> R + Sync + Send) -> Vec<R> {
    match pool(items.len()) {
        None => items.iter().map(f).collect(),
        Some(pool) => pool.install(|| items.par_iter().with_max_len(1).map(f).collect()),
    }
}

/// `f` of every item, in their order.
///
/// # Errors
/// That of the first item that has one.
pub fn try_map<T: Sync, R: Send, E: Send>(
    items: &[T],
    f: impl Fn(&T) -> Result<R, E> + Sync + Send,
) -> Result<Vec<R>, E> {
    match pool(items.len()) {
        None => items.iter().map(f).collect(),
        // All are carried out: which of several errors came first would be chance.
        Some(_) => map(items, f).into_iter().collect(),
    }
}

/// Changes every item by `f`.
pub fn for_each<T: Send>(items: &mut [T], f: impl Fn(&mut T) + Sync + Send) {
    match pool(items.len()) {
        None => items.iter_mut().for_each(f),
        Some(pool) => pool.install(|| items.par_iter_mut().with_max_len(1).for_each(f)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Results stand in the order of the inputs, and of several errors the first is returned, on one thread and on several.
    #[test]
    fn law_order_is_that_of_the_inputs() {
        let items: Vec<u64> = (0..1000).collect();
        for threads in [1, 3] {
            set_threads(threads);
            let squares = map(&items, |x| x * x);
            assert!(squares.iter().zip(&items).all(|(y, x)| *y == x * x));
            let odd = try_map(&items, |&x| if x % 7 == 3 { Err(x) } else { Ok(x) });
            assert_eq!(odd, Err(3));
            let mut changed = items.clone();
            for_each(&mut changed, |x| *x += 1);
            assert_eq!(changed, (1..=1000).collect::<Vec<u64>>());
        }
        set_threads(0);
    }
}
