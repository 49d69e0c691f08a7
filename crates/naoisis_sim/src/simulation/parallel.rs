//! Plays matches on several threads at the same time.

use core::ops::Range;
use core::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::collections::BTreeMap;
use std::sync::mpsc;
use std::thread;

/// Plays the matches with these `indices` on `threads` threads and passes their results to `finished` in the order of the indices.
///
/// Each thread has its own `worker` and takes the next match when it has finished one. `play` must depend only on the index, so that the
/// results are the same for any number of threads. When `stop` becomes true, the matches under way are finished and no others begin.
///
/// # Errors
/// The first error of `finished`, after which no matches begin.
pub fn play_in_order<W, R: Send, E>(
    indices: Range<usize>,
    threads: usize,
    stop: &AtomicBool,
    worker: impl Fn() -> W + Sync,
    play: impl Fn(&mut W, usize) -> R + Sync,
    mut finished: impl FnMut(R) -> Result<(), E>,
) -> Result<(), E> {
    let mut expected = indices.start;
    let next = AtomicUsize::new(indices.start);
    let (sender, receiver) = mpsc::channel();
    thread::scope(|scope| {
        for _ in 0..threads.clamp(1, indices.len().max(1)) {
            let (sender, next, worker, play, end) = (sender.clone(), &next, &worker, &play, indices.end);
            scope.spawn(move || {
                let mut worker = worker();
                while !stop.load(Ordering::Relaxed) {
                    let index = next.fetch_add(1, Ordering::Relaxed);
                    // The receiver is gone after an error.
                    if index >= end || sender.send((index, play(&mut worker, index))).is_err() {
                        break;
                    }
                }
            });
        }
        drop(sender);
        // Results that are ready too early wait for their turn.
        let mut waiting = BTreeMap::new();
        for (index, result) in receiver {
            waiting.insert(index, result);
            while let Some(result) = waiting.remove(&expected) {
                expected += 1;
                finished(result)?;
            }
        }
        Ok(())
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::convert::Infallible;
    use core::time::Duration;

    #[test]
    fn results_come_in_order_on_any_number_of_threads() {
        for threads in [0, 1, 3, 50] {
            let mut results = Vec::new();
            let play = |(): &mut (), index: usize| {
                // Later matches are ready first.
                thread::sleep(Duration::from_millis(10 - index as u64));
                index * index
            };
            let finished = |result| {
                results.push(result);
                Ok::<(), Infallible>(())
            };
            let Ok(()) = play_in_order(2..9, threads, &AtomicBool::new(false), || (), play, finished);
            assert_eq!(results, [4, 9, 16, 25, 36, 49, 64], "{threads}");
        }
    }

    #[test]
    fn after_an_error_or_a_stop_nothing_begins() {
        let begun = AtomicUsize::new(0);
        let play = |(): &mut (), index: usize| {
            begun.fetch_add(1, Ordering::Relaxed);
            index
        };
        let fails = |index| if index == 3 { Err("the third") } else { Ok(()) };
        assert_eq!(play_in_order(0..usize::MAX, 2, &AtomicBool::new(false), || (), play, fails), Err("the third"));
        let before = begun.load(Ordering::Relaxed);
        let nothing = play_in_order(0..10, 2, &AtomicBool::new(true), || (), play, |_| Err("a result"));
        assert_eq!((nothing, begun.load(Ordering::Relaxed)), (Ok(()), before));
    }
}
