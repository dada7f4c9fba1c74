//! Why a contender cannot take part.

/// Reason why a contender cannot take part; the others still can.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PeerError {
    /// There is no contender of this name.
    #[error("there is no contender `{name}`; there are: {known}")]
    Unknown {
        /// The name given.
        name: String,
        /// The names there are.
        known: String,
    },
    /// The shared library of Embree 4 could not be opened.
    #[error(
        "Embree 4 was not found ({reason}). Install it (package `libembree4-4`, or the Python package \
         `embreex`, in whose folder `embreex.libs` it lies) and name the file in the environment \
         variable EMBREE4_LIBRARY"
    )]
    EmbreeMissing {
        /// The files tried, and what was wrong.
        reason: String,
    },
    /// It was compiled without instructions that the library needs.
    #[error("{library} needs {needed}: compile with RUSTFLAGS=\"-C target-cpu=native\"")]
    NeedsInstructions {
        /// Whose index.
        library: &'static str,
        /// The instructions.
        needed: &'static str,
    },
    /// This program was compiled without it.
    #[error("{library} is not in this build: compile with `--features {feature}` ({why_apart})")]
    NotCompiled {
        /// Whose index.
        library: &'static str,
        /// The feature that brings it in.
        feature: &'static str,
        /// Why it is not in the feature `peers`.
        why_apart: &'static str,
    },
    /// It panicked, with a message on stderr.
    #[error("{library} panicked (its message is above)")]
    Panicked {
        /// Whose index.
        library: &'static str,
    },
    /// The library was there and did not build an index.
    #[error("{library}: {reason}")]
    Refused {
        /// Whose index.
        library: &'static str,
        /// In its words.
        reason: String,
    },
}

impl PeerError {
    /// Says which names there are.
    pub fn unknown(name: &str) -> Self {
        let known = super::PEERS.iter().map(|peer| peer.name).collect::<Vec<_>>().join(", ");
        Self::Unknown { name: name.into(), known }
    }
}
