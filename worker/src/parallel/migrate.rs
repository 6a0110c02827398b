//! Migration of elements between workers when boxes are renewed, with their history and the
//! state of their nodes. The data go from worker to worker; the master only sends the boxes.

use crate::contact::Contact;
use crate::contact::pairs::PairHistory;
use crate::fem::blocks::LocalElement;
use crate::math::row::Row;
use crate::nodes::{Nodes, OuterStepMean};
use crate::parallel::ghosts::Ghosts;
use crate::parallel::history_message::{Memories, put_histories, take_histories};
use crate::parallel::partition::{LocalMesh, PartitionData};
use bytemuck::{Pod, Zeroable};
use crumple_proto::boxes::CutTree;
use crumple_proto::ids::{ElemId, NodeId};
use crumple_proto::mesh::{CornerNodes, MAX_CORNERS, OwnSection, Shape};
use crumple_proto::partition::{ElementRecord, NodeRecord};
use crumple_proto::transport::{Mailbox, RankLost, Transport, exchange_all, exchange_with};
use std::collections::HashMap;

/// Element in a message, followed by `columns` numbers: history and energies.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct WireElement {
    id: ElemId,
    part: u32,
    shape: u8,
    /// Bits of a failed and of a slow element.
    marks: u8,
    free_faces: u16,
    nodes: CornerNodes,
    thickness: f64,
    /// Not a number for the offset of the part.
    offset: f64,
    angle: f64,
    mass_factor: f64,
    share: f64,
    stable_dt: f64,
    columns: u64,
}
/// Numbers of items of a message; the items follow in this order.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct Header {
    elements: u64,
    nodes: u64,
    histories: u64,
    means: u64,
}

/// Returns the fields of a type in memory, which are words of a message.
macro_rules! fields {
    ($type:ident: $($field:ident)*) => {{
        // A field that is not in the list is an error here.
        let _ = |all: $type| {
            let $type { $($field: _),* } = all;
        };
        let places = [$((stringify!($field), std::mem::offset_of!($type, $field))),*];
        let mut places: Vec<_> = places.into_iter().chain([("end", size_of::<$type>())]).collect();
        places.sort_by_key(|&(_, at)| at);
        places.iter().map(|(name, at)| format!("{name} at byte {at}")).collect()
    }};
}

