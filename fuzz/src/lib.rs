//! Checks that several fuzz targets have in common.

pub mod surfaces;
