//! `crumple run --trace`: timeline of every worker as Chrome trace events for chrome://tracing
//! and ui.perfetto.dev.
//!
//! The format is that of "Trace Event Format" (Google 2016): one process, a track for each
//! worker, phases as complete events (`X`), orders and redecompositions as instant events (`i`).
//! Times are in microseconds since a common start.

use crumple_proto::disk::{WatchedFile, watched};
use crumple_proto::report::PHASES;
use crumple_proto::trace::{Event, MAX_EVENTS, OrderKind, Recording};
use std::fs::File;
use std::io::{BufWriter, Result, Write};
use std::path::{Path, PathBuf};

/// The file of a trace, and the recordings of the workers.
pub struct TraceFile {
    /// Path of the file.
    pub path: PathBuf,
    file: WatchedFile,
    recordings: Vec<Option<Recording>>,
}

impl TraceFile {
    /// Creates a trace of `workers` workers. The file is created at once, so that a path that
    /// cannot be written is found before the run.
    ///
    /// # Errors
    /// The file cannot be created.
    pub fn new(path: &Path, workers: usize) -> Result<Self> {
        if let Some(folder) = path.parent() {
            watched(folder, || std::fs::create_dir_all(folder))?;
        }
        Ok(Self {
            path: path.to_owned(),
            file: WatchedFile::open(path, |path| File::create(path))?,
            recordings: vec![None; workers],
        })
    }

    /// Adds a worker's recording.
    pub fn add_recording(&mut self, worker: usize, recording: Recording) {
        self.recordings[worker] = Some(recording);
    }

    /// Returns true if a worker's recording has arrived.
    pub fn has(&self, worker: usize) -> bool {
        self.recordings[worker].is_some()
    }

    /// Writes the file. `one_clock` is true if all workers read the same clock. Returns a message
    /// for the user.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write(&mut self, one_clock: bool) -> Result<String> {
        let all =
            || self.recordings.iter().enumerate().filter_map(|(w, r)| r.as_ref().map(|r| (w, r)));
        let first = all().map(|(_, r)| r.origin).min().unwrap_or(0);
        let doubt = if one_clock { 0 } else { all().map(|(_, r)| r.doubt).max().unwrap_or(0) };
        let mut out = BufWriter::new(&mut self.file);
        let clocks = match one_clock {
            true => "one clock for all workers".to_string(),
            false => format!("clocks of workers agree within {:.1} us", 1e-3 * doubt as f64),
        };
        write!(
            out,
            "{{\"displayTimeUnit\":\"ms\",\"otherData\":{{\"program\":\"crumple {}\",\
             \"clocks\":\"{clocks}\"}},\n\"traceEvents\":[\n",
            env!("CARGO_PKG_VERSION")
        )?;
        write!(
            out,
            "{{\"name\":\"process_name\",\"ph\":\"M\",\"pid\":0,\"args\":{{\"name\":\"crumple\"}}}}"
        )?;
        let mut events = 0;
        let mut ended = None;
        for (worker, recording) in all() {
            let shift = if one_clock { recording.origin - first } else { 0 };
            write_track(&mut out, worker, shift, recording)?;
            events += recording.spans.len() + recording.moments.len();
            ended = ended.into_iter().chain(recording.full).min();
        }
        writeln!(out, "\n]}}")?;
        out.flush()?;
        let missing = self.recordings.iter().filter(|r| r.is_none()).count();
        let mut said = format!(
            "{events} events of {} workers in {}; {clocks}",
            all().count(),
            self.path.display()
        );
        if let Some(cycle) = ended {
            said += &format!("; it ends with cycle {cycle}, after {MAX_EVENTS} events of a worker");
        }
        if missing > 0 {
            said += &format!("; {missing} workers sent no events");
        }
        Ok(said)
    }
}