/// Returns the fields of all records of a message, and so of a checkpoint.
pub fn layout() -> [(&'static str, Vec<String>); 4] {
    [
        (
            "element",
            fields!(WireElement: id part shape marks free_faces nodes thickness offset angle
                mass_factor share stable_dt columns),
        ),
        ("node", fields!(NodeRecord: id fixed x0 x seen v w mass inertia)),
        (
            "contact history",
            fields!(PairHistory: name side tolerated kept depth normal force slip thickness pressure
                age),
        ),
        ("mean velocity", fields!(OuterStepMean: id v w)),
    ]
}

/// Data for one worker.
#[derive(Clone, Default)]
struct Parcel {
    element_count: u64,
    elements: Mailbox,
    nodes: Vec<NodeRecord>,
    /// Number of nodes with pair histories.
    history_count: u64,
    histories: Mailbox,
    means: Vec<OuterStepMean>,
}

impl Parcel {
    /// Appends an element with its history columns.
    fn add_element(&mut self, e: &ElementRecord, columns: &[f64]) {
        self.element_count += 1;
        put_element(&mut self.elements, e, columns);
    }

    /// Appends the pair histories of a node.
    fn add_histories(&mut self, node: NodeId, list: &[PairHistory]) {
        self.history_count += 1;
        put_histories(&mut self.histories, node, list);
    }

    /// Returns the message.
    fn into_words(self) -> Vec<u64> {
        let mut mail = Mailbox::default();
        mail.push(Header {
            elements: self.element_count,
            nodes: self.nodes.len() as u64,
            histories: self.history_count,
            means: self.means.len() as u64,
        });
        mail.append(&self.elements);
        mail.extend(&self.nodes);
        mail.append(&self.histories);
        mail.extend(&self.means);
        mail.into_words()
    }
}

/// Adds the items of a message to a partition. Returns `None` if it is no such message; the
/// partition then has a part of it.
pub fn unpack(words: Vec<u64>, share: &mut PartitionData) -> Option<()> {
    let mut mail = Mailbox::from_words(words);
    let header: Header = mail.checked_take()?;
    for _ in 0..header.elements {
        share.elements.push(take_element(&mut mail)?);
    }
    share.nodes.extend_from_slice(mail.checked_take_many(header.nodes)?);
    for _ in 0..header.histories {
        share.memories.extend([take_histories(&mut mail)?]);
    }
    share.means.extend_from_slice(mail.checked_take_many(header.means)?);
    mail.is_read().then_some(())
}

/// Sends every element of the local mesh to the worker whose box contains its centre. Returns
/// the new partition of this worker. Collective.
///
/// # Errors
/// A worker is gone.
pub fn migrate(
    comm: &mut dyn Transport,
    tree: &CutTree,
    local: &LocalMesh,
    contact: Option<&Contact>,
) -> Result<PartitionData, RankLost> {
    let to = |e: &LocalElement| tree.worker_of(centre(&local.nodes.x, e.nodes, e.record.shape));
    let workers = comm.size() - 1;
    let parcels = pack_local(comm, local, contact, workers, to)?;
    exchange(comm, parcels)
}

/// Returns the elements of this worker as its new partition. Collective, because pair histories
/// come from the owners of the pairs.
///
/// # Errors
/// A worker is gone.
pub fn stay(
    comm: &mut dyn Transport,
    local: &LocalMesh,
    contact: Option<&Contact>,
) -> Result<PartitionData, RankLost> {
    let mut share = PartitionData::default();
    unpack(pack_all(comm, local, contact)?, &mut share).expect("a whole message");
    Ok(share)
}

/// Returns the message of [`migrate`] that has all elements of this worker. Collective, because
/// pair histories come from the owners of the pairs.
///
/// # Errors
/// A worker is gone.
pub fn pack_all(
    comm: &mut dyn Transport,
    local: &LocalMesh,
    contact: Option<&Contact>,
) -> Result<Vec<u64>, RankLost> {
    Ok(pack_local(comm, local, contact, 1, |_| 0)?.swap_remove(0))
}

/// Returns the bytes of an element with this number of history columns, of a node and of a pair
/// history in a message, and so in a checkpoint.
pub fn item_bytes(columns: usize) -> [usize; 3] {
    let element = size_of::<WireElement>() + columns * size_of::<f64>();
    [element, size_of::<NodeRecord>(), size_of::<PairHistory>()]
}

/// Sends every element of a partition that no engine has built yet to the worker whose box contains
/// its centre. Returns the new partition of this worker. Collective.
///
/// # Errors
/// A worker is gone.
pub fn distribute(
    comm: &mut dyn Transport,
    tree: &CutTree,
    share: &PartitionData,
) -> Result<PartitionData, RankLost> {
    let nodes: HashMap<NodeId, &NodeRecord> = share.nodes.iter().map(|n| (n.id, n)).collect();
    let means: HashMap<NodeId, &OuterStepMean> = share.means.iter().map(|m| (m.id, m)).collect();
    let elements = share.elements.iter().map(|(e, columns)| {
        let to = tree.worker_of(centre_of_record(e, |id| nodes[&id].x));
        (e, e.nodes, columns.clone(), to)
    });
    let parcels = pack(comm.size() - 1, elements, |id| NodeShare {
        record: *nodes[&id],
        mean: means.get(&id).copied().copied(),
        histories: share.memories.get(&id).map(Vec::as_slice),
    });
    exchange(comm, parcels)
}

/// Returns the centre of an element whose nodes are at `place` [length].
pub fn centre_of_record(e: &ElementRecord, place: impl Fn(NodeId) -> [f64; 3]) -> [f64; 3] {
    let used = e.shape.corners();
    std::array::from_fn(|c| e.nodes[..used].iter().map(|&n| place(n)[c]).sum::<f64>() / used as f64)
}

/// Sends the messages that have elements to the workers. Returns the partition that this worker
/// receives.
fn exchange(
    comm: &mut dyn Transport,
    mut parcels: Vec<Vec<u64>>,
) -> Result<PartitionData, RankLost> {
    let of_none = Parcel::default().into_words();
    parcels.iter_mut().filter(|words| **words == of_none).for_each(Vec::clear);
    let mut share = PartitionData::default();
    for words in exchange_all(comm, parcels)?.into_iter().filter(|words| !words.is_empty()) {
        unpack(words, &mut share).expect("workers send whole messages");
    }
    Ok(share)
}

/// Data of a node that go with its elements.
struct NodeShare<'a> {
    record: NodeRecord,
    mean: Option<OuterStepMean>,
    histories: Option<&'a [PairHistory]>,
}

