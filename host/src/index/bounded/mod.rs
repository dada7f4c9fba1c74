//! Builds within a stated memory, of scenes and indices that are larger: everything large lies in mapped files.
//!
//! ```text
//! scene files --stream--> triangles (file) --clusters--> scratch (file) --pieces--> index (file), renamed at the end
//!  one at a time    \---> columns (files) ---------------------------------------> its scene (file), renamed before
//!                               \------------- a pager keeps resident pages below the memory -------------/
//! ```
//! - The algorithms are those of every build, and so are the bytes. They work in memory that is a mapped file, of which
//!   the system keeps in RAM what is used.
//! - A pager watches the resident memory of the process, mapped pages included, and gives pages back to the system
//!   before the limit is reached. What they hold stays in the file.
//! - Files of scenes are read one at a time, so the largest must fit.

mod columns;
mod mapped;
mod pack;
mod pager;
mod reading;
mod triangles;

pub use pack::{BoundedPack, Packed};

use mapped::{Scratch, View};
use pager::{Pager, Watched};

/// Takes the bytes of a view as values, which the view's beginning is aligned for.
fn cast<T: bytemuck::Pod>(view: &View) -> anyhow::Result<&[T]> {
    match view.bytes() {
        // No bytes may lie anywhere.
        [] => Ok(&[]),
        bytes => bytemuck::try_cast_slice(bytes)
            .map_err(|_| anyhow::anyhow!("mapped memory is not aligned")),
    }
}
