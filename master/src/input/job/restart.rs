//! Changes of the model when a run continues: checks, and the rigid bodies and walls that they add
//! to the job.

use super::validate::JobProblems;
use crumple_proto::job::{Job, Restart, Rigid};
use crumple_proto::problem::Problem;

/// Checks the section `restart`, and appends its rigid bodies and walls to those of the job.
pub fn add(job: &mut Job, findings: &mut JobProblems) {
    let restart = std::mem::take(&mut job.restart);
    let rigid = |id: u32| job.rigid.iter().any(|r| r.parts.contains(&id));
    let mut refuse = |path: String, message: String, help: &str| {
        findings.add(Problem::error(path, message, help));
    };
    let velocities = restart.velocity.iter().flat_map(|v| &v.parts);
    for (key, id) in (restart.delete.iter().map(|id| ("delete", id)))
        .chain(restart.rigid.iter().map(|id| ("rigid", id)))
        .chain(velocities.map(|id| ("velocity", id)))
    {
        let path = format!("restart.{key}");
        if !job.part.iter().any(|p| p.id == *id) {
            refuse(path, format!("there is no part {id}"), "give the ids of parts");
        } else if rigid(*id) {
            let help = "leave it out: only parts that deform can be changed";
            refuse(path, format!("part {id} belongs to a rigid body"), help);
        } else if key != "delete" && restart.delete.contains(id) {
            refuse(path, format!("part {id} is also deleted"), "leave it out here");
        } else if key == "velocity" && restart.rigid.contains(id) {
            let help =
                "continue with the velocity first, and in a later continuation make it rigid";
            refuse(path, format!("part {id} also becomes rigid"), help);
        }
    }
    for (i, velocity) in restart.velocity.iter().enumerate() {
        if velocity.parts.is_empty() {
            let message = "a new velocity names no parts".to_string();
            refuse(format!("restart.velocity.{i}.parts"), message, "give the ids of parts");
        }
    }
    for (i, wall) in restart.wall.iter().enumerate() {
        if wall.velocity.is_some() || wall.displacement.is_some() {
            let message = "an additional wall has a prescribed motion".to_string();
            let help = "give it a mass and a speed, or leave it at rest";
            refuse(format!("restart.wall.{i}"), message, help);
        }
    }
    let body = |&id: &u32| Rigid {
        name: Restart::body_name(id),
        parts: vec![id],
        nodes: None,
        fixed: Vec::new(),
        mass: None,
        centre: None,
        inertia: None,
        added_inertia: None,
        from: 0.0,
        until: None,
        stop: Vec::new(),
        load: Vec::new(),
    };
    let bodies: Vec<Rigid> = restart.rigid.iter().map(body).collect();
    job.rigid.extend(bodies);
    job.wall.extend(restart.wall.iter().cloned());
    job.restart = restart;
}
