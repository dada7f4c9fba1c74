//! Checks that several fuzz targets share.

pub mod plane_polygon;
pub mod surfaces;
