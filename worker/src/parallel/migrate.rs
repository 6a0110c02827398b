//! Migration of elements between workers when boxes are renewed, with their history and the
//! state of their nodes. The data go from worker to worker; the master only sends the boxes.

use crate::contact::Contact;
use crate::contact::pairs::PairHistory;
use crate::nodes::{Nodes, OuterStepMean};
use crate::parallel::partition::{LocalMesh, PartitionData};
use bytemuck::{Pod, Zeroable};
use crumple_proto::boxes::CutTree;
use crumple_proto::ids::{ElemId, NodeId};
use crumple_proto::mesh::{CornerNodes, Shape};
use crumple_proto::partition::{ElementRecord, NodeRecord};
use crumple_proto::transport::{RankLost, Transport, exchange_all, words_of};
use std::collections::BTreeMap;

/// Element in a message, followed by `columns` history numbers.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct WireElement {
    id: ElemId,
    part: u32,
    shape: u16,
    /// Free faces; the bits above mark a failed and a slow element.
    free_faces: u16,
    nodes: CornerNodes,
    thickness: f64,
    mass_factor: f64,
    share: f64,
    stable_dt: f64,
    columns: u64,
}
const ELEMENT_WORDS: usize = size_of::<WireElement>() / 8;
const NODE_WORDS: usize = size_of::<NodeRecord>() / 8;
const MEAN_WORDS: usize = size_of::<OuterStepMean>() / 8;

/// Data for one worker: four lists of words, each preceded by its length when packed.
#[derive(Default)]
struct Parcel {
    elements: Vec<u64>,
    nodes: Vec<u64>,
    memories: Vec<u64>,
    means: Vec<u64>,
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
    let memories = gather_memories(comm, local, contact)?;
    let mut parcels: Vec<Parcel> = (0..comm.size() - 1).map(|_| Parcel::default()).collect();
    let mut goes: Vec<(u32, usize)> = Vec::new();
    for b in &local.blocks.blocks {
        for (i, e) in local.blocks.elements[b.first..b.first + b.count].iter().enumerate() {
            let to = tree.worker_of(centre(&local.nodes, e.nodes, e.record.shape));
            put_element(&mut parcels[to].elements, &e.record, &b.state(i).to_vec());
            goes.extend(e.nodes.map(|n| (n, to)));
        }
    }
    goes.sort_unstable();
    goes.dedup();
    for (n, to) in goes {
        let record = local.nodes.record(n as usize);
        parcels[to].nodes.extend_from_slice(bytemuck::cast_slice(std::slice::from_ref(&record)));
        if let Some(mean) = local.nodes.mean(n as usize) {
            parcels[to].means.extend_from_slice(bytemuck::cast_slice(std::slice::from_ref(&mean)));
        }
        if let Some(list) = memories.get(&record.id) {
            put_memories(&mut parcels[to].memories, record.id, list);
        }
    }
    let packed =
        parcels.into_iter().map(|p| pack(&[p.elements, p.nodes, p.memories, p.means])).collect();
    let mut share = PartitionData::default();
    for parcel in exchange_all(comm, packed)? {
        let [elements, nodes, memories, means] = unpack(&parcel);
        take_elements(elements, &mut share.elements);
        share.nodes.extend(
            nodes
                .chunks_exact(NODE_WORDS)
                .map(|w| bytemuck::pod_read_unaligned::<NodeRecord>(bytemuck::cast_slice(w))),
        );
        take_memories(memories, |id, list| _ = share.memories.insert(id, list));
        share.means.extend(
            means
                .chunks_exact(MEAN_WORDS)
                .map(|w| bytemuck::pod_read_unaligned::<OuterStepMean>(bytemuck::cast_slice(w))),
        );
    }
    Ok(share)
}

/// Returns the centre of an element [length].
pub fn centre(columns: &Nodes, nodes: [u32; 8], shape: Shape) -> [f64; 3] {
    let used = shape.corners();
    std::array::from_fn(|c| {
        nodes[..used].iter().map(|&n| columns.x[n as usize][c]).sum::<f64>() / used as f64
    })
}

/// Returns the pair histories of local nodes, in ascending order of pair keys. Owners of pairs
/// send them to the other workers that have the node.
fn gather_memories(
    comm: &mut dyn Transport,
    local: &LocalMesh,
    contact: Option<&Contact>,
) -> Result<BTreeMap<NodeId, Vec<PairHistory>>, RankLost> {
    let mut all: BTreeMap<NodeId, Vec<PairHistory>> = BTreeMap::new();
    let Some(contact) = contact else { return Ok(all) };
    let mut parcels = vec![Vec::new(); comm.size() - 1];
    for (slave, list) in contact.pair_histories().filter(|(_, l)| !l.is_empty()) {
        let id = local.nodes.id[slave as usize];
        for &user in local.halo.users_of(slave) {
            put_memories(&mut parcels[user as usize], id, list);
        }
        all.entry(id).or_default().extend(list);
    }
    let me = comm.rank() - 1;
    for (_, parcel) in exchange_all(comm, parcels)?.iter().enumerate().filter(|(w, _)| *w != me) {
        take_memories(parcel, |id, list| all.entry(id).or_default().extend(list));
    }
    for list in all.values_mut() {
        list.sort_unstable_by_key(|m| m.name);
        list.dedup_by_key(|m| m.name);
    }
    Ok(all)
}

