//! Tokens and roles. A token is a random text of 256 bits; the database has only its hash.

use crate::cli::Role;
use std::io;

/// The token of a request.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Identity {
    /// Its name.
    pub name: String,
    /// Its role.
    pub role: Role,
}

/// Returns a new secret: 64 hexadecimal digits.
///
/// # Errors
/// The system has no random numbers.
pub fn secret() -> io::Result<String> {
    let mut bytes = [0u8; 32];
    getrandom::fill(&mut bytes).map_err(io::Error::other)?;
    Ok(bytes.iter().map(|byte| format!("{byte:02x}")).collect())
}

/// Returns the hash of a secret. A plain hash is enough: secrets are random, not chosen by people.
pub fn hash(secret: &str) -> String {
    blake3::hash(secret.as_bytes()).to_hex().to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn secrets_differ_and_roles_are_ordered() {
        let (a, b) = (secret().unwrap(), secret().unwrap());
        assert!(a != b && a.len() == 64 && hash(&a) != hash(&b) && hash(&a) != a);
        assert!(Role::Read < Role::Submit && Role::Submit < Role::Admin);
        assert_eq!(Role::of_name("admin"), Some(Role::Admin));
        assert_eq!(Role::of_name("root"), None);
    }
}
