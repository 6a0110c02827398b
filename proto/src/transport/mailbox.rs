//! Typed messages: items of plain types, written to and read from the words of a message in the
//! same order.
//!
//! A type of items is `Pod` and consists of whole words of 64 bits. So a message needs no packing
//! by hand, and its length follows from `size_of`.

use super::{RankLost, Tag, Transport};
use bytemuck::Pod;

/// Returns the number of words of an item in a message.
pub const fn words_of<T: Pod>() -> usize {
    const { assert!(size_of::<T>().is_multiple_of(8) && align_of::<T>() == 8) };
    size_of::<T>() / 8
}

/// A message under construction, or the last message received. Its memory is used again, so that
/// messages of a step allocate none.
///
/// Worker w is rank w + 1.
#[derive(Clone, Debug, Default)]
pub struct Mailbox {
    words: Vec<u64>,
    /// Number of words that have been read.
    read: usize,
}

impl Mailbox {
    /// Starts an empty message.
    pub fn start(&mut self) {
        self.words.clear();
        self.read = 0;
    }

    /// Appends an item.
    #[inline]
    pub fn push<T: Pod>(&mut self, item: T) {
        self.extend(&[item]);
    }

    /// Appends items.
    #[inline]
    pub fn extend<T: Pod>(&mut self, items: &[T]) {
        const { assert!(words_of::<T>() > 0) };
        self.words.extend_from_slice(bytemuck::cast_slice(items));
    }

    /// Appends the content of another message.
    pub fn append(&mut self, other: &Self) {
        self.words.extend_from_slice(&other.words);
    }

    /// Returns the words of the message.
    pub fn into_words(self) -> Vec<u64> {
        self.words
    }

    /// Returns a received message with these words.
    pub fn from_words(words: Vec<u64>) -> Self {
        Self { words, read: 0 }
    }

    /// Returns true if nothing has been written.
    pub fn is_empty(&self) -> bool {
        self.words.is_empty()
    }

    /// Sends the message to a worker. It can be sent again to others.
    ///
    /// # Errors
    /// The worker is gone.
    pub fn send(&self, comm: &mut dyn Transport, worker: usize, tag: Tag) -> Result<(), RankLost> {
        comm.send(worker + 1, tag, &self.words)
    }

    /// Waits for the next message of a worker, which replaces the present one.
    ///
    /// # Errors
    /// The worker is gone.
    pub fn receive(
        &mut self,
        comm: &mut dyn Transport,
        worker: usize,
        tag: Tag,
    ) -> Result<(), RankLost> {
        self.read = 0;
        comm.recv(worker + 1, tag, &mut self.words)
    }

    /// Reads the next items.
    ///
    /// # Panics
    /// If the message has fewer items: the sender writes what the receiver reads.
    #[inline]
    pub fn take_many<T: Pod>(&mut self, count: usize) -> &[T] {
        let start = self.read;
        self.read += count * words_of::<T>();
        bytemuck::cast_slice(&self.words[start..self.read])
    }

    /// Reads the next item.
    ///
    /// # Panics
    /// If there is none: the sender writes what the receiver reads.
    #[inline]
    pub fn take<T: Pod>(&mut self) -> T {
        self.take_many(1)[0]
    }

    /// Reads the next items of a message that may be wrong, because a file has it. Returns `None`
    /// if it has fewer.
    pub fn checked_take_many<T: Pod>(&mut self, count: u64) -> Option<&[T]> {
        let words = usize::try_from(count).ok()?.checked_mul(words_of::<T>())?;
        let end = self.read.checked_add(words).filter(|&end| end <= self.words.len())?;
        let start = std::mem::replace(&mut self.read, end);
        Some(bytemuck::cast_slice(&self.words[start..end]))
    }

    /// Reads the next item of a message that may be wrong. Returns `None` if there is none.
    pub fn checked_take<T: Pod>(&mut self) -> Option<T> {
        self.checked_take_many(1).map(|items| items[0])
    }

    /// Reads all items that are left.
    #[inline]
    pub fn rest<T: Pod>(&mut self) -> &[T] {
        const { assert!(words_of::<T>() > 0) };
        let start = std::mem::replace(&mut self.read, self.words.len());
        bytemuck::cast_slice(&self.words[start..])
    }

    /// Returns true if all words have been read.
    pub fn is_read(&self) -> bool {
        self.read == self.words.len()
    }

    /// Sends one item per entry of `list` to a worker; sends no message if the list is empty.
    ///
    /// # Errors
    /// The worker is gone.
    #[inline]
    pub fn send_items<T: Pod>(
        &mut self,
        comm: &mut dyn Transport,
        worker: usize,
        tag: Tag,
        list: &[u32],
        item: impl Fn(u32) -> T,
    ) -> Result<(), RankLost> {
        if list.is_empty() {
            return Ok(());
        }
        self.start();
        list.iter().for_each(|&i| self.push(item(i)));
        self.send(comm, worker, tag)
    }

