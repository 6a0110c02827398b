//! Constraints on velocities: prescribed motion, rigid bodies, rigid walls and ties, and the order
//! in which they act; the bonds that ties leave when they fail; and seat belts.
//!
//! [`Constraints`] owns all of them. Every method calls them in the order of their precedence in
//! that stage of the step; where two constraints act on one node, the later one decides:
//!
//! | stage | order |
//! |---|---|
//! | forces | forces of bonds and belts; ties: forces on slaves go to their masters |
//! | velocities without contact | prescribed motion, bodies, joints, motion of walls, tied slaves |
//! | during contact | walls stop single nodes; rigid bodies and joints carry their members |
//! | after contact | masters of ties, walls, rigid bodies, joints, tied slaves |
//! | end of the step | rigid bodies, walls |
//!
//! After contact, masters have the contact forces of their slaves before they reach a wall.

pub mod belts;
pub mod bonds;
pub mod prescribed;
pub mod rigid;
mod state;
pub mod ties;
pub mod walls;

use crate::contact::Contact;
use crate::contact::surroundings::Exclusions;
use crate::energy::Ledger;
use crate::math::row::Row;
use crate::nodes::Nodes;
use crate::time::StepSizes;
use crate::work::WorkSum;
use belts::Belts;
use bonds::Bonds;
use crumple_proto::ids::ElemId;
use crumple_proto::partition::Settings;
use crumple_proto::transport::{RankLost, Transport};
use prescribed::Prescribed;
use rigid::Bodies;
pub use state::ConstraintState;
use ties::Ties;
use walls::Walls;

/// All constraints of the job.
#[derive(Debug, Default)]
pub struct Constraints {
    /// Prescribed motions.
    pub prescribed: Prescribed,
    /// Rigid bodies.
    pub bodies: Bodies,
    /// Rigid walls.
    pub walls: Walls,
    /// Tied nodes.
    pub ties: Ties,
    /// Bonds of ties that have failed.
    pub bonds: Bonds,
    /// Seat belts.
    pub belts: Belts,
    /// Touched nodes with their velocities after contact and before walls [length/time].
    before_walls: Vec<(u32, Row)>,
}

impl Constraints {
    /// Returns an inverse mass of local node `n` with which forces on many nodes at once move them
    /// no less than they do with the constraints [1/mass].
    ///
    /// The masters of ties have the masses m of their slaves besides their own M, and their forces
    /// g besides their own G: `|G + g|^2/(M + m) <= 2 |G|^2/(M + m) + 2 |g|^2/m`.
    pub fn largest_inv_mass(&self, n: u32, nodes: &Nodes) -> Row {
        let times = if self.ties.is_empty() { 1.0 } else { 2.0 };
        self.bodies.largest_inv_mass(n, nodes).map(|inverse| times * inverse)
    }

    /// Builds the constraints of a new run, and adds the masses of tied slaves to their masters.
    /// Collective.
    ///
    /// # Errors
    /// A worker is gone.
    pub fn new(
        comm: &mut dyn Transport,
        settings: &Settings,
        nodes: &mut Nodes,
    ) -> Result<Self, RankLost> {
        let ties = Ties::new(comm, settings, nodes)?;
        Ok(Self {
            prescribed: Prescribed::new(&settings.loads),
            bodies: Bodies::new(comm, settings, nodes)?,
            walls: Walls::new(&settings.walls, &settings.loads.curves),
            ties,
            bonds: Bonds::default(),
            belts: Belts::new(&settings.belts),
            before_walls: Vec::new(),
        })
    }

    /// Finds the constrained nodes of a new local mesh. Collective.
    ///
    /// # Errors
    /// A worker is gone.
    pub fn bind_local(
        &mut self,
        comm: &mut dyn Transport,
        nodes: &mut Nodes,
    ) -> Result<(), RankLost> {
        self.ties.bind_local(comm, nodes)?;
        self.bodies.bind_local(nodes);
        self.walls.bind_local(nodes);
        self.prescribed.bind_local(nodes);
        Ok(())
    }

    /// Releases the slaves of elements that have failed on any worker. Returns true if there are
    /// any, on any worker; the local mesh must be built again then. Collective.
    ///
    /// # Errors
    /// A worker is gone.
    pub fn release_failed(
        &mut self,
        comm: &mut dyn Transport,
        failed: &[ElemId],
        nodes: &mut Nodes,
    ) -> Result<bool, RankLost> {
        self.bonds.remove_failed(comm, failed)?;
        self.ties.release_failed(comm, failed, nodes)
    }

    /// Finds the ties that the forces of this step break, with the acceleration of gravity.
    /// Velocities at the end of the step must be known. Collective if ties can fail.
    ///
    /// # Errors
    /// A worker is gone.
    pub fn find_broken(
        &mut self,
        comm: &mut dyn Transport,
        nodes: &Nodes,
        contact: Option<&Contact>,
        now: (StepSizes, Row),
    ) -> Result<(), RankLost> {
        self.ties.find_broken(comm, nodes, contact, now)
    }

