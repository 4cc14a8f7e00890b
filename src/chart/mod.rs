//! Ways to put points on a parameter domain, and the kinds of surface that they lead to.

mod kind;

pub use self::kind::Kind;