fn put_element(words: &mut Vec<u64>, e: &ElementRecord, history: &[f64]) {
    let comm = WireElement {
        id: e.id,
        part: e.part,
        shape: e.shape as u16,
        free_faces: u16::from(e.free_faces) | u16::from(e.failed) << 8 | u16::from(e.slow) << 9,
        nodes: e.nodes,
        thickness: e.thickness,
        mass_factor: e.mass_factor,
        share: e.share,
        stable_dt: e.stable_dt,
        columns: history.len() as u64,
    };
    words.extend_from_slice(bytemuck::cast_slice(std::slice::from_ref(&comm)));
    words.extend(history.iter().map(|h| h.to_bits()));
}

fn take_elements(mut words: &[u64], into: &mut Vec<(ElementRecord, Vec<f64>)>) {
    while words.len() >= ELEMENT_WORDS {
        let (head, rest) = words.split_at(ELEMENT_WORDS);
        let e: WireElement = bytemuck::pod_read_unaligned(bytemuck::cast_slice(head));
        let (history, after) = rest.split_at(e.columns as usize);
        let shape = Shape::ALL[e.shape as usize];
        let record = ElementRecord {
            id: e.id,
            part: e.part,
            shape,
            nodes: e.nodes,
            free_faces: e.free_faces as u8,
            failed: e.free_faces >> 8 & 1 == 1,
            slow: e.free_faces >> 9 & 1 == 1,
            thickness: e.thickness,
            mass_factor: e.mass_factor,
            share: e.share,
            stable_dt: e.stable_dt,
        };
        into.push((record, history.iter().map(|&h| f64::from_bits(h)).collect()));
        words = after;
    }
}

fn put_memories(words: &mut Vec<u64>, node: NodeId, list: &[PairHistory]) {
    words.extend([node.0, list.len() as u64]);
    words.extend_from_slice(bytemuck::cast_slice(list));
}

fn take_memories(mut words: &[u64], mut take: impl FnMut(NodeId, Vec<PairHistory>)) {
    while let [id, count, tail @ ..] = words {
        let (list, after) = tail.split_at(*count as usize * words_of::<PairHistory>());
        take(NodeId(*id), bytemuck::cast_slice(list).to_vec());
        words = after;
    }
}

fn pack(runs: &[Vec<u64>; 4]) -> Vec<u64> {
    runs.iter().flat_map(|r| std::iter::once(r.len() as u64).chain(r.iter().copied())).collect()
}

fn unpack(mut words: &[u64]) -> [&[u64]; 4] {
    std::array::from_fn(|_| match words {
        [len, rest @ ..] => {
            let (run, after) = rest.split_at(*len as usize);
            words = after;
            run
        }
        [] => &[],
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::pairs::PairKey;
    use crate::math::row::V3;
    use crumple_proto::ids::SegmentId;

    /// Encoded data are decoded to the same bits: elements of all shapes with history of any
    /// length, empty lists, pair histories of several nodes.
    #[test]
    fn parcels_make_the_round_trip() {
        let element = |id, shape, part| ElementRecord {
            id: ElemId(id),
            part,
            shape,
            nodes: [0, 1, 2, 3, 4, 5, 6, 7].map(|c| NodeId(id + c)),
            free_faces: part as u8,
            failed: part == 5,
            slow: id == 3 || id == 7,
            thickness: 0.3 * (id % 4) as f64,
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
        let mut runs = [const { Vec::new() }; 4];
        runs[3].extend_from_slice(bytemuck::cast_slice::<OuterStepMean, u64>(&[mean]));
        sent.iter().for_each(|(e, history)| put_element(&mut runs[0], e, history));
        remembered.iter().for_each(|(&node, list)| put_memories(&mut runs[2], node, list));

        let [elements, nodes, memories, means] = unpack(&pack(&runs)).map(<[u64]>::to_vec);
        let (mut arrived, mut known) = (Vec::new(), BTreeMap::new());
        take_elements(&elements, &mut arrived);
        take_memories(&memories, |id, list| _ = known.insert(id, list));
        let bits = |all: &[(ElementRecord, Vec<f64>)]| -> Vec<Vec<u64>> {
            all.iter().map(|(_, h)| h.iter().map(|a| a.to_bits()).collect()).collect()
        };
        assert_eq!(arrived, sent);
        assert_eq!(bits(&arrived), bits(&sent), "-0 stays -0");
        assert_eq!((known, nodes.len()), (remembered, 0));
        assert_eq!(bytemuck::cast_slice::<u64, OuterStepMean>(&means), [mean]);
        assert_eq!(unpack(&[]).map(<[u64]>::len), [0; 4], "an empty message has no items");
    }
}
