//! The pipes of a process that plays a robot: its standard input and output. They behave like a socket with deadlines, in that reads
//! and writes end now and then, so that somebody can look at the clock.

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::ioctl_fionbio;
use std::io::{self, PipeReader, PipeWriter, Read, Write};
use std::os::fd::AsFd;
use std::process::{Child, Stdio};
use std::sync::{Arc, Mutex, PoisonError};

use super::settings::LOOK;

/// A process, which those who talk to it and those who end it share.
pub type SharedChild = Arc<Mutex<Child>>;

/// The ends of a process's pipes that are here.
#[derive(Debug)]
pub struct Pipes {
    output: PipeReader,
    /// None when it has been told everything.
    input: Option<PipeWriter>,
    /// Whose pipes they are, once it runs.
    child: Option<SharedChild>,
}

impl Pipes {
    /// New pipes, and the process's ends of them: its standard input and its standard output.
    ///
    /// # Errors
    /// When there are no more to be had.
    pub fn new() -> io::Result<(Self, Stdio, Stdio)> {
        let (their_input, input) = io::pipe()?;
        let (output, their_output) = io::pipe()?;
        // Of these ends alone: what the process reads and writes waits, as it expects.
        ioctl_fionbio(&input, true)?;
        ioctl_fionbio(&output, true)?;
        Ok((Self { output, input: Some(input), child: None }, their_input.into(), their_output.into()))
    }

    /// Whose pipes they are.
    pub fn belong_to(&mut self, child: SharedChild) {
        self.child = Some(child);
    }

    /// Reads what there is, or comes soon. There is nothing more to come, as in a file that ends, once the process has ended, even
    /// where something that it has started holds its output open.
    pub fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        match self.output.read(bytes) {
            Err(error) if error.kind() == io::ErrorKind::WouldBlock => {}
            read => return read,
        }
        // Looked at before the last look at the pipe: what it wrote before it ended is there by then.
        let has_ended = !wait(&self.output, PollFlags::IN)? && self.child.as_ref().is_some_and(has_ended);
        match self.output.read(bytes) {
            Err(error) if error.kind() == io::ErrorKind::WouldBlock && has_ended => Ok(0),
            read => read,
        }
    }

    /// Writes what fits now, or soon.
    pub fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let input = self.input.as_mut().ok_or(io::ErrorKind::BrokenPipe)?;
        match input.write(bytes) {
            Err(error) if error.kind() == io::ErrorKind::WouldBlock => {}
            written => return written,
        }
        if !wait(&*input, PollFlags::OUT)? && self.child.as_ref().is_some_and(has_ended) {
            return Err(io::ErrorKind::BrokenPipe.into());
        }
        input.write(bytes)
    }

    /// Tells the process everything that it will be told.
    pub fn close_input(&mut self) {
        self.input = None;
    }
}

/// Waits until something can be done with a pipe, though not for long. Whether it can.
fn wait(pipe: &impl AsFd, what: PollFlags) -> io::Result<bool> {
    let time = Timespec { tv_sec: 0, tv_nsec: i64::from(LOOK.subsec_nanos()) };
    Ok(poll(&mut [PollFd::new(pipe, what)], Some(&time))? > 0)
}

fn has_ended(child: &SharedChild) -> bool {
    let status = child.lock().unwrap_or_else(PoisonError::into_inner).try_wait();
    matches!(status, Ok(Some(_)))
}
