//! Checkpoints with right sums and wrong contents: each is refused with a reason, or is a state
//! from which a run continues. None causes a panic.

use crumple::input::job::Model;
use crumple::run::checkpoint::MasterState;
use crumple::run::checkpoint::manifest::Manifest;
use crumple_proto::boxes::CutTree;
use crumple_proto::checkpoint::decode;
use crumple_proto::mesh::Shape;
use crumple_proto::partition::{ElementRecord, NodeRecord};
use crumple_proto::transport::threads;
use crumple_tests::program::{crumple_with, root, run};
use crumple_tests::restart::checkpoints;
use crumple_tests::{case, read, variable};
use crumple_worker::checkpoint::fit::{Fit, InitialModel, read_common};
use crumple_worker::checkpoint::{CheckpointPiece, ReadState};
use crumple_worker::engine::Engine;
use crumple_worker::fem::blocks::Block;
use crumple_worker::fem::elements::build_block;
use crumple_worker::parallel::partition::PartitionData;
use crumple_worker::step::step;
use std::collections::BTreeMap;
use std::fs;

/// Small scenes with contact, rigid bodies, walls, ties, solids and subcycles, each with a setting.
const SCENES: [[&str; 2]; 5] = [
    ["cases/slide", "title=\"\""],
    ["cases/bars", "title=\"\""],
    ["tests/decks/scenes/bodies.toml", "title=\"\""],
    ["cases/corner", "title=\"\""],
    ["cases/graded", "time.subcycles=4"],
];

/// A checkpoint in memory, with its job.
struct Known {
    model: Model,
    elements: Vec<ElementRecord>,
    nodes: Vec<NodeRecord>,
    manifest: Manifest,
    master: Vec<u64>,
    common: Vec<u64>,
    pieces: Vec<Vec<u64>>,
}

impl Known {
    /// Runs a scene on two workers until half of its time.
    fn run_half([scene, set]: [&str; 2]) -> Self {
        let model = read(&root().join(scene), &[set]);
        let at = format!("checkpoint.at=[{:?}]", 0.5 * model.settings.end_time);
        let end = format!("end_time={:?}", 0.51 * model.settings.end_time);
        let ended = run(crumple_with(&[
            "run",
            scene,
            "--no-report",
            "--workers=2",
            "--set=output.field_interval=-1",
            "--set",
            set,
            "--set",
            &at,
            "--set",
            &end,
        ]))
        .with_code(0);
        let folder = ended.out().join("checkpoints").join(&checkpoints(&ended.out())[0]);
        let manifest = Manifest::read(&folder).unwrap();
        let words = |name: &str| decode(&fs::read(folder.join(name)).unwrap()).unwrap();
        let (elements, nodes) = model.records();
        Self {
            master: words(&manifest.master.name),
            common: words(&manifest.common.name),
            pieces: manifest.pieces.iter().map(|piece| words(&piece.name)).collect(),
            model,
            elements,
            nodes,
            manifest,
        }
    }

    fn fit(&self) -> Fit<'_> {
        let (settings, elements, nodes) = (&self.model.settings, &self.elements, &self.nodes);
        Fit::new(InitialModel { settings, elements, nodes })
    }

    /// Checks all files.
    fn check(&self, common: &[u64], pieces: &[Vec<u64>]) -> Result<(), String> {
        let mut fit = self.fit();
        fit.add_common(common, &self.manifest.captured)?;
        pieces.iter().try_for_each(|piece| fit.add_piece(piece))?;
        fit.finish(self.elements.len())
    }

    /// Continues with one worker for some cycles.
    fn go_on(&self, common: &[u64], pieces: &[Vec<u64>]) {
        let mut state = ReadState {
            common: read_common(common, &self.manifest.captured).unwrap(),
            own: Default::default(),
            share: PartitionData::default(),
        };
        for words in pieces {
            CheckpointPiece::new(words).unwrap().add_to(&mut state.share, &mut state.own);
        }
        let mut ends = threads::connect(2);
        let (comm, settings) = (&mut ends[1], self.model.settings.clone());
        let own = (state.common, state.own);
        let mut engine =
            Engine::restore(comm, settings, CutTree::single(), state.share, own).unwrap();
        for _ in 0..3 {
            if step(&mut engine, comm).unwrap().failure.is_some() {
                return;
            }
        }
    }
}