    /// Receives one item per entry of `list`, which the sender has sent with
    /// [`Mailbox::send_items`] in the same order.
    ///
    /// # Errors
    /// The worker is gone.
    #[inline]
    pub fn receive_items<T: Pod>(
        &mut self,
        comm: &mut dyn Transport,
        worker: usize,
        tag: Tag,
        list: &[u32],
        mut store: impl FnMut(u32, T),
    ) -> Result<(), RankLost> {
        if list.is_empty() {
            return Ok(());
        }
        self.receive(comm, worker, tag)?;
        list.iter().zip(self.rest::<T>()).for_each(|(&i, item)| store(i, *item));
        Ok(())
    }

    /// Sends the message to all other workers and calls `read` with the message of each of them, in
    /// ascending order.
    ///
    /// # Errors
    /// A worker is gone.
    pub fn exchange_with_all(
        &mut self,
        comm: &mut dyn Transport,
        tag: Tag,
        mut read: impl FnMut(&mut Self),
    ) -> Result<(), RankLost> {
        let (workers, me) = (comm.size() - 1, comm.rank() - 1);
        for worker in (0..workers).filter(|&w| w != me) {
            self.send(comm, worker, tag)?;
        }
        for worker in (0..workers).filter(|&w| w != me) {
            self.receive(comm, worker, tag)?;
            read(self);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::threads::connect;
    use super::*;

    /// Items of different types are read in the order in which they were written, with the same
    /// bits.
    #[test]
    fn items_arrive_as_they_were_written() {
        let mut ranks = connect(3);
        let (mut there, mut here) = (ranks.remove(2), ranks.remove(1));
        let mut mail = Mailbox::default();
        mail.start();
        assert!(mail.is_empty());
        mail.push(7u64);
        mail.extend(&[[0.1, -0.0, f64::MIN_POSITIVE], [f64::MAX, 1e-300, 3.0]]);
        mail.extend(&[1u64, 2, 3]);
        mail.send(&mut here, 1, Tag::Ties).unwrap();
        mail.receive(&mut there, 0, Tag::Ties).unwrap();
        assert_eq!(mail.take::<u64>(), 7);
        let rows = mail.take_many::<[f64; 3]>(2);
        assert_eq!(rows[0].map(f64::to_bits), [0.1, -0.0, f64::MIN_POSITIVE].map(f64::to_bits));
        assert_eq!(rows[1], [f64::MAX, 1e-300, 3.0]);
        assert!(!mail.is_read());
        assert_eq!(mail.rest::<u64>(), [1, 2, 3]);
        assert!(mail.is_read());
    }

    /// Lists with entries are exchanged, empty lists need no message.
    #[test]
    fn items_of_lists_arrive_at_the_entries_of_the_other_list() {
        let mut ranks = connect(3);
        let (mut there, mut here) = (ranks.remove(2), ranks.remove(1));
        let (columns, mut copies) = ([[1.0, 2.0], [3.0, 4.0], [5.0, 6.0]], [[0.0; 2]; 3]);
        let mut mail = Mailbox::default();
        let of = |i: u32| columns[i as usize];
        mail.send_items(&mut here, 1, Tag::Ties, &[], of).unwrap();
        mail.send_items(&mut here, 1, Tag::Ties, &[2, 0], of).unwrap();
        let mut store = |i: u32, item: [f64; 2]| copies[i as usize] = item;
        mail.receive_items(&mut there, 0, Tag::Ties, &[], &mut store).unwrap();
        mail.receive_items(&mut there, 0, Tag::Ties, &[0, 1], &mut store).unwrap();
        assert_eq!(copies, [[5.0, 6.0], [1.0, 2.0], [0.0, 0.0]]);
    }

    /// Every worker reads the messages of all others, in ascending order.
    #[test]
    fn every_worker_reads_the_message_of_every_other() {
        let mut ranks = connect(4);
        let _master = ranks.remove(0);
        let read = std::thread::scope(|scope| {
            let of_rank = |(worker, mut comm): (usize, super::super::threads::Threads)| {
                scope.spawn(move || {
                    let (mut mail, mut read) = (Mailbox::default(), Vec::new());
                    mail.start();
                    mail.extend(&vec![worker as u64; worker]);
                    mail.exchange_with_all(&mut comm, Tag::Walls, |m| {
                        read.extend_from_slice(m.rest::<u64>());
                    })
                    .unwrap();
                    read
                })
            };
            let all: Vec<_> = ranks.into_iter().enumerate().map(of_rank).collect();
            all.into_iter().map(|t| t.join().unwrap()).collect::<Vec<_>>()
        });
        assert_eq!(read, [vec![1, 2, 2], vec![2, 2], vec![1]]);
    }
}
