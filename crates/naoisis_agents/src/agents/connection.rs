//! A connection to a program: messages in either encoding, bounded in length, with deadlines.

use core::time::Duration;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::io::{self, Read, Write};
use std::net::{Shutdown, TcpStream};
#[cfg(unix)]
use std::os::unix::net::UnixStream;
use std::time::Instant;

pub use super::loss::Loss;
use super::message::{read_message, write_message};
#[cfg(unix)]
use super::pipes::Pipes;
use super::protocol::Encoding;
use super::settings::{BreakOff, LOOK};
use naoisis_core::events::AgentLoss;

/// The number of bytes that one read asks for.
const CHUNK: usize = 4 << 10;
/// The mark with which some editors and languages begin UTF-8 text.
const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";
/// The error message of a program that misses a deadline.
const TOO_LATE: &str = "it did not answer in time";

/// A stream of bytes to and from a program.
#[derive(Debug)]
pub enum Stream {
    /// The pipes of a process.
    #[cfg(unix)]
    Pipes(Pipes),
    /// A Unix socket.
    #[cfg(unix)]
    Unix(UnixStream),
    /// A TCP socket.
    Tcp(TcpStream),
}

/// Runs the first expression for either kind of socket, the second for pipes.
macro_rules! with_stream {
    ($stream:expr, $pipes:ident => $act_on_pipes:expr, $socket:ident => $act:expr) => {
        match $stream {
            #[cfg(unix)]
            Stream::Pipes($pipes) => $act_on_pipes,
            #[cfg(unix)]
            Stream::Unix($socket) => $act,
            Stream::Tcp($socket) => $act,
        }
    };
}

impl Stream {
    /// Sets the longest time that a read or write of a socket waits. Pipes have a limit of their own.
    fn set_timeouts(&self, time: Duration) -> io::Result<()> {
        let time = Some(time);
        with_stream!(self, _pipes => Ok(()),
            socket => socket.set_read_timeout(time).and_then(|()| socket.set_write_timeout(time)))
    }

    /// Sets whether reads of sockets return at once.
    fn set_nonblocking(&self, nonblocking: bool) -> io::Result<()> {
        with_stream!(self, _pipes => Ok(()), socket => socket.set_nonblocking(nonblocking))
    }

    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        with_stream!(self, pipes => pipes.read(bytes), socket => socket.read(bytes))
    }

    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        with_stream!(self, pipes => pipes.write(bytes), socket => socket.write(bytes))
    }

    /// Closes the direction to the program: nothing more will be sent.
    fn end_writing(&mut self) {
        // The program may have closed the connection already.
        let _ =
            with_stream!(self, pipes => { pipes.close_input(); Ok(()) }, socket => socket.shutdown(Shutdown::Write));
    }
}

/// A connection to a program.
#[derive(Debug)]
pub struct Connection {
    stream: Stream,
    encoding: Encoding,
    /// The longest message that is accepted, bytes.
    longest: usize,
    /// Bytes that were received and not yet read as messages.
    received: Vec<u8>,
    /// The length of the part of `received` that is known to have no end of line.
    searched: usize,
    /// Whether a byte order mark may still come.
    may_be_marked: bool,
    outgoing: Vec<u8>,
    /// Whether reads and writes return regularly, so that the clock can be checked.
    looks: bool,
    break_off: Option<BreakOff>,
}

impl Connection {
    /// Creates a connection over `stream`, which starts with lines of JSON. Waiting ends when `break_off` returns that the match is broken
    /// off.
    pub fn new(stream: Stream, longest: usize, break_off: Option<BreakOff>) -> Self {
        let (encoding, received, outgoing) = (Encoding::Json, Vec::new(), Vec::new());
        Self {
            stream,
            encoding,
            longest,
            received,
            searched: 0,
            may_be_marked: true,
            outgoing,
            looks: false,
            break_off,
        }
    }

    /// Sets the encoding of all further messages.
    pub fn set_encoding(&mut self, encoding: Encoding) {
        self.encoding = encoding;
    }

