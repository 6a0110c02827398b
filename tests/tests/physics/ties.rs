//! Nodes tied to surfaces: waves through a tie, momentum and energy, the same bits on any number
//! of workers, and jobs with errors. Units mm, ms, kg.

use crumple::input::job::{self, Model};
use crumple_tests::{run_alone, run_side_by_side};
use crumple_worker::energy::momentum;
use crumple_worker::engine::Engine;

const E: f64 = 207.0;
const RHO: f64 = 7.85e-6;
/// Length of each bar, its side, and the length of its cells [mm].
const LENGTH: f64 = 60.0;
const SIDE: f64 = 4.0;
const CELL: f64 = 1.0;

/// Rows of a mesh.
#[derive(Default)]
struct Rows {
    nodes: String,
    shells: String,
    solids: String,
    beams: String,
    count: usize,
    elements: usize,
}

impl Rows {
    fn node(&mut self, [x, y, z]: [f64; 3]) -> usize {
        self.count += 1;
        self.nodes += &format!("[{}, {x:?}, {y:?}, {z:?}],\n", self.count);
        self.count
    }

    /// Adds a block of solids from one corner to the opposite one; returns its nodes by their
    /// grid indices.
    fn block(
        &mut self,
        part: u32,
        [from, to]: [[f64; 3]; 2],
        n: [usize; 3],
    ) -> Vec<([usize; 3], usize)> {
        let mut ids = Vec::new();
        for k in 0..=n[2] {
            for j in 0..=n[1] {
                for i in 0..=n[0] {
                    let at = [i, j, k];
                    let x =
                        [0, 1, 2].map(|c| from[c] + (to[c] - from[c]) * at[c] as f64 / n[c] as f64);
                    ids.push((at, self.node(x)));
                }
            }
        }
        let id = |i: usize, j: usize, k: usize| ids[(k * (n[1] + 1) + j) * (n[0] + 1) + i].1;
        for k in 0..n[2] {
            for j in 0..n[1] {
                for i in 0..n[0] {
                    let layer =
                        |k| [id(i, j, k), id(i + 1, j, k), id(i + 1, j + 1, k), id(i, j + 1, k)];
                    self.elements += 1;
                    let corners = [layer(k), layer(k + 1)].concat();
                    let corners: Vec<String> = corners.iter().map(usize::to_string).collect();
                    self.solids +=
                        &format!("[{}, {part}, {}],\n", self.elements, corners.join(", "));
                }
            }
        }
        ids
    }

    /// Adds a plate of shells perpendicular to the third axis; returns its nodes, row by row.
    fn plate(&mut self, part: u32, [from, to]: [[f64; 2]; 2], z: f64, n: [usize; 2]) -> Vec<usize> {
        let place = |c: usize, i: usize| from[c] + (to[c] - from[c]) * i as f64 / n[c] as f64;
        let mut ids = Vec::new();
        for j in 0..=n[1] {
            for i in 0..=n[0] {
                ids.push(self.node([place(0, i), place(1, j), z]));
            }
        }
        let id = |i: usize, j: usize| ids[j * (n[0] + 1) + i];
        for j in 0..n[1] {
            for i in 0..n[0] {
                self.elements += 1;
                let corners =
                    [id(i, j), id(i + 1, j), id(i + 1, j + 1), id(i, j + 1)].map(|n| n.to_string());
                self.shells += &format!("[{}, {part}, {}],\n", self.elements, corners.join(", "));
            }
        }
        ids
    }

    fn job(&self, sets: &[(&str, Vec<usize>)], rest: &str) -> String {
        let sets: Vec<String> =
            sets.iter().map(|(name, ids)| format!("{name} = {ids:?}")).collect();
        format!(
            "[mesh]\nnodes = [{}]\nshells = [{}]\nsolids = [{}]\nbeams = [{}]\n\
             node_sets = {{ {} }}\n\
             [output]\nfield_interval = -1.0\n[[material]]\nname = \"steel\"\nlaw = \"elastic\"\n\
             density = {RHO:?}\n\
             youngs_modulus = {E:?}\npoisson = 0.0\n{rest}",
            self.nodes,
            self.shells,
            self.solids,
            self.beams,
            sets.join(", ")
        )
    }
}

fn model(text: &str) -> Result<Model, String> {
    let there = tempfile::tempdir().unwrap();
    let path = there.path().join("ties.toml");
    std::fs::write(&path, text).unwrap();
    job::read(&path, &[]).map_err(|report| report.to_string())
}

/// Returns two bars end to end, with 2 x 2 and 3 x 3 cells in the cross section. The nodes at
/// the end of the second bar are tied to the first bar, at the distance `gap`.
fn bars(gap: f64, rest: &str) -> String {
    let mut rows = Rows::default();
    let along = (LENGTH / CELL) as usize;
    rows.block(1, [[0.0; 3], [LENGTH, SIDE, SIDE]], [along, 2, 2]);
    let second =
        rows.block(2, [[LENGTH + gap, 0.0, 0.0], [2.0 * LENGTH, SIDE, SIDE]], [along, 3, 3]);
    let end = second.iter().filter(|(at, _)| at[0] == 0).map(|n| n.1).collect();
    let own = second.iter().map(|n| n.1).collect();
    let parts = "[[part]]\nid = 1\nmaterial = \"steel\"\n[[part]]\nid = 2\nmaterial = \"steel\"\n";
    rows.job(&[("end", end), ("second", own)], &format!("{parts}{rest}"))
}

/// Conserved quantities of a free run: the largest changes of momentum and angular momentum
/// since the first step seen, and the largest error of the energy as a fraction of the initial
/// energy.
#[derive(Default)]
struct Watch {
    first: Option<[[f64; 3]; 2]>,
    changed: [f64; 2],
    initial: f64,
    unexplained: f64,
}

