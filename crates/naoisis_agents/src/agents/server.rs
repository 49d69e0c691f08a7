//! A server that programs connect to, over TCP or a Unix socket.

use bevy::prelude::*;
use core::fmt;
use core::str::FromStr;
use core::time::Duration;
use std::io;
use std::net::{SocketAddr, TcpListener, ToSocketAddrs};
#[cfg(unix)]
use std::os::unix::fs::FileTypeExt;
#[cfg(unix)]
use std::os::unix::net::{UnixListener, UnixStream};
#[cfg(unix)]
use std::path::Path;
use std::path::PathBuf;
use std::thread;
use std::time::Instant;

use super::connection::{Connection, Stream};
use super::loss::Loss;
use super::player::{Agent, AgentPlayer};
use super::protocol::Hello;
use super::remote::{PlayedElsewhere, remote_robots};
use super::settings::AgentSettings;
use super::start::begin;
use naoisis_core::behaviour::Program;
use naoisis_core::robot::Roster;
use naoisis_core::team::RobotId;
use naoisis_sim::scenario::wording::one_of;

/// The time between two checks for new connections.
const LOOK: Duration = Duration::from_millis(2);
/// The greatest number of programs that are connected before their hello. Further ones wait.
const MOST_SILENT: usize = 256;
/// The reason for refusing a program when no robot is free.
const ALL_PLAYED: &str = "all remote robots of the match are taken";

/// The address of a match: `tcp:127.0.0.1:10000` (port 0 is any free port) or `unix:PATH`.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum Address {
    /// A port of a network interface.
    Tcp(SocketAddr),
    /// A socket in the file system.
    Unix(PathBuf),
}

impl Address {
    /// Whether other machines can reach it.
    pub fn is_reachable(&self) -> bool {
        matches!(self, Address::Tcp(address) if !address.ip().to_canonical().is_loopback())
    }
}

/// The error that a text is no address.
#[derive(Clone, PartialEq, Eq, thiserror::Error)]
#[error("expected tcp:HOST:PORT, such as tcp:127.0.0.1:10000, or unix:PATH")]
pub struct NotAnAddress;

naoisis_core::debug_as_displayed!(NotAnAddress);

impl FromStr for Address {
    type Err = NotAnAddress;

    fn from_str(word: &str) -> Result<Self, NotAnAddress> {
        match word.split_once(':') {
            Some(("tcp", place)) => {
                let mut addresses = place.to_socket_addrs().map_err(|_| NotAnAddress)?;
                addresses.next().map(Address::Tcp).ok_or(NotAnAddress)
            }
            Some(("unix", path)) if cfg!(unix) && !path.is_empty() => Ok(Address::Unix(path.into())),
            _ => Err(NotAnAddress),
        }
    }
}

impl fmt::Display for Address {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Address::Tcp(address) => write!(formatter, "tcp:{address}"),
            Address::Unix(path) => write!(formatter, "unix:{}", path.display()),
        }
    }
}

/// Accepts connections of programs.
#[derive(Debug)]
pub struct Server {
    listener: Listener,
    address: Address,
    /// The programs that have connected and not said hello yet.
    silent: Vec<Agent>,
}

#[derive(Debug)]
enum Listener {
    Tcp(TcpListener),
    #[cfg(unix)]
    Unix(UnixListener),
}

impl Listener {
    fn accept(&self) -> io::Result<Stream> {
        match self {
            Listener::Tcp(listener) => listener.accept().and_then(|(stream, _)| {
                stream.set_nonblocking(false)?;
                stream.set_nodelay(true)?;
                Ok(Stream::Tcp(stream))
            }),
            #[cfg(unix)]
            Listener::Unix(listener) => listener.accept().and_then(|(stream, _)| {
                stream.set_nonblocking(false)?;
                Ok(Stream::Unix(stream))
            }),
        }
    }
}

