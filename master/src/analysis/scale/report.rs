//! Output of `crumple scale`: table, `scale.csv` and chart.

use super::census::Count;
use super::model::{LOSSES, Network};
use super::{Prediction, ScaleSample};
use crate::analysis::study::chart::series::{Polyline, percent_over_doublings};
use std::fmt::Write;
use std::path::Path;

/// Smallest acceptable efficiency.
const WORTHWHILE: f64 = 0.5;
/// Largest number of workers that is measured. Larger ones are modelled on every machine.
const MEASURED: usize = 2;

/// Returns the table of one time as Markdown, and the cause that limits the efficiency.
pub fn table(sample: &ScaleSample, network: Network) -> String {
    let w = &sample.whole;
    let mut out = format!(
        "T={}, counted after cycle {}: {} elements, {} nodes, {} near candidates, {} contact \
         pairs; one worker takes {:.1} us per step.\n\
         Model: {:.2} us per message and {:.1} GB/s; more than {MEASURED} workers are not \
         measured. Renewals and caches are not included. Scaled: {:.0} elements per worker.\n\n\
         | workers | elements | at shared nodes | copied nodes | neighbours | messages | kB \
         | step [us] | efficiency | scaled |\n\
         |---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|\n",
        sample.at,
        sample.cycle,
        w.elements,
        w.held,
        w.near,
        w.pairs,
        1e6 * sample.alone.total(),
        1e6 * network.latency,
        1e-9 * network.bandwidth,
        sample.grows_by
    );
    for p in &sample.predictions {
        let least = p.counts.iter().map(|c| c.elements).min().unwrap_or(0);
        // Writing to a string cannot fail.
        let _ = writeln!(
            out,
            "| {} | {least}..{} | {} | {} | {} | {:.0} | {:.1} | {:.1} | {:.1} % | {:.1} % |",
            p.workers,
            most(p, |c| c.elements),
            most(p, |c| c.shared),
            most(p, |c| c.exterior_nodes),
            most(p, |c| c.neighbours),
            p.step.messages,
            1e-3 * p.step.bytes,
            1e6 * p.step.total,
            100.0 * p.step.efficiency(),
            100.0 * p.scaled
        );
    }
    out += "\nCounts, messages and kB are the largest of all workers.\n";
    out + &sentence(sample)
}

fn most(p: &Prediction, of: fn(&Count) -> u64) -> u64 {
    p.counts.iter().map(of).max().unwrap_or(0)
}

/// Names the largest loss at the largest number of workers with acceptable efficiency.
fn sentence(sample: &ScaleSample) -> String {
    let worth = sample.predictions.iter().rfind(|p| p.step.efficiency() > WORTHWHILE);
    let (p, lead) = match (worth, sample.predictions.first()) {
        (Some(p), _) => {
            (p, "is the largest of these numbers of workers with an efficiency above 50 %")
        }
        (None, Some(p)) => (p, "workers already have an efficiency below 50 %"),
        (None, None) => return String::new(),
    };
    let share = |i: usize| 100.0 * p.step.lost[i] / p.step.total;
    let first = p.step.first_limit();
    let others: Vec<String> = (0..LOSSES.len())
        .filter(|&i| i != first)
        .map(|i| format!("{} {:.1} %", LOSSES[i], share(i)))
        .collect();
    let to_all = match LOSSES[first] {
        "latency" if p.to_all > 0.0 => {
            format!(
                " ({:.0} messages of the worker that sends most, {:.0} of them to all others)",
                p.step.messages, p.to_all
            )
        }
        _ => String::new(),
    };
    format!(
        "{} {lead} ({:.1} %); the largest loss there is {}{to_all}, {:.1} % of the processor \
         time; {}.\n",
        p.workers,
        100.0 * p.step.efficiency(),
        LOSSES[first],
        share(first),
        others.join(", ")
    )
}

/// Writes `scale.csv` and the chart, and returns a text that names the files.
///
/// # Errors
/// A file cannot be written.
pub fn write(title: &str, samples: &[ScaleSample], out: &Path) -> Result<String, String> {
    let path = out.join("scale.csv");
    std::fs::write(&path, csv(samples)).map_err(|error| format!("{}: {error}", path.display()))?;
    let mut curves = Vec::new();
    for (colour, s) in samples.iter().enumerate() {
        let points = |of: fn(&Prediction) -> f64| {
            s.predictions.iter().map(|p| [p.workers as f64, 100.0 * of(p)]).collect::<Vec<_>>()
        };
        let fixed = Polyline {
            name: format!("T = {}", s.at),
            dashed: false,
            colour,
            points: points(|p| p.step.efficiency()),
        };
        let scaled = format!("scaled, {:.0} elements per worker", s.grows_by);
        curves.extend([
            fixed,
            Polyline { name: scaled, dashed: true, colour, points: points(|p| p.scaled) },
        ]);
    }
    let titles = ["workers", "parallel efficiency, modelled [%]"];
    let [svg, png] = percent_over_doublings(title, titles, &curves, &out.join("scale"))?;
    Ok(format!("{}, {}, {}", path.display(), svg.display(), png.display()))
}

fn csv(samples: &[ScaleSample]) -> String {
    let mut out = String::from(
        "time,cycle,workers,elements least,elements most,elements at shared nodes most,\
         held nodes most,copied nodes most,copied segments most,neighbours most,\
         workers near most,workers with copies of pairs most,near candidates most,pairs most,\
         messages most,messages to all others,bytes most,\
         step [us],own work of the critical path [us],efficiency [%],scaled efficiency [%]",
    );
    LOSSES.iter().for_each(|name| out += &format!(",{name} [%]"));
    out.push('\n');
    for s in samples {
        for p in &s.predictions {
            let counts: [fn(&Count) -> u64; 9] = [
                |c| c.shared,
                |c| c.held,
                |c| c.exterior_nodes,
                |c| c.exterior_segments,
                |c| c.neighbours,
                |c| c.near_workers,
                |c| c.meets,
                |c| c.near,
                |c| c.pairs,
            ];
            let least = p.counts.iter().map(|c| c.elements).min().unwrap_or(0);
            out +=
                &format!("{},{},{},{least},{}", s.at, s.cycle, p.workers, most(p, |c| c.elements));
            counts.iter().for_each(|&of| out += &format!(",{}", most(p, of)));
            let t = &p.step;
            out += &format!(
                ",{:.0},{:.0},{:.0},{:.3},{:.3}",
                t.messages,
                p.to_all,
                t.bytes,
                1e6 * t.total,
                1e6 * t.own
            );
            out += &format!(",{:.2},{:.2}", 100.0 * t.efficiency(), 100.0 * p.scaled);
            t.lost.iter().for_each(|l| out += &format!(",{:.2}", 100.0 * l / t.total));
            out.push('\n');
        }
    }
    out
}