impl Watch {
    fn look(&mut self, e: &Engine) {
        let (p, l) = momentum(&e.nodes);
        let first = *self.first.get_or_insert([p, l]);
        for ((changed, now), then) in self.changed.iter_mut().zip([p, l]).zip(first) {
            *changed = (0..3).map(|c| (now[c] - then[c]).abs()).fold(*changed, f64::max);
        }
        let energies = e.ledger.energies(&e.nodes, &e.blocks).values();
        if e.clock.cycle == 1 {
            self.initial = energies.balance(0.0);
        }
        self.unexplained =
            self.unexplained.max(energies.balance(self.initial).abs() / self.initial);
    }
}

/// The nodes at the end of the second bar share the displacements of one node. The bar starts
/// with a velocity: the tied nodes move together, and momentum is conserved.
#[test]
fn nodes_share_displacements() {
    let rest = "[[tie]]\nnodes = \"rest\"\nnode = 550\n[[initial_velocity]]\nnodes = \"second\"\n\
                velocity = [1.0, 0.0, 0.0]\n";
    let text = format!("end_time = 0.02\n{}", bars(0.0, rest));
    let listed =
        text.split("end = [").nth(1).unwrap().split(']').next().unwrap().replacen("550, ", "", 1);
    let text = text.replacen("node_sets = {", &format!("node_sets = {{ rest = [{listed}],"), 1);
    let mut watch = Watch::default();
    let end = run_alone(&model(&text).unwrap(), |e: &Engine| watch.look(e));
    let carrier = end.nodes.local_index(crumple_proto::ids::NodeId(550)).unwrap() as usize;
    for id in listed.split(", ").map(|id| crumple_proto::ids::NodeId(id.parse().unwrap())) {
        assert_eq!(
            end.nodes.v[end.nodes.local_index(id).unwrap() as usize],
            end.nodes.v[carrier],
            "{id}"
        );
    }
    let whole = RHO * SIDE * SIDE * LENGTH;
    assert!(watch.changed[0] < 1e-12 * whole, "round-off: {:?}", watch.changed);
    // A tie to a node with another velocity changes no momentum: it is that of the mesh.
    let came = watch.first.unwrap()[0][0];
    assert!((came - whole).abs() < 1e-12 * whole, "{came} {whole}");
}

const TIE: &str = "[[tie]]\nname = \"joint\"\nnodes = \"end\"\nparts = [1]\n";

/// The first bar hits the second one, which is at rest. A wave with half its velocity goes
/// through both, the momentum of the second bar grows by the stress `rho c v / 2` times the
/// area, and the front arrives at its middle with the velocity of waves. The tolerance of 1 %
/// covers oscillations behind the front in means over 30 cells; the front is two cells wide.
#[test]
fn a_wave_goes_through_a_tie() {
    let c = (E / RHO).sqrt();
    let rest = "[[initial_velocity]]\nvelocity = [1.0, 0.0, 0.0]\n[[initial_velocity]]\n\
                nodes = \"second\"\nvelocity = [0.0, 0.0, 0.0]\n";
    let half = 0.5 * LENGTH / c;
    let text = format!("end_time = {:?}\n{}", 1.4 * half, bars(0.0, &format!("{TIE}{rest}")));
    let model = model(&text).unwrap();
    assert_eq!(model.settings.ties.len(), 16);
    let mut watch = Watch::default();
    let (mut arrival, mut at_half) = (None, None);
    run_alone(&model, |e: &Engine| {
        watch.look(e);
        let middle = (0..e.nodes.local_count).find(|&i| e.nodes.x0[i][0] == 1.5 * LENGTH).unwrap();
        if e.nodes.v[middle][0] > 0.25 {
            arrival.get_or_insert(e.clock.time);
        }
        if e.clock.time >= half && at_half.is_none() {
            // The masters carry the mass of the tied end, which is that of half a cell.
            let tied = 0.5 * CELL * SIDE * SIDE * RHO * 0.5;
            let second = (0..e.nodes.local_count).filter(|&i| e.nodes.x0[i][0] > LENGTH + 0.1);
            let given: f64 = second.map(|i| e.nodes.mass[i] * e.nodes.v[i][0]).sum::<f64>() + tied;
            let near = |&i: &usize| (e.nodes.x0[i][0] - LENGTH).abs() < 0.4 * LENGTH;
            let near: Vec<f64> =
                (0..e.nodes.local_count).filter(near).map(|i| e.nodes.v[i][0]).collect();
            // Velocities are those in the middle of the last step.
            at_half = Some((given / (e.clock.time - 0.5 * e.clock.last_dt), near));
        }
    });
    let (force, near) = at_half.unwrap();
    let expected = 0.5 * RHO * c * SIDE * SIDE;
    assert!((force / expected - 1.0).abs() < 0.01, "{force} {expected}");
    let mean = near.iter().sum::<f64>() / near.len() as f64;
    assert!((mean - 0.5).abs() < 0.005, "{mean}");
    let arrival = arrival.unwrap();
    assert!((arrival - half).abs() < 2.0 * CELL / c, "{arrival} {half}");
    let whole = RHO * SIDE * SIDE * LENGTH;
    let changed = watch.changed[0];
    assert!(changed < 1e-12 * whole, "round-off of sums over 1000 nodes: {changed} of {whole}");
    // The same bars as one mesh: the step changes with the strain, which causes this error of
    // the balance.
    let mut rows = Rows::default();
    let one = rows.block(
        1,
        [[0.0; 3], [2.0 * LENGTH, SIDE, SIDE]],
        [(2.0 * LENGTH / CELL) as usize, 2, 2],
    );
    let second = one.iter().filter(|(at, _)| at[0] as f64 * CELL > LENGTH).map(|n| n.1).collect();
    let text =
        rows.job(&[("second", second)], &format!("[[part]]\nid = 1\nmaterial = \"steel\"\n{rest}"));
    let mut one = Watch::default();
    run_alone(
        &self::model(&format!("end_time = {:?}\n{text}", 1.4 * half)).unwrap(),
        |e: &Engine| one.look(e),
    );
    let (unexplained, of_one) = (watch.unexplained, one.unexplained);
    assert!(unexplained < 2.0 * of_one && of_one < 1e-6, "{unexplained}, in one mesh {of_one}");
}

