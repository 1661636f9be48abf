//! Addresses of links.

use std::fmt;
use std::str::FromStr;

use crate::error::LinkError;

/// Baud rate of a serial link whose address names none.
const DEFAULT_BAUD: u32 = 921_600;

/// Where the autopilot is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Address {
    /// `udpin:HOST:PORT`: wait on this port, and answer to its last four senders.
    UdpIn(String),
    /// `udpout:HOST:PORT`: send to this port.
    UdpOut(String),
    /// `tcp:HOST:PORT` or `tcpout:HOST:PORT`: connect to this port.
    Tcp(String),
    /// `serial:DEVICE:BAUD` or `serial:DEVICE`.
    Serial {
        /// The device.
        device: String,
        /// Baud rate.
        baud: u32,
    },
}

impl FromStr for Address {
    type Err = LinkError;

    fn from_str(text: &str) -> Result<Self, LinkError> {
        let bad = |reason: &str| LinkError::Address {
            address: text.to_string(),
            reason: reason.to_string(),
        };
        let (scheme, rest) = text.split_once(':').ok_or_else(|| {
            bad("expected `udpin:`, `udpout:`, `tcp:` or `serial:` before the place")
        })?;
        let place = || {
            let port = rest.rsplit_once(':').filter(|(host, _)| !host.is_empty());
            port.filter(|(_, port)| port.parse::<u16>().is_ok())
                .map(|_| rest.to_string())
                .ok_or_else(|| {
                    bad("expected HOST:PORT after the scheme, as in udpin:0.0.0.0:14540")
                })
        };
        match scheme {
            "udpin" => Ok(Self::UdpIn(place()?)),
            "udpout" => Ok(Self::UdpOut(place()?)),
            "tcp" | "tcpout" => Ok(Self::Tcp(place()?)),
            "serial" => {
                let (device, baud) = match rest.rsplit_once(':') {
                    None => (rest, DEFAULT_BAUD),
                    Some((device, baud)) => {
                        let expected = "expected a baud rate above 0 after the device, as in serial:/dev/ttyTHS1:921600";
                        let baud = baud.parse().ok().filter(|baud| *baud > 0);
                        (device, baud.ok_or_else(|| bad(expected))?)
                    }
                };
                if device.is_empty() {
                    return Err(bad("expected a device, as in serial:/dev/ttyTHS1:921600"));
                }
                Ok(Self::Serial {
                    device: device.to_string(),
                    baud,
                })
            }
            _ => Err(bad(
                "the schemes are `udpin:`, `udpout:`, `tcp:`, `tcpout:` and `serial:`",
            )),
        }
    }
}

impl fmt::Display for Address {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::UdpIn(place) => write!(f, "udpin:{place}"),
            Self::UdpOut(place) => write!(f, "udpout:{place}"),
            Self::Tcp(place) => write!(f, "tcp:{place}"),
            Self::Serial { device, baud } => write!(f, "serial:{device}:{baud}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_addresses_are_read_as_they_are_written() {
        for text in [
            "udpin:0.0.0.0:14540",
            "udpout:127.0.0.1:14580",
            "tcp:[::1]:5760",
            "serial:/dev/ttyACM0:57600",
        ] {
            assert_eq!(text.parse::<Address>().unwrap().to_string(), text);
        }
        let serial: Address = "serial:/dev/ttyACM0".parse().unwrap();
        assert_eq!(serial.to_string(), "serial:/dev/ttyACM0:921600");
        assert_eq!(
            "tcpout:h:1".parse::<Address>().unwrap(),
            Address::Tcp("h:1".into())
        );
    }

    #[test]
    fn prop_what_is_no_address_is_refused_with_an_example() {
        for text in [
            "",
            "udpin",
            "udpin:14540",
            "udpin:h:x",
            "http:h:1",
            "serial:",
            "serial:/dev/a:fast",
            "serial:/dev/a:0",
        ] {
            let error = text.parse::<Address>().unwrap_err().to_string();
            assert!(error.contains("is no address"), "{error}");
        }
    }
}
