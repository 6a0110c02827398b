//! Engineering warnings: one small job beyond each limit, and one without any. Each warning has its
//! time, its place and its cure, in the output, in `summary.json` and in `crumple advise`.

use crumple_tests::program::{Ended, crumple_with, run};
use serde_json::Value;
use std::fs;
use tempfile::TempDir;

/// A square shell of steel. The tests add the motion of its corners.
const SQUARE: &str = r#"
    title = "A square"
    end_time = 0.1
    [mesh]
    nodes = [[1, 0.0, 0.0, 0.0], [2, 10.0, 0.0, 0.0], [3, 10.0, 10.0, 0.0], [4, 0.0, 10.0, 0.0]]
    shells = [[7, 1, 1, 2, 3, 4]]
    node_sets = { even = [2, 4], odd = [1, 3], left = [1, 4], right = [2, 3] }
    [output]
    field_interval = -1.0
    [[material]]
    name = "steel"
    law = "elastic"
    density = 7.85e-6
    youngs_modulus = 207.0
    poisson = 0.3
    [[part]]
    id = 1
    name = "plate"
    material = "steel"
    element = "belytschko_tsay"
    thickness = 1.0
"#;
const ROTATIONS: &str = r#"dofs = ["x", "y", "rx", "ry", "rz"]"#;

/// Runs the square with more sections.
fn square(more: &str) -> (TempDir, Ended) {
    let folder = tempfile::tempdir().unwrap();
    let job = folder.path().join("job.toml");
    fs::write(&job, format!("{SQUARE}{more}")).unwrap();
    let words = ["run", job.to_str().unwrap(), "--no-report", "--workers=1"];
    (folder, run(crumple_with(&words)).with_code(0))
}

fn case(words: &[&str]) -> Ended {
    run(crumple_with(&[&["run"], words, &["--no-report"]].concat())).with_code(0)
}

/// Returns the warning of a kind for a part, or for the whole model.
fn warning(ended: &Ended, kind: &str, part: &str) -> Value {
    let all = ended.summary()["warnings"].clone();
    let is_it = |w: &&Value| w["kind"] == kind && w["part"] == part;
    let found = all.as_array().unwrap().iter().find(is_it).cloned();
    let found = found.unwrap_or_else(|| panic!("no {kind} of `{part}`: {all:#}"));
    let (what, said) = (found["what"].as_str().unwrap(), ended.said());
    assert!(said.contains(what), "it is not in the output: {what}\n{said}");
    let message = format!("warning: {}\n", found["message"].as_str().unwrap());
    assert!(said.contains(&message), "{message}{said}");
    assert!(message.contains(found["cure"].as_str().unwrap()), "{message}");
    let shown = run(crumple_with(&["advise", ended.out().to_str().unwrap()])).with_code(0).said();
    assert!(shown.contains(what), "it is not in the advice: {what}\n{shown}");
    found
}

#[test]
fn a_healthy_job_has_no_warning() {
    let ended = case(&["cases/bars", "--workers=2"]);
    assert_eq!(ended.summary()["warnings"], serde_json::json!([]));
    assert!(!ended.said().contains("warning"), "{}", ended.said());
}

/// Opposite corners move up, the others down: a mode without strain at the integration point.
#[test]
fn hourglass_energy_of_a_part_is_a_warning() {
    let (_folder, ended) = square(&format!(
        "[[fix]]\nnodes = \"even\"\n{ROTATIONS}\n[[fix]]\nnodes = \"odd\"\n{ROTATIONS}\n\
         [[motion]]\nnodes = \"even\"\ndofs = [\"z\"]\nvelocity = [0.0, 0.0, 1.0]\n\
         [[motion]]\nnodes = \"odd\"\ndofs = [\"z\"]\nvelocity = [0.0, 0.0, -1.0]\n"
    ));
    let of_part = warning(&ended, "hourglass", "`plate`");
    assert!(of_part["cure"].as_str().unwrap().contains("part.element"), "{of_part}");
    assert!(of_part["value"].as_f64().unwrap() > 0.1, "{of_part}");
    warning(&ended, "hourglass", "");
}

/// The right side moves to the left until 3 % of the square are left.
#[test]
fn an_element_that_is_about_to_invert_is_named_and_so_is_the_step() {
    let all = r#"dofs = ["y", "z", "rx", "ry", "rz"]"#;
    let (_folder, ended) = square(&format!(
        "[[fix]]\nnodes = \"left\"\ndofs = [\"x\", \"y\", \"z\", \"rx\", \"ry\", \"rz\"]\n\
         [[fix]]\nnodes = \"right\"\n{all}\n\
         [[motion]]\nnodes = \"right\"\ndofs = [\"x\"]\nvelocity = [-97.0, 0.0, 0.0]\n"
    ));
    let flat = warning(&ended, "inversion", "`plate`");
    assert!(flat["place"].as_str().unwrap().starts_with("element 7 at (0."), "{flat}");
    let (first, worst) = (flat["time"].as_f64().unwrap(), flat["worst_time"].as_f64().unwrap());
    assert!((0.09..0.097).contains(&first) && worst > 0.099, "{flat}");
    assert!((flat["value"].as_f64().unwrap() - 0.03).abs() < 0.01, "{flat}");
    // The report has the warning once, with the worst time, to which its button goes.
    let out = ended.out();
    run(crumple_with(&["report", out.to_str().unwrap()])).with_code(0);
    let page = fs::read_to_string(out.join("report.html")).unwrap();
    let items: Vec<&str> = page.lines().flat_map(|line| line.split("<li")).collect();
    let of_corner =
        |item: &&&str| item.starts_with(" data-time") && item.contains("of its Jacobian");
    let of_corner: Vec<_> = items.iter().filter(of_corner).collect();
    assert_eq!(of_corner.len(), 1, "{of_corner:?}");
    assert!(of_corner[0].contains(flat["what"].as_str().unwrap()), "{of_corner:?}");
    let time = of_corner[0].split("data-time=\"").nth(1).and_then(|rest| rest.split('"').next());
    let time: f64 = time.unwrap().parse().unwrap();
    assert!((time - worst).abs() < 1e-6 * worst, "{time} {worst}");
    let step = warning(&ended, "time_step", "`plate`");
    assert!(step["cure"].as_str().unwrap().contains("time.mass_scaling_dt"), "{step}");
}

