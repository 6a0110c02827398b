//! Counts of the data and messages that each worker of a decomposition would have, computed by
//! one engine that has the whole mesh.
//!
//! In a run the workers find these out from each other (`partition.rs`). Here the process with
//! the whole mesh counts the same for any number of workers, by the same rules. An element
//! belongs to the box that contains its centre; a node belongs to the lowest worker with an
//! element at it. A worker gets ghosts of all segments that touch the box around its slaves,
//! extended by the distance that ghosts must cover.

use crumple_proto::boxes::{Aabb, CutTree};
use crumple_proto::ids::ElemId;
use crumple_proto::transport::{MaxReduction, messages_of_sum, traffic_of_gather};
use crumple_worker::constraints::rigid::{ACTING_WORDS, MET_WORDS};
use crumple_worker::contact::Contact;
use crumple_worker::contact::acceleration::words_of_sum;
use crumple_worker::contact::beams::with_edges;
use crumple_worker::contact::pairs::{Pair, PairTable};
use crumple_worker::contact::surface::{Segment, Surface};
use crumple_worker::engine::Engine;
use crumple_worker::fem::blocks::LocalElement;
use crumple_worker::math::row::xyz;
use crumple_worker::nodes::Nodes;
use crumple_worker::parallel::contact_decomposition::boxes_of_parts;
use crumple_worker::parallel::convergence::distances;
use crumple_worker::parallel::ghost_segments::{are_near, covered, seeking};
use crumple_worker::parallel::ghosts;
use crumple_worker::parallel::migrate::centre;
use crumple_worker::parallel::pair_exchange::{self, TrafficEstimate};
use crumple_worker::parallel::reduction;
use crumple_worker::parallel::replicated_pairs::message_words;
use std::collections::{BTreeMap, BTreeSet, HashMap};

/// Work and messages of one worker in a step.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Count {
    /// Number of the worker, from 0.
    pub worker: usize,
    /// Own elements.
    pub elements: u64,
    /// Lanes that they occupy, per part; a group of lanes is computed as a whole.
    pub lanes: Vec<u64>,
    /// Own elements with shared nodes.
    pub shared: u64,
    /// Nodes of own elements.
    pub held: u64,
    /// Nodes of own elements that the worker owns.
    pub owned: u64,
    /// Nodes on the contact surface for which the worker searches.
    pub slaves: u64,
    /// Own segments.
    pub segments: u64,
    /// Ghosts of other workers' segments.
    pub exterior_segments: u64,
    /// Ghosts of other workers' nodes.
    pub exterior_nodes: u64,
    /// Workers with shared nodes.
    pub neighbours: u64,
    /// Element nodal forces that are sent to these workers.
    pub corners: u64,
    /// Node states that are sent to workers with ghosts of them.
    pub exports: u64,
    /// Workers whose entities could come into contact with those of this worker; they exchange
    /// their motion.
    pub near_workers: u64,
    /// Workers that have a common node, local or ghost; they exchange contact pairs.
    pub meets: u64,
    /// Candidates in the near list, of own slaves.
    pub near: u64,
    /// Own contact pairs.
    pub pairs: u64,
    /// Copies of own pairs that are sent to other workers.
    pub copies: u64,
    /// Words of these messages.
    pub copied_words: u64,
    /// Workers with common contact pairs.
    pub partners: u64,
    /// Rounds after which the worker knows that none of the workers connected to it by contact
    /// pairs, directly or indirectly, changes a force any more.
    pub quiet: u64,
    /// Phases of Gauss-Seidel sweeps of the workers connected to it by contact pairs, directly or
    /// indirectly.
    pub phases: u64,
    /// Messages with the forces of a phase in a sweep, to all partners.
    pub phase_messages: u64,
    /// Owned nodes of rigid bodies with forces.
    pub members: u64,
    /// The exchange of pairs, if these are replicated.
    pub replicated: Option<ReplicationCount>,
    /// Pairs of other workers whose forces the worker computes too.
    pub replicas: u64,
}

