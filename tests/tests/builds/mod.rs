//! Builds: clusters, the choice of an index, an end within bounds, the same bytes in slices and in pieces.

mod clusters;
mod ends;
mod pieces;
mod selection;
mod slices;
