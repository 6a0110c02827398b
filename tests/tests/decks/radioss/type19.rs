//! `/INTER/TYPE19`: contact of two surfaces with their edges. Units mm, ms, kg.

use super::{model, reading, said, with};

fn interface(first: &str, sensor: &str) -> String {
    with(&format!(
        "/SURF/PART/1\n=plate\ni1\n/SURF/PART/2\n=cube\ni2\n/INTER/TYPE19/7\n=both\n\
         {first}\nr0 r0\nr1 r0 r0 r0 i0 i0\nr0 r0.3 r1.76 r0 r5\n\
         _ _ _ i5 r0 r0 r0\ni0 i0 r0 i0 {sensor}\n"
    ))
}

/// The fields of TYPE7, between surfaces, and contact of edges.
#[test]
fn two_surfaces_and_their_edges_are_in_contact() {
    let found = model(&interface("i1 i2 i4 i0 i1000 i0 i0 i0 i0", "i0"));
    let contact = found.job.contact.as_ref().expect("a contact");
    assert!(contact.edges && contact.interface.is_empty());
    assert_eq!((&contact.parts[..], &contact.against[..]), (&[1][..], &[2][..]));
    assert_eq!((contact.friction, contact.thickness), (0.3, Some(1.76)));
    assert!(said(&found).contains("/INTER/TYPE19"), "{}", said(&found));
    let report = reading(&interface("i1 i2 i4 i0 i0 i0 i0 i0 i0", "i3"), &[]).err();
    assert!(report.expect("a report").contains("contact that a sensor starts"));
}
