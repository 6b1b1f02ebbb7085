//! The line to a board: bytes out, bytes in, and a clock.

use std::io::{ErrorKind, Read, Write};
use std::path::Path;
use std::time::{Duration, Instant};

use serialport::SerialPort;

use super::error::Error;

/// The speed of the line, in bits a second.
pub const BAUD: u32 = 115_200;
/// How long writing may take: a board that takes nothing for so long is gone.
const WRITE: Duration = Duration::from_millis(500);

/// A line to a board. Its clock is the one that its waiting is measured by: for an emulated board, emulated time.
pub trait Link {
    /// Sends bytes.
    ///
    /// # Errors
    ///
    /// When the line fails.
    fn send(&mut self, bytes: &[u8]) -> Result<(), Error>;

    /// What has come; waits for it at most so long, and gives nothing if nothing came.
    ///
    /// # Errors
    ///
    /// When the line fails.
    fn receive(&mut self, wait: Duration) -> Result<Vec<u8>, Error>;

    /// The time since some moment that stays the same.
    fn now(&self) -> Duration;
}

impl<L: Link + ?Sized> Link for Box<L> {
    fn send(&mut self, bytes: &[u8]) -> Result<(), Error> {
        (**self).send(bytes)
    }

    fn receive(&mut self, wait: Duration) -> Result<Vec<u8>, Error> {
        (**self).receive(wait)
    }

    fn now(&self) -> Duration {
        (**self).now()
    }
}

/// A serial port.
#[derive(Debug)]
pub struct Serial {
    port: Box<dyn SerialPort>,
    name: String,
    begun: Instant,
}

/// The serial ports of this machine. Pseudo terminals are not among them.
#[must_use]
pub fn ports() -> Vec<String> {
    // The library panics on a Linux without it.
    if cfg!(target_os = "linux") && !Path::new("/sys/class/tty").is_dir() {
        return Vec::new();
    }
    let mut names: Vec<String> =
        serialport::available_ports().unwrap_or_default().into_iter().map(|port| port.port_name).collect();
    names.sort();
    names
}

impl Serial {
    /// Opens a port, for this program alone. An Arduino Uno resets when its port is opened.
    ///
    /// # Errors
    ///
    /// [`Error::NoPort`], [`Error::PortBusy`], [`Error::NotPermitted`], or [`Error::Line`].
    pub fn open(name: &str) -> Result<Self, Error> {
        let port = serialport::new(name, BAUD).timeout(WRITE).open().map_err(|error| why(name, &error))?;
        // What came before belongs to nobody.
        let _ = port.clear(serialport::ClearBuffer::All);
        Ok(Self { port, name: name.to_owned(), begun: Instant::now() })
    }

    fn failed(&self, error: &std::io::Error) -> Error {
        Error::Line { port: self.name.clone(), cause: error.to_string() }
    }
}

fn why(name: &str, error: &serialport::Error) -> Error {
    let port = name.to_owned();
    match error.kind() {
        serialport::ErrorKind::Io(ErrorKind::PermissionDenied) => Error::NotPermitted { port },
        serialport::ErrorKind::Io(ErrorKind::NotFound) => Error::NoPort { port, there_are: ports() },
        // The library says the same of a port that is not there and of one that is taken.
        serialport::ErrorKind::NoDevice if cfg!(unix) && Path::new(name).exists() => Error::PortBusy { port },
        serialport::ErrorKind::NoDevice => Error::NoPort { port, there_are: ports() },
        _ => Error::Line { port, cause: error.to_string() },
    }
}

impl Link for Serial {
    fn send(&mut self, bytes: &[u8]) -> Result<(), Error> {
        let sent = self
            .port
            .set_timeout(WRITE)
            .map_err(std::io::Error::from)
            .and_then(|()| self.port.write_all(bytes));
        sent.map_err(|error| self.failed(&error))
    }

    fn receive(&mut self, wait: Duration) -> Result<Vec<u8>, Error> {
        let mut bytes = [0; 256];
        // The library takes zero to mean for ever.
        let wait = wait.max(Duration::from_millis(1));
        let read = self
            .port
            .set_timeout(wait)
            .map_err(std::io::Error::from)
            .and_then(|()| self.port.read(&mut bytes));
        match read {
            // The end of a file: the device is gone.
            Ok(0) => Err(self.failed(&ErrorKind::UnexpectedEof.into())),
            Ok(length) => Ok(bytes[..length].to_vec()),
            Err(error)
                if matches!(
                    error.kind(),
                    ErrorKind::TimedOut | ErrorKind::WouldBlock | ErrorKind::Interrupted
                ) =>
            {
                Ok(Vec::new())
            }
            Err(error) => Err(self.failed(&error)),
        }
    }

    fn now(&self) -> Duration {
        self.begun.elapsed()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_port_that_is_not_there_is_told_with_those_that_are() {
        let error = Serial::open("/dev/ttyNONE9").unwrap_err();
        assert!(matches!(&error, Error::NoPort { port, .. } if port == "/dev/ttyNONE9"), "{error}");
        assert!(error.to_string().contains("there is no port /dev/ttyNONE9"), "{error}");
    }

    #[test]
    fn what_is_no_port_is_told() {
        let file = tempfile::NamedTempFile::new().unwrap();
        let error = Serial::open(file.path().to_str().unwrap()).unwrap_err();
        assert!(matches!(error, Error::Line { .. }), "{error}");
    }
}
