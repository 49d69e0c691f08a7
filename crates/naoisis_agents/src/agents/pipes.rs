//! The pipes to the standard input and output of a process that plays a robot. They behave like a socket with deadlines: reads and writes
//! return regularly, so that the caller can check the clock.

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::ioctl_fionbio;
use std::io::{self, PipeReader, PipeWriter, Read, Write};
use std::os::fd::AsFd;
use std::process::{Child, Stdio};
use std::sync::{Arc, Mutex, PoisonError};

use super::settings::LOOK;

/// A process that is shared by the code that talks to it and the code that ends it.
pub type SharedChild = Arc<Mutex<Child>>;

/// This side's ends of the pipes of a process.
#[derive(Debug)]
pub struct Pipes {
    output: PipeReader,
    /// The standard input of the process; `None` after it was closed.
    input: Option<PipeWriter>,
    /// The process, once it runs.
    child: Option<SharedChild>,
}

impl Pipes {
    /// Creates pipes. Also returns the ends of the process: its standard input and its standard output.
    ///
    /// # Errors
    /// If the system has no more pipes.
    pub fn new() -> io::Result<(Self, Stdio, Stdio)> {
        let (their_input, input) = io::pipe()?;
        let (output, their_output) = io::pipe()?;
        // Only these ends are non-blocking: reads and writes of the process block, as it expects.
        ioctl_fionbio(&input, true)?;
        ioctl_fionbio(&output, true)?;
        Ok((Self { output, input: Some(input), child: None }, their_input.into(), their_output.into()))
    }

    /// Sets the process to which the pipes belong.
    pub fn belong_to(&mut self, child: SharedChild) {
        self.child = Some(child);
    }

    /// Reads bytes that are available or arrive soon. Returns 0, as at the end of a file, once the process has ended,
    /// even if another process that it started still holds its output open.
    pub fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        match self.output.read(bytes) {
            Err(error) if error.kind() == io::ErrorKind::WouldBlock => {}
            read => return read,
        }
        // Whether the process has ended is checked before the last read: everything it wrote before its end is in the pipe by then.
        let has_ended = !wait(&self.output, PollFlags::IN)? && self.child.as_ref().is_some_and(has_ended);
        match self.output.read(bytes) {
            Err(error) if error.kind() == io::ErrorKind::WouldBlock && has_ended => Ok(0),
            read => read,
        }
    }

    /// Writes the bytes that fit now, or soon.
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

    /// Closes the standard input of the process: nothing more will be sent.
    pub fn close_input(&mut self) {
        self.input = None;
    }
}

/// Waits a short time until a pipe is ready for `what`. Returns whether it is.
fn wait(pipe: &impl AsFd, what: PollFlags) -> io::Result<bool> {
    let time = Timespec { tv_sec: 0, tv_nsec: i64::from(LOOK.subsec_nanos()) };
    Ok(poll(&mut [PollFd::new(pipe, what)], Some(&time))? > 0)
}

fn has_ended(child: &SharedChild) -> bool {
    let status = child.lock().unwrap_or_else(PoisonError::into_inner).try_wait();
    matches!(status, Ok(Some(_)))
}
