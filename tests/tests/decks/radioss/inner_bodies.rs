//! `/RBODY` whose group has the main node of another one. Units mm, ms, kg.

use super::{model, reading, said, with};
use std::collections::BTreeSet;

/// The cube with the main node 90, and an end of the plate with the main node 91 and the node 90.
fn bodies(lines: &str) -> String {
    let head = "_ i0 i0";
    with(&format!(
        "/NODE\ni90 r5 r5 r5\ni91 r10 r5 r12\n\
         /RBODY/1\n=cube body\ni90 i0 i0 i0 r0.5 i10 i0 i0\nr0 r0 r0\nr0 r0 r0\n{head}\n\
         /RBODY/2\n=plate body\ni91 i0 i0 i0 r0.25 i20 i0 i0\nr0 r0 r0\nr0 r0 r0\n{head}\n\
         /GRNOD/NODE/10\n=inner\ni1 i2 i3 i4 i5 i6 i7 i8\n\
         /GRNOD/NODE/20\n=outer\ni13 i16 i90\n{lines}"
    ))
}

/// Both are one body, with the masses of both main nodes, each on its own nodes. A velocity of the
/// inner main node has no effect next to that of the outer one.
#[test]
fn a_body_with_another_one_is_one_body() {
    let velocity = "/GRNOD/NODE/30\n=all\ni11 i12 i13 i14 i15 i16 i90 i91 i1 i2\n\
                    /INIVEL/TRA/3\n=v\nr1 r0 r0 i30\n";
    let found = model(&bodies(velocity));
    let [body] = &found.job.rigid[..] else { panic!("{} bodies", found.job.rigid.len()) };
    assert_eq!(body.name, "plate body");
    let parts: BTreeSet<u32> = body.parts.iter().copied().collect();
    assert_eq!(parts, [2].into());
    assert_eq!(found.job.mass.iter().map(|m| m.mass).sum::<f64>(), 0.75);
    for (mass, count) in [(0.5, 8), (0.25, 2)] {
        let own = found.job.mass.iter().find(|m| m.mass == mass).expect("the mass of a body");
        assert_eq!(found.mesh.node_sets[&own.nodes].len(), count, "{mass}");
    }
    let all = said(&found);
    assert!(all.contains("its main node 90 is a node of the body plate body"), "{all}");
    assert!(!all.contains("belongs to no element"), "{all}");
}

/// Conditions on the main node of an inner body are refused.
#[test]
fn conditions_on_an_inner_main_node_are_refused() {
    let fix = "/GRNOD/NODE/31\n=inner main\ni90\n/BCS/1\n=b\n";
    let text = bodies(fix) + "   111 000         0        31\n";
    let report = reading(&text, &[]).err().expect("a report");
    let words = "/BCS/1: node 90 is the main node of a body that another body has";
    assert!(report.contains(words), "{report}");
}
