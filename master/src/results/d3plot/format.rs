//! Binary layout of LS-DYNA's state database (*LS-DYNA Database: Binary Output Files*, Livermore
//! Software Technology Corporation 2017, chapter "State database"): single precision, the
//! geometry in the first file, states in the following ones.
//!
//! A file is a sequence of 4-byte words: 64 control words, coordinates, connectivity, user
//! numbers, titles; then for each state its time, global values, nodal values, values of solids
//! and shells, and the deletion table. Internal numbers count from 1 in the order of the file. A
//! file ends with a marker and is filled with zeros to a whole block.

use super::source::{DatabaseState, FieldMesh, PointValues};
use super::strain::StateStrains;
use std::io::{self, Write};

/// Marker at the end of the geometry and of every file.
const MARKER: f32 = -999_999.0;
/// Words per block.
const BLOCK: usize = 512;
/// Global words of a state: kinetic, internal and total energy, and the velocity of the model,
/// which is left zero.
const GLOBAL: usize = 6;
/// Words per solid: six stresses and the plastic strain.
const SOLID: usize = 7;
/// Words per point of a shell: those of a solid, and the von Mises stress as additional variable.
const POINT: usize = SOLID + 1;
/// Words per shell besides its points: thickness, two unused variables, internal energy.
const REST: usize = 4;
/// Words of a strain.
const STRAIN: usize = 6;

/// Layout of the database for one mesh.
pub struct DatabaseLayout {
    mesh: FieldMesh,
    /// True if states have strains.
    strains: bool,
}

impl DatabaseLayout {
    /// Creates the layout for this mesh, with strains if `strains` is true.
    pub fn new(mesh: FieldMesh, strains: bool) -> Self {
        Self { mesh, strains }
    }

    /// Returns the number of points of a shell.
    fn points(&self) -> usize {
        self.mesh.points.max(1)
    }

    /// Returns the number of words of a solid and of a shell.
    fn words_of_elements(&self) -> [usize; 2] {
        let strain = if self.strains { STRAIN } else { 0 };
        [SOLID + strain, self.points() * POINT + REST + 2 * strain]
    }

    /// Returns the number of words of one state.
    fn state_words(&self) -> usize {
        let (solids, shells) = (self.mesh.solids.len(), self.mesh.shells.len());
        let [solid, shell] = self.words_of_elements();
        1 + GLOBAL + 6 * self.mesh.nodes.len() + solids * (solid + 1) + shells * (shell + 1)
    }

    /// Returns the number of bytes of one state.
    pub fn state_bytes(&self) -> u64 {
        4 * self.state_words() as u64
    }

    /// Writes the first file: control words, geometry, user numbers, titles.
    pub fn write_geometry(&self, out: &mut dyn Write) -> io::Result<()> {
        let m = &self.mesh;
        let mut words = self.control();
        words.floats(m.x.iter().flatten().copied());
        for (element, corners) in m.solids.iter().zip(&m.solid_corners) {
            words.ints(corners.iter().map(|c| c + 1));
            words.int(m.part_of(element.part));
        }
        for (element, corners) in m.shells.iter().zip(&m.shell_corners) {
            words.ints(corners.iter().map(|c| c + 1));
            words.int(m.part_of(element.part));
        }
        self.numbers(&mut words);
        words.float(MARKER);
        words.int(90_001); // titles of parts follow
        words.int(m.parts.len() as i32);
        for (id, name) in &m.parts {
            words.int(*id);
            words.text(name, 18);
        }
        words.float(MARKER);
        words.fill();
        out.write_all(&words.bytes)
    }

    fn control(&self) -> Words {
        let m = &self.mesh;
        let (solids, shells) = (m.solids.len() as i32, m.shells.len() as i32);
        let solid_parts =
            m.parts.iter().filter(|(id, _)| m.solids.iter().any(|e| e.part == *id)).count() as i32;
        let all_parts = m.parts.len() as i32;
        let mut w = Words::default();
        w.text(&m.title, 10);
        w.ints([0, 1, 0]); // run time not set; the kind of file; version of the source
        w.text("R7", 1);
        w.float(971.0);
        w.ints([4, m.nodes.len() as i32, 6, GLOBAL as i32]); // unpacked, three dimensions
        w.ints([0, 1, 1, 0]); // no temperatures; coordinates; velocities; no accelerations
        let [solid, shell] = self.words_of_elements().map(|words| words as i32);
        w.ints([solids, solid_parts, 0, 0, solid]);
        w.ints([0, 0, 0]); // beams
        w.ints([shells, all_parts - solid_parts, shell]);
        // Additional variables of solids, which are strains, and of shells.
        w.ints([solid - SOLID as i32, 1]);
        w.int(-(10_000 + self.points() as i32)); // points of shells, and the deletion table
        w.ints([0, 0, self.number_words() as i32]); // particles; the user numbers
        w.ints([0, 0, 0]); // thick shells
        w.ints([1000, 1000, 0, 1000]); // stress, plastic strain, no resultants, thickness, energy
        w.ints([0, 0, 0, 0, all_parts]); // multi-material, fluids, adaptivity; parts
        w.ints([0; 12]); // no other data
        debug_assert_eq!(w.bytes.len(), 4 * 64);
        w
    }

    fn number_words(&self) -> usize {
        let m = &self.mesh;
        16 + m.nodes.len() + m.solids.len() + m.shells.len() + 3 * m.parts.len()
    }