/// Tied bars turn in free flight. Momentum and angular momentum are conserved, the tie is
/// strained only by the centrifugal load, and tied nodes keep their positions on the faces.
#[test]
fn tied_bars_turn_without_strain() {
    let spin = 2.0;
    let rest = format!(
        "[[initial_velocity]]\nvelocity = [1.0, 2.0, -3.0]\nspin = [0.1, 0.3, {spin:?}]\n\
         centre = [{LENGTH:?}, 2.0, 2.0]\n"
    );
    let text = format!("end_time = 0.4\n{}", bars(0.0, &format!("{TIE}{rest}")));
    let model = model(&text).unwrap();
    let mut watch = Watch::default();
    let end = run_alone(&model, |e: &Engine| watch.look(e));
    let Watch { changed: worst, unexplained, .. } = watch;
    let whole = 2.0 * RHO * SIDE * SIDE * LENGTH;
    assert!(worst[0] < 1e-11 * whole && worst[1] < 1e-10 * whole * 100.0, "{worst:?} of {whole}");
    assert!(unexplained < 1e-6, "{unexplained}");
    let at = |id| xyz_of(&end, id);
    for tie in &model.settings.ties {
        let stand = tie
            .masters
            .iter()
            .fold([0.0; 3], |s, &(id, n)| std::array::from_fn(|c| s[c] + n * at(id)[c]));
        let off = (0..3).map(|c| (stand[c] - at(tie.node)[c]).abs()).fold(0.0, f64::max);
        assert!(off < 1e-12 * 1000.0, "round-off of the steps: {off}");
    }
}

/// A patch at the end of arms above a plate, in free flight: it turns about an axis of the plate
/// or is struck at one end. Momentum and angular momentum are conserved, arms keep their length,
/// and without the impact there is no strain.
#[test]
fn arms_turn_with_their_face() {
    for struck in [false, true] {
        let mut rows = Rows::default();
        rows.plate(1, [[0.0, 0.0], [40.0, 40.0]], 0.0, [4, 4]);
        let patch = rows.plate(2, [[8.0, 9.0], [31.0, 32.0]], 1.1, [4, 3]);
        let part =
            |id: u32| format!("[[part]]\nid = {id}\nmaterial = \"steel\"\nthickness = 1.0\n");
        let strike = "[[initial_velocity]]\nnodes = \"far\"\nvelocity = [0.0, 3.0, 5.0]\n";
        let far = vec![1, 2];
        let rest = format!(
            "{}{}[[tie]]\nnodes = \"patch\"\nparts = [1]\noffset = true\n\
             [[initial_velocity]]\nvelocity = [1.0, 0.0, 2.0]\nspin = [0.8, -0.5, 0.2]\n\
             centre = [20.0, 20.0, 0.0]\n{}",
            part(1),
            part(2),
            if struck { strike } else { "" }
        );
        let sets = [("patch", patch), ("far", far)];
        let model = model(&format!("end_time = 1.0\n{}", rows.job(&sets, &rest))).unwrap();
        assert!(model.settings.ties.iter().all(|t| t.offset) && model.settings.ties.len() == 20);
        let mut watch = Watch::default();
        let end = run_alone(&model, |e: &Engine| watch.look(e));
        let Watch { changed: worst, unexplained, initial, .. } = watch;
        let energies = end.ledger.energies(&end.nodes, &end.blocks).values();
        // The arms turn exactly, but their moments are those of small steps: the error is the
        // square of rotations within a step.
        let (strained, left) = if struck { (0.5, 1e-3) } else { (1e-4, 1e-5) };
        assert!(
            energies.internal < strained * initial && unexplained < left,
            "{unexplained} of {energies:?}"
        );
        let at = |id| xyz_of(&end, id);
        for tie in &model.settings.ties {
            let foot = tie
                .masters
                .iter()
                .fold([0.0; 3], |s, &(id, n)| std::array::from_fn(|c| s[c] + n * at(id)[c]));
            let arm = (0..3).map(|c| (at(tie.node)[c] - foot[c]).powi(2)).sum::<f64>().sqrt();
            assert!((arm - 1.1).abs() < 1e-10, "{arm}: round-off of several thousand rotations");
        }
        assert!(worst[0] < 1e-14 && worst[1] < 1e-12, "round-off: {worst:?}");
    }
}

fn xyz_of(e: &Engine, id: crumple_proto::ids::NodeId) -> [f64; 3] {
    let i = e.nodes.local_index(id).unwrap();
    [0, 1, 2].map(|c| e.nodes.x[i as usize][c])
}

