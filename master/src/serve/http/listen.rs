//! Connections: with or without TLS, bounded in number, in the time of their headers and of their
//! handshake.

use super::paced::Paced;
use axum::Router;
use axum::extract::ConnectInfo;
use hyper::server::conn::http1;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use std::net::SocketAddr;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::net::TcpListener;
use tokio::sync::Semaphore;
use tokio_rustls::TlsAcceptor;
use tokio_rustls::rustls::pki_types::pem::PemObject;
use tokio_rustls::rustls::pki_types::{CertificateDer, PrivateKeyDer};
use tokio_rustls::rustls::{Error, ServerConfig};

/// Largest number of connections.
const MOST_CONNECTIONS: usize = 4000;
/// Longest time for the headers of a request, and for a handshake.
const HEADERS_WITHIN: Duration = Duration::from_secs(15);
/// Largest headers of a request [byte].
const LARGEST_HEADERS: usize = 64 * 1024;

/// Reads certificate and key for TLS.
///
/// # Errors
/// They cannot be read, or do not belong together; the message names the file.
pub fn tls(certificate: &Path, key: &Path) -> Result<TlsAcceptor, String> {
    let named = |path: &Path, why: &dyn std::fmt::Display| format!("{}: {why}", path.display());
    let chain: Vec<CertificateDer> = CertificateDer::pem_file_iter(certificate)
        .and_then(|all| all.collect())
        .map_err(|why| named(certificate, &why))?;
    if chain.is_empty() {
        return Err(named(certificate, &"it has no certificate in PEM"));
    }
    let secret = PrivateKeyDer::from_pem_file(key).map_err(|why| named(key, &why))?;
    let provider = Arc::new(tokio_rustls::rustls::crypto::ring::default_provider());
    let mut config = ServerConfig::builder_with_provider(provider)
        .with_safe_default_protocol_versions()
        .map_err(|why| why.to_string())?
        .with_no_client_auth()
        .with_single_cert(chain, secret)
        .map_err(|why| match why {
            Error::InconsistentKeys(_) => {
                let why = format!("the key in {} is not that of the certificate", key.display());
                named(certificate, &why)
            }
            why => named(certificate, &why),
        })?;
    config.alpn_protocols = vec![b"http/1.1".to_vec()];
    Ok(TlsAcceptor::from(Arc::new(config)))
}

/// Serves connections, for ever. A client has `patience` to take each 64 kB of an answer.
pub async fn serve(
    listener: TcpListener,
    acceptor: Option<TlsAcceptor>,
    router: Router,
    patience: Duration,
) {
    let places = Arc::new(Semaphore::new(MOST_CONNECTIONS));
    loop {
        let Ok(place) = places.clone().acquire_owned().await else { return };
        let (stream, address) = match listener.accept().await {
            Ok(accepted) => accepted,
            // Too many open files, for example.
            Err(error) => {
                tracing::warn!(%error, "no connection is accepted");
                tokio::time::sleep(Duration::from_millis(100)).await;
                continue;
            }
        };
        let _ = stream.set_nodelay(true);
        let stream = Paced::new(stream, patience);
        let (acceptor, router) = (acceptor.clone(), router.clone());
        tokio::spawn(async move {
            match acceptor {
                None => connection(stream, address, router).await,
                Some(acceptor) => {
                    let shaken = tokio::time::timeout(HEADERS_WITHIN, acceptor.accept(stream));
                    if let Ok(Ok(stream)) = shaken.await {
                        connection(stream, address, router).await;
                    }
                }
            }
            drop(place);
        });
    }
}

async fn connection(
    stream: impl AsyncRead + AsyncWrite + Unpin + Send + 'static,
    address: SocketAddr,
    router: Router,
) {
    let router = router.layer(axum::Extension(ConnectInfo(address)));
    let mut http = http1::Builder::new();
    http.timer(TokioTimer::new()).header_read_timeout(HEADERS_WITHIN).max_buf_size(LARGEST_HEADERS);
    let service = TowerToHyperService::new(router);
    // An error is one of the client: it left, or sent no HTTP.
    let _ = http.serve_connection(TokioIo::new(stream), service).await;
}