impl Server {
    /// Listens at an address.
    ///
    /// # Errors
    /// If the system refuses, for example because another program listens there.
    pub fn listen(address: &Address) -> io::Result<Self> {
        let (listener, address) = match address {
            Address::Tcp(address) => {
                let listener = TcpListener::bind(address)?;
                listener.set_nonblocking(true)?;
                let address = Address::Tcp(listener.local_addr()?);
                (Listener::Tcp(listener), address)
            }
            #[cfg(unix)]
            Address::Unix(path) => {
                let listener = UnixListener::bind(path).or_else(|error| match is_left_over(path) {
                    true => std::fs::remove_file(path).and_then(|()| UnixListener::bind(path)),
                    false => Err(error),
                })?;
                listener.set_nonblocking(true)?;
                (Listener::Unix(listener), address.clone())
            }
            #[cfg(not(unix))]
            Address::Unix(_) => return Err(io::ErrorKind::Unsupported.into()),
        };
        Ok(Self { listener, address, silent: Vec::new() })
    }

    /// The address, with the actual port if any free port was asked for.
    pub fn address(&self) -> &Address {
        &self.address
    }

    /// Accepts programs until every remote robot of the match is played, or `is_enough` returns true. A program that stays silent does not
    /// delay the others. `said` receives messages about programs that connect.
    pub fn let_in(&mut self, world: &mut World, is_enough: impl Fn() -> bool, mut said: impl FnMut(&str)) {
        while !is_enough() && !free_robots(world).is_empty() {
            for robot in leave(world) {
                said(&format!("{robot} is free again: its program closed the connection"));
            }
            self.look(world, &mut said);
            thread::sleep(LOOK);
        }
        for mut agent in self.silent.drain(..) {
            agent.refuse(ALL_PLAYED.to_owned());
        }
    }

    /// Accepts programs that have connected and said hello by now, without waiting: for robots whose programs were lost. Other programs are
    /// refused in words. `said` receives messages about them.
    pub fn look(&mut self, world: &mut World, mut said: impl FnMut(&str)) {
        let settings = world.resource::<AgentSettings>();
        while self.silent.len() < MOST_SILENT
            && let Ok(stream) = self.listener.accept()
        {
            let connection = Connection::new(stream, settings.longest_message, settings.break_off.clone());
            let deadline = settings.answer_timeout.map(|time| Instant::now() + time);
            self.silent.push(Agent::new(connection, None, deadline));
        }
        if self.silent.is_empty() {
            return;
        }
        let settings = settings.clone();
        // In the order of their connections.
        let spoken: Vec<Agent> = self.silent.extract_if(.., Agent::has_spoken).collect();
        for agent in spoken {
            match introduce(world, agent, &settings) {
                Ok((robot, name)) => said(&format!("{robot} is played by {name}")),
                Err(loss) => said(&format!("a program was refused: {loss}")),
            }
        }
    }
}

/// Whether the socket at `path` was left behind by a program that was killed, so that nothing listens at it.
#[cfg(unix)]
fn is_left_over(path: &Path) -> bool {
    std::fs::symlink_metadata(path).is_ok_and(|file| file.file_type().is_socket())
        && UnixStream::connect(path).is_err_and(|error| error.kind() == io::ErrorKind::ConnectionRefused)
}

impl Drop for Server {
    fn drop(&mut self) {
        if let Address::Unix(path) = &self.address {
            // The file may have been removed already.
            let _ = std::fs::remove_file(path);
        }
    }
}

/// Frees the robots whose programs closed the connection before the match began. Returns these robots.
fn leave(world: &mut World) -> Vec<RobotId> {
    let mut players = world.query::<(Entity, &RobotId, &mut AgentPlayer)>();
    let gone = players.iter_mut(world).filter_map(|(entity, id, mut player)| {
        let has_left = player.0.as_mut().is_some_and(Agent::has_hung_up);
        has_left.then_some((*id, entity))
    });
    let mut gone: Vec<(RobotId, Entity)> = gone.collect();
    gone.sort_by_key(|(id, _)| *id);
    for (_, entity) in &gone {
        world.entity_mut(*entity).remove::<AgentPlayer>();
    }
    gone.into_iter().map(|(id, _)| id).collect()
}