/// Messages of replicated pairs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ReplicationCount {
    /// Messages and words of the exchange of pairs.
    pub exchange: [u64; 2],
    /// Messages in a sum over the workers with nodes of pairs; 0 for the others.
    pub messages_of_sum: usize,
}

/// Distribution of elements and nodes over workers.
pub struct Census {
    /// Counts of each worker.
    pub counts: Vec<Count>,
    /// Worker of each element, by its index in the engine's blocks.
    worker: Vec<u32>,
    /// Workers that have a node, as local or ghost node: node after node, ascending within the
    /// first `holders` of a node, which have it as local node, and within the rest.
    local_start: Vec<u32>,
    local: Vec<u32>,
    holders: Vec<u32>,
    /// Cuts of the second decomposition, if contact has one.
    contact: Option<CutTree>,
}

impl Census {
    /// Distributes the whole mesh to the boxes of `tree`, at the present positions of the
    /// nodes. `contact` are the cuts of the second decomposition, if contact has one. Contact pairs
    /// are counted later ([`Census::count_contact`]).
    ///
    /// # Panics
    /// If the engine is one of several.
    pub fn new(engine: &Engine, tree: &CutTree, contact: Option<CutTree>) -> Self {
        assert!(engine.halo.links.is_empty(), "the engine has the whole mesh");
        let (nodes, blocks) = (&engine.nodes, &engine.blocks);
        let workers = tree.workers();
        let is_static = contact.is_some();
        let of = |e: &LocalElement| tree.worker_of(centre_for(nodes, e, is_static)) as u32;
        let worker: Vec<u32> = blocks.elements.iter().map(of).collect();
        let mut held: Vec<(u32, u32)> = Vec::new();
        for (e, &w) in blocks.elements.iter().zip(&worker) {
            held.extend(e.nodes[..e.record.shape.corners()].iter().map(|&n| (n, w)));
        }
        held.sort_unstable();
        held.dedup();
        let mut census = Self {
            counts: (0..workers)
                .map(|worker| Count {
                    worker,
                    lanes: vec![0; engine.settings.parts.len()],
                    ..Count::default()
                })
                .collect(),
            worker,
            local_start: Vec::new(),
            local: Vec::new(),
            holders: Vec::new(),
            contact,
        };
        census.set_local(nodes.len(), &held, &[]);
        census.count_elements(engine);
        census.count_nodes(engine);
        if let Some(contact) = &engine.contact {
            let copies = census.copy_exterior(engine, &contact.surface, &held);
            census.set_local(nodes.len(), &held, &copies);
            census.count_meetings();
        }
        census
    }

    /// Counts the candidates and pairs of the engine's last local search.
    pub fn count_contact(&mut self, engine: &Engine) {
        let Some(contact) = &engine.contact else { return };
        for (slave, near) in contact.count_near() {
            let searcher = self.searcher(slave, &engine.nodes);
            self.counts[searcher].near += near as u64;
        }
        let workers = self.workers_of_elements(engine);
        let mut partners: Vec<(u32, u32)> = Vec::new();
        let mut owners: Vec<(u32, Vec<u32>)> = Vec::new();
        for pair in &contact.table.pairs {
            let owner = self.owner_of_pair((&contact.surface, &engine.nodes), pair, &workers);
            let mut others: Vec<u32> =
                pair.local_nodes().flat_map(|n| self.local(n)).copied().collect();
            others.sort_unstable();
            others.dedup();
            others.retain(|&w| w != owner);
            self.counts[owner as usize].pairs += 1;
            self.counts[owner as usize].copies += others.len() as u64;
            self.counts[owner as usize].copied_words +=
                (others.len() * pair_exchange::message_words(pair)) as u64;
            partners.extend(others.iter().flat_map(|&w| [(owner, w), (w, owner)]));
            owners.push((owner, others));
        }
        if engine.replicates_pairs() {
            self.count_replicas(&contact.table, &owners);
            return;
        }
        partners.sort_unstable();
        partners.dedup();
        partners.iter().for_each(|p| self.counts[p.0 as usize].partners += 1);
        let phases = self.count_phases(&contact.table, &owners);
        self.count_quiet(&partners, &phases);
    }

