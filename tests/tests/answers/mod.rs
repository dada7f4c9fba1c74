//! Answers: exact, and the same by every index, in every way to ask.

mod batches;
mod indices;
mod kernel_oracle;
mod leaks;
mod mesh;
mod special_rays;
