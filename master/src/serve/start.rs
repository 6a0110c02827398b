//! Start of the service: options, tokens, address.

use super::disk::Disk;
use super::folder::Root;
use super::http::{self, HttpSettings, listen};
use super::keeper::Keeper;
use super::launcher::Launcher;
use super::launcher::local::Local;
use super::launcher::slurm::{SCRIPT, Slurm};
use super::limits::Amount;
use super::store::Store;
use super::tokens;
use crate::cli::Role;
use crate::cli::ServeArgs;
use crate::stdout::say;
use crumple_proto::exit_code::{BAD_INPUT, COMPLETED};
use rustix::process::{Resource, getrlimit, setrlimit};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fs::{File, TryLockError};
use std::io::Write;
use std::net::SocketAddr;
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;
use tokio::net::TcpListener;

/// File in the folder of the service that has its address and the first token, for the commands of
/// the same user.
pub const ACCESS_FILE: &str = "access.json";
/// Share of the memory of the machine that jobs may use.
const MEMORY_SHARE: f64 = 0.8;
/// Memory of a machine that does not say how much it has [MB].
const UNKNOWN_MEMORY: f64 = 4000.0;

/// Number of open files that the service asks of the system: more than its connections.
const OPEN_FILES: u64 = 8192;

/// Address and token of a service.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Access {
    /// Such as `http://127.0.0.1:8787`.
    pub address: String,
    /// Token.
    pub token: String,
}

/// Carries out `crumple serve` and returns the exit code.
pub fn run(args: &ServeArgs) -> u8 {
    if args.openapi {
        crate::stdout::write(format_args!("{}", super::openapi()));
        return COMPLETED;
    }
    let runtime = tokio::runtime::Builder::new_multi_thread().enable_all().build();
    let ended = runtime.map_err(|error| error.to_string()).and_then(|runtime| {
        let ended = runtime.block_on(serve(args));
        runtime.shutdown_background(); // checks that run are repeated at the next start
        ended
    });
    match ended {
        Ok(()) => COMPLETED,
        Err(why) => {
            eprintln!("error: {why}");
            BAD_INPUT
        }
    }
}

/// Raises the limit of open files as far as the system allows. A shell often sets one that is below
/// the number of connections, so that slow clients would keep out all others.
fn allow_open_files() {
    let mut limit = getrlimit(Resource::Nofile);
    if limit.current.is_some_and(|now| now < OPEN_FILES) {
        limit.current = Some(limit.maximum.map_or(OPEN_FILES, |most| most.min(OPEN_FILES)));
        // Without it the service works with fewer clients.
        let _ = setrlimit(Resource::Nofile, limit);
    }
}

async fn serve(args: &ServeArgs) -> Result<(), String> {
    let shown = args.dir.display();
    let root = Root::make(&args.dir).map_err(|error| format!("{shown}: {error}"))?;
    let store = Store::open(&root.path("service.db"))?;
    let in_database = |error: rusqlite::Error| format!("{shown}: {error}");
    if let Some((name, role)) = &args.new_token {
        let token = new_token(&store, name, *role).await?;
        say!("{token}");
        return Ok(());
    }
    if let Some(name) = &args.remove_token {
        let removed = store.remove_token(name.clone()).await.map_err(in_database)?;
        return removed.then_some(()).ok_or_else(|| format!("there is no token {name}"));
    }
    let acceptor = match (&args.tls_cert, &args.tls_key) {
        (Some(certificate), Some(key)) => Some(listen::tls(certificate, key)?),
        _ => None,
    };
    if !args.listen.ip().is_loopback() && acceptor.is_none() {
        return Err(format!(
            "--listen {}: other machines can reach this address, so TLS is needed: give --tls-cert \
             and --tls-key, or listen on 127.0.0.1 and use a tunnel: ssh -L",
            args.listen
        ));
    }
    let _lock = lock(&root)?;
    allow_open_files();
    let listener = TcpListener::bind(args.listen)
        .await
        .map_err(|error| format!("--listen {}: {error}", args.listen))?;
    let bound = listener.local_addr().map_err(|error| error.to_string())?;
    let scheme = if acceptor.is_some() { "https" } else { "http" };
    let hosts = hosts(bound, &args.host);
    let address = format!("{scheme}://{}", hosts[0]);
    let token = access(&root, &store, &address).await?;
    let program = std::env::current_exe().map_err(|error| error.to_string())?;
    let launchers = launchers(args, &root, &program)?;
    let root_path = root.path("");
    let keeper = Keeper::new(store, root, launchers, program);
    keeper.tidy().await?;
    tokio::spawn(keeper.clone().run());
    let settings = HttpSettings {
        hosts,
        is_secure: acceptor.is_some(),
        most_bytes: args.max_upload.saturating_mul(1_000_000),
        rate: args.rate,
        disk: Disk { folder: root_path, least: args.disk_limit.map(|gb| (gb * 1e9) as u64) },
    };
    say!("crumple serve: {address}/#token={token}");
    say!("  open this address in a browser; the token is in {}", shown_access(args));
    let patience = Duration::from_secs(args.stall_limit);
    let served = listen::serve(listener, acceptor, http::router(keeper, settings), patience);
    tokio::select! {
        () = served => {}
        _ = tokio::signal::ctrl_c() => {}
        () = terminated() => {}
    }
    say!("crumple serve has ended; jobs that run go on, and are found at the next start");
    Ok(())
}

fn shown_access(args: &ServeArgs) -> String {
    args.dir.join(ACCESS_FILE).display().to_string()
}

