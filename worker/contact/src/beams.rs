//! Beams and trusses in contact: each element is a round bar about the line between its nodes, with
//! rounded ends, so that nothing catches between two consecutive beams.
//!
//! A beam is in contact by its nodes and by its line. The line is both a segment for nodes
//! (`local_search.rs`) and an edge for edges (`edges.rs`). Lines with a common node do not touch
//! each other, and a node does not touch the lines next to its own.
//!
//! The radius of a tube is its outer radius. For other sections it is the radius of the circle
//! with the same area, which keeps the volume. For an I it is that of the rectangle around the
//! section, because nothing fits between its flanges. (LS-DYNA uses as the diameter the first
//! dimension of the section, or the square root of the area if only the area is given.) The
//! diameter of a beam is limited to its length where `thickness_limit` requires this.

use crumple_proto::job::{BeamInput, BeamSection, ContactInput, Part, TrussInput};
use crumple_proto::partition::Settings;
use std::f64::consts::PI;

/// Returns the radius of the circle with an area [length].
fn of_area(area: f64) -> f64 {
    (area / PI).sqrt()
}

/// Returns the contact radius of trusses [length].
fn of_truss(truss: &TrussInput) -> f64 {
    truss.contact_radius.unwrap_or_else(|| of_area(truss.area))
}

/// Returns the contact radius of beams with a section [length]. Returns `None` for welds without
/// a contact radius, which are between the parts that they join.
pub fn radius(beam: &BeamInput) -> Option<f64> {
    let of_section = || match beam.section {
        BeamSection::Tube => beam.radius,
        BeamSection::Rectangle | BeamSection::I => of_area(beam.height * beam.width),
        BeamSection::General => of_area(beam.area),
    };
    beam.contact_radius.or_else(|| beam.weld.is_none().then(of_section))
}

/// Returns true for parts of beams or trusses.
pub fn has_bars(part: &Part) -> bool {
    part.beam.is_some() || part.truss.is_some()
}

/// Returns the contact radius of a part of beams or trusses in any of its interfaces, or `None` if
/// it is not in contact [length].
pub fn half(contact: &ContactInput, part: &Part) -> Option<f64> {
    let touches = |c: ContactInput| c.has_beams() && c.takes_part(part.id);
    let of_truss = || part.truss.as_ref().map(of_truss);
    let radius = part.beam.as_ref().map_or_else(of_truss, radius);
    radius.filter(|_| contact.each().any(touches))
}

/// Returns true if edges are needed: either all edges can touch, or those of beams can.
pub fn with_edges(settings: &Settings) -> bool {
    settings
        .contact
        .as_ref()
        .is_some_and(|c| c.edges || settings.parts.iter().any(|p| half(c, p).is_some()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crumple_proto::job::Weld;

    fn beam(section: BeamSection) -> BeamInput {
        BeamInput {
            section,
            height: 4.0,
            width: 3.0,
            flange: 0.0,
            web: 0.0,
            radius: 2.0,
            wall: 0.5,
            area: 5.0,
            second_moments: [0.0; 2],
            torsion: 0.0,
            shear_areas: [0.0; 2],
            weld: None,
            contact_radius: None,
            preload: Vec::new(),
            preload_bending: false,
        }
    }

    #[test]
    fn the_radius_is_that_of_the_section_unless_it_is_given() {
        let of = |section| radius(&beam(section)).unwrap();
        assert_eq!(of(BeamSection::Tube), 2.0, "for any wall thickness");
        for (section, area) in
            [(BeamSection::Rectangle, 12.0), (BeamSection::I, 12.0), (BeamSection::General, 5.0)]
        {
            assert!((PI * of(section).powi(2) / area - 1.0).abs() < 1e-15, "{section:?}");
        }
        let given = BeamInput { contact_radius: Some(0.7), ..beam(BeamSection::I) };
        assert_eq!(radius(&given), Some(0.7));
    }

    #[test]
    fn welds_take_no_part_without_a_radius() {
        let limits =
            Weld { normal: 1.0, shear: 0.0, bending: 0.0, torsion: 0.0, exponents: [2.0; 2] };
        let weld = BeamInput { weld: Some(limits), ..beam(BeamSection::Tube) };
        assert_eq!(radius(&weld), None);
        assert_eq!(radius(&BeamInput { contact_radius: Some(1.0), ..weld }), Some(1.0));
    }
}