    /// Writes the user numbers: start and length of each list, then the lists.
    fn numbers(&self, words: &mut Words) {
        let m = &self.mesh;
        let (nodes, solids, shells) =
            (m.nodes.len() as i32, m.solids.len() as i32, m.shells.len() as i32);
        let parts = m.parts.len() as i32;
        let after_nodes = 1 + nodes;
        let after_solids = after_nodes + solids;
        let after_shells = after_solids + shells;
        // A negative first number means that numbers of parts follow.
        words.ints([-1, after_nodes, after_solids, after_solids, after_shells]);
        words.ints([nodes, solids, 0, shells, 0]);
        words.ints([after_shells, after_shells + parts, after_shells + 2 * parts, parts, 0, parts]);
        words.ints(m.nodes.iter().copied());
        words.ints(m.solids.iter().map(|e| e.id));
        words.ints(m.shells.iter().map(|e| e.id));
        let ids = || m.parts.iter().map(|p| p.0);
        words.ints(ids()); // ascending, as they come, and their order
        words.ints(ids());
        words.ints(1..=parts);
    }

    /// Writes one state and returns the number of its words.
    pub fn write_state(
        &self,
        out: &mut dyn Write,
        state: &DatabaseState,
        strains: Option<&StateStrains>,
    ) -> io::Result<usize> {
        debug_assert_eq!(strains.is_some(), self.strains);
        let m = &self.mesh;
        let mut words = Words::default();
        words.float(state.time as f32);
        let [kinetic, internal, total] = state.energies.map(|e| e as f32);
        words.floats([kinetic, internal, total, 0.0, 0.0, 0.0]);
        words.floats(state.x.iter().flatten().copied());
        words.floats(state.v.iter().flatten().copied());
        for (i, values) in state.solids.iter().enumerate() {
            words.floats(values.stress);
            words.float(values.plastic_strain);
            words.floats(strains.iter().flat_map(|s| s.solids[i]));
        }
        for (i, values) in state.shells.iter().enumerate() {
            match m.points {
                0 => {
                    words.floats(values.stress);
                    words.floats([values.plastic_strain, values.von_mises]);
                }
                count => {
                    let own = &state.points[i * count..][..count];
                    order(count).for_each(|k| words.point(&own[k]));
                }
            }
            words.floats([values.thickness, 0.0, 0.0]);
            words.floats(strains.iter().flat_map(|s| s.shells[i]).flatten());
            words.float(0.0);
        }
        // The part number of an existing element, zero of a deleted one.
        let left =
            |(element, values): (&super::source::ElementIds, &super::source::StateValues)| {
                if values.alive { m.part_of(element.part) as f32 } else { 0.0 }
            };
        words.floats(m.solids.iter().zip(&state.solids).map(left));
        words.floats(m.shells.iter().zip(&state.shells).map(left));
        debug_assert_eq!(words.bytes.len(), 4 * self.state_words());
        out.write_all(&words.bytes)?;
        Ok(self.state_words())
    }

    /// Ends a file of `words` words.
    pub fn end(&self, out: &mut dyn Write, words: usize) -> io::Result<()> {
        out.write_all(&MARKER.to_ne_bytes())?;
        out.write_all(&vec![0; 4 * ((words + 1).next_multiple_of(BLOCK) - words - 1)])
    }
}

/// Returns the points of a shell in the order of the format: three points are the middle, the inner
/// and the outer one; others come from the inner surface to the outer one.
fn order(count: usize) -> impl Iterator<Item = usize> {
    let three = [1, 0, 2];
    (0..count).map(move |k| if count == 3 { three[k] } else { k })
}

/// Words under construction.
#[derive(Default)]
struct Words {
    bytes: Vec<u8>,
}

impl Words {
    fn int(&mut self, value: i32) {
        self.bytes.extend(value.to_ne_bytes());
    }

    fn ints(&mut self, values: impl IntoIterator<Item = i32>) {
        values.into_iter().for_each(|v| self.int(v));
    }

    fn float(&mut self, value: f32) {
        self.bytes.extend(value.to_ne_bytes());
    }

    fn floats(&mut self, values: impl IntoIterator<Item = f32>) {
        values.into_iter().for_each(|v| self.float(v));
    }

    /// Adds a point of a shell.
    fn point(&mut self, point: &PointValues) {
        let [xx, yy, zz, xy, yz, zx] = point.stress;
        let direct = (xx - yy).powi(2) + (yy - zz).powi(2) + (zz - xx).powi(2);
        let shear = xy * xy + yz * yz + zx * zx;
        self.floats(point.stress);
        self.floats([point.plastic_strain, (0.5 * direct + 3.0 * shear).sqrt()]);
    }

    /// Adds a text of `words` words, cut or filled with blanks. A character that is not ASCII
    /// becomes a question mark.
    fn text(&mut self, text: &str, words: usize) {
        let plain =
            text.chars().map(|c| if c.is_ascii_graphic() || c == ' ' { c as u8 } else { b'?' });
        self.bytes.extend(plain.chain(std::iter::repeat(b' ')).take(4 * words));
    }

    /// Fills the last block with zeros.
    fn fill(&mut self) {
        self.bytes.resize(self.bytes.len().next_multiple_of(4 * BLOCK), 0);
    }
}
