//! The catalogue: every entry in order, with its checks, and what of it is not covered yet and why.

use super::{Entry, bars, beams, contact, crush, elements, invariance, materials, walls};

const HEX: &str = "hex variant: needs eight-node solids";
const LOADS: &str = "needs pressure, gravity or nodal loads";
const RELAX: &str = "needs loads and dynamic relaxation";
const SOLID: &str = "needs eight-node solids";
const RIGID: &str = "needs rigid bodies";

const fn entry(id: &'static str, title: &'static str, checks: &'static [super::Check], open: &'static str) -> Entry {
    Entry { id, title, checks, open }
}

/// Every entry.
pub const CATALOGUE: &[Entry] = &[
    entry("A01", "Two identical elastic bars, head-on", &[bars::PAIR, bars::PAIR_UNEQUAL, bars::PAIR_ORDER], HEX),
    entry(
        "A03",
        "Bar on a rigid wall",
        &[walls::TRUSS, walls::ROD, walls::TARGETS],
        "(b) is in uniaxial strain: needs eight-node solids",
    ),
    entry("A05", "Elastic step wave in a bar", &[], LOADS),
    entry("A06", "Elastic-plastic wave", &[walls::PLASTIC], HEX),
    entry("A07", "Sliding block, Coulomb friction", &[], LOADS),
    entry("A08", "Stick-slip on a shaken base", &[], "needs gravity and prescribed motion"),
    entry("A09", "Block on an incline", &[], LOADS),
    entry("A10", "Hertz, quasi-static", &[], SOLID),
    entry("A11", "Hertz, bouncing sphere", &[], SOLID),
    entry("A13", "Free fall and bounce of a rigid body", &[], RIGID),
    entry("A14", "Oblique impact of a sphere with friction", &[], RIGID),
    entry(
        "A15",
        "Beam frequencies",
        &[beams::BEAMS, beams::FREE_BEAM],
        "one-point hexes with hourglass stiffness: needs eight-node solids",
    ),
    entry(
        "A16",
        "Plate frequencies",
        &[beams::PLATE, beams::FREE_PLATE],
        "clamped and cantilever plates ([U] coefficients), static deflection (needs loads and relaxation)",
    ),
    entry("A17", "Added masses", &[beams::MASSES], "in gravity: needs gravity"),
    entry("A19", "Rigid rotation, spinning body", &[elements::TURNED, beams::SPINNING_BAR, beams::SPINNING_SHELL], HEX),
    entry("A21", "Patch tests", &[elements::MEMBRANE, elements::BENDING], HEX),
    entry("A22", "Contact patch test", &[], "needs eight-node solids and pressure"),
    entry("A23", "Stability limit of central differences", &[elements::STEP], "(a), (b) rods and hexes: needs solids"),
    entry(
        "A24",
        "Penalty stiffness and the time step",
        &[],
        "our penalty takes its stiffness from masses and step, so there is no stiffness to give; C01 tests the outcome",
    ),
    entry("A25", "Pinned beam, step pressure", &[], LOADS),
    entry(
        "A26",
        "Large strain of a single element",
        &[elements::LARGE],
        "(a) in its solid form, (c): needs eight-node solids",
    ),
    entry(
        "A27",
        "J2 material drivers",
        &[materials::UNIAXIAL, materials::PATHS],
        "cyclic loading, Johnson-Cook, solids",
    ),
    entry("A29", "Conservation", &[invariance::CONSERVATION], "hex bodies in a closed box for 1e5 steps"),
    entry("A30", "Large deflection of shells", &[], RELAX),
    entry(
        "A31",
        "Independence of the partition",
        &[invariance::WORKERS],
        "A07 and B15 as scenes; 8 ranks; MPI (tests/tests/mpi.rs)",
    ),
    entry("B01", "Taylor bar, linear hardening", &[], SOLID),
    entry("B02", "Taylor bar, Johnson-Cook", &[], SOLID),
    entry("B03", "Taylor tests, experiments", &[], SOLID),
    entry("B04", "Impulsively loaded clamped beam", &[crush::BEAM], ""),
    entry("B06", "Spherical cap, step pressure", &[], LOADS),
    entry("B08", "Elastic-plastic plate, step pressure", &[], LOADS),
    entry("B09", "Twisted beam, Scordelis-Lo, pinched cylinder, hemisphere", &[], RELAX),
    entry("B10", "NAFEMS LE5 Z-section", &[], RELAX),
    entry(
        "B11",
        "Square tube, axial crush",
        &[crush::SQUARE],
        "3.33 mm mesh; a rigid head (here a guided ring of masses)",
    ),
    entry("B12", "Square tubes, mean crush force", &[crush::MEAN_FORCE], "the section 49.31 by 1.63 mm; rate"),
    entry("B13", "Circular tube, axial crush", &[crush::ROUND], "the mode of folding is not measured"),
    entry("B15", "S-beam crash", &[], "the source gives no numbers"),
    entry("B17", "Pipe impact and other experiments", &[], "no numbers could be read from the sources"),
    entry("B18", "Can crush, brick wall", &[], "qualitative; bricks need eight-node solids"),
    entry("C01", "Penalty too stiff", &[contact::STIFF], ""),
    entry(
        "C02",
        "Light node on a heavy segment and the reverse",
        &[contact::LIGHT],
        "foam block on steel: needs eight-node solids",
    ),
    entry(
        "C03",
        "Corner, facet, vertex",
        &[],
        "with an elastic cube: needs solids; worker/src/contact/enforce/tests.rs has it for a node",
    ),
    entry("C04", "Edge to edge", &[], "edges do not meet edges yet: contact is node to segment"),
    entry("C06", "Initial penetration", &[contact::SUNK], "a block of solids"),
    entry("C07", "Tunnelling through a thin shell", &[contact::FAST], "a rotating plate hit by its own edge"),
    entry("C08", "Symmetric contact, double counting", &[], LOADS),
    entry("C09", "Friction reversal", &[], LOADS),
    entry("C10", "Hourglass blow-up", &[elements::HOURGLASS], "hexes; (b) needs pressure, (c) a point load"),
    entry("C11", "Warped shells", &[elements::WARPED], "B09 table: needs loads and dynamic relaxation"),
    entry("C12", "Volumetric locking", &[], SOLID),
    entry(
        "C13",
        "Element inversion",
        &[],
        "tests/tests/endings.rs tests that an inverted shell ends the run; no hexes yet",
    ),
    entry("C14", "Time step collapse", &[], "not written yet: sliver with mass scaling"),
    entry(
        "C15",
        "Over-constraint by several pairs",
        &[contact::SANDWICH, contact::CRADLE],
        "(b) needs gravity, (c) a block in a corner, (d) has unit tests in worker/src/contact/enforce/tests.rs",
    ),
    entry("C16", "Numbering of a shell in shear", &[elements::NUMBERING], ""),
    entry("C18", "Sliding across facets and off edges", &[], LOADS),
];

#[cfg(test)]
mod tests {
    use super::*;

    /// An entry is run or says why not, once, in order.
    #[test]
    fn the_catalogue_is_whole() {
        assert!(CATALOGUE.windows(2).all(|e| e[0].id < e[1].id), "ids ascend");
        for e in CATALOGUE {
            assert!(!e.checks.is_empty() || !e.open.is_empty(), "{}: neither run nor explained", e.id);
        }
        assert_eq!(CATALOGUE.len(), 55, "the catalogue has 55 entries");
    }
}