#[test]
fn added_mass_is_a_warning_with_its_parts() {
    let scaled = ["--set=time.mass_scaling_dt=5.5e-4", "--set=time.mass_scaling_limit=1.0"];
    let words = [&["cases/bars", "--set=time.max_cycles=20"], &scaled[..]].concat();
    let ended = case(&words);
    let of_part = warning(&ended, "added_mass", "`one`");
    assert!(of_part["place"].as_str().unwrap().starts_with("element "), "{of_part}");
    warning(&ended, "added_mass", "`two`");
    warning(&ended, "added_mass", "");
}

#[test]
fn deep_penetration_is_a_warning_with_its_node_on_any_number_of_workers() {
    let soft = ["--set=contact.law=penalty", "--set=contact.penalty_scale=1e-4"];
    let places = ["1", "2"].map(|workers| {
        let words = [&["cases/bars", "--workers", workers], &soft[..]].concat();
        warning(&case(&words), "penetration", "`one`")
    });
    assert!(places[0]["place"].as_str().unwrap().starts_with("node "), "{}", places[0]);
    assert_eq!(places[0], places[1]);
}

/// Undamped springs that are too stiff for the step.
#[test]
fn energy_created_by_contact_is_a_warning() {
    let sets = ["law=penalty", "penalty_cap=false", "penalty_damping=0", "penalty_scale=1.8"];
    let sets = sets.map(|set| format!("--set=contact.{set}"));
    let words = ["cases/bars", "--end-time=0.025"].into_iter().chain(sets.iter().map(|s| &s[..]));
    let words: Vec<&str> = words.collect();
    let created = warning(&case(&words), "contact_energy", "");
    assert!(created["what"].as_str().unwrap().contains("is negative"), "{created}");
}

#[test]
fn friction_that_takes_most_of_the_energy_is_a_warning() {
    let [friction, other] = ["--workers=1", "--workers=2"]
        .map(|workers| warning(&case(&["cases/slide", "--end-time=1", workers]), "friction", ""));
    assert!(friction["place"].as_str().unwrap().starts_with("node "), "{friction}");
    assert_eq!(friction["place"], other["place"], "on any number of workers");
    assert!(friction["what"].as_str().unwrap().contains("dissipated"), "{friction}");
    assert!(friction["cure"].as_str().unwrap().contains("contact.friction"), "{friction}");
}

/// A square, deformable or rigid, is pressed onto a plane, on which it slides until friction has
/// taken its energy.
#[test]
fn friction_on_a_wall_is_a_warning_of_its_own() {
    let sliding = "[[load]]\nnodes = \"even\"\nforce = [0.0, 0.0, -1.0]\n\
                   [[load]]\nnodes = \"odd\"\nforce = [0.0, 0.0, -1.0]\n\
                   [[wall]]\nname = \"floor\"\npoint = [0.0, 0.0, 0.0]\n\
                   normal = [0.0, 0.0, 1.0]\nfriction = 0.3\n\
                   [[initial_velocity]]\nvelocity = [20.0, 0.0, 0.0]\n";
    let rigid = "[[rigid]]\nname = \"body\"\nparts = [1]\n";
    // Energies at the start contain half a step of friction: 0.4 % with this step.
    let step = "[time]\ndt_max = 2e-4\n";
    for more in ["", rigid] {
        let (_folder, ended) = square(&format!("{sliding}{more}{step}"));
        let friction = warning(&ended, "wall_friction", "");
        assert!(friction["what"].as_str().unwrap().contains("on rigid walls has dissipated"));
        assert!(friction["cure"].as_str().unwrap().contains("wall.friction"), "{friction}");
        let all = ended.summary();
        let energy = |name: &str| all["energy"][name].as_f64().unwrap();
        // The normal forces of the plane do no work, and friction takes all kinetic energy.
        let initial = energy("total_initial");
        for other in [energy("wall"), -initial] {
            let difference = (energy("wall_friction") - other).abs();
            assert!(difference < 0.01 * initial, "{}", all["energy"]);
        }
        let kinds = all["warnings"].as_array().unwrap().iter().map(|w| w["kind"].to_string());
        assert!(kinds.into_iter().all(|kind| kind != "\"friction\""), "contact has none");
    }
}