/// A fine patch is tied to a coarse plate, posts of beams are tied with their rotations between
/// it and a plate above, a rigid foot carries a plate's edge, and a block falls on the patch,
/// above a wall: the same bits on 1, 2 and 4 workers, with forced renewals of the boxes.
#[test]
fn bits_do_not_depend_on_workers() {
    let mut rows = Rows::default();
    rows.plate(1, [[0.0, 0.0], [80.0, 80.0]], 0.0, [8, 8]);
    let patch = rows.plate(2, [[13.0, 17.0], [53.0, 59.0]], 1.1, [7, 6]);
    rows.plate(3, [[0.0, 0.0], [80.0, 30.0]], 20.0, [6, 3]);
    let mut ends = Vec::new();
    for (x, y) in [(4.0, 5.0), (66.0, 12.0), (71.0, 24.0)] {
        let post = [0.0, 10.0, 20.0].map(|z| rows.node([x, y, z]));
        ends.extend([post[0], post[2]]);
        for pair in post.windows(2) {
            rows.elements += 1;
            rows.beams += &format!("[{}, 4, {}, {}, 1],\n", rows.elements, pair[0], pair[1]);
        }
    }
    let block = rows.block(5, [[22.0, 27.0, 2.7], [41.0, 49.0, 12.0]], [3, 4, 2]);
    rows.block(6, [[80.0, 0.0, 15.0], [90.0, 30.0, 25.0]], [1, 2, 1]);
    let edge = rows.plate(7, [[90.0, 3.0], [110.0, 27.0]], 21.0, [3, 4]);
    let edge: Vec<usize> = edge.into_iter().step_by(4).collect();
    let part = |id: u32, rest: &str| format!("[[part]]\nid = {id}\nmaterial = \"steel\"\n{rest}\n");
    let parts: String = [1, 2, 3, 7].map(|id| part(id, "thickness = 1.0")).concat();
    let rest = format!(
        "{parts}{}{}{}[[tie]]\nname = \"patch\"\nnodes = \"patch\"\nparts = [1]\noffset = true\n\
         [[tie]]\nname = \"posts\"\nnodes = \"ends\"\nparts = [1, 3]\nrotations = true\n\
         [[tie]]\nname = \"edge\"\nnodes = \"edge\"\nparts = [6]\n\
         [[rigid]]\nname = \"foot\"\nparts = [6]\n[contact]\nfriction = 0.2\n\
         [[wall]]\npoint = [0.0, 0.0, -1.0]\nnormal = [0.1, 0.0, 1.0]\n\
         [[initial_velocity]]\nvelocity = [0.0, 0.0, -8.0]\n\
         [[initial_velocity]]\nnodes = \"block\"\nvelocity = [3.0, 0.0, -30.0]\n",
        part(4, "[part.beam]\nsection = \"tube\"\nradius = 2.0"),
        part(5, ""),
        part(6, ""),
    );
    let sets = [
        ("patch", patch),
        ("ends", ends),
        ("edge", edge),
        ("block", block.iter().map(|n| n.1).collect()),
    ];
    let model = model(&format!("end_time = 1.0\n{}", rows.job(&sets, &rest))).unwrap();
    assert_eq!(model.settings.ties.len(), 56 + 6);
    assert!(model.settings.ties.iter().filter(|t| t.rotations).count() == 6);
    assert_eq!(model.settings.rigid[0].nodes.len(), 12 + 5, "the edge belongs to the foot");
    let serial = run_side_by_side(&model, 1, 600, 0);
    assert!(serial.trouble.is_none(), "{:?} in cycle {}", serial.trouble, serial.pairs.len());
    assert!(serial.pairs.iter().any(|p| !p.is_empty()), "it touches");
    for (workers, force) in [(2, 0), (4, 0), (2, 7), (4, 11)] {
        let parallel = run_side_by_side(&model, workers, 600, force);
        assert_eq!(serial.digest(), parallel.digest(), "{workers} workers, renewed every {force}");
    }
}

/// A block hits the patch of the same plate: the momentum that the block loses the plate gains,
/// and no energy is created.
#[test]
fn contact_on_tied_nodes_keeps_momentum_and_makes_no_energy() {
    let mut rows = Rows::default();
    rows.plate(1, [[0.0, 0.0], [80.0, 80.0]], 0.0, [8, 8]);
    let patch = rows.plate(2, [[13.0, 17.0], [53.0, 59.0]], 0.0, [7, 6]);
    let block = rows.block(5, [[22.0, 27.0, 1.6], [41.0, 49.0, 12.0]], [3, 4, 2]);
    let block = block.iter().map(|n| n.1).collect();
    let part = |id: u32, rest: &str| format!("[[part]]\nid = {id}\nmaterial = \"steel\"\n{rest}\n");
    let rest = format!(
        "{}{}{}[[tie]]\nnodes = \"patch\"\nparts = [1]\n[contact]\nlaw = \"LAW\"\n\
         [[initial_velocity]]\nnodes = \"block\"\nvelocity = [3.0, 0.0, -30.0]\n",
        part(1, "thickness = 1.0"),
        part(2, "thickness = 1.0"),
        part(5, ""),
    );
    let text =
        format!("end_time = 0.6\n{}", rows.job(&[("patch", patch), ("block", block)], &rest));
    // The kinematic law needs the masses of the nodes themselves, but tied nodes have passed
    // theirs to the masters.
    for law in ["lagrange", "kinematic"] {
        let model = model(&text.replace("LAW", law)).unwrap();
        let (mut watch, mut least, mut deepest) = (Watch::default(), 0.0f64, 0.0f64);
        let end = run_alone(&model, |e: &Engine| {
            watch.look(e);
            deepest = deepest.max(e.contact.as_ref().unwrap().penetration);
            least =
                least.max(e.ledger.energies(&e.nodes, &e.blocks).values().contact / watch.initial);
        });
        let Watch { changed: [worst, _], unexplained: most, initial, .. } = watch;
        let energies = end.ledger.energies(&end.nodes, &end.blocks).values();
        assert!(
            energies.contact < -0.01 * initial,
            "{law}: there is an impact: {energies:?} of \
            {initial}"
        );
        assert!(least < 1e-3, "{law}: contact adds energy: {least}");
        assert!(worst < 1e-11, "{law}: {worst}");
        assert!(most < 0.01, "{law}: {most}");
        // The measured value is 0.016 of the thickness for both laws; if tied nodes had no mass,
        // it would be 0.89 for the kinematic law.
        assert!(deepest < 0.05, "{law}: {deepest}");
    }
}