    /// Sends a message.
    ///
    /// # Errors
    /// If the program does not accept the message by the deadline.
    pub fn send(&mut self, message: &impl Serialize, deadline: Option<Instant>) -> Result<(), Loss> {
        self.outgoing.clear();
        write_message(self.encoding, message, &mut self.outgoing)?;
        self.look()?;
        let mut sent = 0;
        while sent < self.outgoing.len() {
            match self.stream.write(&self.outgoing[sent..]) {
                Ok(0) => return Err(Loss::new(AgentLoss::Closed, "it has hung up")),
                Ok(count) => sent += count,
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) if is_silence(&error) => {
                    self.wait_on(deadline, "it does not read the messages that it is sent")?;
                }
                Err(_) => return Err(Loss::new(AgentLoss::Closed, "it has hung up")),
            }
        }
        Ok(())
    }

    /// Receives a message.
    ///
    /// # Errors
    /// If no message arrives by the deadline, or it is not of type `T`.
    pub fn receive<T: DeserializeOwned>(&mut self, deadline: Option<Instant>) -> Result<T, Loss> {
        let mut may_have_more = true;
        loop {
            if let Some((start, end, next)) = self.next_message()? {
                let bytes = &self.received[start..end];
                let message = read_message(self.encoding, bytes);
                self.received.drain(..next);
                self.searched = 0;
                self.may_be_marked = false;
                return message;
            }
            // A program that sends a few bytes now and then has no more time than others.
            if !may_have_more {
                self.wait_on(deadline, TOO_LATE)?;
            }
            may_have_more = self.read_more(deadline)? == CHUNK;
        }
    }

    /// Whether [`receive`](Self::receive) would return at once, with a message or with an error. Does not wait on
    /// sockets.
    pub fn is_ready(&mut self) -> bool {
        let is_broken = self.stream.set_nonblocking(true).is_err();
        let is_ready = is_broken || self.has_message_or_end();
        self.stream.set_nonblocking(false).is_err() || is_ready
    }

    /// Whether [`receive`](Self::receive) would return at once. Waits up to 20 ms.
    pub fn is_ready_soon(&mut self) -> bool {
        self.has_message_or_end()
    }

    /// Whether the program has closed the connection. Call it only while no message of the program is awaited.
    pub fn has_hung_up(&mut self) -> bool {
        self.is_ready() && !matches!(self.next_message(), Ok(Some(_)))
    }

    fn has_message_or_end(&mut self) -> bool {
        loop {
            if !matches!(self.next_message(), Ok(None)) {
                return true;
            }
            match self.read_more(Some(Instant::now())) {
                Ok(_) => {}
                Err(loss) => return loss.reason != AgentLoss::TimedOut,
            }
        }
    }

    /// Waits until the program closes the connection. Ignores anything that it still sends.
    pub fn wait_for_end(&mut self, deadline: Option<Instant>) {
        self.stream.end_writing();
        loop {
            self.received.clear();
            if self.read_more(deadline).is_err() || deadline.is_some_and(|deadline| deadline <= Instant::now()) {
                break;
            }
        }
    }

    /// Drops a byte order mark before the first message, and empty lines before any, as some languages and consoles write them.
    fn drop_what_is_before_a_line(&mut self) {
        let is_marked = self.may_be_marked && self.received.starts_with(BYTE_ORDER_MARK);
        let mark = if is_marked { BYTE_ORDER_MARK.len() } else { 0 };
        let empty = self.received[mark..].iter().take_while(|byte| byte.is_ascii_whitespace()).count();
        if mark + empty > 0 {
            self.received.drain(..mark + empty);
            self.searched = 0;
        }
    }

    /// The start and the end of the first message in `received`, and the start of the next. `None` if the message is
    /// incomplete.
    fn next_message(&mut self) -> Result<Option<(usize, usize, usize)>, Loss> {
        let longest = self.longest;
        let too_long =
            || Loss::new(AgentLoss::TooLong, format!("it sent a message of more than {longest} bytes; expected fewer"));
        match self.encoding {
            Encoding::Json => {
                self.drop_what_is_before_a_line();
                let end = self.received[self.searched..].iter().position(|&byte| byte == b'\n');
                match end.map(|end| self.searched + end) {
                    Some(end) if end <= longest => Ok(Some((0, end, end + 1))),
                    None if self.received.len() <= longest => {
                        self.searched = self.received.len();
                        Ok(None)
                    }
                    _ => Err(too_long()),
                }
            }
            Encoding::Msgpack => {
                let Some((length, rest)) = self.received.split_first_chunk::<4>() else { return Ok(None) };
                let length = u32::from_be_bytes(*length) as usize;
                if length > longest {
                    return Err(too_long());
                }
                Ok((rest.len() >= length).then_some((4, 4 + length, 4 + length)))
            }
        }
    }

    /// Reads available bytes, or waits for some. Returns their number. Bytes that are available are read even after the
    /// deadline.
    fn read_more(&mut self, deadline: Option<Instant>) -> Result<usize, Loss> {
        self.look()?;
        let before = self.received.len();
        self.received.resize(before + CHUNK, 0);
        let read = loop {
            match self.stream.read(&mut self.received[before..]) {
                Ok(0) if before > 0 => {
                    break Err(Loss::new(AgentLoss::Closed, "it closed the connection in the middle of a message"));
                }
                Ok(0) => break Err(Loss::new(AgentLoss::Closed, "it has hung up")),
                Ok(count) => break Ok(count),
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) if is_silence(&error) => {
                    if let Err(loss) = self.wait_on(deadline, TOO_LATE) {
                        break Err(loss);
                    }
                }
                Err(_) => break Err(Loss::new(AgentLoss::Closed, "it has hung up")),
            }
        };
        self.received.truncate(before + *read.as_ref().unwrap_or(&0));
        read
    }

    /// Makes reads and writes return regularly.
    fn look(&mut self) -> Result<(), Loss> {
        if !self.looks {
            self.stream.set_timeouts(LOOK).map_err(|_| Loss::new(AgentLoss::Closed, "it has hung up"))?;
            self.looks = true;
        }
        Ok(())
    }

    /// Checks whether to continue waiting for a program.
    ///
    /// # Errors
    /// With the message `too_late` after the deadline, or if the match is broken off.
    fn wait_on(&self, deadline: Option<Instant>, too_late: &str) -> Result<(), Loss> {
        if deadline.is_some_and(|deadline| deadline <= Instant::now()) {
            return Err(Loss::new(AgentLoss::TimedOut, too_late));
        }
        match &self.break_off {
            Some(BreakOff(is_broken_off)) if is_broken_off() => {
                Err(Loss::new(AgentLoss::TimedOut, "the match was broken off while it waited for the program"))
            }
            _ => Ok(()),
        }
    }
}