/// Writes the events of one worker, with all times shifted by `shift` [ns].
fn write_track(
    out: &mut impl Write,
    worker: usize,
    shift: u64,
    recording: &Recording,
) -> Result<()> {
    let us = |ns: u64| format!("{}.{:03}", ns / 1000, ns % 1000);
    let at = |ns: u64| us(ns + shift);
    let place = format!("\"pid\":0,\"tid\":{worker}");
    write!(
        out,
        ",\n{{\"name\":\"thread_name\",\"ph\":\"M\",{place},\
         \"args\":{{\"name\":\"worker {worker}\"}}}}"
    )?;
    write!(
        out,
        ",\n{{\"name\":\"thread_sort_index\",\"ph\":\"M\",{place},\
         \"args\":{{\"sort_index\":{worker}}}}}"
    )?;
    for s in &recording.spans {
        write!(
            out,
            ",\n{{\"name\":\"{}\",\"cat\":\"phase\",\"ph\":\"X\",{place},\"ts\":{},\"dur\":{},\
             \"args\":{{\"cycle\":{}}}}}",
            PHASES[usize::from(s.phase)],
            at(s.start),
            us(s.duration),
            s.cycle
        )?;
    }
    for m in &recording.moments {
        write!(
            out,
            ",\n{{\"name\":\"{}\",\"cat\":\"order\",\"ph\":\"i\",\"s\":\"t\",{place},\"ts\":{},\
             \"args\":{{\"cycle\":{}}}}}",
            words(&m.event),
            at(m.at),
            m.cycle
        )?;
    }
    if let Some(cycle) = recording.full {
        write!(
            out,
            ",\n{{\"name\":\"recording_ended\",\"ph\":\"M\",{place},\
             \"args\":{{\"cycle\":{cycle},\"events\":{MAX_EVENTS}}}}}"
        )?;
    }
    Ok(())
}

fn words(event: &Event) -> String {
    let of = |kind: &OrderKind| match kind {
        OrderKind::High => "high redecomposition",
        OrderKind::Low => "low redecomposition",
        OrderKind::Checkpoint => "checkpoint",
        OrderKind::View => "view",
        OrderKind::Steering => "steering",
        OrderKind::Stop => "stop",
    };
    match event {
        Event::Arrived(number, kind) => format!("order {number} received: {}", of(kind)),
        Event::Begun(number, kind) => format!("order {number}: {}", of(kind)),
        Event::Erosion => "renewal: failed elements leave the surface".into(),
        Event::Classes([interior, interface, exterior]) => {
            format!("{interior} interior, {interface} interface, {exterior} exterior elements")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crumple_proto::report::Phase;
    use crumple_proto::trace::{Moment, Span};

    /// Times are shifted to the earliest origin if all workers read the same clock. A lost worker
    /// is reported, and also a truncated recording.
    #[test]
    fn the_file_is_json_with_all_events_on_one_time_line() {
        let folder = tempfile::tempdir().unwrap();
        let mut trace = TraceFile::new(&folder.path().join("deep/trace.json"), 3).unwrap();
        let span = Span { phase: Phase::Halo as u8, cycle: 7, start: 1500, duration: 20 };
        let moment = Moment { event: Event::Begun(3, OrderKind::Low), cycle: 8, at: 2000 };
        let recording =
            |origin| Recording { origin, doubt: 900, spans: vec![span], ..Recording::default() };
        trace.add_recording(
            0,
            Recording { moments: vec![moment], full: Some(9), ..recording(5_000) },
        );
        trace.add_recording(2, recording(4_000));
        let read = |trace: &TraceFile| -> serde_json::Value {
            serde_json::from_str(&std::fs::read_to_string(&trace.path).unwrap()).unwrap()
        };
        let said = trace.write(true).unwrap();
        assert!(
            said.contains("3 events of 2 workers")
                && said.contains("cycle 9")
                && said.contains("1 workers"),
            "{said}"
        );
        let events = read(&trace)["traceEvents"].as_array().unwrap().clone();
        let of = |tid: u64, ph: &str| {
            events.iter().find(|e| e["tid"] == tid && e["ph"] == ph).unwrap().clone()
        };
        assert_eq!((of(0, "X")["ts"].as_f64(), of(2, "X")["ts"].as_f64()), (Some(2.5), Some(1.5)));
        assert_eq!(
            (of(0, "X")["name"].as_str(), of(0, "X")["dur"].as_f64()),
            (Some("halo"), Some(0.02))
        );
        assert_eq!(of(0, "i")["name"], "order 3: low redecomposition");
        assert!(events.iter().any(|e| e["name"] == "recording_ended" && e["args"]["cycle"] == 9));

        let mut apart = TraceFile::new(&folder.path().join("apart.json"), 2).unwrap();
        apart.add_recording(0, recording(5_000));
        apart.add_recording(1, recording(77));
        assert!(apart.write(false).unwrap().contains("within 0.9 us"));
        let starts: Vec<f64> = read(&apart)["traceEvents"]
            .as_array()
            .unwrap()
            .iter()
            .filter_map(|e| e["ts"].as_f64())
            .collect();
        assert_eq!(starts, [1.5, 1.5], "clocks of different machines are not compared");
    }
}