    /// Counts the messages of replicated pairs, and the replicas. `owners` are the owner of each
    /// pair and the other workers that know it.
    fn count_replicas(&mut self, table: &PairTable, owners: &[(u32, Vec<u32>)]) {
        let workers = self.counts.len();
        let mut of_worker: Vec<(Vec<&Pair>, BTreeSet<u32>)> = vec![Default::default(); workers];
        let mut groups: BTreeMap<u32, (Vec<u64>, BTreeSet<u32>)> = BTreeMap::new();
        let mut members: BTreeSet<u32> = BTreeSet::new();
        let pairs = table.pairs.iter().zip(owners).zip(table.connected_groups());
        for ((pair, (owner, others)), group) in pairs {
            let (own, users) = &mut of_worker[*owner as usize];
            own.push(pair);
            users.extend(others);
            members.insert(*owner);
            members.extend(others);
            let (own, needed_by) =
                groups.entry(group).or_insert_with(|| (vec![0; workers], BTreeSet::new()));
            own[*owner as usize] += 1;
            needed_by.insert(*owner);
            needed_by.extend(others);
        }
        let words = of_worker.iter().map(|(own, users)| message_words(own, users.len()));
        let words: Vec<usize> = words.collect();
        for (w, count) in self.counts.iter_mut().enumerate() {
            let place = members.iter().position(|&member| member as usize == w);
            count.replicated = Some(ReplicationCount {
                exchange: traffic_of_gather(w, &words).map(|n| n as u64),
                messages_of_sum: place.map_or(0, |place| messages_of_sum(place, members.len())),
            });
        }
        for (own, needed_by) in groups.values() {
            let all: u64 = own.iter().sum();
            for w in needed_by.iter().map(|&w| w as usize) {
                self.counts[w].replicas += all - own[w];
            }
        }
    }

    /// Counts the messages of each phase of Gauss-Seidel sweeps. `owners` are the owner of each
    /// pair and the other workers that know it. Returns the number of phases of the pairs of each
    /// worker.
    ///
    /// A pair comes in a later phase than earlier pairs of other workers with a common node, and
    /// not in an earlier phase than such pairs of its own worker (`pairs/schedule.rs`).
    fn count_phases(&mut self, table: &PairTable, owners: &[(u32, Vec<u32>)]) -> Vec<u64> {
        let mut phases = vec![0_u64; self.counts.len()];
        // Last phase at each node by worker.
        let mut last: HashMap<u32, BTreeMap<u32, u32>> = HashMap::new();
        let mut sent: BTreeSet<(u32, u32, u32)> = BTreeSet::new();
        for i in table.sweep_order() {
            let (pair, (owner, others)) = (&table.pairs[i as usize], &owners[i as usize]);
            let after = |(w, phase): (&u32, &u32)| phase + u32::from(w != owner);
            let at_nodes = pair.local_nodes().filter_map(|n| last.get(&n));
            let phase = at_nodes.flat_map(|by| by.iter().map(after)).max().unwrap_or(0);
            for n in pair.local_nodes() {
                let known = last.entry(n).or_default().entry(*owner).or_default();
                *known = phase.max(*known);
            }
            phases[*owner as usize] = phases[*owner as usize].max(u64::from(phase) + 1);
            sent.extend(others.iter().map(|&to| (*owner, to, phase)));
        }
        sent.iter().for_each(|s| self.counts[s.0 as usize].phase_messages += 1);
        phases
    }

