//! Frames on the line: COBS, so that a zero always ends one, with a checksum.

use crc::{CRC_32_ISO_HDLC, Crc};

/// What a frame carries at most beside its head, in bytes.
pub const MAX_PAYLOAD: usize = 60;
/// The longest frame on the line: more without an end is noise.
const MAX_ENCODED: usize = 80;
const HEAD: usize = 6;

/// CRC-32, as of Ethernet and zip files.
#[must_use]
pub fn crc(bytes: &[u8]) -> u32 {
    Crc::<u32>::new(&CRC_32_ISO_HDLC).checksum(bytes)
}

/// One message with who says it and which it is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Frame {
    /// What kind of message it is.
    pub kind: u8,
    /// Whose session it belongs to.
    pub session: u32,
    /// The number of the request; an answer has that of its request.
    pub sequence: u8,
    /// The message itself.
    pub payload: Vec<u8>,
}

impl Frame {
    /// Its bytes on the line, with the zero at the end.
    #[must_use]
    pub fn encode(&self) -> Vec<u8> {
        let mut bytes = vec![self.kind];
        bytes.extend(self.session.to_le_bytes());
        bytes.push(self.sequence);
        bytes.extend(&self.payload);
        bytes.extend(crc(&bytes).to_le_bytes());
        let mut line = cobs::encode_vec(&bytes);
        line.push(0);
        line
    }

    /// Reads what came before a zero; nothing if it is broken.
    #[must_use]
    pub fn decode(line: &[u8]) -> Option<Self> {
        let bytes = cobs::decode_vec(line).ok()?;
        let (body, sum) = bytes.split_last_chunk::<4>()?;
        if body.len() < HEAD || body.len() > HEAD + MAX_PAYLOAD || crc(body) != u32::from_le_bytes(*sum) {
            return None;
        }
        let session = u32::from_le_bytes(body[1..5].try_into().ok()?);
        Some(Self { kind: body[0], session, sequence: body[5], payload: body[HEAD..].to_vec() })
    }
}

/// Makes frames out of bytes as they come in.
#[derive(Clone, Debug, Default)]
pub struct Decoder {
    line: Vec<u8>,
}

impl Decoder {
    /// Takes bytes; gives the whole frames among them. What is broken is dropped.
    pub fn feed(&mut self, bytes: &[u8]) -> Vec<Frame> {
        let mut out = Vec::new();
        for byte in bytes {
            if *byte == 0 {
                out.extend(Frame::decode(&self.line));
                self.line.clear();
            } else if self.line.len() <= MAX_ENCODED {
                self.line.push(*byte);
            }
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn the_checksum_is_the_one_that_is_documented() {
        assert_eq!(crc(b"123456789"), 0xCBF4_3926);
    }

    proptest! {
        #[test]
        fn frames_come_back_whatever_is_around_them(
            kind: u8, session: u32, sequence: u8,
            payload in proptest::collection::vec(any::<u8>(), 0..=MAX_PAYLOAD),
            noise in proptest::collection::vec(any::<u8>(), 0..200),
        ) {
            let frame = Frame { kind, session, sequence, payload };
            let mut line = noise;
            line.push(0);
            line.extend(frame.encode());
            prop_assert_eq!(Decoder::default().feed(&line).pop(), Some(frame));
        }

        #[test]
        fn three_flipped_bits_are_seen(
            payload in proptest::collection::vec(any::<u8>(), 0..=MAX_PAYLOAD),
            flips in proptest::collection::btree_set(0_usize..70 * 8, 1..=3),
        ) {
            let mut bytes = vec![6, 1, 2, 3, 4, 5];
            bytes.extend(&payload);
            bytes.extend(crc(&bytes).to_le_bytes());
            let mut broken = bytes.clone();
            for bit in flips {
                let bit = bit % (bytes.len() * 8);
                broken[bit / 8] ^= 1 << (bit % 8);
            }
            prop_assume!(broken != bytes);
            prop_assert_eq!(Frame::decode(&cobs::encode_vec(&broken)), None);
        }
    }
}
