//! Bodies within bodies: an `/RBODY` whose main node is a node of another `/RBODY`. The inner body
//! moves with the outer one, so both are one body of the job, that of the outer main node.

use super::StarterConverter;
use super::bodies::StarterBody;
use crate::input::deck::record::CardRecord;
use crumple_proto::ids::NodeId;

impl StarterConverter {
    /// Joins each body whose main node another body has to that one.
    pub(super) fn join_inner_bodies(&mut self) {
        self.used_nodes();
        while let Some((inner, outer)) = self.nested() {
            let Some(body) = self.mains.remove(&inner) else { return };
            let Some(whole) = self.mains.get_mut(&outer) else { return };
            whole.nodes.extend(&body.nodes);
            let used = &self.used;
            for nodes in [&mut whole.nodes, &mut whole.own] {
                nodes.retain(|n| used.contains(n) || ![inner, outer].contains(n));
            }
            let walls = match (whole.in_walls, body.in_walls) {
                (true, false) | (false, true) => ", and walls stop all its nodes",
                _ => "",
            };
            whole.in_walls |= body.in_walls;
            let inertia = match body.added_inertia {
                Some(_) => {
                    ", to which its inertia adds; its mass and those of its nodes count at \
                     their places"
                }
                None => "",
            };
            if let Some((more, place)) = body.added_inertia {
                let (sum, _) = whole.added_inertia.get_or_insert(([0.0; 6], place));
                sum.iter_mut().zip(more).for_each(|(a, b)| *a += b);
            }
            self.deck.map(
                format!("body {}", body.name),
                format!("its main node {} is a node of the body {}", inner.label(), whole.name),
                format!("one body with that one{walls}{inertia}"),
            );
            self.inner_bodies.insert(inner, body);
        }
    }

    /// Returns the main nodes of a body and of another one that has the first node.
    fn nested(&self) -> Option<(NodeId, NodeId)> {
        self.mains.keys().find_map(|&inner| {
            let has = |body: &StarterBody| body.nodes.contains(&inner);
            let mut outer = self.mains.iter().filter(|(main, body)| **main != inner && has(body));
            outer.next().map(|(&main, _)| (inner, main))
        })
    }

    /// Removes the main nodes of inner bodies from the nodes of a condition. Reports them, unless
    /// they have their velocity from the outer body (`follows`).
    pub(super) fn without_inner_mains(
        &mut self,
        record: &CardRecord,
        nodes: &mut Vec<NodeId>,
        follows: bool,
    ) {
        let is_inner =
            |node: &NodeId| self.inner_bodies.contains_key(node) && !self.used.contains(node);
        let Some(main) = nodes.iter().copied().find(is_inner) else { return };
        nodes.retain(|node| !is_inner(node));
        if follows {
            let asked = format!("node {}, the main node of a body in another one", main.label());
            return self.deck.map(record.name(), asked, "it moves with the outer body");
        }
        let message = format!(
            "{}/{}: node {} is the main node of a body that another body has",
            record.name(),
            record.integer("id"),
            main.label()
        );
        let what = format!("{} on the main node of an inner body", record.name());
        self.deck.unsupported(record.place("grnod"), message, what);
    }
}