    /// Counts the rounds of convergence detection: one more than the largest distance of two
    /// workers that `partners`, in both directions and ascending, connect directly or
    /// indirectly. The largest number of `phases` of such workers is that of all of them.
    fn count_quiet(&mut self, partners: &[(u32, u32)], phases: &[u64]) {
        let mut neighbours: BTreeMap<u64, Vec<u64>> = BTreeMap::new();
        partners.iter().for_each(|&(a, b)| neighbours.entry(a.into()).or_default().push(b.into()));
        // Lowest worker that each worker is connected to, and the distance to the farthest one.
        let reached: Vec<(u64, u64, u64)> = neighbours
            .keys()
            .map(|&w| {
                let to = distances(&neighbours, w);
                (w, to.keys().next().copied().unwrap_or(w), to.values().copied().max().unwrap_or(0))
            })
            .collect();
        let mut widest: BTreeMap<u64, [u64; 2]> = BTreeMap::new();
        for &(w, group, far) in &reached {
            let most = widest.entry(group).or_default();
            *most = [most[0].max(far), most[1].max(phases[w as usize])];
        }
        for (w, group, _) in &reached {
            let count = &mut self.counts[*w as usize];
            [count.quiet, count.phases] = [widest[group][0] + 1, widest[group][1]];
        }
    }

    /// Returns the workers that have a node, as local or ghost node.
    fn local(&self, node: u32) -> &[u32] {
        &self.local
            [self.local_start[node as usize] as usize..self.local_start[node as usize + 1] as usize]
    }

    /// Returns the workers that have a node as local node, ascending.
    fn holders(&self, node: u32) -> &[u32] {
        &self.local(node)[..self.holders[node as usize] as usize]
    }

    /// Returns the worker that owns a node.
    fn owner(&self, node: u32) -> usize {
        self.holders(node)[0] as usize
    }

    /// Returns the worker that searches for a node.
    fn searcher(&self, node: u32, nodes: &Nodes) -> usize {
        match &self.contact {
            Some(tree) => tree.worker_of(xyz(&nodes.x[node as usize])),
            None => self.owner(node),
        }
    }

    /// Stores the workers of each node; both lists contain (node, worker), ascending.
    fn set_local(&mut self, nodes: usize, held: &[(u32, u32)], copies: &[(u32, u32)]) {
        (self.local_start, self.holders) = (vec![0], vec![0; nodes]);
        self.local.clear();
        let (mut held, mut copies) = (held.iter().peekable(), copies.iter().peekable());
        for n in 0..nodes as u32 {
            while let Some(&(_, w)) = held.next_if(|h| h.0 == n) {
                self.local.push(w);
                self.holders[n as usize] += 1;
            }
            while let Some(&(_, w)) = copies.next_if(|c| c.0 == n) {
                self.local.push(w);
            }
            self.local_start.push(self.local.len() as u32);
        }
    }

    fn count_elements(&mut self, engine: &Engine) {
        let elements = &engine.blocks.elements;
        let mut links: HashMap<(u32, u32), u64> = HashMap::new();
        for (e, &w) in elements.iter().zip(&self.worker) {
            let corners = &e.nodes[..e.record.shape.corners()];
            let shared = corners.iter().any(|&n| self.holders(n).len() > 1);
            for &other in corners.iter().flat_map(|&n| self.holders(n)).filter(|&&o| o != w) {
                *links.entry((w, other)).or_default() += 1;
            }
            self.counts[w as usize].elements += 1;
            self.counts[w as usize].shared += u64::from(shared);
        }
        for ((w, _), corners) in links {
            self.counts[w as usize].neighbours += 1;
            self.counts[w as usize].corners += corners;
        }
        // Each block of the engine has one part and shape, as the blocks of each worker do.
        for b in &engine.blocks.blocks {
            let mut of_worker: HashMap<u32, usize> = HashMap::new();
            self.worker[b.first..b.first + b.count]
                .iter()
                .for_each(|&w| *of_worker.entry(w).or_default() += 1);
            let part = elements[b.first].record.part as usize;
            for (w, count) in of_worker {
                self.counts[w as usize].lanes[part] += count.next_multiple_of(b.lanes()) as u64;
            }
        }
    }

