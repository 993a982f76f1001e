//! Files that others wrote (make.py) hold what they say, and what is damaged is refused.

mod damage;
mod files;
mod refused;
mod written;