/// The remote robots that no program plays: not yet, or no more.
pub fn free_robots(world: &World) -> Vec<RobotId> {
    let roster = world.resource::<Roster>();
    let is_free = |id: &RobotId| {
        let robot = roster.get(*id).map(|entity| world.entity(entity));
        let is_played = |robot: EntityRef| {
            robot.get().is_some_and(AgentPlayer::has_program)
                || robot.contains::<Program>()
                || robot.contains::<PlayedElsewhere>()
        };
        robot.is_some_and(|robot| !is_played(robot))
    };
    remote_robots(world).into_iter().filter(is_free).collect()
}

/// Lets a program that has connected play the robot that it wants, or else the first free one.
fn introduce(world: &mut World, mut agent: Agent, settings: &AgentSettings) -> Result<(RobotId, String), Loss> {
    let hello = agent.hello()?;
    if settings.token.is_some() && hello.token != settings.token {
        return Err(agent.refuse("its token is wrong; expected that of `naoisis serve --token`".to_owned()));
    }
    let robot = match wanted(world, &hello) {
        Ok(robot) => robot,
        Err(reason) => return Err(agent.refuse(reason)),
    };
    begin(world, robot, &mut agent, &hello)?;
    if let Some(entity) = world.resource::<Roster>().get(robot) {
        world.entity_mut(entity).insert(AgentPlayer(Some(agent)));
    }
    let name = if hello.name.is_empty() { "a program without a name".to_owned() } else { format!("`{}`", hello.name) };
    Ok((robot, name))
}

/// The robot that a program is to play, or why there is none.
fn wanted(world: &World, hello: &Hello) -> Result<RobotId, String> {
    let free = free_robots(world);
    let robot = match hello.robot {
        Some(robot) => free.iter().find(|id| **id == robot),
        None => free.first(),
    };
    robot.copied().ok_or_else(|| {
        if free.is_empty() {
            return ALL_PLAYED.to_owned();
        }
        let free: Vec<String> = free.iter().map(RobotId::to_string).collect();
        let wanted = hello.robot.map(|robot| format!("`{robot}`")).unwrap_or_else(|| "a robot".to_owned());
        format!(
            "{wanted} cannot be played; expected one that is remote and free: {}",
            one_of(free.iter().map(String::as_str))
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_address_is_a_port_or_a_path() {
        assert_eq!("tcp:127.0.0.1:80".parse::<Address>().unwrap().to_string(), "tcp:127.0.0.1:80");
        for word in ["127.0.0.1:80", "tcp:80", "tcp:127.0.0.1", "udp:127.0.0.1:80", "unix:", ""] {
            assert_eq!(word.parse::<Address>(), Err(NotAnAddress), "{word}");
        }
    }

    #[test]
    fn only_addresses_of_this_machine_cannot_be_reached() {
        for (word, is_reachable) in [
            ("tcp:127.0.0.1:80", false),
            ("tcp:127.9.9.9:80", false),
            ("tcp:[::1]:80", false),
            ("tcp:[::ffff:127.0.0.1]:80", false),
            ("tcp:0.0.0.0:80", true),
            ("tcp:[::]:80", true),
            ("tcp:192.168.1.2:80", true),
        ] {
            assert_eq!(word.parse::<Address>().unwrap().is_reachable(), is_reachable, "{word}");
        }
        assert!(!Address::Unix("path".into()).is_reachable());
    }

    #[test]
    #[cfg(unix)]
    fn the_socket_of_somebody_who_was_killed_is_in_nobodys_way() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("socket");
        let listen = || Server::listen(&Address::Unix(path.clone()));
        let alive = UnixListener::bind(&path).unwrap();
        assert_eq!(listen().unwrap_err().kind(), io::ErrorKind::AddrInUse);
        // The file of the socket stays, as after a kill.
        drop(alive);
        assert!(path.exists());
        drop(listen().unwrap());
        // A file that is not a socket belongs to another program.
        std::fs::write(&path, "kept").unwrap();
        assert!(listen().is_err());
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "kept");
    }
}
