//! Scenes with known outcome: waves, beams, loads and constraints.

mod airbags;
mod bars;
mod beams;
mod belts;
mod cohesive;
mod composites;
mod discrete_beams;
mod free_rotation;
mod joints;
mod loads;
mod particles;
mod rigid;
mod sections;
mod shocks;
mod solids;
mod spring_laws;
mod springs;
mod stops;
mod switches;
mod ties;
mod trusses;
mod walls;
