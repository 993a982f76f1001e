//! Files that others wrote (the scripts in make) hold what they say, and what is damaged is refused.

mod damage;
mod files;
mod refused;
mod written;
