//! Parallel work within a cycle: one job per image. The result does not depend on the number of threads.

use bevy::prelude::*;
use bevy::tasks::{ComputeTaskPool, TaskPool, available_parallelism};
use std::sync::{Mutex, PoisonError};

/// The number of threads on which camera images are drawn and processed. One is best where many matches run at the same time.
#[derive(Resource, Clone, Copy, PartialEq, Eq, Debug)]
pub struct SensingThreads(pub usize);

impl Default for SensingThreads {
    /// One thread per core.
    fn default() -> Self {
        Self(available_parallelism())
    }
}

/// Runs each job once, on up to `threads` threads with a worker each. The workers are kept in `workers` for the next call.
pub fn for_each<W: Default + Send, J: Send>(
    threads: SensingThreads,
    workers: &mut Vec<W>,
    jobs: &mut [J],
    run: impl Fn(&mut W, &mut J) + Sync,
) {
    let count = threads.0.min(jobs.len()).max(1);
    if workers.len() < count {
        workers.resize_with(count, W::default);
    }
    let Some((own, others)) = workers[..count].split_first_mut() else { return };
    if others.is_empty() {
        jobs.iter_mut().for_each(|job| run(own, job));
        return;
    }
    let queue = Mutex::new(jobs.iter_mut());
    let work = |worker: &mut W| {
        loop {
            let job = queue.lock().unwrap_or_else(PoisonError::into_inner).next();
            let Some(job) = job else { break };
            run(worker, job);
        }
    };
    ComputeTaskPool::get_or_init(TaskPool::default).scope(|scope| {
        for worker in others {
            let work = &work;
            scope.spawn(async move { work(worker) });
        }
        work(own);
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_job_is_done_once_on_any_number_of_threads() {
        for threads in [0, 1, 2, 7] {
            let mut jobs: Vec<u32> = (0..100).collect();
            let mut workers: Vec<u32> = Vec::new();
            for_each(SensingThreads(threads), &mut workers, &mut jobs, |worker, job| {
                *worker += 1;
                *job += 1000;
            });
            assert!(jobs.iter().enumerate().all(|(index, job)| *job == 1000 + index as u32));
            assert_eq!(workers.iter().sum::<u32>(), 100);
        }
    }

    #[test]
    fn without_jobs_nothing_is_done() {
        for_each(SensingThreads(2), &mut Vec::<u32>::new(), &mut Vec::<u32>::new(), |_, _| panic!());
    }
}