/// Whether the error means that nothing happened for a while.
fn is_silence(error: &io::Error) -> bool {
    matches!(error.kind(), io::ErrorKind::WouldBlock | io::ErrorKind::TimedOut)
}

#[cfg(test)]
#[cfg(unix)]
mod tests {
    use super::super::protocol::Answer;
    use super::*;
    use serde_json::json;

    /// A connection, and the program's end of the connection.
    fn pair() -> (Connection, UnixStream) {
        let (here, there) = UnixStream::pair().unwrap();
        (Connection::new(Stream::Unix(here), 1000, None), there)
    }

    /// The message received from a program that sends these bytes and then closes the connection.
    fn received(encoding: Encoding, bytes: &[u8]) -> Result<Answer, Loss> {
        let (mut connection, mut program) = pair();
        connection.set_encoding(encoding);
        program.write_all(bytes).unwrap();
        drop(program);
        connection.receive(None)
    }

    #[test]
    fn messages_arrive_in_either_encoding_however_they_are_cut() {
        let answer = Answer { cycle: 7, ..Answer::default() };
        for encoding in [Encoding::Json, Encoding::Msgpack] {
            let (mut here, there) = pair();
            let mut program = Connection::new(Stream::Unix(there), 1000, None);
            here.set_encoding(encoding);
            program.set_encoding(encoding);
            program.send(&json!({ "cycle": 6 }), None).unwrap();
            program.send(&answer, None).unwrap();
            assert_eq!(here.receive::<Answer>(None).unwrap().cycle, 6);
            assert_eq!(here.receive::<Answer>(None), Ok(answer.clone()));
        }
        let (mut here, mut program) = pair();
        let writer = std::thread::spawn(move || {
            for byte in b"{\"cycle\":3}\n" {
                program.write_all(&[*byte]).unwrap();
            }
        });
        assert_eq!(here.receive::<Answer>(None).unwrap().cycle, 3);
        writer.join().unwrap();
    }

    #[test]
    fn empty_lines_a_mark_at_the_beginning_and_windows_ends_are_no_messages() {
        let (mut here, mut program) = pair();
        let writer = std::thread::spawn(move || {
            for byte in b"\xef\xbb\xbf\r\n\n \n{\"cycle\":3}\r\n\r\n \n{\"cycle\":4}\r\n\r\n" {
                program.write_all(&[*byte]).unwrap();
            }
        });
        let cycles = [here.receive::<Answer>(None), here.receive::<Answer>(None)].map(|answer| answer.unwrap().cycle);
        assert_eq!(cycles, [3, 4]);
        writer.join().unwrap();
        assert_eq!(here.receive::<Answer>(None).unwrap_err().reason, AgentLoss::Closed);
        // A mark is not expected later.
        let late = b"{\"cycle\":3}\n\xef\xbb\xbf{\"cycle\":4}\n";
        let (mut here, mut program) = pair();
        program.write_all(late).unwrap();
        assert_eq!(here.receive::<Answer>(None).unwrap().cycle, 3);
        assert_eq!(here.receive::<Answer>(None).unwrap_err().reason, AgentLoss::Malformed);
    }

