//! The service by TLS, with certificates of a private authority.

use crumple_tests::program::{crumple, root};
use crumple_tests::service::Service;
use rcgen::{BasicConstraints, CertificateParams, DnType, IsCa, Issuer, KeyPair};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use tempfile::TempDir;

/// Certificates in a folder: `NAME.pem` of an authority; `NAME-cert.pem` and `NAME-key.pem` of a
/// service at 127.0.0.1 that it vouches for.
struct Certificates(TempDir);

impl Certificates {
    fn new(names: &[&str]) -> Self {
        let own = Self(tempfile::tempdir().unwrap());
        for name in names {
            let mut params = CertificateParams::new(vec![]).unwrap();
            params.is_ca = IsCa::Ca(BasicConstraints::Unconstrained);
            params.distinguished_name.push(DnType::CommonName, *name);
            let key = KeyPair::generate().unwrap();
            fs::write(own.path(&format!("{name}.pem")), params.self_signed(&key).unwrap().pem())
                .unwrap();
            let authority = Issuer::new(params, key);
            let mut params = CertificateParams::new(vec!["127.0.0.1".to_string()]).unwrap();
            params.distinguished_name.push(DnType::CommonName, "the service");
            let key = KeyPair::generate().unwrap();
            let certificate = params.signed_by(&key, &authority).unwrap();
            fs::write(own.path(&format!("{name}-cert.pem")), certificate.pem()).unwrap();
            fs::write(own.path(&format!("{name}-key.pem")), key.serialize_pem()).unwrap();
        }
        own
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }
}

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&[&output.stdout[..], &output.stderr].concat()).into_owned()
}

#[test]
fn commands_reach_a_service_whose_authority_they_trust() {
    let all = Certificates::new(&["own", "other"]);
    let (certificate, key) = (all.path("own-cert.pem"), all.path("own-key.pem"));
    let service = Service::start(&["--tls-cert", text(&certificate), "--tls-key", text(&key)]);
    assert!(service.said().contains("https://127.0.0.1:"), "{}", service.said());
    let job = root().join("cases/bars/job.toml");
    let (own, other) = (all.path("own.pem"), all.path("other.pem"));
    let done = service.command(&["submit", text(&job), "--watch", "--ca", text(&own)]);
    assert_eq!(done.status.code(), Some(0), "{}", said(&done));
    assert!(said(&done).contains("job 1: completed"), "{}", said(&done));
    let folder = tempfile::tempdir().unwrap();
    let out = text(folder.path());
    let fetched =
        service.command(&["fetch", "1", "results/history.csv", "--out", out, "--ca", text(&own)]);
    assert_eq!(fetched.status.code(), Some(0), "{}", said(&fetched));
    // Neither public authorities nor another private one vouch for it, and the token is not sent.
    for words in [&["jobs"][..], &["jobs", "--ca", text(&other)]] {
        let ended = service.command(words);
        assert_eq!(ended.status.code(), Some(2), "{words:?}: {}", said(&ended));
        assert!(said(&ended).contains("certificate"), "{words:?}: {}", said(&ended));
    }
    let no_certificate = service.command(&["jobs", "--ca", text(&key)]);
    assert!(said(&no_certificate).contains("no certificate in PEM"), "{}", said(&no_certificate));
    // Plain HTTP gets no answer on this port.
    let plain = service.get("/api/jobs");
    assert_eq!(plain.status, 0, "{}", plain.text());
    let bytes = [plain.head.as_bytes(), &plain.body].concat();
    assert!(!String::from_utf8_lossy(&bytes).contains("HTTP"), "{bytes:?}");
}

#[test]
fn a_service_does_not_start_with_a_certificate_and_a_key_that_do_not_fit() {
    let all = Certificates::new(&["own", "other"]);
    let empty = all.path("empty.pem");
    fs::write(&empty, "").unwrap();
    let (own, other) = (all.path("own-cert.pem"), all.path("other-key.pem"));
    let absent = all.path("absent.pem");
    for (certificate, key, named, why) in [
        (&own, &other, &own, "is not that of the certificate"),
        (&empty, &other, &empty, "no certificate"),
        (&own, &empty, &empty, ""),
        (&own, &own, &own, ""),
        (&absent, &other, &absent, ""),
        (&own, &absent, &absent, ""),
    ] {
        let mut command = Command::new(crumple());
        command.args(["serve", "--listen", "127.0.0.1:0", "--dir"]).arg(all.path("service"));
        command.arg("--tls-cert").arg(certificate).arg("--tls-key").arg(key);
        let ended = command.output().unwrap();
        assert_eq!(ended.status.code(), Some(2), "{}", said(&ended));
        let said = said(&ended);
        assert!(said.starts_with("error: ") && said.contains(text(named)), "{said}");
        assert!(said.contains(why), "{said}");
    }
}
