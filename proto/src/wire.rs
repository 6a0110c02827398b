//! Control messages as bytes: bincode, preceded by the length, padded to whole words. Columns
//! of numbers are sent as words without this encoding.

use crate::transport::{RankLost, Tag, Transport};
use serde::{Serialize, de::DeserializeOwned};

/// Encodes a message as words; the first word is its length in bytes.
pub fn encode<T: Serialize>(message: &T) -> Vec<u64> {
    let bytes = bincode::serde::encode_to_vec(message, bincode::config::standard())
        .expect("plain data always encodes");
    let mut words = vec![0u64; 1 + bytes.len().div_ceil(8)];
    words[0] = bytes.len() as u64;
    bytemuck::cast_slice_mut::<u64, u8>(&mut words[1..])[..bytes.len()].copy_from_slice(&bytes);
    words
}

/// Decodes a message from [`encode`]; returns `None` if the words are no such message.
pub fn decode<T: DeserializeOwned>(words: &[u64]) -> Option<T> {
    let bytes = bytes_of(words)?;
    let decoded = bincode::serde::decode_from_slice(bytes, bincode::config::standard()).ok();
    decoded.filter(|(_, read)| *read == bytes.len()).map(|(m, _)| m)
}

/// Largest memory for the numbers and texts of a state in [`decode_state`] [byte].
const MOST: usize = 1 << 30;

/// Decodes what [`encode`] has written, from a file: no memory is reserved for a wrong length of a
/// text. Returns `None` if the words are no such state.
pub fn decode_state<T: DeserializeOwned>(words: &[u64]) -> Option<T> {
    let bytes = bytes_of(words)?;
    let config = bincode::config::standard().with_limit::<MOST>();
    let decoded = bincode::serde::decode_from_slice(bytes, config).ok();
    decoded.filter(|(_, read)| *read == bytes.len()).map(|(m, _)| m)
}

/// Returns the bytes of an encoded message.
fn bytes_of(words: &[u64]) -> Option<&[u8]> {
    let (&len, body) = words.split_first()?;
    bytemuck::cast_slice::<u64, u8>(body).get(..usize::try_from(len).ok()?)
}

/// Sends a control message.
///
/// # Errors
/// The receiver is gone.
pub fn post<T: Serialize>(
    comm: &mut dyn Transport,
    to: usize,
    tag: Tag,
    message: &T,
) -> Result<(), RankLost> {
    comm.send(to, tag, &encode(message))
}

/// Waits for a control message.
///
/// # Errors
/// The sender is gone, or its message cannot be decoded.
pub fn await_message<T: DeserializeOwned>(
    comm: &mut dyn Transport,
    from: usize,
    tag: Tag,
) -> Result<T, RankLost> {
    let mut words = Vec::new();
    comm.recv(from, tag, &mut words)?;
    decode(&words).ok_or(RankLost { rank: from })
}

/// Receives a control message if one has arrived.
///
/// # Errors
/// The sender is gone, or its message cannot be decoded.
pub fn poll_message<T: DeserializeOwned>(
    comm: &mut dyn Transport,
    from: usize,
    tag: Tag,
) -> Result<Option<T>, RankLost> {
    let mut words = Vec::new();
    if !comm.try_recv(from, tag, &mut words)? {
        return Ok(None);
    }
    decode(&words).map(Some).ok_or(RankLost { rank: from })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::boxes::CutTree;
    use crate::message::{Action, ToMaster, ToWorker};
    use crate::report::{Failure, FinalReport, StepReport};
    use crate::steering::Steer;

    #[test]
    fn messages_make_the_round_trip() {
        let orders = [Action::Renew(CutTree::single()), Action::Recut, Action::Steer(Steer::Stop)];
        for (number, action) in (1..).zip(orders) {
            let back = decode(&encode(&ToWorker::Order { number, action: action.clone() }));
            assert!(matches!(
                back,
                Some(ToWorker::Order { number: n, action: a }) if n == number && a == action
            ));
        }
        let report =
            StepReport { cycle: 7, cpu: vec![0.5], drift: [1.0, 2.0, 3.0], ..Default::default() };
        let back = decode(&encode(&ToMaster::Report(Box::new(report.clone()))));
        assert!(matches!(back, Some(ToMaster::Report(r)) if *r == report));
        let trouble = Failure { elem: None, cycle: 3, time: 0.25, why: "inverted".into() };
        let back = decode(&encode(&ToMaster::Trouble(trouble.clone())));
        assert!(matches!(back, Some(ToMaster::Trouble(t)) if t == trouble));
        let closing = ToMaster::Closing(
            Box::new(FinalReport { cycles: 5, ..Default::default() }),
            vec![Default::default()],
        );
        let back = decode(&encode(&closing));
        assert!(matches!(back, Some(ToMaster::Closing(c, n)) if c.cycles == 5 && n.len() == 1));
    }

    #[test]
    fn broken_words_are_refused() {
        assert!(decode::<ToMaster>(&[]).is_none());
        assert!(decode::<ToMaster>(&[99, 0]).is_none());
    }
}