async fn terminated() {
    use tokio::signal::unix::{SignalKind, signal};
    match signal(SignalKind::terminate()) {
        Ok(mut signal) => drop(signal.recv().await),
        Err(_) => std::future::pending().await,
    }
}

/// Locks the folder: two services would start jobs twice.
fn lock(root: &Root) -> Result<File, String> {
    let path = root.path("service.lock");
    let file = File::create(&path).map_err(|error| format!("{}: {error}", path.display()))?;
    match file.try_lock() {
        Ok(()) => Ok(file),
        Err(TryLockError::WouldBlock) => {
            Err(format!("{}: another service uses this folder", path.display()))
        }
        Err(TryLockError::Error(error)) => Err(format!("{}: {error}", path.display())),
    }
}

/// Returns the names under which the service is reached, the first for its own messages.
fn hosts(bound: SocketAddr, given: &[String]) -> Vec<String> {
    let port = bound.port();
    let own = bound.to_string();
    let loopback = ["127.0.0.1", "localhost", "[::1]"].map(|host| format!("{host}:{port}"));
    let given = given.iter().flat_map(|host| [format!("{host}:{port}"), host.clone()]);
    let mut all: Vec<String> = given.chain(std::iter::once(own)).collect();
    if bound.ip().is_loopback() || bound.ip().is_unspecified() {
        all.extend(loopback);
    }
    all
}

/// Makes a token and returns its secret.
async fn new_token(store: &Store, name: &str, role: Role) -> Result<String, String> {
    let secret = tokens::secret().map_err(|error| error.to_string())?;
    let hash = tokens::hash(&secret);
    store.add_token(name.into(), role, hash).await.map_err(|error| error.to_string())?;
    Ok(secret)
}

/// Returns the first token. It is made at the first start, or if its file was removed.
async fn access(root: &Root, store: &Store, address: &str) -> Result<String, String> {
    let path = root.path(ACCESS_FILE);
    let known = read_access(&path).ok().map(|access| access.token);
    let token = match known {
        Some(token)
            if store.token(tokens::hash(&token)).await.is_ok_and(|found| found.is_some()) =>
        {
            token
        }
        _ => new_token(store, "admin", Role::Admin).await?,
    };
    let text = serde_json::to_string(&Access { address: address.into(), token: token.clone() });
    let text = text.map_err(|error| error.to_string())?;
    let new = root.path("access.json.new");
    let write = || -> std::io::Result<()> {
        let _ = std::fs::remove_file(&new);
        let mut file = File::options().create_new(true).write(true).mode(0o600).open(&new)?;
        file.write_all(text.as_bytes())?;
        std::fs::rename(&new, &path)
    };
    write().map_err(|error| format!("{}: {error}", path.display()))?;
    Ok(token)
}

/// Reads address and token of a service.
///
/// # Errors
/// There is no such file, or it is another one.
pub fn read_access(path: &Path) -> std::io::Result<Access> {
    serde_json::from_slice(&std::fs::read(path)?).map_err(std::io::Error::other)
}

fn launchers(
    args: &ServeArgs,
    root: &Root,
    program: &Path,
) -> Result<BTreeMap<&'static str, Arc<dyn Launcher>>, String> {
    let cores = std::thread::available_parallelism().map_or(1, |n| n.get() as u32);
    let memory_mb = args.memory.unwrap_or_else(|| MEMORY_SHARE * machine_memory());
    let workers = args.slots.unwrap_or(cores);
    let mut all: BTreeMap<&'static str, Arc<dyn Launcher>> = BTreeMap::new();
    let local = |ranks: Option<String>, workers| -> Arc<dyn Launcher> {
        let limit = Amount { workers, memory_mb };
        Arc::new(Local { limit, program: program.to_owned(), ranks })
    };
    all.insert("threads", local(None, workers));
    if let Some(command) = &args.mpirun {
        let workers = args.mpirun_slots.unwrap_or(workers);
        all.insert("mpirun", local(Some(command.clone()), workers));
    }
    if args.slurm {
        let script: PathBuf = root.path("slurm.sh");
        std::fs::write(&script, SCRIPT).map_err(|e| format!("{}: {e}", script.display()))?;
        let slurm = Slurm {
            limit: Amount { workers: args.slurm_slots, memory_mb: f64::MAX },
            program: program.to_owned(),
            script,
            options: args.slurm_option.clone(),
            ranks: args.slurm_launcher.clone(),
        };
        all.insert("slurm", Arc::new(slurm));
    }
    Ok(all)
}

/// Returns the memory of this machine [MB].
fn machine_memory() -> f64 {
    let text = std::fs::read_to_string("/proc/meminfo").unwrap_or_default();
    let total = text.lines().find_map(|line| line.strip_prefix("MemTotal:"));
    let kilobytes = total.and_then(|t| t.trim().trim_end_matches("kB").trim().parse::<f64>().ok());
    kilobytes.map_or(UNKNOWN_MEMORY, |kb| kb * 1024.0 / 1e6)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_service_answers_to_its_own_names_only() {
        let on = |address: &str, given: &[&str]| {
            let given: Vec<String> = given.iter().map(ToString::to_string).collect();
            hosts(address.parse().unwrap(), &given)
        };
        let loopback = on("127.0.0.1:80", &[]);
        assert_eq!(loopback[0], "127.0.0.1:80");
        assert!(loopback.contains(&"localhost:80".to_string()));
        let other = on("10.0.0.1:80", &["crash.example"]);
        assert_eq!(other, ["crash.example:80", "crash.example", "10.0.0.1:80"]);
    }
}