    #[test]
    fn what_is_no_message_is_told_from_what_never_comes() {
        let reason = |encoding, bytes: &[u8]| received(encoding, bytes).unwrap_err().reason;
        let json = |text: &str| reason(Encoding::Json, text.as_bytes());
        assert_eq!(json(""), AgentLoss::Closed);
        assert_eq!(json("{\"cycle\":"), AgentLoss::Closed);
        assert_eq!(json("Hello, world!\n"), AgentLoss::Malformed);
        assert_eq!(json("{\"cycle\":-1}\n"), AgentLoss::Malformed);
        // A list is not an object, not even an empty one.
        for list in ["[1]", "{\"cycle\":1,\"command\":[]}", "{\"cycle\":1,\"command\":{\"kick\":[\"left_side\"]}}"] {
            assert_eq!(json(&format!("{list}\n")), AgentLoss::Malformed, "{list}");
        }
        assert_eq!(json(&format!("{}\n", "[".repeat(900))), AgentLoss::Malformed);
        assert_eq!(json(&"x".repeat(2000)), AgentLoss::TooLong);
        assert_eq!(reason(Encoding::Json, b"{\"cycle\":1,\"\xff\":2}\n"), AgentLoss::Malformed);
        let message_pack = |bytes: &[u8]| reason(Encoding::Msgpack, bytes);
        assert_eq!(message_pack(&[0xff; 4]), AgentLoss::TooLong);
        assert_eq!(message_pack(&[0, 0, 0, 9, 1]), AgentLoss::Closed);
        assert_eq!(message_pack(&[0, 0, 0, 1, 0xc1]), AgentLoss::Malformed);
        assert_eq!(message_pack(&[0, 0, 0, 2, 0x91, 1]), AgentLoss::Malformed);
        // A list with a declared length of four thousand million, and deeply nested lists.
        assert_eq!(message_pack(&[0, 0, 0, 5, 0xdd, 0xff, 0xff, 0xff, 0xff]), AgentLoss::Malformed);
        assert_eq!(message_pack(&[&[0, 0, 1, 0][..], &[0x91; 256]].concat()), AgentLoss::Malformed);
    }

    #[test]
    fn who_is_silent_is_too_late_and_who_does_not_listen_too() {
        let (mut connection, program) = pair();
        let soon = || Some(Instant::now() + Duration::from_millis(5));
        assert_eq!(connection.receive::<Answer>(soon()).unwrap_err().reason, AgentLoss::TimedOut);
        let large = "x".repeat(1 << 20);
        assert_eq!(connection.send(&large, soon()).unwrap_err().reason, AgentLoss::TimedOut);
        drop(program);
    }

    #[test]
    fn what_is_there_is_taken_however_late_and_a_part_of_it_is_not_waited_for() {
        let (mut connection, mut program) = pair();
        let now = Some(Instant::now());
        let answer = format!("{{\"cycle\":3{}}}\n", " ".repeat(900));
        program.write_all(answer.as_bytes()).unwrap();
        program.write_all(b"{\"cycle\":").unwrap();
        assert_eq!(connection.receive::<Answer>(now).unwrap().cycle, 3);
        assert_eq!(connection.receive::<Answer>(now).unwrap_err().reason, AgentLoss::TimedOut);
    }

    #[test]
    fn nobody_is_waited_for_when_the_match_is_broken_off() {
        let (here, _program) = UnixStream::pair().unwrap();
        let break_off = BreakOff(std::sync::Arc::new(|| true));
        let mut connection = Connection::new(Stream::Unix(here), 1000, Some(break_off));
        let loss = connection.receive::<Answer>(None).unwrap_err();
        assert!(loss.reason == AgentLoss::TimedOut && loss.message.contains("broken off"), "{loss}");
        let loss = connection.send(&"x".repeat(1 << 20), None).unwrap_err();
        assert!(loss.reason == AgentLoss::TimedOut && loss.message.contains("broken off"), "{loss}");
    }

    #[test]
    fn what_is_wrong_with_an_answer_is_said_in_words() {
        let wrong = received(Encoding::Json, b"{\"cycle\": 1, \"comand\": {}}\n").unwrap_err().to_string();
        assert!(wrong.contains("there is no field `comand`: did you mean `command`?"), "{wrong}");
    }
}
