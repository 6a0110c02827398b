//! Thicknesses of single shells, and shells whose middle surface is offset from their nodes.
//! Units mm, ms, kg.

use crumple::input::job::{self, Model};
use crumple_tests::sheets::distance_at_contact;
use crumple_tests::{case, model_of, read, run_alone, run_side_by_side};
use crumple_verification::scene::Scene;
use crumple_worker::engine::Engine;

/// Steel without transverse strain, so that strips are beams.
const E: f64 = 200.0;
const RHO: f64 = 7.85e-6;
const WIDTH: f64 = 10.0;

/// Runs a strip of `n` squares along x, clamped at x = 0 and pulled at its other end by `force`,
/// with damping until it is at rest.
fn strip(
    n: usize,
    thickness: f64,
    [force, damping, end]: [f64; 3],
    of_part: &str,
    of_mesh: &str,
) -> Model {
    let mut scene = Scene::default();
    let grid = scene.lattice(1, [n, 1], |i, j| [WIDTH * i as f64, WIDTH * j as f64, 0.0]);
    scene.mesh(of_mesh);
    scene.set_named("root", &grid.row(0));
    scene.set_named("tip", &grid.row(n));
    let text = format!(
        "end_time = {end:?}\n{}[time]\n\
         damping = {damping:?}\n[output]\n\
         field_interval = -1.0\n[[material]]\nname = \"steel\"\nlaw = \"elastic\"\n\
         density = {RHO:?}\nyoungs_modulus = {E:?}\n\
         poisson = 0.0\n[[part]]\nid = 1\nmaterial = \"steel\"\nthickness = {thickness:?}\n\
         {of_part}\n[[fix]]\nnodes = \"root\"\n\
         dofs = [\"x\", \"y\", \"z\", \"rx\", \"ry\", \"rz\"]\n[[load]]\nnodes = \"tip\"\n\
         force = [{force:?}, 0.0, 0.0]\n",
        scene.mesh_text()
    );
    model_of(&text, &[])
}

/// Returns the displacement of a node along an axis.
fn moved(e: &Engine, node: usize, axis: usize) -> f64 {
    e.nodes.x[node][axis] - e.nodes.x0[node][axis]
}

fn near(found: f64, wanted: f64, tolerance: f64, why: &str) {
    assert!((found / wanted - 1.0).abs() < tolerance, "{found}, expected {wanted}: {why}");
}

