//! Keys of `[[part]]` that several formulations use. A formulation publishes its keys in its row
//! of `ELEMENTS`.

use crate::materials::MAX_POINTS;
use crate::parameter::{DefaultValue, Form, ParameterRow, Range, Values};
use crumple_proto::job::Part;
use crumple_proto::problem::Problem;

/// Hourglass control of one-point elements.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HourglassForm {
    /// Elastic resistance against the accumulated deformation of the mode.
    Stiffness,
    /// Resistance against the rate of the mode.
    Viscous,
    /// Solids only: strains assumed for the modes, so that bending is correct without a
    /// coefficient.
    AssumedStrain,
}

const STIFFNESS: &str = "stiffness";
const VISCOUS: &str = "viscous";
const ASSUMED_STRAIN: &str = "assumed_strain";

impl HourglassForm {
    /// Forms of shells, as in a job.
    pub const OF_SHELLS: &[&str] = &[STIFFNESS, VISCOUS];
    /// Forms of solids, as in a job.
    pub const OF_SOLIDS: &[&str] = &[STIFFNESS, VISCOUS, ASSUMED_STRAIN];

    /// Returns its word in a job.
    pub const fn word(self) -> &'static str {
        match self {
            Self::Stiffness => STIFFNESS,
            Self::Viscous => VISCOUS,
            Self::AssumedStrain => ASSUMED_STRAIN,
        }
    }

    /// Returns the form with this word in a job.
    ///
    /// # Panics
    /// On another word: the table of the element has rejected it.
    pub(super) fn from_word(word: &str) -> Self {
        match word {
            STIFFNESS => Self::Stiffness,
            VISCOUS => Self::Viscous,
            ASSUMED_STRAIN => Self::AssumedStrain,
            _ => panic!("no hourglass form {word}"),
        }
    }
}

/// Points through the thickness.
const POINTS: ParameterRow = ParameterRow {
    key: "points",
    form: Form::Whole,
    otherwise: DefaultValue::Whole(5),
    range: Some(Range { wanted: "from 1 to 10", fits: |n| (1.0..=MAX_POINTS as f64).contains(&n) }),
    meaning: "Number of integration points through the thickness, 1 to 10; see \
              `cases/studies/README.md`, plate-points, beam-shells and panel.",
};

/// Treatment of inverted shells.
const INVERTED: ParameterRow = ParameterRow {
    key: "inverted",
    form: Form::Word(&["stop", DELETE]),
    otherwise: DefaultValue::Word("stop"),
    range: None,
    meaning: "Treatment of an inverted shell, which has no area or is strained by more than a \
              half in one step. `stop` ends the run and names the shell. `delete` lets it fail \
              as at a failure strain: its forces are zero from then on, and it leaves the \
              contact surface. The work done on it stays in the internal energy, and a warning \
              names it. In both cases, coordinates or forces that are not finite end the run. \
              So does a step below `time.dt_min_ratio` times the first.",
};

/// Change of the thickness.
const THINNING: ParameterRow = ParameterRow {
    key: "thinning",
    form: Form::Flag,
    otherwise: DefaultValue::Flag(false),
    range: None,
    meaning: "Update the thickness by the strain through it (`cases/studies/README.md`, \
              panel).",
};

/// Keys of thick shells.
pub(super) const OF_THICK_SHELLS: &[ParameterRow] = &[
    POINTS,
    INVERTED,
    DELETION_STEP,
    ParameterRow {
        otherwise: DefaultValue::Flag(true),
        meaning: "The distance of the faces follows the strain of the law through the thickness; \
                  otherwise it is held at that of the start.",
        ..THINNING
    },
];

/// Keys of all shells.
pub(super) const OF_SHELLS: &[ParameterRow] = &[
    POINTS,
    INVERTED,
    DELETION_STEP,
    THINNING,
    ParameterRow {
        key: "drilling",
        form: Form::Number,
        otherwise: DefaultValue::Number(0.01),
        range: Some(Range {
            wanted: "from 0 to 1 (0.01 is usual)",
            fits: |alpha| (0.0..=1.0).contains(&alpha),
        }),
        meaning: "Drilling stiffness as a fraction of the shear stiffness G h A / 4 \
                  (`cases/studies/README.md`, twist and twist-thin). In quads with a plastic law, \
                  its moments of a node are bounded by 1/400 of the plastic moment of a side.",
    },
];

/// Key of shells and solids that are deleted by their step.
pub(super) const DELETION_STEP: ParameterRow = ParameterRow {
    key: "deletion_step",
    form: Form::Number,
    otherwise: DefaultValue::Number(0.0),
    range: Some(Range { wanted: "0 or above", fits: |dt| dt >= 0.0 && dt.is_finite() }),
    meaning: "Stable step below which an element of the part is deleted, with scaled masses \
              included, without `time.safety`; 0 for none [time]. Deletion is as with \
              `inverted = \"delete\"`, which a step above 0 includes. Elements are not tested \
              until they are strained.",
};

/// Key of shells without bending.
pub(super) const MEMBRANE: ParameterRow = ParameterRow {
    key: "membrane",
    form: Form::Flag,
    otherwise: DefaultValue::Flag(false),
    range: None,
    meaning: "Membrane: one point, and neither bending nor transverse shear nor drilling \
              stiffness. In quads, hourglass control keeps a small stiffness of the twist out of \
              the plane.",
};

/// Returns true for a membrane.
///
/// # Errors
/// If the part also has layers or angles, which a single point does not have.
pub(super) fn is_membrane(part: &Part, values: &Values<'_>) -> Result<bool, Vec<Problem>> {
    let membrane = values.flag("membrane");
    if membrane && !(part.layer.is_empty() && part.angles.is_empty()) {
        let key = if part.layer.is_empty() { "angles" } else { "layer" };
        let message = format!("part {}: a membrane has one point and no layers", part.label());
        let help = format!("remove `membrane`, or `{key}` and give the part a thickness");
        return Err(vec![Problem::error(key, message, help)]);
    }
    Ok(membrane)
}

/// Returns the keys that have no effect in membranes, with the reason.
pub(super) fn idle_in_membranes(values: &Values<'_>) -> &'static [(&'static str, &'static str)] {
    if values.flag("membrane") {
        &[("points", "a membrane has one point"), ("drilling", "a membrane has none")]
    } else {
        &[]
    }
}

/// The same for triangles, which have no mode of the hourglass control either.
pub(super) fn idle_in_membrane_triangles(
    values: &Values<'_>,
) -> &'static [(&'static str, &'static str)] {
    if values.flag("membrane") {
        &[
            ("points", "a membrane has one point"),
            ("drilling", "a membrane has none"),
            ("hourglass_coefficient", "a membrane has no mode that it controls"),
        ]
    } else {
        &[]
    }
}

pub(super) const DELETE: &str = "delete";

/// Returns true if inverted elements fail instead of ending the run.
pub(super) fn deletes_inverted(values: &Values<'_>) -> bool {
    values.word("inverted") == DELETE || values.number(DELETION_STEP.key) > 0.0
}

/// Returns the row of the hourglass coefficient of a shell, with its default.
pub(super) const fn coefficient_of_shell(default: f64, meaning: &'static str) -> ParameterRow {
    ParameterRow {
        key: "hourglass_coefficient",
        form: Form::Number,
        otherwise: DefaultValue::Number(default),
        range: Some(Range {
            wanted: "from 0 to 1 (0.01 to 0.1 is usual)",
            fits: |r| (0.0..=1.0).contains(&r),
        }),
        meaning,
    }
}
