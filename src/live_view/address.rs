use std::fmt;
use std::io;
use std::net::{SocketAddr, TcpStream, ToSocketAddrs};
use std::str::FromStr;
use std::time::Duration;

/// How long to wait for a host that does not answer.
const PATIENCE: Duration = Duration::from_secs(3);

/// Where a viewer listens: `HOST:PORT`, or `PORT` alone for this machine.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Address(String);

/// The text is no address.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("write HOST:PORT or PORT alone, such as 14158, where tev listens by default")]
pub struct NoAddress;

impl Address {
    /// A connection to the first of the host's addresses that takes one.
    pub(super) fn connect(&self) -> io::Result<TcpStream> {
        let mut refused = None;
        for address in self.0.to_socket_addrs()? {
            match TcpStream::connect_timeout(&address, PATIENCE) {
                Ok(stream) => return Ok(stream),
                Err(error) => refused = Some(error),
            }
        }
        Err(refused.unwrap_or_else(|| io::ErrorKind::HostUnreachable.into()))
    }
}

impl FromStr for Address {
    type Err = NoAddress;

    fn from_str(text: &str) -> Result<Address, NoAddress> {
        let is_port = |text: &str| text.parse::<u16>().is_ok_and(|port| port > 0);
        match text.rsplit_once(':') {
            None if is_port(text) => Ok(Address(format!("127.0.0.1:{text}"))),
            Some((host, port)) if !host.is_empty() && is_port(port) => Ok(Address(text.into())),
            _ => Err(NoAddress),
        }
    }
}

impl From<SocketAddr> for Address {
    fn from(address: SocketAddr) -> Address {
        Address(address.to_string())
    }
}

impl fmt::Display for Address {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(&self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_port_alone_is_of_this_machine() {
        let address = |text: &str| text.parse::<Address>().map(|address| address.to_string());
        assert_eq!(address("14158"), Ok("127.0.0.1:14158".into()));
        assert_eq!(address("viewer.lan:14158"), Ok("viewer.lan:14158".into()));
        assert_eq!(address("[::1]:80"), Ok("[::1]:80".into()));
        for wrong in ["", "host", ":80", "host:", "0", "host:99999", "1e4"] {
            assert_eq!(address(wrong), Err(NoAddress), "{wrong}");
        }
    }
}