/// Returns `count` messages; own element `e` is in message `to(e)`.
fn pack_local(
    comm: &mut dyn Transport,
    local: &LocalMesh,
    contact: Option<&Contact>,
    count: usize,
    to: impl Fn(&LocalElement) -> usize,
) -> Result<Vec<Vec<u64>>, RankLost> {
    let memories = match contact {
        Some(contact) => gather_memories(comm, &local.nodes, &local.halo, contact)?,
        None => Memories::new(),
    };
    let elements = local.blocks.blocks.iter().flat_map(|b| {
        let own = local.blocks.elements[b.first..b.first + b.count].iter().enumerate();
        own.map(|(i, e)| (&e.record, e.nodes, b.columns(i), to(e)))
    });
    Ok(pack(count, elements, |n: u32| {
        let record = local.nodes.record(n as usize);
        NodeShare {
            record,
            mean: local.nodes.mean(n as usize),
            histories: memories.get(&record.id).map(Vec::as_slice),
        }
    }))
}

/// Returns `count` messages with elements and their nodes. An element comes with its nodes, its
/// history columns and the number of its message.
fn pack<'a, 'b, N: Copy + Ord>(
    count: usize,
    elements: impl Iterator<Item = (&'a ElementRecord, [N; MAX_CORNERS], Vec<f64>, usize)>,
    node: impl Fn(N) -> NodeShare<'b>,
) -> Vec<Vec<u64>> {
    let mut parcels: Vec<Parcel> = (0..count).map(|_| Parcel::default()).collect();
    let mut goes: Vec<(N, usize)> = Vec::new();
    for (e, nodes, columns, to) in elements {
        parcels[to].add_element(e, &columns);
        goes.extend(nodes.map(|n| (n, to)));
    }
    goes.sort_unstable();
    goes.dedup();
    for (n, to) in goes {
        let NodeShare { record, mean, histories } = node(n);
        parcels[to].nodes.push(record);
        parcels[to].means.extend(mean);
        if let Some(list) = histories {
            parcels[to].add_histories(record.id, list);
        }
    }
    parcels.into_iter().map(Parcel::into_words).collect()
}

/// Returns the centre of an element with the nodes at `x` [length].
pub fn centre(x: &[Row], nodes: [u32; MAX_CORNERS], shape: Shape) -> [f64; 3] {
    let used = shape.corners();
    std::array::from_fn(|c| {
        nodes[..used].iter().map(|&n| x[n as usize][c]).sum::<f64>() / used as f64
    })
}

/// Returns the pair histories of local nodes, in ascending order of pair keys. Owners of pairs
/// send them to the other workers that have the node.
///
/// # Errors
/// A worker is gone.
pub fn gather_memories(
    comm: &mut dyn Transport,
    nodes: &Nodes,
    halo: &Ghosts,
    contact: &Contact,
) -> Result<Memories, RankLost> {
    let mut all = Memories::new();
    let mut parcels = vec![Mailbox::default(); comm.size() - 1];
    for (slave, list) in contact.pair_histories().filter(|(_, l)| !l.is_empty()) {
        let id = nodes.id[slave as usize];
        for &user in halo.users_of(slave) {
            put_histories(&mut parcels[user as usize], id, list);
        }
        all.entry(id).or_default().extend(list);
    }
    let me = comm.rank() - 1;
    let mut partners = vec![false; parcels.len()];
    for link in &halo.links {
        partners[link.worker] = link.shares_nodes;
    }
    let parcels = parcels.into_iter().map(Mailbox::into_words).collect();
    let parcels = exchange_with(comm, parcels, &partners)?;
    for (_, words) in parcels.into_iter().enumerate().filter(|(w, _)| *w != me) {
        let mut mail = Mailbox::from_words(words);
        while !mail.is_read() {
            let (id, list) = take_histories(&mut mail).expect("workers send whole messages");
            all.entry(id).or_default().extend(list);
        }
    }
    for list in all.values_mut() {
        list.sort_unstable_by_key(|m| m.name);
        list.dedup_by_key(|m| m.name);
    }
    Ok(all)
}

fn put_element(mail: &mut Mailbox, e: &ElementRecord, columns: &[f64]) {
    // A new field is an error here, and has to be sent.
    let &ElementRecord {
        id,
        part,
        shape,
        nodes,
        free_faces,
        failed,
        own: OwnSection { thickness, offset, angle },
        mass_factor,
        share,
        slow,
        stable_dt,
    } = e;
    mail.push(WireElement {
        id,
        part,
        shape: shape as u8,
        marks: u8::from(failed) | u8::from(slow) << 1,
        free_faces,
        nodes,
        thickness,
        offset: offset.unwrap_or(f64::NAN),
        angle,
        mass_factor,
        share,
        stable_dt,
        columns: columns.len() as u64,
    });
    mail.extend(columns);
}

fn take_element(mail: &mut Mailbox) -> Option<(ElementRecord, Vec<f64>)> {
    let e: WireElement = mail.checked_take()?;
    let record = ElementRecord {
        id: e.id,
        part: e.part,
        shape: *Shape::ALL.get(usize::from(e.shape))?,
        nodes: e.nodes,
        free_faces: e.free_faces,
        failed: e.marks & 1 == 1,
        slow: e.marks >> 1 & 1 == 1,
        own: OwnSection {
            thickness: e.thickness,
            offset: Some(e.offset).filter(|offset| !offset.is_nan()),
            angle: e.angle,
        },
        mass_factor: e.mass_factor,
        share: e.share,
        stable_dt: e.stable_dt,
    };
    Some((record, mail.checked_take_many(e.columns)?.to_vec()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::pairs::PairKey;
    use crate::math::row::V3;
    use crumple_proto::ids::SegmentId;
    use std::collections::BTreeMap;

    /// Encoded data are decoded to the same bits: elements of all shapes with history of any
    /// length, empty lists, pair histories of several nodes.
    #[test]
    fn parcels_make_the_round_trip() {
        let element = |id, shape, part| ElementRecord {
            id: ElemId(id),
            part,
            shape,
            nodes: std::array::from_fn(|c| NodeId(id + c as u64)),
            free_faces: part as u16 | 0x8100,
            failed: part == 5,
            slow: id == 3 || id == 7,
            own: OwnSection {
                thickness: 0.3 * (id % 4) as f64,
                offset: (id % 2 == 0).then_some(-0.7),
                angle: 10.0 * (id % 5) as f64,
            },
            mass_factor: 1.0 + 0.1 * id as f64,
            share: 1.0 / (1.0 + 0.1 * id as f64),
            stable_dt: if part == 2 { f64::INFINITY } else { 0.3 },
        };
        let sent = vec![
            (element(7, Shape::Quad4, 0), vec![0.1, -0.0, f64::MIN_POSITIVE / 3.0]),
            (element(3, Shape::Tri3, 5), Vec::new()),
            (element(u64::MAX >> 11, Shape::Hex8, 2), vec![f64::MAX; 100]),
            (element(4, Shape::Line2, 1), vec![1.0; 5]),
            (element(5, Shape::Beam2, 0), vec![0.5; 7]),
        ];
        let memory = |segment, side| PairHistory {
            name: PairKey::of_node(NodeId(4), SegmentId(segment)),
            side,
            tolerated: -1e-3 / 3.0,
            kept: -1e-3 / 7.0,
            depth: 0.7,
            normal: V3::new(0.6, -0.8, 0.0),
            force: V3::new(1.0 / 3.0, 2.0, -3.0),
            slip: V3::new(0.0, -0.0, 1e-300),
            thickness: 0.3,
            pressure: 0.7,
            age: 17,
        };
        let remembered = BTreeMap::from([
            (NodeId(4), vec![memory(9, 1.0), memory(11, -1.0)]),
            (NodeId(8), vec![memory(1, 1.0)]),
        ]);
        let mean =
            OuterStepMean { id: NodeId(4), v: [0.1, -0.0, 1e-300], w: [1.0 / 3.0, 2.0, -3.0] };
        let mut parcel = Parcel { means: vec![mean], ..Parcel::default() };
        sent.iter().for_each(|(e, history)| parcel.add_element(e, history));
        remembered.iter().for_each(|(&node, list)| parcel.add_histories(node, list));

        let mut arrived = PartitionData::default();
        let words = parcel.into_words();
        unpack(words.clone(), &mut arrived).unwrap();
        let bits = |all: &[(ElementRecord, Vec<f64>)]| -> Vec<Vec<u64>> {
            all.iter().map(|(_, h)| h.iter().map(|a| a.to_bits()).collect()).collect()
        };
        assert_eq!(arrived.elements, sent);
        assert_eq!(bits(&arrived.elements), bits(&sent), "-0 stays -0");
        assert_eq!((arrived.memories, arrived.nodes.len()), (remembered, 0));
        assert_eq!(arrived.means, [mean]);
        let mut none = PartitionData::default();
        unpack(Parcel::default().into_words(), &mut none).unwrap();
        assert!(none.elements.is_empty() && none.nodes.is_empty() && none.memories.is_empty());
        for cut in 0..words.len() {
            assert!(unpack(words[..cut].to_vec(), &mut PartitionData::default()).is_none());
        }
        let more = [&words[..], &[0]].concat();
        assert!(unpack(more, &mut PartitionData::default()).is_none());
    }
}
