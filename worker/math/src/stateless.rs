//! The check that a type has nothing that a checkpoint must contain.

/// States that a type holds nothing that a checkpoint must contain: all its fields come from the
/// job, or are computed for each partition or in each step before they are used. The macro takes
/// the names of all fields. A new field is a compile error until it is added: to the list, or, if
/// it is state, to the checkpoint.
#[macro_export]
macro_rules! stateless {
    ($name:ident { $($field:ident),* $(,)? }) => {
        const _: fn(&$name) = |value| {
            let $name { $($field: _),* } = value;
        };
    };
}
