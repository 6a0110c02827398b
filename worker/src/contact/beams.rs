//! Beams as lines in contact: each element is a round bar about the line between its nodes, rounded
//! off at its ends, so that nothing catches where one beam ends and the next begins.
//!
//! A beam takes part by its nodes and by its line, which is both a segment that nodes meet
//! (`local.rs`) and an edge that edges meet (`edges.rs`). Lines that have a node in common do not
//! meet, nor does a node meet the lines next to its own.
//!
//! The radius is the outer one of a tube; else that of the circle of the section's area, which
//! keeps the volume, and for an I that of the rectangle around it, since nothing gets between its
//! flanges. (LS-DYNA takes for the diameter the first dimension of the section, or the square root
//! of the area where that is all it has.) A beam is no thicker than it is long, as far as
//! `thickness_limit` says so.

use crumple_proto::job::{Beam, BeamSection, Contact, Part};
use crumple_proto::partition::Settings;
use std::f64::consts::PI;

/// Radius with which beams of a section are met [length]; `None` for welds without one of their
/// own, which lie between what they join.
pub fn radius(beam: &Beam) -> Option<f64> {
    let of_area = |area: f64| (area / PI).sqrt();
    let of_section = || match beam.section {
        BeamSection::Tube => beam.radius,
        BeamSection::Rectangle | BeamSection::I => of_area(beam.height * beam.width),
        BeamSection::General => of_area(beam.area),
    };
    beam.contact_radius.or_else(|| beam.weld.is_none().then(of_section))
}

/// Radius of a part of beams in contact, by any of its interfaces; `None` if they take no part
/// [length].
pub fn half(contact: &Contact, part: &Part) -> Option<f64> {
    let touches = |c: Contact| c.has_beams() && c.takes_part(part.id);
    part.beam.as_ref().and_then(radius).filter(|_| contact.each().any(touches))
}

/// Whether edges are to be known: all of them may meet, or those that beams do.
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

    fn beam(section: BeamSection) -> Beam {
        Beam {
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
        }
    }

    #[test]
    fn the_radius_is_that_of_the_section_unless_it_is_given() {
        let of = |section| radius(&beam(section)).unwrap();
        assert_eq!(of(BeamSection::Tube), 2.0, "whatever its wall");
        for (section, area) in
            [(BeamSection::Rectangle, 12.0), (BeamSection::I, 12.0), (BeamSection::General, 5.0)]
        {
            assert!((PI * of(section).powi(2) / area - 1.0).abs() < 1e-15, "{section:?}");
        }
        let given = Beam { contact_radius: Some(0.7), ..beam(BeamSection::I) };
        assert_eq!(radius(&given), Some(0.7));
    }

    #[test]
    fn welds_take_no_part_without_a_radius() {
        let limits =
            Weld { normal: 1.0, shear: 0.0, bending: 0.0, torsion: 0.0, exponents: [2.0; 2] };
        let weld = Beam { weld: Some(limits), ..beam(BeamSection::Tube) };
        assert_eq!(radius(&weld), None);
        assert_eq!(radius(&Beam { contact_radius: Some(1.0), ..weld }), Some(1.0));
    }
}