    fn count_nodes(&mut self, engine: &Engine) {
        for n in 0..engine.nodes.len() as u32 {
            let Some(&owner) = self.holders(n).first() else { continue };
            let holders = self.holders(n).to_vec();
            holders.iter().for_each(|&w| self.counts[w as usize].held += 1);
            self.counts[owner as usize].owned += 1;
        }
        for n in engine.constraints.bodies.acted_on(&engine.nodes) {
            let owner = self.owner(n);
            self.counts[owner].members += 1;
        }
    }

    /// Counts segments and ghosts. Returns the ghost nodes as (node, worker), ascending.
    fn copy_exterior(
        &mut self,
        engine: &Engine,
        surface: &Surface,
        held: &[(u32, u32)],
    ) -> Vec<(u32, u32)> {
        let nodes = &engine.nodes;
        let of_element = self.workers_of_elements(engine);
        let worker = |s: &Segment| {
            worker_of(&of_element, s.id.elem()).expect("segments belong to own elements")
        };
        let of_segment: Vec<u32> = surface.segments.iter().map(worker).collect();
        let mut parts: Vec<Surface> = self.counts.iter().map(|_| Surface::default()).collect();
        let with_edges = with_edges(&engine.settings);
        for (s, &w) in surface.segments.iter().zip(&of_segment) {
            self.counts[w as usize].segments += 1;
            if with_edges {
                parts[w as usize].segments.push(*s);
            }
        }
        surface.slaves.iter().for_each(|&n| parts[self.searcher(n, nodes)].slaves.push(n));
        // Nodes of hidden solids are known if solids can fail.
        let exposes = !surface.hidden.is_empty();
        let grow = covered(&engine.settings, surface, surface.largest_scale(), exposes);
        // Ordered by the lower end along x, so that few segments are tested for each box.
        let mut bounds: Vec<(Aabb, u32)> = (0..)
            .zip(&surface.segments)
            .map(|(g, s): (u32, &Segment)| (s.bounds(&nodes.x, 0.0), g))
            .collect();
        bounds.sort_unstable_by(|a, b| a.0.min[0].total_cmp(&b.0.min[0]));
        let widest = bounds.iter().map(|(b, _)| b.max[0] - b.min[0]).fold(0.0, f64::max);
        let seeking: Vec<Aabb> = match &self.contact {
            Some(tree) => boxes_of_parts(tree, &surface.segments, nodes),
            None => parts.iter().map(|part| seeking(&engine.settings, part, nodes)).collect(),
        };
        let mut copies: Vec<(u32, u32)> = Vec::new();
        for ((w, own), seeking) in (0u32..).zip(&parts).zip(&seeking) {
            let count = &mut self.counts[w as usize];
            count.slaves = own.slaves.len() as u64;
            if seeking.is_empty() {
                continue;
            }
            let region = seeking.grown(grow);
            let first = bounds.partition_point(|(b, _)| b.min[0] < region.min[0] - widest);
            let last = bounds.partition_point(|(b, _)| b.min[0] <= region.max[0]);
            for (_, g) in
                bounds[first..last.max(first)].iter().filter(|(b, _)| region.intersects(b))
            {
                if of_segment[*g as usize] != w {
                    count.exterior_segments += 1;
                    copies.extend(surface.segments[*g as usize].nodes.map(|n| (n, w)));
                }
            }
        }
        copies.sort_unstable();
        copies.dedup();
        copies.retain(|c| held.binary_search(c).is_err());
        for &(n, w) in &copies {
            let owner = self.owner(n);
            self.counts[owner].exports += 1;
            self.counts[w as usize].exterior_nodes += 1;
        }
        self.count_near([held, &copies], &seeking, engine, grow);
        copies
    }