/// A plate of two elements, the brittle one under a patch that is tied to it. Under tension the
/// brittle element fails: the patch is released with its mass and velocity and continues alone,
/// on any number of workers.
#[test]
fn a_face_that_fails_lets_go() {
    let mut rows = Rows::default();
    rows.plate(1, [[0.0, 0.0], [10.0, 10.0]], 0.0, [1, 1]);
    let patch = rows.plate(3, [[2.0, 2.0], [8.0, 8.0]], 1.0, [2, 2]);
    let pulled = vec![2, 4];
    let part = |id: u32, material: &str| {
        format!("[[part]]\nid = {id}\nmaterial = \"{material}\"\nthickness = 1.0\n")
    };
    let brittle = "[[material]]\nname = \"brittle\"\nlaw = \"j2\"\ndensity = 7.85e-6\n\
                   youngs_modulus = 207.0\npoisson = 0.3\n\
                   yield_stress = 0.2\nfailure_strain = 0.01\n";
    let rest = format!(
        "{brittle}{}{}[[tie]]\nnodes = \"patch\"\nparts = [1]\noffset = true\n[contact]\n\
         [[initial_velocity]]\nvelocity = [0.0, 1.0, 0.0]\n\
         [[initial_velocity]]\nnodes = \"pulled\"\nvelocity = [100.0, 1.0, 0.0]\n",
        part(1, "brittle"),
        part(3, "steel")
    );
    let text = format!(
        "end_time = 0.2\n{}",
        rows.job(&[("patch", patch.clone()), ("pulled", pulled)], &rest)
    );
    let model = model(&text).unwrap();
    assert_eq!(model.settings.ties.len(), 9);
    let mut watch = Watch::default();
    let (mut whole, mut left) = (Vec::new(), None);
    let end = run_alone(&model, |e: &Engine| {
        watch.look(e);
        whole.push((0..e.nodes.local_count).map(|i| e.nodes.mass[i]).sum::<f64>());
        if e.constraints.ties.is_empty() && left.is_none() {
            left = Some((
                e.clock.time,
                patch.iter().map(|&n| xyz_of(e, id_of(n))).collect::<Vec<_>>(),
            ));
        }
    });
    let (time, places) = left.expect("the tie is released");
    assert!(end.constraints.ties.is_empty() && time < 0.1, "{time}");
    let mass = whole[0];
    assert!(whole.iter().all(|m| (m - mass).abs() < 1e-14 * mass * 100.0), "masses are restored");
    assert!(watch.changed[0] < 1e-10 * mass * 10.0, "momentum: {:?}", watch.changed);
    // After release the patch continues as a whole with its own momentum.
    let mean =
        |x: &[[f64; 3]]| [0, 1].map(|c| x.iter().map(|p| p[c]).sum::<f64>() / x.len() as f64);
    let now: Vec<[f64; 3]> = patch.iter().map(|&n| xyz_of(&end, id_of(n))).collect();
    let went = [0, 1].map(|c| (mean(&now)[c] - mean(&places)[c]) / (end.clock.time - time));
    assert!(went[0] > 10.0 && went[0] < 90.0 && (went[1] - 1.0).abs() < 0.3, "{went:?}");
    let serial = run_side_by_side(&model, 1, 120, 0);
    assert!(serial.trouble.is_none(), "{:?}", serial.trouble);
    for (workers, force) in [(2, 0), (4, 7)] {
        let parallel = run_side_by_side(&model, workers, 120, force);
        assert_eq!(serial.digest(), parallel.digest(), "{workers} workers, renewed every {force}");
    }
}

fn id_of(n: usize) -> crumple_proto::ids::NodeId {
    crumple_proto::ids::NodeId(n as u64)
}

/// Chained ties: a strip on a strip on a strip, struck at one end, conserve their momentum and
/// move together. A chain at the end of arms is refused.
#[test]
fn ties_stand_on_ties_but_for_arms() {
    let scene = |offset: bool, shift: f64| {
        let mut rows = Rows::default();
        rows.plate(1, [[0.0, 0.0], [40.0, 10.0]], 0.0, [4, 1]);
        let second = rows.plate(2, [[30.0, 1.0], [70.0, 9.0]], shift, [4, 1]);
        let third = rows.plate(3, [[31.0, 2.0], [39.0, 8.0]], 2.0 * shift, [2, 1]);
        let on_first: Vec<usize> =
            second.iter().copied().filter(|n| (n - second[0]) % 5 < 2).collect();
        let part =
            |id: u32| format!("[[part]]\nid = {id}\nmaterial = \"steel\"\nthickness = 1.0\n");
        let tie = |nodes: &str, part: u32| {
            format!("[[tie]]\nnodes = \"{nodes}\"\nparts = [{part}]\noffset = {offset}\n")
        };
        let rest = format!(
            "{}{}{}{}{}[[initial_velocity]]\nnodes = \"third\"\nvelocity = [3.0, 1.0, 0.0]\n",
            part(1),
            part(2),
            part(3),
            tie("second", 1),
            tie("third", 2),
        );
        (
            third.clone(),
            model(&format!(
                "end_time = 0.5\n{}",
                rows.job(&[("second", on_first), ("third", third)], &rest)
            )),
        )
    };
    let (_, refused) = scene(true, 1.0);
    let refused = refused.err().expect("offsets in a chain are refused");
    assert!(
        refused.contains("which is itself tied") && refused.contains("no offsets in a chain"),
        "{refused}"
    );
    let (third, model) = scene(false, 0.0);
    let model = model.unwrap();
    assert!(
        model.warnings.iter().any(|w| w.message.contains("have other initial velocities")),
        "{:?}",
        model.warnings
    );
    // The third strip lies between nodes of the second one, all of them tied: its masters are
    // nodes of the first one.
    let own = |n: u64| third.contains(&(n as usize));
    let of_third: Vec<_> = model.settings.ties.iter().filter(|t| own(t.node.0)).collect();
    assert!(
        of_third.len() == 6
            && of_third.iter().all(|t| t.masters.iter().all(|c| c.0.0 <= 10) && t.faces.len() > 1)
    );
    let mut watch = Watch::default();
    run_alone(&model, |e: &Engine| watch.look(e));
    let mass = RHO * 8.0 * 6.0;
    let came = watch.first.unwrap()[0];
    for (came, velocity) in came.into_iter().zip([3.0, 1.0, 0.0]) {
        assert!((came - mass * velocity).abs() < 1e-12 * mass, "{came}");
    }
    assert!(
        watch.changed[0] < 1e-11 * mass && watch.unexplained < 1e-3,
        "{:?} {}",
        watch.changed,
        watch.unexplained
    );
}

