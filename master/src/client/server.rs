//! A service, as the commands reach it.

use crate::cli::ServerArgs;
use crate::serve::api::Refusal;
use crate::serve::{ACCESS_FILE, read_access};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::fs::File;
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;
use ureq::http::Response;
use ureq::tls::{PemItem, RootCerts, TlsConfig, parse_pem};
use ureq::{Agent, Body, SendBody};

/// Longest time for a connection.
const CONNECT_WITHIN: Duration = Duration::from_secs(20);

/// A service.
pub struct Server {
    agent: Agent,
    address: String,
    token: String,
}

impl Server {
    /// Finds the service that the options name.
    ///
    /// # Errors
    /// There is none, or its token is not known.
    pub fn find(args: &ServerArgs) -> Result<Self, String> {
        let (address, token) = match &args.server {
            Some(address) => {
                let token = std::env::var("CRUMPLE_TOKEN");
                let missing = "with --server, give the token in the variable CRUMPLE_TOKEN";
                (address.trim_end_matches('/').to_string(), token.map_err(|_| missing)?)
            }
            None => {
                let path = args.dir.join(ACCESS_FILE);
                let access = read_access(&path).map_err(|error| {
                    let shown = path.display();
                    format!("{shown}: {error}; start one with: crumple serve, or give --server")
                })?;
                (access.address, access.token)
            }
        };
        let tls = match &args.ca {
            Some(path) => trusting(path)?,
            None => TlsConfig::default(),
        };
        let config = Agent::config_builder()
            .tls_config(tls)
            .http_status_as_error(false)
            .timeout_connect(Some(CONNECT_WITHIN))
            .build();
        Ok(Self { agent: config.into(), address, token })
    }

    fn url(&self, path: &str) -> String {
        format!("{}{path}", self.address)
    }

    fn bearer(&self) -> String {
        format!("Bearer {}", self.token)
    }

    fn answered(
        &self,
        sent: Result<Response<Body>, ureq::Error>,
    ) -> Result<Response<Body>, String> {
        let mut response = sent.map_err(|error| format!("{}: {error}", self.address))?;
        let status = response.status();
        if status.is_success() {
            return Ok(response);
        }
        let refusal = response.body_mut().read_json::<Refusal>().map(|refusal| refusal.error);
        Err(refusal.unwrap_or_else(|_| format!("{}: status {status}", self.address)))
    }

    fn parsed<T: DeserializeOwned>(&self, mut response: Response<Body>) -> Result<T, String> {
        let parsed = response.body_mut().with_config().limit(u64::MAX).read_json();
        parsed.map_err(|error| format!("{}: no such answer is known: {error}", self.address))
    }

    /// Asks for JSON.
    ///
    /// # Errors
    /// The service does not answer, or refuses.
    pub fn get<T: DeserializeOwned>(&self, path: &str) -> Result<T, String> {
        let sent = self.agent.get(self.url(path)).header("Authorization", self.bearer()).call();
        self.parsed(self.answered(sent)?)
    }

    /// Sends JSON.
    ///
    /// # Errors
    /// The service does not answer, or refuses.
    pub fn post<T: DeserializeOwned>(
        &self,
        path: &str,
        body: &impl Serialize,
    ) -> Result<T, String> {
        let request = self.agent.post(self.url(path)).header("Authorization", self.bearer());
        self.parsed(self.answered(request.send_json(body))?)
    }

    /// Sends a body of another kind.
    ///
    /// # Errors
    /// The service does not answer, or refuses.
    pub fn send<T: DeserializeOwned>(
        &self,
        path: &str,
        kind: &str,
        body: &mut dyn Read,
    ) -> Result<T, String> {
        let request = self.agent.post(self.url(path)).header("Authorization", self.bearer());
        let sent = request.header("Content-Type", kind).send(SendBody::from_reader(body));
        self.parsed(self.answered(sent)?)
    }

    /// Opens a stream of events after the event `after`.
    ///
    /// # Errors
    /// The service does not answer (true), or refuses (false).
    pub fn events(&self, path: &str, after: i64) -> Result<impl Read + use<>, (bool, String)> {
        let request = self.agent.get(self.url(path)).header("Authorization", self.bearer());
        let sent = request.header("Last-Event-ID", after.to_string()).call();
        let is_away = sent.is_err();
        let response = self.answered(sent).map_err(|why| (is_away, why))?;
        Ok(response.into_body().into_with_config().limit(u64::MAX).reader())
    }

    /// Copies a file. It has its name when it is complete.
    ///
    /// # Errors
    /// The service refuses, or the file cannot be written.
    pub fn download(&self, path: &str, to: &Path) -> Result<(), String> {
        let sent = self.agent.get(self.url(path)).header("Authorization", self.bearer()).call();
        let response = self.answered(sent)?;
        let mut body = response.into_body().into_with_config().limit(u64::MAX).reader();
        let part = PathBuf::from(format!("{}.part", to.display()));
        let mut copy = || -> std::io::Result<()> {
            if let Some(folder) = to.parent() {
                std::fs::create_dir_all(folder)?;
            }
            let mut file = File::create(&part)?;
            std::io::copy(&mut body, &mut file)?;
            file.flush()?;
            std::fs::rename(&part, to)
        };
        copy().map_err(|error| format!("{}: {error}", to.display()))
    }
}

/// Returns settings of TLS that trust the certificates of a file, and no others.
fn trusting(path: &Path) -> Result<TlsConfig, String> {
    let named = |why: &dyn std::fmt::Display| format!("{}: {why}", path.display());
    let text = std::fs::read(path).map_err(|error| named(&error))?;
    let mut certificates = Vec::new();
    for item in parse_pem(&text) {
        if let PemItem::Certificate(certificate) = item.map_err(|error| named(&error))? {
            certificates.push(certificate);
        }
    }
    match certificates.is_empty() {
        true => Err(named(&"it has no certificate in PEM")),
        false => {
            let roots = RootCerts::new_with_certs(&certificates);
            Ok(TlsConfig::builder().root_certs(roots).build())
        }
    }
}

/// Returns text as a part of a path or query; slashes stay.
pub fn escaped(text: &str) -> String {
    let plain = |b: &u8| b.is_ascii_alphanumeric() || b"-._~/".contains(b);
    let one = |b: u8| if plain(&b) { char::from(b).to_string() } else { format!("%{b:02X}") };
    text.bytes().map(one).collect()
}