    /// Counts near workers: those with near boxes, or with ghosts (`copies`) of the other's
    /// nodes.
    fn count_near(
        &mut self,
        [held, copies]: [&[(u32, u32)]; 2],
        seeking: &[Aabb],
        engine: &Engine,
        grow: f64,
    ) {
        let copied: BTreeSet<(usize, usize)> = copies
            .iter()
            .map(|&(n, w)| (self.owner(n), w as usize))
            .flat_map(|(o, w)| [(o, w), (w, o)])
            .collect();
        let mut places: Vec<Vec<[f64; 3]>> = vec![Vec::new(); seeking.len()];
        held.iter().for_each(|&(n, w)| places[w as usize].push(xyz(&engine.nodes.x[n as usize])));
        let held: Vec<Aabb> = places.into_iter().map(Aabb::around).collect();
        let one_way = |a: usize, b: usize| are_near(&seeking[a], &held[b], grow);
        let near = |a: usize, b: usize| one_way(a, b) || one_way(b, a) || copied.contains(&(a, b));
        for (w, count) in self.counts.iter_mut().enumerate() {
            count.near_workers =
                (0..seeking.len()).filter(|&o| o != w && near(w, o)).count() as u64;
        }
    }

    fn count_meetings(&mut self) {
        let workers = self.counts.len();
        let mut met = vec![false; workers * workers];
        for n in 0..self.holders.len() as u32 {
            let local = self.local(n);
            for &w in local.iter().filter(|_| local.len() > 1) {
                local
                    .iter()
                    .filter(|&&o| o != w)
                    .for_each(|&o| met[w as usize * workers + o as usize] = true);
            }
        }
        for (count, row) in self.counts.iter_mut().zip(met.chunks_exact(workers)) {
            count.meets = row.iter().filter(|&&m| m).count() as u64;
        }
    }

    /// Returns the worker of each element, by ascending id.
    fn workers_of_elements(&self, engine: &Engine) -> Vec<(ElemId, u32)> {
        let mut all: Vec<_> = engine
            .blocks
            .elements
            .iter()
            .zip(&self.worker)
            .map(|(e, &w)| (e.record.id, w))
            .collect();
        all.sort_unstable();
        all
    }

    /// Returns the owner of a pair, which searches for its node, for the lowest segment with its
    /// edge, or for its segment.
    fn owner_of_pair(
        &self,
        (surface, nodes): (&Surface, &Nodes),
        pair: &Pair,
        workers: &[(ElemId, u32)],
    ) -> u32 {
        let of_segment = |s: &Segment| match &self.contact {
            Some(_) => Some(self.searcher(s.nodes[0], nodes) as u32),
            None => worker_of(workers, s.id.elem()),
        };
        if pair.key.is_segment() {
            let id = pair.key.slave_quarter().0;
            let place = surface.segments.binary_search_by_key(&id, |s| s.id).ok();
            let of_slave = place.and_then(|place| of_segment(&surface.segments[place]));
            return of_slave.unwrap_or_else(|| self.searcher(pair.nodes[0], nodes) as u32);
        }
        let [slave, far] = [pair.nodes[0], pair.nodes[1]];
        let of_edge = || {
            let place = surface.slaves.binary_search(&slave).ok()?;
            of_segment(surface.around(place).find(|s| s.nodes.contains(&far))?)
        };
        let of_node = self.searcher(slave, nodes) as u32;
        if pair.key.is_edge() { of_edge().unwrap_or(of_node) } else { of_node }
    }
}

