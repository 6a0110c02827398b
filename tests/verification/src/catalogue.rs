//! The catalogue: every entry in order, with its checks, and the parts that are not covered yet,
//! with the reason.

use super::{
    Entry, bars, beam_contact, beams, contact, crashes, crush, drum, dynamic_relaxation, edges,
    elements, experiments, facets, hertz, invariance, joints, lines, materials, plates,
    pressure_patch, ridges, rigid, sections, sheets, sliding, solid_bars, solid_cells,
    solid_patches, stability, stacks, steps, taylor, walls,
};

const fn entry(
    id: &'static str,
    title: &'static str,
    checks: &'static [super::Check],
    open: &'static str,
) -> Entry {
    Entry { id, title, checks, open }
}

/// Every entry.
pub const CATALOGUE: &[Entry] = &[
    entry(
        "A01",
        "Two identical elastic bars, head-on",
        &[
            bars::PAIR,
            bars::PAIR_UNEQUAL,
            bars::PAIR_ORDER,
            solid_bars::PAIR,
            solid_bars::PAIR_UNEQUAL,
            solid_bars::PAIR_SPLIT,
            solid_bars::PAIR_SEGMENTS,
            solid_bars::PAIR_ORDER,
        ],
        "",
    ),
    entry(
        "A03",
        "Bar on a rigid wall",
        &[walls::TRUSS, walls::ROD, walls::TARGETS, solid_bars::STRAIN],
        "",
    ),
    entry("A05", "Elastic step wave in a bar", &[solid_bars::STEP], ""),
    entry("A06", "Elastic-plastic wave", &[walls::PLASTIC, solid_patches::PLASTIC], ""),
    entry(
        "A07",
        "Sliding block, Coulomb friction",
        &[sliding::STOP, sliding::ITERATIONS, sliding::HEAVY],
        "",
    ),
    entry("A08", "Stick-slip on a shaken base", &[sliding::SHAKEN], ""),
    entry("A09", "Block on an incline", &[sliding::INCLINE], ""),
    entry(
        "A10",
        "Hertz, quasi-static",
        &[hertz::CYLINDER],
        "spheres: (b) is run instead of (a) and (c)",
    ),
    entry("A11", "Hertz, bouncing sphere", &[taylor::BALL], "the stiff sphere"),
    entry("A13", "Free fall and bounce of a rigid body", &[rigid::FALL], ""),
    entry("A14", "Oblique impact of a sphere with friction", &[rigid::OBLIQUE], ""),
    entry(
        "A15",
        "Beam frequencies",
        &[beams::BEAMS, beams::FREE_BEAM, solid_cells::BEAMS],
        "elongated cells",
    ),
    entry(
        "A16",
        "Plate frequencies",
        &[beams::PLATE, beams::FREE_PLATE, beams::CLAMPED_PLATE, dynamic_relaxation::SAGGED],
        "frequencies 4 to 8 of FV12, NAFEMS 13H",
    ),
    entry("A17", "Added masses", &[beams::MASSES, dynamic_relaxation::HANGING], ""),
    entry(
        "A19",
        "Rigid rotation, spinning body",
        &[elements::TURNED, solid_patches::TURNED, beams::SPINNING_BAR, beams::SPINNING_SHELL],
        "",
    ),
    entry("A21", "Patch tests", &[elements::MEMBRANE, elements::BENDING, solid_patches::PATCH], ""),
    entry(
        "A22",
        "Contact patch test",
        &[pressure_patch::PATCH],
        "inclined and curved surfaces; the closed form of Serac (neo-Hookean)",
    ),
    entry(
        "A23",
        "Stability limit of central differences",
        &[elements::STEP, solid_cells::STEP, solid_patches::ROD],
        "",
    ),
    entry("A24", "Penalty stiffness and the time step", &[stability::SPRING], ""),
    entry(
        "A25",
        "Pinned beam, step pressure",
        &[solid_cells::PINNED],
        "one cube through the depth: it has no node at mid-depth to pin",
    ),
    entry(
        "A26",
        "Large strain of a single element",
        &[elements::LARGE, materials::SQUASHED],
        "(a) for solids: see C13",
    ),
    entry(
        "A27",
        "J2 material drivers",
        &[
            materials::UNIAXIAL,
            materials::PATHS,
            materials::CYCLIC,
            materials::JOHNSON_COOK,
            materials::RATES,
        ],
        "kinematic hardening: only the tests of the law compare it with closed forms",
    ),
    entry("A29", "Conservation", &[invariance::CONSERVATION, invariance::BOX], ""),
    entry(
        "A30",
        "Large deflection of shells",
        &[
            dynamic_relaxation::STRIP,
            dynamic_relaxation::ROLL,
            dynamic_relaxation::HEMISPHERE,
            dynamic_relaxation::PULLED,
        ],
        "",
    ),
    entry(
        "A31",
        "Independence of the partition",
        &[invariance::WORKERS, invariance::SCENES],
        "B15 as a scene; MPI: tests/tests/mpi/processes.rs",
    ),
    entry(
        "A32",
        "Ties",
        &[joints::WAVE, joints::FLIGHT],
        "ties that are released by a failed element",
    ),
    entry("A33", "Spot welds that break", &[joints::WELD], "bending and torque"),
    entry("A34", "Beams", &[lines::SWING, lines::HINGE], ""),
    entry("A35", "Springs and dampers", &[lines::OSCILLATOR], ""),
    entry("A36", "Thickness in plastic flow", &[sheets::THINNING], ""),
    entry(
        "A37",
        "Elements that fail",
        &[sheets::EROSION],
        "contact of the remaining elements: tests/tests/contact/erosion.rs",
    ),
    entry("A38", "Triangles in motion", &[sheets::TRIANGLES], ""),
    entry("A39", "Mass scaling with contact", &[steps::SCALED], ""),
    entry("A40", "Subcycles", &[steps::SUBCYCLES], "with contact, which a job must request"),
    entry(
        "A41",
        "Thicknesses of single shells",
        &[sections::STEPPED],
        "contact: tests/tests/physics/sections.rs",
    ),
    entry(
        "A42",
        "Shells with an offset middle surface",
        &[sections::PULLED],
        "contact: it places their surfaces about the nodes",
    ),
    entry(
        "B01",
        "Taylor bar, linear hardening",
        &[taylor::COARSE, taylor::FINE, taylor::WALL, taylor::OTHER_SOLIDS],
        "the perfectly plastic variant of Abaqus",
    ),
    entry(
        "B02",
        "Taylor bar, Johnson-Cook",
        &[taylor::JOHNSON_COOK],
        "temperature, which is not an output field",
    ),
    entry(
        "B03",
        "Taylor tests, experiments",
        &[experiments::COPPER, experiments::STEEL_4340],
        "copper M1 at 316 m/s, where the rim folds over; a material law of copper M1",
    ),
    entry("B04", "Impulsively loaded clamped beam", &[crush::BEAM], ""),
    entry("B06", "Spherical cap, step pressure", &[plates::CAP], ""),
    entry("B08", "Elastic-plastic plate, step pressure", &[plates::PLATE, plates::FINE_PLATE], ""),
    entry(
        "B09",
        "Twisted beam, Scordelis-Lo, pinched cylinder, hemisphere",
        &[dynamic_relaxation::CURVED, dynamic_relaxation::TWISTED, dynamic_relaxation::THIN],
        "Raasch hook",
    ),
    entry("B10", "NAFEMS LE5 Z-section", &[dynamic_relaxation::FOLDED], ""),
    entry(
        "B11",
        "Square tube, axial crush",
        &[crush::SQUARE],
        "a rigid head (here a guided ring of masses)",
    ),
    entry(
        "B12",
        "Square tubes, mean crush force",
        &[crush::MEAN_FORCE],
        "the strain-rate factor ([U] constants)",
    ),
    entry("B13", "Circular tube, axial crush", &[crush::ROUND], ""),
    entry(
        "B15",
        "S-beam crash",
        &[crashes::S_BEAM],
        "the source gives no numbers: the reference is a finer mesh of our own",
    ),
    entry(
        "B17",
        "Impulsively loaded plates and other experiments",
        &[experiments::PLATES],
        "pipe on pipe: no numbers could be read from the sources",
    ),
    entry("B18", "Can crush, brick wall", &[], "qualitative"),
    entry(
        "B19",
        "Short square tube (`cases/tube`)",
        &[crashes::SHORT_TUBE, crashes::COEFFICIENTS],
        "",
    ),
    entry(
        "B20",
        "Jeep frame, first 10 ms (`cases/jeep-frame`)",
        &[crashes::FRAME, crashes::FRAME_FULL],
        "times after 10 ms",
    ),
    entry("C01", "Penalty too stiff", &[contact::STIFF], ""),
    entry(
        "C02",
        "Light node on a heavy segment and the reverse",
        &[contact::LIGHT, stacks::FOAM],
        "",
    ),
    entry("C03", "Corner, facet, vertex", &[facets::DROPPED], ""),
    entry("C04", "Edge to edge", &[edges::UPRIGHT, edges::FLAT, ridges::ROOFS, ridges::JOINTS], ""),
    entry("C06", "Initial penetration", &[contact::SUNK, solid_patches::SUNK], ""),
    entry(
        "C07",
        "Tunnelling through a thin shell",
        &[contact::FAST],
        "a rotating plate hit by its own edge",
    ),
    entry("C08", "Symmetric contact, double counting", &[stacks::PLATES, stacks::LONG], ""),
    entry("C09", "Friction reversal", &[sliding::REVERSAL], ""),
    entry(
        "C10",
        "Hourglass blow-up",
        &[elements::HOURGLASS, solid_cells::HOURGLASS, plates::MODES],
        "(c): the source gives no bound",
    ),
    entry("C11", "Warped shells", &[elements::WARPED], "twisted strips: see B09"),
    entry("C12", "Volumetric locking", &[solid_cells::CYLINDER, solid_cells::FRONT], "stress"),
    entry(
        "C13",
        "Element inversion",
        &[solid_cells::CRUSHED],
        "shells: tests/tests/run/exit_codes.rs checks that an inverted shell ends the run",
    ),
    entry(
        "C14",
        "Time step collapse",
        &[stability::SLIVER],
        "the solid at a tenth of its height: see C13; a node squeezed to a hundredth of its gap: \
         no contact law becomes stiffer there",
    ),
    entry(
        "C15",
        "Over-constraint by several pairs",
        &[contact::SANDWICH, stacks::STACK, stacks::CORNER, contact::CRADLE],
        "(d) has unit tests in worker/contact/src/enforce/tests.rs",
    ),
    entry("C16", "Numbering of a shell in shear", &[elements::NUMBERING], ""),
    entry(
        "C18",
        "Sliding across facets and off edges",
        &[facets::FLAT, facets::EDGE, drum::DRUM],
        "a node that rests beyond the free edge of a shell",
    ),
    entry(
        "C20",
        "Beams as lines",
        &[beam_contact::RIGID, beam_contact::ELASTIC, beam_contact::EDGE, beam_contact::REST],
        "",
    ),
];

#[cfg(test)]
mod tests {
    use super::*;

    /// Each entry is run or gives a reason, once, in order.
    #[test]
    fn the_catalogue_is_whole() {
        assert!(CATALOGUE.windows(2).all(|e| e[0].id < e[1].id), "ids ascend");
        for e in CATALOGUE {
            assert!(
                !e.checks.is_empty() || !e.open.is_empty(),
                "{}: add a check or a reason",
                e.id
            );
        }
        assert_eq!(CATALOGUE.len(), 69, "the catalogue has 69 entries");
    }
}
