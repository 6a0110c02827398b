//! Contact: laws, interfaces, edges, beams, initial penetrations and failed elements.

mod beam_contact;
mod contact_laws;
mod edges;
mod erosion;
mod fast_fragment;
mod friction;
mod initial_penetration;
mod interfaces;
