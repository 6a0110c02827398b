//! Limits of the disk, and of clients that do not read.

use super::attacks::{multipart, refused};
use crumple_tests::service::{Service, bars};
use std::fs::{self, File};
use std::io::{Read, Write};
use std::net::TcpStream;
use std::time::Duration;

/// Size of a file that fits into no buffer of a connection [byte].
const LARGE: u64 = 48 << 20;

#[test]
fn jobs_that_leave_too_little_of_the_disk_are_refused() {
    let mut service = Service::start(&["--disk-limit=1000000000"]);
    let full = service.post("/api/jobs", &bars(&[]));
    refused(&service, "a full disk", &full, &[507]);
    let why = full.json()["error"].as_str().unwrap().to_string();
    assert!(why.contains("1000000000.000 GB") && why.contains("--disk-limit"), "{why}");
    let parts = [("file", Some("job.toml"), &b"x"[..])];
    refused(&service, "a form", &multipart(&service, &parts), &[507]);
    assert_eq!(service.get("/api/jobs").json()["total"], 0);
    assert!(fs::read_dir(service.dir().join("jobs")).unwrap().next().is_none());
    // A request that states more than the disk has is refused before it arrives.
    service.set_options(&["--disk-limit=0", "--max-upload=100000000000"]);
    service.kill();
    service.again();
    let head = format!(
        "POST /api/jobs HTTP/1.1\r\nHost: {}\r\nAuthorization: Bearer {}\r\nConnection: close\r\n\
         Content-Type: multipart/form-data; boundary=xyz\r\nContent-Length: {}\r\n\r\n",
        service.host, service.token, 90_000_000_000_000_000_u64
    );
    refused(&service, "a job beyond the disk", &service.raw(head.as_bytes()), &[507]);
    let id = service.submit(&bars(&[]));
    service.wait_for(id, "completed");
}

/// Asks for a large file of a job.
fn ask(service: &Service, id: i64) -> TcpStream {
    let mut stream = TcpStream::connect(&service.host).unwrap();
    let request = format!(
        "GET /api/jobs/{id}/files/results/large HTTP/1.1\r\nHost: {}\r\nAuthorization: Bearer \
         {}\r\nConnection: close\r\n\r\n",
        service.host, service.token
    );
    stream.write_all(request.as_bytes()).unwrap();
    stream
}

#[test]
fn a_client_that_does_not_read_is_disconnected_and_a_slow_one_is_not() {
    let service = Service::start(&["--stall-limit=5"]);
    let id = service.submit(&bars(&[]));
    service.wait_for(id, "completed");
    let large = File::create(service.folder(id).join("results/large")).unwrap();
    large.set_len(LARGE).unwrap();
    let mut slow = ask(&service, id);
    let mut stalled = ask(&service, id);
    // For longer than the limit, but with pauses that are shorter.
    let mut piece = vec![0; 1 << 20];
    let mut read = slow.read(&mut piece).unwrap() as u64; // the head, and some of the file
    for _ in 0..10 {
        std::thread::sleep(Duration::from_millis(600));
        slow.read_exact(&mut piece).unwrap();
        read += piece.len() as u64;
    }
    read += std::io::copy(&mut slow, &mut std::io::sink()).unwrap();
    assert!(read > LARGE, "the slow client has the whole file: {read}");
    service.wait("the connection is closed", |service| {
        let text = fs::read_to_string(format!("/proc/{}/net/tcp", service.id())).ok()?;
        let port: u16 = service.host.rsplit(':').next()?.parse().ok()?;
        let own = format!("0100007F:{port:04X}");
        // State 01 is an open connection.
        let is_open = |line: &str| {
            let words: Vec<&str> = line.split_whitespace().collect();
            words.len() > 3 && words[1] == own && words[3] == "01"
        };
        (!text.lines().any(is_open)).then_some(())
    });
    let mut rest = 0;
    while let Ok(n @ 1..) = stalled.read(&mut piece) {
        rest += n as u64;
    }
    assert!(rest < LARGE, "the stalled client had {rest} bytes");
    assert_eq!(service.get("/api/jobs").status, 200);
}
