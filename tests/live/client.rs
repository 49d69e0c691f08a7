//! A viewer for tests: as much of WebSocket and of Foxglove's protocol (`foxglove.sdk.v1`) as a match is watched with.

use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::time::Duration;

/// What a server sends.
#[derive(Debug)]
pub enum Received {
    /// A message of a channel: its topic, its time and its data.
    Message(String, u64, Vec<u8>),
    /// The answer of a service, or its refusal.
    Answer(Result<(), String>),
    /// The end of the connection.
    End,
}

/// A connection to a live view.
pub struct Viewer {
    stream: BufReader<TcpStream>,
    /// The number and the encoding of each topic.
    pub topics: BTreeMap<String, (u64, String)>,
    services: BTreeMap<String, u64>,
    subscribed: BTreeMap<u32, String>,
    pub info: Value,
}

impl Viewer {
    pub fn connect(address: &str) -> Self {
        let stream = TcpStream::connect(address).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(60))).unwrap();
        let mut viewer = Self {
            stream: BufReader::new(stream),
            topics: BTreeMap::new(),
            services: BTreeMap::new(),
            subscribed: BTreeMap::new(),
            info: Value::Null,
        };
        let request = "GET / HTTP/1.1\r\nHost: naoisis\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n\
                       Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Protocol: foxglove.sdk.v1\r\n\r\n";
        viewer.stream.get_mut().write_all(request.as_bytes()).unwrap();
        let mut line = String::new();
        viewer.stream.read_line(&mut line).unwrap();
        assert!(line.starts_with("HTTP/1.1 101"), "{line}");
        while line != "\r\n" {
            line.clear();
            viewer.stream.read_line(&mut line).unwrap();
        }
        viewer
    }

    /// Reads until all of these topics and services are advertised.
    pub fn await_topics(&mut self, topics: &[&str], services: &[&str]) {
        while !topics.iter().all(|topic| self.topics.contains_key(*topic))
            || !services.iter().all(|name| self.services.contains_key(*name))
        {
            let (opcode, payload) = self.frame().unwrap_or_else(|| panic!("{:?} {:?}", self.topics, self.services));
            if opcode == 1 {
                self.text(serde_json::from_slice(&payload).unwrap());
            }
        }
    }

    pub fn subscribe(&mut self, topics: &[&str]) {
        let subscriptions = topics.iter().map(|topic| {
            let id = self.subscribed.len() as u32 + 1;
            self.subscribed.insert(id, (*topic).to_owned());
            json!({ "id": id, "channelId": self.topics[*topic].0 })
        });
        let subscriptions: Vec<Value> = subscriptions.collect();
        let text = json!({ "op": "subscribe", "subscriptions": subscriptions }).to_string();
        self.send(1, text.as_bytes());
    }

    /// Calls a service and reads until its answer. Messages that come before it are returned, too.
    pub fn call(&mut self, service: &str, request: &Value) -> (Result<(), String>, Vec<Received>) {
        let mut bytes = vec![2];
        bytes.extend((self.services[service] as u32).to_le_bytes());
        bytes.extend(7_u32.to_le_bytes());
        bytes.extend(4_u32.to_le_bytes());
        bytes.extend(b"json");
        bytes.extend(request.to_string().as_bytes());
        self.send(2, &bytes);
        let mut before = Vec::new();
        loop {
            match self.receive() {
                Received::Answer(answer) => return (answer, before),
                Received::End => panic!("the connection ends before the answer of {service}"),
                message => before.push(message),
            }
        }
    }

    /// Reads until there is something for the user of the viewer.
    pub fn receive(&mut self) -> Received {
        loop {
            let Some((opcode, payload)) = self.frame() else { return Received::End };
            match opcode {
                1 => {
                    let value: Value = serde_json::from_slice(&payload).unwrap();
                    if let Some(answer) = self.text(value) {
                        return answer;
                    }
                }
                2 if payload[0] == 1 => {
                    let id = u32::from_le_bytes(payload[1..5].try_into().unwrap());
                    let time_ns = u64::from_le_bytes(payload[5..13].try_into().unwrap());
                    return Received::Message(self.subscribed[&id].clone(), time_ns, payload[13..].to_vec());
                }
                2 if payload[0] == 3 => return Received::Answer(Ok(())),
                8 => return Received::End,
                9 => self.send(10, &payload),
                _ => {}
            }
        }
    }

    fn text(&mut self, value: Value) -> Option<Received> {
        match value["op"].as_str()? {
            "serverInfo" => self.info = value,
            "advertise" => {
                for channel in value["channels"].as_array()? {
                    let encoding = channel["encoding"].as_str()?.to_owned();
                    self.topics.insert(channel["topic"].as_str()?.to_owned(), (channel["id"].as_u64()?, encoding));
                }
            }
            "advertiseServices" => {
                for service in value["services"].as_array()? {
                    self.services.insert(service["name"].as_str()?.to_owned(), service["id"].as_u64()?);
                }
            }
            "serviceCallFailure" => return Some(Received::Answer(Err(value["message"].to_string()))),
            _ => {}
        }
        None
    }

    /// Reads a frame: its opcode and its payload. `None` at the end of the connection.
    fn frame(&mut self) -> Option<(u8, Vec<u8>)> {
        let mut start = [0; 2];
        self.stream.read_exact(&mut start).ok()?;
        assert!(start[0] & 0x80 != 0 && start[1] & 0x80 == 0, "a whole frame without a mask");
        let length = match start[1] {
            126 => {
                let mut bytes = [0; 2];
                self.stream.read_exact(&mut bytes).ok()?;
                u64::from(u16::from_be_bytes(bytes))
            }
            127 => {
                let mut bytes = [0; 8];
                self.stream.read_exact(&mut bytes).ok()?;
                u64::from_be_bytes(bytes)
            }
            length => u64::from(length),
        };
        let mut payload = vec![0; length as usize];
        self.stream.read_exact(&mut payload).ok()?;
        Some((start[0] & 15, payload))
    }

    /// Sends a frame of less than 64 KiB, with a mask of zeros.
    fn send(&mut self, opcode: u8, payload: &[u8]) {
        let mut frame = vec![0x80 | opcode, 0x80 | 126];
        frame.extend(u16::try_from(payload.len()).unwrap().to_be_bytes());
        frame.extend([0; 4]);
        frame.extend(payload);
        self.stream.get_mut().write_all(&frame).unwrap();
    }
}
