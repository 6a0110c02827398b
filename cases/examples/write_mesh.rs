//! Writes a generator's mesh as a mesh file that a job can name: `write_mesh jeep_frame refine=2 >
//! mesh.toml`.

use crumple_cases::generate;
use crumple_proto::quality::quality;
use std::io::{BufWriter, Write};

fn main() -> std::io::Result<()> {
    let mut arguments = std::env::args().skip(1);
    let name = arguments.next().unwrap_or_default();
    let options = arguments.collect::<Vec<_>>().join("\n");
    let scene =
        options.parse().unwrap_or_else(|e| fail(&format!("write options as key=value: {e}")));
    let mesh = generate(&name, &scene).unwrap_or_else(|problems| {
        fail(&problems.iter().map(|p| format!("{}: {p}", p.path)).collect::<Vec<_>>().join("\n"))
    });
    eprintln!(
        "{} nodes, {} elements, {:#?}",
        mesh.nodes.len(),
        mesh.elements.len(),
        quality(&mesh)
    );

    let mut out = BufWriter::new(std::io::stdout().lock());
    writeln!(out, "nodes = [")?;
    for n in &mesh.nodes {
        writeln!(out, "  [{}, {:?}, {:?}, {:?}],", n.id, n.x[0], n.x[1], n.x[2])?;
    }
    writeln!(out, "]\nshells = [")?;
    for e in &mesh.elements {
        let corners: Vec<String> = e.corners().iter().map(|id| id.to_string()).collect();
        writeln!(out, "  [{}, {}, {}],", e.id, e.part, corners.join(", "))?;
    }
    writeln!(out, "]\n\n[node_sets]")?;
    for (set, nodes) in &mesh.node_sets {
        let nodes: Vec<String> = nodes.iter().map(|id| id.to_string()).collect();
        writeln!(out, "{set} = [{}]", nodes.join(", "))?;
    }
    out.flush()
}

fn fail(message: &str) -> ! {
    eprintln!("{message}");
    std::process::exit(2)
}