/// Half of a strip is twice as thick: it has twice the weight, half of the stress and half of
/// the elongation.
#[test]
fn a_strip_of_two_thicknesses_lengthens_and_weighs_by_each() {
    let (n, force) = (8, 0.1);
    let model = strip(
        n,
        1.0,
        [force, 200.0, 0.6],
        "",
        "thicknesses = [[5, 2.0], [6, 2.0], [7, 2.0], [8, 2.0]]",
    );
    let masses: Vec<f64> = model.elements.mass.iter().map(|m| m / (RHO * WIDTH * WIDTH)).collect();
    (0..n).for_each(|e| {
        near(masses[e], if e < 4 { 1.0 } else { 2.0 }, 1e-12, "round-off of the mass")
    });
    let said = crumple::input::check::describe(&model);
    assert!(said.contains("1 to 2"), "{said}");
    let engine = run_alone(&model, |_| {});
    let total: f64 = (0..engine.nodes.len()).map(|i| engine.nodes.mass[i]).sum();
    near(total, RHO * WIDTH * WIDTH * 12.0, 1e-12, "round-off of the mass of all");
    let half = 4.0 * WIDTH * force / (E * WIDTH);
    near(moved(&engine, 8, 0), half, 1e-3, "the thin half; strains of 5e-5 and residual damping");
    near(moved(&engine, 17, 0), 1.5 * half, 1e-3, "both halves");
    let block = &engine.blocks.blocks[0];
    for e in 0..n {
        let fields = block
            .element
            .fields(block.state(e), &[[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]);
        let thickness = if e < 4 { 1.0 } else { 2.0 };
        assert_eq!(fields.thickness, thickness);
        near(fields.stress[0], force / (WIDTH * thickness), 1e-3, "stress");
    }
}

/// A strip is pulled along its nodes, e below its middle. As in a beam under tension and
/// bending, its tip moves until its middle is on the line of the force: it rises by `e (1 -
/// 1/cosh k L)`, `k^2 = F/EI`.
#[test]
fn a_strip_with_an_offset_rises_towards_the_line_of_the_force() {
    let (n, thickness, force) = (6, 2.0, 0.1);
    let (length, inertia) = (WIDTH * n as f64, WIDTH * 8.0 / 12.0);
    let k = (force / (E * inertia)).sqrt();
    for offset in [1.0, -0.5] {
        let model = strip(n, thickness, [force, 8.0, 6.0], &format!("offset = {offset:?}"), "");
        let engine = run_alone(&model, |_| {});
        let wanted = 0.5 * offset * thickness * (1.0 - 1.0 / (k * length).cosh());
        near(moved(&engine, 2 * n, 2), wanted, 0.01, "six elements and residual damping");
    }
}

/// The same strip with the offset e1 on the half at the clamp and e2 on the other half. With `u =
/// w - w(L)` its equation is `u'' = k^2 (u + e)`; two halves with `C = cosh kL/2`, `S = sinh
/// kL/2` give `w(L) = e1 - (e2 - (e2 - e1) C)/(C^2 + S^2)`.
#[test]
fn a_strip_with_two_offsets_bends_by_each() {
    let (n, thickness, force) = (6, 2.0, 0.1);
    let (length, inertia) = (WIDTH * n as f64, WIDTH * 8.0 / 12.0);
    let k = (force / (E * inertia)).sqrt();
    let (c, s) = ((0.5 * k * length).cosh(), (0.5 * k * length).sinh());
    for [one, two] in [[0.0, 1.0], [1.0, 0.0], [1.0, -0.5]] {
        let rows = (1..=n).map(|e| format!("[{e}, {:?}]", if e <= n / 2 { one } else { two }));
        // Shells without a row have the offset of the part.
        let rows: Vec<String> = rows.skip(usize::from(one == 1.0)).collect();
        let rows = format!("offsets = [{}]", rows.join(", "));
        let of_part = format!("offset = {one:?}");
        let model = strip(n, thickness, [force, 8.0, 6.0], &of_part, &rows);
        let engine = run_alone(&model, |_| {});
        let [e1, e2] = [one, two].map(|offset| 0.5 * offset * thickness);
        let wanted = e1 - (e2 - (e2 - e1) * c) / (c * c + s * s);
        let found = moved(&engine, 2 * n, 2);
        let scale = e1.abs().max(e2.abs()) * (1.0 - 1.0 / (k * length).cosh());
        assert!(
            (found - wanted).abs() < 0.01 * scale,
            "offsets {one} and {two}: {found}, expected {wanted}: six elements and residual damping"
        );
    }
}

/// Two sheets that fly at each other turn back when their middles are half the sum of the
/// thicknesses of the touching shells apart.
#[test]
fn shells_meet_at_their_own_thickness() {
    let rows =
        |value: &str| (10..19).map(|e| format!("[{e}, {value}]")).collect::<Vec<_>>().join(", ");
    let (thick, down) = (rows("3.0"), rows("-1.0"));
    for (thicknesses, of_part, wanted) in [
        ("", "contact_thickness_scale=1.0", 1.0),
        (thick.as_str(), "contact_thickness_scale=1.0", 2.0),
        ("[5, 4.0]", "contact_thickness_scale=1.0", 2.5),
        ("[5, 0.5]", "contact_thickness_scale=1.0", 1.0),
        ("", "contact_thickness=4.0", 2.5),
        (thick.as_str(), "contact_thickness_scale=0.5", 1.25),
        (thick.as_str(), "contact_thickness=0.4", 0.7),
    ] {
        let sets = [format!("mesh.thicknesses=[{thicknesses}]"), format!("part.2.{of_part}")];
        let apart = distance_at_contact("[contact]", &[&sets[0], &sets[1]]);
        assert!((apart - wanted).abs() < 0.01, "{sets:?}: distance {apart}, expected {wanted}");
    }
    // The sheets touch at the middle surface of each shell.
    for (offsets, of_part, wanted) in [
        (down.as_str(), 0.0, 1.5),
        (down.as_str(), 2.0, 1.5),
        ("[14, -1.0]", 0.0, 1.5),
        ("[14, 1.0]", 0.0, 1.0),
        ("[14, -0.5]", 0.2, 1.25),
    ] {
        let sets = [format!("mesh.offsets=[{offsets}]"), format!("part.2.offset={of_part:?}")];
        let contact = "[contact]\nshell_offset = true";
        let apart = distance_at_contact(contact, &[&sets[0], &sets[1]]);
        assert!((apart - wanted).abs() < 0.01, "{sets:?}: distance {apart}, expected {wanted}");
    }
}

/// Thicknesses of single shells and offsets in a scene with dense contact: the same bits on any
/// number of workers.
#[test]
fn own_thicknesses_and_offsets_give_the_same_bits_on_any_number_of_workers() {
    let plain = read(&case("tumble"), &["time.max_cycles=600"]);
    let rows = plain.mesh.elements.iter().filter(|e| e.id.label() % 3 != 0);
    let rows: Vec<String> = rows
        .map(|e| format!("[{}, {:?}]", e.id.label(), 0.8 + 0.1 * (e.id.label() % 5) as f64))
        .collect();
    let thicknesses = format!("mesh.thicknesses=[{}]", rows.join(", "));
    let model = read(
        &case("tumble"),
        &["time.max_cycles=600", &thicknesses, "part.1.offset=0.5", "part.5.offset=-1.0"],
    );
    let own: Vec<String> = plain
        .mesh
        .elements
        .iter()
        .step_by(4)
        .map(|e| e.id.label())
        .map(|id| format!("[{id}, {:?}]", 0.5 * (id % 5) as f64 - 1.0))
        .collect();
    let offsets = format!("mesh.offsets=[{}]", own.join(", "));
    let shifted = read(
        &case("tumble"),
        &["time.max_cycles=600", "contact.shell_offset=true", &offsets, "part.5.offset=-1.0"],
    );
    let serial = run_side_by_side(&model, 1, 600, 0);
    assert_ne!(serial.digest(), run_side_by_side(&plain, 1, 600, 0).digest(), "they matter");
    for (workers, force_every) in [(2, 0), (3, 7), (4, 0)] {
        assert_eq!(
            serial.digest(),
            run_side_by_side(&model, workers, 600, force_every).digest(),
            "{workers} workers"
        );
    }
    let serial = run_side_by_side(&shifted, 1, 600, 0);
    for (workers, force_every) in [(2, 0), (3, 7)] {
        let found = run_side_by_side(&shifted, workers, 600, force_every);
        assert_eq!(serial.digest(), found.digest(), "offsets of single shells, {workers} workers");
    }
}

/// Contact at the middle surface in a scene with dense contact: the same bits on any number of
/// workers, with each law. Without an offset the option changes nothing.
#[test]
fn contact_at_middle_surfaces_gives_the_same_bits_on_any_number_of_workers() {
    let digest = |sets: &[&str], workers: usize, force_every: u64| {
        let model = read(&case("tumble"), &[&["time.max_cycles=400"][..], sets].concat());
        run_side_by_side(&model, workers, 400, force_every).digest()
    };
    let offsets = ["part.1.offset=0.5", "part.5.offset=-1.0"];
    for law in LAWS {
        let law = format!("contact.law={law}");
        let of = |shifted: &'static str| [&offsets[..], &[&law, shifted]].concat();
        let serial = digest(&of("contact.shell_offset=true"), 1, 0);
        assert_ne!(serial, digest(&of("contact.shell_offset=false"), 1, 0), "{law}: it matters");
        for (workers, force_every) in [(2, 0), (3, 7), (4, 0)] {
            let found = digest(&of("contact.shell_offset=true"), workers, force_every);
            assert_eq!(serial, found, "{law}, {workers} workers");
        }
    }
    assert_eq!(digest(&["contact.shell_offset=true"], 2, 0), digest(&[], 1, 0));
}

#[test]
fn mistakes_in_thicknesses_and_offsets_are_reported_all_at_once() {
    let sets = [
        "mesh.thicknesses=[[1, -2.0], [999999, 1.0], [2, 1.0], [2, 3.0]]".to_string(),
        "mesh.offsets=[[3, -11.0], [4, 0.5], [4, 0.5], [999998, 1.0]]".to_string(),
        "part.1.offset=30.0".to_string(),
        "part.1.contact_thickness=0.0".to_string(),
        "contact.friction_limit=-1.0".to_string(),
    ];
    let report = job::read(&case("tumble"), &sets).err().expect("it is wrong").to_string();
    for words in [
        "element 1: its thickness is -2.0",
        "there is no element 999999",
        "element 2 is given a thickness twice",
        "element 3: its offset is -11.0",
        "there is no element 999998",
        "element 4 is given an offset twice",
        "offset is 30",
        "contact_thickness is 0",
        "`friction_limit` is -1.0",
    ] {
        assert!(report.contains(words), "{words} in\n{report}");
    }
}

const LAWS: [&str; 4] = ["lagrange", "kinematic", "penalty", "mortar"];
