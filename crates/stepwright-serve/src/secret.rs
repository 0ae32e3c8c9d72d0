//! Random secrets.

use subtle::ConstantTimeEq;

/// 128 random bits in hexadecimal digits.
///
/// # Panics
/// If the system has no random numbers: then there is no safe way to go on.
pub(crate) fn random() -> String {
    let mut bytes = [0u8; 16];
    getrandom::fill(&mut bytes).expect("the system's random numbers");
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// The secret that requests from other computers need.
#[derive(Clone, Debug)]
pub struct Token(String);

impl Token {
    /// A new random token.
    pub fn new() -> Token {
        Token(random())
    }

    /// Whether this is the token. The time of the comparison does not tell how much of it is right.
    pub fn is(&self, said: &str) -> bool {
        said.as_bytes().ct_eq(self.0.as_bytes()).into()
    }

    /// The token as it is printed.
    pub fn text(&self) -> &str {
        &self.0
    }
}

impl Default for Token {
    fn default() -> Token {
        Token::new()
    }
}
