//! Converts `/TH/...`.

use super::StarterConverter;
use crate::input::deck::convert::tree::JobTable;
use crate::input::deck::number;
use crumple_proto::ids::NodeId;

/// Columns of an id.
const WIDTH: usize = 10;

impl StarterConverter {
    pub(super) fn histories(&mut self) {
        let mut tables = Vec::new();
        for record in self.take(&["/TH/NODE"]) {
            let mut ids = Vec::new();
            // Lines with names of variables come before those with nodes.
            for line in record.lines("row") {
                let text = line.word("row");
                let first = text.get(..WIDTH).unwrap_or(text).trim();
                match number::integer(first.as_bytes()) {
                    Some(id) if id > 0 => ids.push(id),
                    _ => {}
                }
            }
            if ids.is_empty() {
                let message = format!("/TH/NODE/{} names no nodes", record.integer("id"));
                let help = "give one node per line, after the line of variables";
                self.deck.trouble.warning(record.head, message, help);
                continue;
            }
            let title = record.word("title").trim().to_string();
            let name = match title.is_empty() {
                true => format!("nodes {}", record.integer("id")),
                false => title,
            };
            let list = format!("history-{}", record.integer("id"));
            let mut nodes: Vec<NodeId> =
                ids.iter().filter_map(|&n| super::groups::node(n)).collect();
            let is_main = |node: &NodeId| self.deck.rows.stand_ins.contains(node);
            if let Some(main) = nodes.iter().find(|node| is_main(node)) {
                let message = format!(
                    "/TH/NODE/{}: node {}, the main node of a body, is in no element and has no \
                     history",
                    record.integer("id"),
                    main.label()
                );
                let help = "name a node of the body that elements have";
                self.deck.trouble.warning(record.head, message, help);
            }
            nodes.retain(|node| !self.deck.rows.stand_ins.contains(node));
            if nodes.is_empty() {
                continue;
            }
            let list = self.deck.rows.add_new_set(&list, nodes, record.head);
            let table = JobTable::new(record.head).with("name", record.place("title"), name).with(
                "nodes",
                record.head,
                list,
            );
            tables.push((record.head, table));
        }
        // Every part has a history.
        self.take(&["/TH/PART"]);
        self.deck.put_list("node", tables);
    }
}