/// A prescribed motion of a plate and of the nodes tied to it moves both in the same way, and
/// does the work of both masses once.
#[test]
fn prescribed_nodes_move_tied_slaves() {
    let mut rows = Rows::default();
    let plate = rows.plate(1, [[0.0, 0.0], [40.0, 40.0]], 0.0, [4, 4]);
    let patch = rows.plate(2, [[13.0, 12.0], [27.0, 31.0]], 0.0, [3, 2]);
    let part = |id: u32| format!("[[part]]\nid = {id}\nmaterial = \"steel\"\nthickness = 1.0\n");
    let rest = format!(
        "{}{}[[tie]]\nnodes = \"patch\"\nparts = [1]\n[[curve]]\nname = \"ramp\"\n\
         points = [[0.0, 0.0], [1.0, 2.0]]\n\
         [[motion]]\nnodes = \"both\"\nvelocity = [1.0, 0.0, 0.0]\ncurve = \"ramp\"\n",
        part(1),
        part(2)
    );
    let both = plate.iter().chain(&patch).copied().collect();
    let model =
        model(&format!("end_time = 1.0\n{}", rows.job(&[("patch", patch), ("both", both)], &rest)))
            .unwrap();
    let end = run_alone(&model, |_| {});
    let speeds: Vec<f64> = end.nodes.v.iter().map(|v| v[0]).collect();
    // Round-off of positions over the length of a step.
    assert!(speeds.iter().all(|v| (v - speeds[0]).abs() < 1e-10), "{speeds:?}");
    let mass = RHO * (40.0 * 40.0 + 14.0 * 19.0);
    let energies = end.ledger.energies(&end.nodes, &end.blocks).values();
    let exact = 0.5 * mass * speeds[0].powi(2);
    // The velocities and the work are half a step apart.
    assert!(
        (energies.external / exact - 1.0).abs() < 0.01 && speeds[0] > 1.9,
        "{energies:?} {exact}"
    );
    assert!(energies.balance(0.0).abs() < 1e-9 * exact, "{}", energies.balance(0.0));
}

/// A block falls on a patch that is tied to a plate, which lies on a rigid wall with a mass. The
/// wall receives the impulse in the same step, and the total momentum is conserved.
#[test]
fn a_wall_with_a_mass_receives_impacts_on_tied_nodes() {
    let mut rows = Rows::default();
    rows.plate(1, [[0.0, 0.0], [40.0, 40.0]], 0.0, [4, 4]);
    let patch = rows.plate(2, [[9.0, 8.0], [33.0, 31.0]], 0.0, [6, 6]);
    let block = rows.block(3, [[15.0, 14.0, 1.2], [26.0, 25.0, 9.0]], [3, 3, 2]);
    let part = |id: u32, rest: &str| format!("[[part]]\nid = {id}\nmaterial = \"steel\"\n{rest}\n");
    let rest = format!(
        "{}{}{}[[tie]]\nnodes = \"patch\"\nparts = [1]\n[contact]\n\
         [[wall]]\npoint = [0.0, 0.0, 0.0]\nnormal = [0.0, 0.0, 1.0]\nmass = 0.02\n\
         except = \"patch\"\n\
         [[initial_velocity]]\nnodes = \"block\"\nvelocity = [0.0, 0.0, -20.0]\n",
        part(1, "thickness = 1.0"),
        part(2, "thickness = 1.0"),
        part(3, "")
    );
    let block = block.iter().map(|n| n.1).collect();
    let model = model(&format!(
        "end_time = 0.3\n{}",
        rows.job(&[("patch", patch), ("block", block)], &rest)
    ))
    .unwrap();
    let (mut deepest, mut first, mut worst) = (0.0f64, None, 0.0f64);
    let end = run_alone(&model, |e: &Engine| {
        let wall = &e.constraints.walls.each()[0];
        let floor = wall.displacement()[2];
        let plate = (0..25).map(|n| xyz_of(e, id_of(n + 1))[2]).fold(f64::INFINITY, f64::min);
        deepest = deepest.max(floor - plate);
        let all = momentum(&e.nodes).0[2] + e.constraints.walls.carried(true).1[2];
        worst = worst.max((all - *first.get_or_insert(all)).abs());
    });
    let wall = end.constraints.walls.carried(true).1[2];
    let came = -20.0 * RHO * 11.0 * 11.0 * 7.8;
    assert!(wall < 0.2 * came, "the wall takes a large part of the impulse: {wall} of {came}");
    // A delay of one step in the force on the wall would give a penetration by the displacement
    // of that step.
    assert!(deepest < 1e-9, "{deepest}");
    assert!(worst < 1e-10 * came.abs(), "{worst} of {came}");
}

