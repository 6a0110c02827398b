//! Boundaries that let waves out: dampers at the nodes of outer faces of solids.
//!
//! A plane wave that meets a plane with the traction `-rho c_p v_n` along the normal and
//! `-rho c_s v_t` in the plane is not reflected if it comes along the normal; oblique ones are in
//! part (Lysmer & Kuhlemeyer, Finite dynamic model for infinite media, J. Eng. Mech. Div. ASCE 95,
//! 1969). c_p and c_s are the elastic speeds of dilatation and shear at the start. Each corner of a
//! face has its share of the area, and areas and normals are those of the start, so that the
//! dampers of a node are one constant matrix
//! ```text
//! C = sum over faces of A_a (rho c_p n n' + rho c_s (1 - n n'))
//! ```

use super::loads::part_faces;
use super::state::NodeSets;
use super::validate::JobProblems;
use crumple_proto::ids::NodeId;
use crumple_proto::job::Job;
use crumple_proto::loads::Absorber;
use crumple_proto::mesh::{Mesh, MeshElement};
use crumple_proto::partition::Settings;
use crumple_proto::problem::Problem;
use crumple_worker::fem::materials::elastic_of;
use std::collections::{BTreeMap, HashMap};

/// Returns the dampers of all nodes on such boundaries, in ascending id.
pub fn resolve(
    job: &Job,
    mesh: &Mesh,
    settings: &Settings,
    sets: &NodeSets<'_>,
    findings: &mut JobProblems,
) -> Vec<Absorber> {
    let mut sums: BTreeMap<NodeId, [f64; 6]> = BTreeMap::new();
    if job.non_reflecting.is_empty() {
        return Vec::new();
    }
    let impedances: HashMap<u32, [f64; 2]> = settings
        .parts
        .iter()
        .filter_map(|part| Some((part.id, impedance(settings, &part.material)?)))
        .collect();
    let place: HashMap<NodeId, usize> =
        mesh.nodes.iter().enumerate().map(|(n, node)| (node.id, n)).collect();
    for (i, boundary) in job.non_reflecting.iter().enumerate() {
        let path = format!("non_reflecting.{i}");
        let of = (&boundary.parts[..], &boundary.nodes);
        let what = "non-reflecting boundary";
        let Some(faces) = part_faces(of, &path, what, (job, mesh, sets), findings) else {
            continue;
        };
        let waves = [boundary.pressure_waves, boundary.shear_waves];
        if waves == [false; 2] {
            let message = "a non-reflecting boundary lets no waves out";
            let help = "set `pressure_waves` or `shear_waves`, or remove it";
            findings.add(Problem::warning(&path, message, help));
        }
        let mut others = 0;
        for (element, face) in faces {
            let e = &mesh.elements[element];
            match impedances.get(&e.part).filter(|_| e.shape.is_solid()) {
                Some(&[normal, shear]) => {
                    let each = [(waves[0], normal), (waves[1], shear)];
                    let each = each.map(|(acts, impedance)| if acts { impedance } else { 0.0 });
                    add_face(&mut sums, (e, face), each, |id| mesh.nodes[place[&id]].x);
                }
                None => others += 1,
            }
        }
        if others > 0 {
            let message =
                format!("{others} faces of a non-reflecting boundary are of no elastic solid");
            let help = "name faces of solids of a material that has wave speeds";
            findings.add(Problem::error(&path, message, help));
        }
    }
    sums.into_iter().map(|(node, damping)| Absorber { node, damping }).collect()
}

/// Returns rho c of dilatation and shear of a material [mass/(length^2 time)].
fn impedance(settings: &Settings, material: &str) -> Option<[f64; 2]> {
    let material = settings.materials.iter().find(|m| m.name == material)?;
    let elastic = elastic_of(material).ok().flatten()?;
    let of = |modulus: f64| (elastic.density * modulus).sqrt();
    let [p, s] = [elastic.lame() + 2.0 * elastic.shear_modulus(), elastic.shear_modulus()].map(of);
    (p.is_finite() && s.is_finite()).then_some([p, s])
}

/// Adds the dampers of a face of a solid to its nodes, with these impedances along the normal and
/// in the plane.
fn add_face(
    sums: &mut BTreeMap<NodeId, [f64; 6]>,
    (e, face): (&MeshElement, usize),
    [normal, shear]: [f64; 2],
    place: impl Fn(NodeId) -> [f64; 3],
) {
    let corners = e.shape.faces()[face];
    let count = if corners[2] == corners[3] { 3 } else { 4 };
    let x = corners.map(|c| place(e.nodes[c]));
    let between = |a: usize, b: usize| [0, 1, 2].map(|c| x[b][c] - x[a][c]);
    let (a, b) = (between(0, 2), if count == 4 { between(1, 3) } else { between(0, 1) });
    let twice = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    let size = twice.iter().map(|c| c * c).sum::<f64>().sqrt();
    if size == 0.0 {
        return;
    }
    let n = twice.map(|c| c / size);
    let shares = e.shape.load_shares(face);
    for corner in 0..count {
        let area = 0.5 * size / count as f64 * shares[corner];
        let sum = sums.entry(e.nodes[corners[corner]]).or_insert([0.0; 6]);
        for (k, (r, c)) in [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)].into_iter().enumerate()
        {
            let unit = if r == c { 1.0 } else { 0.0 };
            sum[k] += area * (normal * n[r] * n[c] + shear * (unit - n[r] * n[c]));
        }
    }
}
