//! Scenes that a comparison is made on.

use std::path::PathBuf;

use anyhow::ensure;
use clap::Args;

use crate::commands::arguments::OriginArgument;
use crate::scene::{self, Model, UpAxis, builtin};

/// Names of scenes.
#[derive(Args)]
pub struct SceneChoice {
    /// Scene files, beside the built-in scenes
    #[arg(value_name = "SCENE")]
    files: Vec<PathBuf>,
    /// Only these built-in scenes, separated by commas: fig2, fig3, fig4a to fig4e, city, mixed, sphere, mesh; mesh-N
    /// and city-N with about N triangles; `none` for the files alone
    #[arg(long, value_name = "NAME,...", value_delimiter = ',')]
    scenes: Vec<String>,
    #[command(flatten)]
    origin: OriginArgument,
}

impl SceneChoice {
    /// Makes the scenes named, or the `usual` ones, and loads the files, each with a light. At least one.
    ///
    /// # Errors
    /// If none is named, or one cannot be had.
    pub fn models(
        &self,
        usual: impl IntoIterator<Item = &'static str>,
    ) -> anyhow::Result<Vec<Model>> {
        ensure!(!self.is_none(), "`--scenes none` leaves no scene: name a file");
        let names: Vec<&str> = match self.scenes.as_slice() {
            [] => usual.into_iter().collect(),
            [only] if only == "none" => Vec::new(),
            names => names.iter().map(String::as_str).collect(),
        };
        let mut models = Vec::new();
        for name in names {
            models.push(builtin::require(name)?);
        }
        for path in &self.files {
            models.push(scene::load(path, self.origin.get())?);
        }
        Ok(models.into_iter().map(|model| model.with_default_light(UpAxis::Auto)).collect())
    }

    /// Tells whether neither a built-in scene nor a file is to be compared on.
    pub fn is_none(&self) -> bool {
        self.files.is_empty() && self.scenes == ["none"]
    }
}
