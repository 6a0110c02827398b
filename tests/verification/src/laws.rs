//! Contact laws and their forms, as the checks of contact use them.

/// A contact law with the settings that define a method.
pub struct Law {
    /// Name in the tables.
    pub name: &'static str,
    law: &'static str,
    more: &'static str,
}

impl Law {
    /// Every law and form of nodes on segments.
    pub const ALL: &[Self] = &[
        Self { name: "lagrange", law: "lagrange", more: "" },
        Self { name: "kinematic", law: "kinematic", more: "" },
        Self { name: "penalty", law: "penalty", more: "" },
        Self {
            name: "penalty stiffness",
            law: "penalty",
            more: "penalty_form = \"stiffness\"\npenalty_scale = 1.0\n",
        },
    ];

    /// Laws and forms of segments on segments, for checks in which surfaces press on surfaces.
    pub const BY_SEGMENTS: &[Self] = &[
        Self { name: "mortar", law: "mortar", more: "" },
        Self {
            name: "mortar stiffness",
            law: "mortar",
            more: "penalty_form = \"stiffness\"\npenalty_scale = 1.0\n",
        },
    ];

    /// Returns every law and form.
    pub fn all() -> impl Iterator<Item = &'static Self> {
        Self::ALL.iter().chain(Self::BY_SEGMENTS)
    }

    /// Lagrange law with masses split among pairs.
    pub const SPLIT: Self =
        Self { name: "lagrange split", law: "lagrange", more: "iteration = \"split\"\n" };

    /// Returns true if this is a form of the law with this name in the job.
    pub fn has_name(&self, law: &str) -> bool {
        self.law == law
    }

    /// Returns the `[contact]` table.
    pub fn table(&self) -> String {
        format!("[contact]\nlaw = \"{}\"\n{}", self.law, self.more)
    }

    /// Returns the `[contact]` table without contact damping, as the catalogue requires for part
    /// A except for sliding.
    pub fn undamped(&self) -> String {
        format!("{}{UNDAMPED}", self.table())
    }

    /// Returns true if the law is a penalty.
    pub fn is_spring(&self) -> bool {
        is_spring(self.law)
    }

    /// Returns true if segments press on segments, which gives uniform pressure for all meshes.
    pub fn by_segments(&self) -> bool {
        self.law == "mortar"
    }

    /// Returns true if the law is much softer than the elements next to the contact.
    pub fn is_soft(&self) -> bool {
        ["penalty", "mortar"].contains(&self.name)
    }
}

/// Returns true if the law of this name uses springs.
pub fn is_spring(law: &str) -> bool {
    ["penalty", "mortar"].contains(&law)
}

/// Setting that removes contact damping.
pub const UNDAMPED: &str = "penalty_damping = 0.0\n";

#[cfg(test)]
mod tests {
    use super::*;
    use crumple_proto::job::ContactInput;

    /// A law with only default settings would repeat the rows of another law.
    #[test]
    fn no_two_laws_are_the_same() {
        let settings = |law: &Law| {
            let table: toml::Table = law.table().parse().unwrap();
            let contact: ContactInput = table["contact"].clone().try_into().unwrap();
            format!("{contact:?}")
        };
        let different: std::collections::BTreeSet<String> =
            Law::all().chain([&Law::SPLIT]).map(settings).collect();
        assert_eq!(different.len(), Law::all().count() + 1);
    }
}
