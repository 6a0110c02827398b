//! State of all constraints for a checkpoint. Every worker has all rigid bodies, walls, ties,
//! bonds and seat belts with the same values, so it is stored once.

use super::Constraints;
use super::belts::{BeltState, Belts};
use super::bonds::Bonds;
use super::prescribed::Prescribed;
use super::rigid::Bodies;
use super::ties::Ties;
use super::walls::{WallState, Walls};
use crumple_proto::partition::Settings;
use crumple_proto::wall::ResolvedWall;
use serde::{Deserialize, Serialize};

/// State of all constraints, equal on all workers.
#[derive(Debug, Serialize, Deserialize)]
pub struct ConstraintState {
    bodies: Bodies,
    walls: Vec<WallState>,
    ties: Ties,
    bonds: Bonds,
    belts: BeltState,
}

/// State of all constraints, as it is written.
#[derive(Debug, Serialize)]
pub struct ConstraintStateView<'a> {
    bodies: &'a Bodies,
    walls: Vec<WallState>,
    ties: &'a Ties,
    bonds: &'a Bonds,
    belts: &'a BeltState,
}

impl ConstraintState {
    /// Checks that the state has the bodies, walls and ties of a job.
    ///
    /// # Errors
    /// It has others: the reason.
    pub fn validate(&self, settings: &Settings) -> Result<(), String> {
        let (walls, jobs) = (self.walls.len(), settings.walls.len());
        if walls > jobs {
            return Err(format!("it has {walls} walls, and the job has {jobs}"));
        }
        let is_other = |(wall, job): (&WallState, &ResolvedWall)| !wall.fits(job);
        if let Some(wall) = self.walls.iter().zip(&settings.walls).position(is_other) {
            return Err(format!("rigid wall {wall} differs from that of the job"));
        }
        self.bodies.validate(settings)?;
        self.ties.validate(&settings.ties)?;
        self.bonds.validate(&settings.ties)?;
        self.belts.validate(&settings.belts)
    }
}

impl ConstraintState {
    /// Marks bodies that have become rigid for the rest of the run: their elements compute no
    /// forces.
    pub fn settle(&self, settings: &mut Settings) {
        for (b, body) in settings.rigid.iter_mut().enumerate() {
            if self.bodies.has_settled(b, body) {
                body.window = None;
            }
        }
    }
}

impl Constraints {
    /// Returns the state that all workers have in common. The impulses of walls,
    /// [`Walls::impulses`], are sums of one worker and not part of it.
    pub fn state(&self) -> ConstraintStateView<'_> {
        // Prescribed motions are functions of time; `before_walls` belongs to one step.
        let Self { prescribed: _, bodies, walls, ties, bonds, belts, before_walls: _ } = self;
        ConstraintStateView { bodies, walls: walls.state(), ties, bonds, belts: belts.state() }
    }

    /// Builds the constraints of a run that continues from a state.
    pub fn restore(settings: &Settings, state: ConstraintState) -> Self {
        let curves = &settings.loads.curves;
        let mut walls = Walls::new(&settings.walls, curves);
        walls.restore(&state.walls);
        let mut bodies = state.bodies;
        bodies.restore(settings);
        Self {
            prescribed: Prescribed::new(&settings.loads),
            bodies,
            walls,
            ties: state.ties,
            bonds: state.bonds,
            belts: Belts::restore(&settings.belts, state.belts),
            before_walls: Vec::new(),
        }
    }
}
