//! Model files to begin with: `modalign new --model beam` writes one beside the scene.

use std::collections::BTreeMap;
use std::path::Path;

use super::SceneError;
use super::model::{LoadedModel, model_of_text};

/// A model file with the values of an example.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ModelDraft {
    /// The kind of the model, by which it is asked for.
    pub kind: &'static str,
    /// The text of the file.
    pub text: &'static str,
}

impl ModelDraft {
    /// Every draft.
    pub const ALL: [ModelDraft; 2] = [
        ModelDraft {
            kind: "beam",
            text: include_str!("model_drafts/beam.toml"),
        },
        ModelDraft {
            kind: "lumped",
            text: include_str!("model_drafts/lumped.toml"),
        },
    ];
    /// The name of the file beside the scene.
    pub const FILE: &'static str = "model.toml";

    /// The draft of this kind, unless a file has the name.
    pub fn at(path: &Path) -> Option<Self> {
        let named = Self::ALL
            .into_iter()
            .find(|draft| path == Path::new(draft.kind));
        named.filter(|_| !path.exists())
    }

    /// The model of its values.
    ///
    /// # Errors
    /// As for a model file.
    pub fn load(self) -> Result<LoadedModel, SceneError> {
        model_of_text(self.text, Path::new(Self::FILE), &BTreeMap::new())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::theory::ModeOptions;

    #[test]
    fn every_draft_is_a_model_with_modes() {
        for draft in ModelDraft::ALL {
            assert_eq!(ModelDraft::at(Path::new(draft.kind)), Some(draft));
            let loaded = draft.load().unwrap();
            let theory = loaded.solve(&[], &ModeOptions::default()).unwrap();
            let highest = theory.modes.modes.last().unwrap();
            assert!(highest.frequency_hz > 10.0, "{}", draft.kind);
        }
    }
}
