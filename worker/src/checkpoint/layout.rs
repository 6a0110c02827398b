//! Names of all that the files of a checkpoint have, in their order. Files have numbers only: the
//! manifest has the names, so that a program with other columns refuses the checkpoint.

use crate::constraints::walls::SurfaceForm;
use crate::engine::checkpoint::{CommonState, WorkerState};
use crate::fem::blocks::Block;
use crate::fem::elements::build_block;
use crate::parallel::migrate;
use crumple_proto::mesh::Shape;
use crumple_proto::partition::Settings;
use serde::de::DeserializeOwned;
use serde_reflection::{ContainerFormat, Named, Tracer, TracerConfig};
use std::collections::BTreeMap;

/// Names of columns and fields, by what they belong to.
pub type Layout = BTreeMap<String, Vec<String>>;

/// Returns the names of the files of workers: columns of the elements of each part and shape in
/// `kinds`, records, and states.
pub fn of_workers(settings: &Settings, kinds: impl IntoIterator<Item = (u32, Shape)>) -> Layout {
    let columns = kinds.into_iter().filter_map(|(part, shape)| {
        let element = build_block(settings, part as usize, shape).ok()?;
        let id = settings.parts[part as usize].id;
        Some((format!("{shape:?} of part {id}"), Block::names_of(&*element)))
    });
    let records = migrate::layout().map(|(name, fields)| (name.to_string(), fields));
    let mut all: Layout = columns.chain(records).collect();
    all.extend(of_states(|tracer| {
        trace::<CommonState>(tracer);
        trace::<WorkerState>(tracer);
        trace::<SurfaceForm>(tracer);
    }));
    all
}

/// Returns the names and types of the fields of the states that a function traces, and of all types
/// in them.
///
/// # Panics
/// If the variants of an enumeration are not all known: it has to be traced by itself too.
pub fn of_states(trace: impl FnOnce(&mut Tracer)) -> Layout {
    let mut tracer = Tracer::new(TracerConfig::default());
    trace(&mut tracer);
    let types = tracer.registry().expect("each enumeration is traced");
    types.iter().map(|(name, format)| (name.clone(), fields(format))).collect()
}

/// Traces a state.
///
/// # Panics
/// If it cannot be decoded from zeros.
pub fn trace<T: DeserializeOwned>(tracer: &mut Tracer) {
    tracer.trace_simple_type::<T>().expect("states are plain data");
}

fn fields(format: &ContainerFormat) -> Vec<String> {
    let field = |f: &Named<_>| format!("{}: {:?}", f.name, f.value);
    match format {
        ContainerFormat::UnitStruct => Vec::new(),
        ContainerFormat::NewTypeStruct(inner) => vec![format!("{inner:?}")],
        ContainerFormat::TupleStruct(inner) => inner.iter().map(|f| format!("{f:?}")).collect(),
        ContainerFormat::Struct(inner) => inner.iter().map(field).collect(),
        ContainerFormat::Enum(variants) => variants
            .iter()
            .map(|(number, v)| format!("{number} {}: {:?}", v.name, v.value))
            .collect(),
    }
}

/// Returns the first difference between the names in a checkpoint and those of this program.
pub fn difference(written: &Layout, own: &Layout) -> Option<String> {
    let keys = written.keys().chain(own.keys().filter(|key| !written.contains_key(*key)));
    keys.into_iter().find_map(|key| {
        let [there, here] = [written, own].map(|layout| layout.get(key).map_or(&[][..], |v| v));
        let count = there.len().max(here.len());
        let at = (0..count).find(|&i| there.get(i) != here.get(i))?;
        let named =
            |list: &[String]| list.get(at).map_or("missing".into(), |name| format!("`{name}`"));
        Some(format!(
            "number {} of {key} is {} in the checkpoint and {} in this program",
            at + 1,
            named(there),
            named(here)
        ))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn states_have_the_names_of_their_fields() {
        let all = of_workers(&crumple_fem::testing::settings(), []);
        assert!(all["Clock"].contains(&"cycle: U64".to_string()), "{:?}", all["Clock"]);
        for name in ["Body", "Tie", "Ledger", "WallSurface"] {
            assert!(!all[name].is_empty(), "{name}");
        }
        assert_eq!(all["SurfaceForm"].len(), 4, "{:?}", all["SurfaceForm"]);
        assert_eq!(all["mean velocity"].last().unwrap(), "end at byte 56");
    }

    #[test]
    fn the_first_other_name_is_found() {
        let of = |names: &[&str]| {
            let names = names.iter().map(|name| name.to_string()).collect();
            Layout::from([("Quad4 of part 1".to_string(), names)])
        };
        let old = of(&["stress", "strain"]);
        assert_eq!(difference(&old, &old), None);
        let renamed = difference(&old, &of(&["stress", "damage"])).unwrap();
        assert!(
            renamed
                .contains("number 2 of Quad4 of part 1 is `strain` in the checkpoint and `damage`")
        );
        let more = difference(&old, &of(&["stress", "strain", "damage"])).unwrap();
        assert!(more.contains("is missing in the checkpoint and `damage`"), "{more}");
        assert!(difference(&old, &Layout::new()).is_some());
        assert!(difference(&Layout::new(), &old).is_some());
    }
}
