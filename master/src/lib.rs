//! The master of Crumple as a library. The `crumple` binary is the package in `program/`.
//!
//! - [`cli`]: the command line; [`features`]: features of this build; [`stdout`]: standard output
//! - [`input`]: jobs ([`input::job`]), LS-DYNA keyword decks ([`input::deck`]), checks
//!   (`crumple check`), reference (`crumple schema`)
//! - [`run`]: start reading at [`run::control`], the run on the master; [`run::launch`]:
//!   `crumple run` on threads or under MPI; [`run::embedded`]: engines in this process without a
//!   master
//! - [`results`]: fields, histories, summary, report page, exports
//! - [`serve`]: `crumple serve`, jobs in a queue; [`client`]: commands that ask a service
//! - [`analysis`]: `crumple study`, `advise`, `diff`, `reproduce`, `scale`, `bench`, `cost`
//!
//! `crumple verify` is the crate `crumple-verification` in `tests/verification/`.
//!
//! # Two bars
//!
//! [`run::embedded`] runs a job in this process. Here two bars of equal mass collide. After the
//! impact the first one is at rest (Graff 1975, chapter 2: they exchange their velocities).
//!
//! ```
//! use crumple::{input::job, run::embedded::run_alone};
//! use std::{ops::ControlFlow, path::Path};
//!
//! let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../cases/bars");
//! let model = job::read(&folder, &[]).unwrap_or_else(|report| panic!("{report}"));
//! let end = run_alone(&model, |_| ControlFlow::Continue(())).unwrap();
//! let nodes = &end.engine.nodes;
//! let momentum = |from: f64, to: f64| -> f64 {
//!     let moving = (0..nodes.len()).filter(|i| (from..to).contains(&nodes.x[*i][0]));
//!     moving.map(|i| nodes.mass[i] * nodes.v[i][0]).sum()
//! };
//! let middle = 100.0; // both bars are 100 mm long
//! let [first, second] = [momentum(-1e3, middle), momentum(middle, 1e3)];
//! assert!(first.abs() < 0.02 * second);
//! ```
//!
//! # One element under strain
//!
//! A square shell is pulled along x while its width is held. Its stress is that of plane strain in
//! y, `E/(1 - nu^2) ln(stretch)`.
//!
//! ```
//! use crumple::{input::job, run::embedded::run_alone};
//! use std::ops::ControlFlow;
//!
//! let text = r#"
//!     end_time = 1.0                      # [ms]
//!     [mesh]
//!     nodes = [[1, 0.0, 0.0, 0.0], [2, 10.0, 0.0, 0.0], [3, 10.0, 10.0, 0.0], [4, 0.0, 10.0, 0.0]]
//!     shells = [[1, 1, 1, 2, 3, 4]]
//!     node_sets = { left = [1, 4], right = [2, 3] }
//!     [[material]]
//!     name = "steel"
//!     law = "elastic"
//!     density = 7.85e-6                   # [kg/mm^3]
//!     youngs_modulus = 207.0              # [GPa]
//!     poisson = 0.3
//!     [[part]]
//!     id = 1
//!     material = "steel"
//!     thickness = 1.0
//!     [[fix]]
//!     nodes = "left"
//!     dofs = ["x", "y", "z"]
//!     [[fix]]
//!     nodes = "right"
//!     dofs = ["y", "z"]
//!     [[motion]]
//!     nodes = "right"
//!     dofs = ["x"]
//!     velocity = [0.01, 0.0, 0.0]         # a strain of 0.1 % at the end
//! "#;
//! let model = job::read_text("square.toml".into(), text.into(), &[]);
//! let model = model.unwrap_or_else(|report| panic!("{report}"));
//! let end = run_alone(&model, |_| ControlFlow::Continue(())).unwrap();
//! let (blocks, nodes) = (&end.engine.blocks, &end.engine.nodes);
//! let corners = blocks.elements[0].nodes.map(|n| std::array::from_fn(|c| nodes.x[n as usize][c]));
//! let block = &blocks.blocks[0];
//! let stress = block.element.fields(block.state(0), &corners).stress[0];
//! // Forces, and so stresses, are those before the last step of positions.
//! let clock = &end.engine.clock;
//! let stretch = 1.0 + 0.001 * (clock.time - clock.last_dt);
//! let exact = 207.0 / (1.0 - 0.3 * 0.3) * stretch.ln();
//! assert!((stress / exact - 1.0).abs() < 1e-6, "{stress} GPa, {exact} expected");
//! ```
//!
//! # A new law
//!
//! A material or contact law from outside adds its row to the table, `LAWS.add(&LAW)`, before the
//! first job is read: `docs/tutorials/new-material.md`, and `tests/tests/added_laws/main.rs`.

pub mod analysis;
pub mod cli;
pub mod client;
pub mod features;
pub mod input;
pub mod results;
pub mod run;
pub mod serve;
pub mod stdout;