#[test]
fn wrong_jobs_are_reported() {
    let said = |rest: &str, words: &[&str]| {
        let report = match model(&format!(
            "end_time = 1.0\n{}",
            bars(0.0, &format!("[[initial_velocity]]\nvelocity = [1.0, 0.0, 0.0]\n{rest}"))
        )) {
            Ok(model) => model.warnings.iter().map(|w| format!("{}\n", w.message)).collect(),
            Err(report) => report,
        };
        words
            .iter()
            .for_each(|word| assert!(report.contains(word), "missing text: {word}\n{report}"));
    };
    said("[[tie]]\nnodes = \"end\"\n", &["a tie has no surface"]);
    said(
        "[[tie]]\nnodes = \"ends\"\nparts = [3]\n",
        &["there is no node set `ends`", "tie: there is no part 3"],
    );
    said(
        "[[tie]]\nnodes = \"end\"\nnode = 550\nparts = [1]\n",
        &["has no surface and no offset", "node 550 is tied to itself"],
    );
    said("[[tie]]\nnodes = \"end\"\nnode = 9999\n", &["no element has node 9999"]);
    said("[[tie]]\nnodes = \"end\"\nparts = [1]\ntolerance = -1.0\n", &["tolerance is -1"]);
    said(
        "[[tie]]\nnodes = \"end\"\nparts = [1]\nthicknesses = [0.0, -1.0]\n",
        &["a thickness is -1"],
    );
    said(
        &format!("{TIE}[[wall]]\npoint = [-1.0, 0.0, 0.0]\nnormal = [1.0, 0.0, 0.0]\n"),
        &["16 tied nodes do not touch rigid walls"],
    );
    said(&format!("{TIE}{TIE}"), &["is tied twice: by tie `joint` and tie `joint`"]);
    said(
        "[[tie]]\nnodes = \"second\"\nparts = [1]\n",
        &["tie 1: 960 of 976 nodes are not near enough to its surface"],
    );
    said("[[tie]]\nnodes = \"end\"\nparts = [2]\n", &["none of its 16 nodes is near enough"]);
    said(
        "[[tie]]\nnodes = \"end\"\nparts = [1]\nfaces = \"second\"\n",
        &["its surface has no face"],
    );
    said(
        &format!("{TIE}[[fix]]\nnodes = \"end\"\ndofs = [\"y\"]\n"),
        &["16 tied nodes have another constraint or motion: 550, 611,"],
    );
    said(
        &format!("{TIE}[[rigid]]\nname = \"b\"\nparts = [2]\n"),
        &["16 tied nodes belong to rigid bodies"],
    );
}

/// Nodes near a surface are moved onto it, with a warning; nodes farther away than the tolerance
/// are not tied.
#[test]
fn nodes_are_moved_onto_the_surface() {
    let moving = "[[initial_velocity]]\nvelocity = [1.0, 0.0, 0.0]\n";
    let near = model(&format!("end_time = 1.0\n{}", bars(0.1, &format!("{TIE}{moving}")))).unwrap();
    let warning = near.warnings.iter().find(|w| w.message.contains("moved onto")).unwrap();
    assert!(
        warning.message.contains("tie `joint`: 16 nodes are moved onto its surface"),
        "{}",
        warning.message
    );
    let at = |id| near.mesh.nodes.iter().find(|n| n.id == id).unwrap().x[0];
    assert!(
        near.settings.ties.iter().all(|t| (at(t.node) - LENGTH).abs() < 1e-12),
        "round-off of the projection"
    );
    // A twentieth of a diagonal of 2 sqrt 2 is 0.14.
    let far =
        model(&format!("end_time = 1.0\n{}", bars(0.2, &format!("{TIE}{moving}")))).err().unwrap();
    assert!(far.contains("none of its 16 nodes"), "{far}");
    model(&format!("end_time = 1.0\n{}", bars(0.2, &format!("{TIE}tolerance = 0.25\n{moving}"))))
        .unwrap();
    // The tolerance follows from the thicknesses of a deck, but is at least a twentieth of the
    // diagonal.
    model(&format!(
        "end_time = 1.0\n{}",
        bars(0.2, &format!("{TIE}thicknesses = [0.2, 0.2]\n{moving}"))
    ))
    .unwrap();
    model(&format!(
        "end_time = 1.0\n{}",
        bars(0.1, &format!("{TIE}thicknesses = [0.01, 0.0]\n{moving}"))
    ))
    .unwrap();
}

