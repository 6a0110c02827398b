//! Keyword decks of LS-DYNA and Radioss: formats and problems, models, contacts, joints, arbitrary
//! bytes, runs. Mesh files of other programs.

mod accelerometers;
mod airbags;
mod barlat;
mod bars;
mod base;
mod broken_meshes;
mod bytes;
mod cases;
mod cohesive;
mod composites;
mod contacts;
mod damage;
mod discrete_beams;
mod exported;
mod fates;
mod field_meshes;
mod formats;
mod honeycomb;
mod joints;
mod materials;
mod mesh_details;
mod mesh_files;
mod models;
mod nastran_sets;
mod odd_files;
mod particles;
mod radioss;
mod rigid_joints;
mod rigid_parts;
mod runs;
mod spring_laws;
mod stops_and_times;
mod submodels;
mod ten_nodes;
mod tiebreaks;