/// Changes of random kinds to the words of all files. `CRUMPLE_MUTATIONS` sets their number. A run
/// of a few cycles follows where a change is accepted, but not more often than every
/// tenth time: it is slow.
#[test]
fn mutated_contents_are_refused_or_are_states() {
    let known: Vec<Known> = SCENES.map(Known::run_half).into();
    for known in &known {
        known.check(&known.common, &known.pieces).unwrap();
        known.go_on(&known.common, &known.pieces);
        MasterState::from_words(&known.master, &known.manifest.captured).unwrap();
    }
    let mut random = fastrand::Rng::with_seed(20);
    let (mut accepted, mut due) = (0, 0);
    let total = variable("CRUMPLE_MUTATIONS", 3000);
    for number in 0..total {
        let known = &known[random.usize(..known.len())];
        let which = random.usize(..2 + known.pieces.len());
        if which == 0 {
            let bad = mutated(&mut random, &known.master);
            let _ = MasterState::from_words(&bad, &known.manifest.captured)
                .and_then(|state| state.validate(&known.model));
            continue;
        }
        let (mut common, mut pieces) = (known.common.clone(), known.pieces.clone());
        let changed = if which == 1 { &mut common } else { &mut pieces[which - 2] };
        *changed = mutated(&mut random, changed);
        if known.check(&common, &pieces).is_ok() {
            accepted += 1;
            if number >= due {
                due = number + 10;
                known.go_on(&common, &pieces);
            }
        }
    }
    println!("{accepted} of {total} accepted: only physical values differ");
    assert!(accepted > 0 && accepted < total, "{accepted}");
}

/// Returns words with one to three changes: bits, whole words, cuts, repeated or removed ranges.
fn mutated(random: &mut fastrand::Rng, good: &[u64]) -> Vec<u64> {
    let mut words = good.to_vec();
    for _ in 0..random.usize(1..=3) {
        if words.is_empty() {
            return words;
        }
        let (a, b) = (random.usize(..words.len()), random.usize(..words.len()));
        let (from, to) = (a.min(b), a.max(b));
        match random.u8(..10) {
            0..4 => words[a] ^= 1 << random.u8(..64),
            4 => words[a] = random.u64(..),
            5 => {
                let odd =
                    [0, 1, u64::MAX, 1 << 53, 1 << 63, 1e300f64.to_bits(), f64::NAN.to_bits()];
                words[a] = odd[random.usize(..odd.len())];
            }
            6 => words.truncate(a),
            7 => drop(words.drain(from..to)),
            8 => words.swap(a, b),
            _ => {
                let range = words[from..(from + 8).min(to)].to_vec();
                words.splice(a..a, range);
            }
        }
    }
    words
}

/// Every column of every kind of element in the scenes has a name of its own.
#[test]
fn every_column_has_a_name() {
    let scenes = fs::read_dir(case("")).unwrap().map(|e| e.unwrap().path());
    let mut kinds = 0;
    for scene in scenes.filter(|p| p.join("job.toml").exists()) {
        let model = read(&scene, &[]);
        let (elements, _) = model.records();
        let all: BTreeMap<(u32, u8), Shape> =
            elements.iter().map(|e| ((e.part, e.shape as u8), e.shape)).collect();
        for ((part, _), shape) in all {
            let element = build_block(&model.settings, part as usize, shape).unwrap();
            let mut names = Block::names_of(&*element);
            assert_eq!(names.len(), Block::columns_of(&*element), "{shape:?} {}", scene.display());
            names.sort();
            names.dedup();
            assert_eq!(names.len(), Block::columns_of(&*element), "{shape:?} {names:?}");
            kinds += 1;
        }
    }
    assert!(kinds > 20, "{kinds}");
}