/// A block falls on one large skin between the corners of a frame, which stops it; without the
/// skin it falls through. The skin has mass, does not limit the step and carries no load: a
/// moving corner does not act on the others.
#[test]
fn a_skin_touches_and_bears_nothing() {
    let run = |skin: bool| {
        let mut rows = Rows::default();
        let corners = [[0.0, 0.0], [40.0, 0.0], [40.0, 40.0], [0.0, 40.0]]
            .map(|[x, y]| rows.node([x, y, 0.0]));
        let block = rows.block(1, [[15.0, 15.0, 1.0], [25.0, 25.0, 11.0]], [2, 2, 2]);
        let mut sets = vec![("block", block.iter().map(|n| n.1).collect())];
        let [a, b, c, d] = corners;
        if skin {
            rows.elements += 1;
            rows.shells += &format!("[{}, 2, {a}, {b}, {c}, {d}],\n", rows.elements);
            sets.push(("corner", vec![a]));
        }
        let part =
            |id: u32, rest: &str| format!("[[part]]\nid = {id}\nmaterial = \"steel\"\n{rest}\n");
        let led = "[[initial_velocity]]\nnodes = \"corner\"\nvelocity = [1.0, 0.0, 0.0]\n";
        let rest = format!(
            "{}{}[contact]\n[[initial_velocity]]\nnodes = \"block\"\nvelocity = [0.0, 0.0, -5.0]\n\
             {}",
            part(1, ""),
            if skin { part(2, "thickness = 1.0\nskin = true") } else { String::new() },
            if skin { led } else { "" },
        );
        let model = model(&format!("end_time = 3.0\n{}", rows.job(&sets, &rest))).unwrap();
        let end = run_alone(&model, |_| {});
        (model.first_dt().0, end, block[0].1, corners)
    };
    let (with, without) = (run(true), run(false));
    assert_eq!(with.0, without.0, "the step");
    let id = |n: usize| crumple_proto::ids::NodeId(n as u64);
    let low = |run: &(f64, Engine, usize, [usize; 4])| xyz_of(&run.1, id(run.2))[2];
    assert!(
        (low(&without) - (1.0 - 15.0)).abs() < 1e-9,
        "the block falls freely: {}",
        low(&without)
    );
    let [a, b, ..] = with.3.map(|n| xyz_of(&with.1, id(n)));
    let skin = b[2];
    assert!(skin < -0.5, "the block moves the skin: {skin}");
    assert!(low(&with) > skin - 0.1, "the block does not pass through: {} {skin}", low(&with));
    // An elastic skin would pull both to the same velocity. The block pushes along a normal that
    // tilts with the corners, by 1e-6.
    assert!(
        (a[0] - 3.0).abs() < 1e-4 && (b[0] - 40.0).abs() < 1e-4,
        "corners do not affect each other: {a:?} {b:?}"
    );
}

/// A coarse patch in the plane of a fine plate that carries it: contact finds no penetration of
/// either, from either side, and has no effect.
#[test]
fn contact_ignores_tied_nodes() {
    let mut rows = Rows::default();
    rows.plate(1, [[0.0, 0.0], [40.0, 40.0]], 0.0, [16, 16]);
    let patch = rows.plate(2, [[9.0, 8.0], [33.0, 31.0]], 0.0, [2, 2]);
    let part = |id: u32| format!("[[part]]\nid = {id}\nmaterial = \"steel\"\nthickness = 1.0\n");
    let rest = format!(
        "{}{}[[tie]]\nnodes = \"patch\"\nparts = [1]\n[contact]\n[[initial_velocity]]\n\
         velocity = [1.0, 0.0, 5.0]\n",
        part(1),
        part(2)
    );
    let model =
        model(&format!("end_time = 0.2\n{}", rows.job(&[("patch", patch)], &rest))).unwrap();
    assert!(
        !model.warnings.iter().any(|w| w.message.contains("start inside")),
        "{:?}",
        model.warnings
    );
    let end = run_alone(&model, |_| {});
    let off = end
        .nodes
        .v
        .iter()
        .flat_map(|v| [v[0] - 1.0, v[1], v[2] - 5.0])
        .fold(0.0, |m: f64, d| m.max(d.abs()));
    assert!(off < 1e-11, "round-off: {off}");
}

/// A cantilever of two strips of shells; the edge of the second strip is tied across the last
/// row of cells of the first one. With tied rotations its tip deflects by P L^3 / 3 E I as that
/// of one strip, without them the tie is a hinge. 2 %: the tie bends the row's cells bilinearly.
#[test]
fn a_tied_edge_bends_as_one_strip() {
    let (length, width) = (100.0f64, 10.0);
    let bending = E * width / 12.0;
    let force = 3.0 * bending / length.powi(3);
    let w = 1.875_104_07f64.powi(2) * (bending / (RHO * width * length.powi(4))).sqrt();
    let down = |rotations: bool| {
        let mut rows = Rows::default();
        let first = rows.plate(1, [[0.0, 0.0], [50.0, width]], 0.0, [10, 2]);
        let second = rows.plate(2, [[47.0, 0.0], [length, width]], 0.0, [10, 3]);
        let every = |ids: &[usize], from: usize| {
            ids.iter().copied().skip(from).step_by(11).collect::<Vec<_>>()
        };
        let sets =
            [("root", every(&first, 0)), ("edge", every(&second, 0)), ("tip", every(&second, 10))];
        let tip = sets[2].1[0];
        let part =
            |id: u32| format!("[[part]]\nid = {id}\nmaterial = \"steel\"\nthickness = 1.0\n");
        let rest = format!(
            "{}{}[[tie]]\nnodes = \"edge\"\nparts = [1]\nrotations = {rotations}\n[time]\n\
             damping = {:?}\n\
             [[fix]]\nnodes = \"root\"\ndofs = [\"x\", \"y\", \"z\", \"rx\", \"ry\", \"rz\"]\n\
             [[load]]\nnodes = \"tip\"\nforce = [0.0, 0.0, {:?}]\n",
            part(1),
            part(2),
            2.0 * w,
            -force
        );
        let text = format!("end_time = {:?}\n{}", 16.0 / w, rows.job(&sets, &rest));
        let end = run_alone(&model(&text).unwrap(), |_| {});
        -xyz_of(&end, crumple_proto::ids::NodeId(tip as u64))[2]
    };
    let (bent, hung) = (down(true), down(false));
    assert!((bent - 1.0).abs() < 0.02, "{bent}");
    assert!(hung > 3.0, "{hung}");
}