impl Count {
    /// Returns [`Self::traffic`] with the reductions over all workers of the accelerated sweeps:
    /// a sum each, and the largest of a value each if forces are extrapolated.
    pub fn traffic_with_sums(
        &self,
        engine: &Engine,
        workers: usize,
        estimate: &TrafficEstimate,
    ) -> [f64; 2] {
        let [messages, bytes] = self.traffic(engine, workers);
        let sums = estimate.accelerated_sweeps * self.messages_of_sum(workers) as f64;
        let largest = estimate.accelerated_sweeps
            * match &self.replicated {
                Some(count) => count.messages_of_sum as f64,
                None => f64::from(MaxReduction::hops(workers)),
            };
        let words = sums * words_of_sum() as f64 + largest;
        [messages + sums + largest, bytes + 8.0 * words]
    }

    /// Returns the number of messages that the worker sends in a sum of the contact iteration.
    fn messages_of_sum(&self, workers: usize) -> usize {
        let of_all = || messages_of_sum(self.worker, workers);
        self.replicated.as_ref().map_or_else(of_all, |count| count.messages_of_sum)
    }

    /// Returns the numbers of messages and bytes that the worker sends in a step of a run on
    /// `workers` workers. The exchange of contact forces between partners is not included
    /// because it depends on the number of sweeps ([`pair_exchange::TrafficEstimate`]).
    pub fn traffic(&self, engine: &Engine, workers: usize) -> [f64; 2] {
        let others = workers as f64 - 1.0;
        if workers < 2 {
            return [0.0; 2];
        }
        let hops = MaxReduction::hops(workers) as f64;
        let mut messages = self.neighbours as f64 + hops + messages_to_all(engine, workers);
        let mut words =
            (self.corners * ghosts::element_force_words(engine.settings.rotations)) as f64;
        words += hops * reduction::WORDS as f64;
        if engine.contact.is_some() {
            let [exchanges, of_pairs] = match &self.replicated {
                Some(count) => count.exchange,
                None => [self.meets, self.copied_words],
            };
            messages += (self.near_workers + exchanges) as f64;
            let spins = engine.contact.as_ref().is_some_and(|c| c.has_couples(&engine.nodes));
            words += (self.near_workers * ghosts::RIGID_MOTION_WORDS as u64) as f64
                + (self.exports * ghosts::ghost_words(spins)) as f64
                + of_pairs as f64;
        }
        if engine.contact.as_ref().is_some_and(Contact::accelerates) {
            // Convergence of all sweeps, and number of pairs.
            let sent = self.messages_of_sum(workers) as f64;
            messages += sent;
            words += 2.0 * sent;
        }
        if !engine.constraints.bodies.is_empty() {
            words += others * (1 + self.members * ACTING_WORDS as u64) as f64;
            if engine.contact.is_some() {
                words += others * (engine.constraints.bodies.bodies.len() * MET_WORDS) as f64;
            }
        }
        [messages, 8.0 * words]
    }
}

/// Returns the centre of an element that decides on its worker [length]: the present one, or with a
/// second decomposition of contact that at the start, since elements then stay.
pub fn centre_for(nodes: &Nodes, e: &LocalElement, is_static: bool) -> [f64; 3] {
    let x = if is_static { &nodes.x0 } else { &nodes.x };
    centre(x, e.nodes, e.record.shape)
}

/// Returns the worker of an element in a list of ascending ids.
fn worker_of(workers: &[(ElemId, u32)], elem: ElemId) -> Option<u32> {
    workers.binary_search_by_key(&elem, |w| w.0).ok().map(|at| workers[at].1)
}

/// Returns the number of messages of a step that every worker sends to all others: forces on
/// rigid bodies, contact of rigid bodies, and nodes that may touch walls with a mass.
pub fn messages_to_all(engine: &Engine, workers: usize) -> f64 {
    let (contact, bodies) = (engine.contact.is_some(), !engine.constraints.bodies.is_empty());
    let rounds =
        usize::from(bodies) + usize::from(contact && bodies) + engine.constraints.walls.pushed();
    rounds as f64 * (workers as f64 - 1.0).max(0.0)
}