    /// Releases the slaves of ties that have broken, and adds their bonds. The local mesh must be
    /// built again then. Collective.
    ///
    /// # Errors
    /// A worker is gone.
    pub fn release_broken(
        &mut self,
        comm: &mut dyn Transport,
        nodes: &mut Nodes,
        dt: f64,
    ) -> Result<(), RankLost> {
        let released = self.ties.release_broken(nodes);
        self.bonds.add(comm, released, nodes, dt)
    }

    /// Constrains and frees nodes whose motions begin or have ended, before any acceleration.
    pub fn begin_step(&mut self, nodes: &mut Nodes, time: f64) {
        self.prescribed.begin_step(nodes, time);
    }

    /// Distributes forces on constrained nodes, once all but contact forces are known.
    ///
    /// # Errors
    /// A worker is gone.
    pub fn distribute_forces(
        &mut self,
        comm: &mut dyn Transport,
        nodes: &mut Nodes,
        now: (f64, StepSizes),
    ) -> Result<(), RankLost> {
        self.bonds.add_forces(comm, nodes)?;
        self.belts.add_forces(comm, nodes, &self.bodies, now)?;
        self.ties.distribute_forces(comm, nodes)
    }

    /// Imposes prescribed motions and rigid bodies on the velocities without contact. Contact also
    /// needs the velocities of tied slaves and, with friction, the rotational velocities of members
    /// of bodies.
    ///
    /// # Errors
    /// A worker is gone.
    pub fn constrain(
        &mut self,
        comm: &mut dyn Transport,
        nodes: &mut Nodes,
        contact: Option<&Contact>,
        time: f64,
        steps: StepSizes,
    ) -> Result<(), RankLost> {
        self.prescribed.apply(nodes, time, steps.dt); // inverse mass is zero there
        self.bodies.accelerate(comm, nodes, time, steps)?;
        self.walls.start_step(time, steps.dt);
        if let Some(contact) = contact {
            self.ties.update_slave_velocities(comm, nodes, steps.dt)?;
            if contact.has_couples(nodes) {
                self.bodies.turn(nodes);
            }
        }
        Ok(())
    }

    /// Lets constraints react to contact. Adds the work of walls and rigid bodies to the ledger.
    ///
    /// # Errors
    /// A worker is gone.
    pub fn react(
        &mut self,
        comm: &mut dyn Transport,
        nodes: &mut Nodes,
        contact: Option<&Contact>,
        (time, steps): (f64, StepSizes),
        ledger: &mut Ledger,
    ) -> Result<(), RankLost> {
        if let Some(contact) = contact {
            self.ties.distribute_contact_forces(comm, nodes, contact, steps)?;
        }
        if !self.walls.is_empty() {
            self.bodies.add_wall_impulses(&mut self.walls);
            self.before_walls.clear();
            let touched = contact.iter().flat_map(|c| c.contact_forces(nodes, steps));
            self.before_walls.extend(touched);
            self.ties.add_contact_forces(&mut self.before_walls, nodes, steps);
            let pushed = &self.before_walls;
            self.walls.enforce(comm, nodes, pushed, steps, &mut ledger.wall)?;
        }
        self.bodies.finish(nodes, &mut self.walls, time, steps, ledger);
        self.ties.update_slave_velocities(comm, nodes, steps.dt)?;
        if !self.bonds.is_empty() {
            self.bonds.add_work(nodes, steps, &mut ledger.links);
        }
        self.belts.add_work(nodes, steps, ledger);
        if nodes.me == 0 {
            // All workers know it: count it once.
            ledger.wall.total.add(self.walls.work_on_masses());
        }
        Ok(())
    }

    /// Adds the work of prescribed motions on owned nodes in the step, with final velocities, to
    /// `sum`.
    pub fn add_prescribed_work(
        &self,
        nodes: &Nodes,
        contact: Option<&Contact>,
        now: (f64, StepSizes),
        sum: &mut WorkSum,
    ) {
        self.prescribed.add_work(nodes, (contact, &self.ties), now, sum);
    }

    /// Moves rigid bodies with their members, and walls, to their positions at the end of the step.
    pub fn advance(&mut self, nodes: &mut Nodes, dt: f64) {
        self.bodies.advance(nodes, dt);
        self.walls.advance(dt);
    }
}

impl Exclusions for Constraints {
    fn excludes(&self, node: u32, segment: &[u32; 4]) -> bool {
        self.bodies.share_body(node, segment) || self.ties.are_tied(node, segment)
    }

    fn are_tied(&self, node: u32, segment: &[u32; 4]) -> bool {
        self.ties.are_tied(node, segment)
    }
}
