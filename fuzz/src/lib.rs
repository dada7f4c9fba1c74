//! Checks that several fuzz targets share.

pub mod surfaces;
