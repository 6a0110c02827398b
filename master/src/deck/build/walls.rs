//! `*RIGIDWALL_...`.

use super::Build;
use super::tree::Table;

impl Build {
    pub(super) fn walls(&mut self) {
        for (number, record) in self.take("RIGIDWALL_PLANAR").into_iter().enumerate() {
            for option in ["FINITE", "MOVING"] {
                if record.has(option) {
                    let name = format!("{}_{option}", record.name());
                    self.unsupported(record.head, format!("{name} is not supported yet"), name);
                }
            }
            let tail = ["xt", "yt", "zt"].map(|c| record.real(c));
            let head = ["xh", "yh", "zh"].map(|c| record.real(c));
            let normal = [0, 1, 2].map(|c| head[c] - tail[c]);
            let friction = record.real("fric");
            let place = record.place("xt");
            let heading = record.word("heading");
            let name = if heading.is_empty() { format!("wall-{}", number + 1) } else { heading.to_string() };
            if friction == 1.0 {
                self.map(&name, "fric 1: no sliding", "friction 1");
            } else if !(0.0..=1.0).contains(&friction) {
                self.unsupported_value(&record, "fric", "codes of sliding; give a coefficient from 0 to 1");
            }
            if record.real("wvel") != 0.0 {
                self.unsupported_value(&record, "wvel", "walls that move");
            }
            let (birth, death) = (record.real("birth"), record.real("death"));
            if birth > 0.0 || (death > 0.0 && death < self.end_time) {
                let field = if birth > 0.0 { "birth" } else { "death" };
                self.unsupported_value(&record, field, "walls that come or go within the run");
            }
            let all =
                ["nsid", "nsidex", "boxid"].iter().all(|f| record.integer(f) == 0) && record.real("offset") == 0.0;
            if !all {
                self.some_nodes(&record, &name, tail, normal);
            }
            let table = Table::new(record.head)
                .with("name", record.place("heading"), name)
                .with("point", place, tail)
                .with("normal", record.place("xh"), normal)
                .with("friction", record.place("fric"), friction);
            self.add("wall", table);
        }
    }

    /// A wall for some nodes stops all here: told, and an error if others stand behind it at the start.
    fn some_nodes(&mut self, record: &crate::deck::record::Record, name: &str, tail: [f64; 3], normal: [f64; 3]) {
        let fields: Vec<String> = ["nsid", "nsidex", "boxid"]
            .iter()
            .filter(|f| record.integer(f) != 0)
            .map(|f| format!("{f} {}", record.integer(f)))
            .collect();
        let behind = |x: &[f64; 3]| (0..3).map(|c| normal[c] * (x[c] - tail[c])).sum::<f64>() < 0.0;
        let used = self.rows.nodes_of(|_| true);
        let found = self.rows.nodes.iter().filter(|n| behind(&n.x) && used.binary_search(&n.id).is_ok());
        let (count, first) = (found.clone().count(), found.map(|n| n.id).next());
        if let Some(first) = first {
            let message =
                format!("{name} is for some nodes only ({}), and {count} others stand behind it", fields.join(", "));
            let what = format!("{} with {}", record.name(), fields.join(", "));
            self.unsupported(record.place("nsid"), format!("{message}; the first is node {first}"), what);
        }
        self.map(name, format!("stops some nodes: {}", fields.join(", ")), "stops all nodes");
    }
}
