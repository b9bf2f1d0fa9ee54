//! The guide for users: a tutorial, a page for each subject, and the references of verbs, files,
//! scenes and methods. The pages are the files of `src/guide`.

#[doc = include_str!("guide/tutorial.md")]
pub mod tutorial {}

#[doc = include_str!("guide/systems.md")]
pub mod systems {}

#[doc = include_str!("guide/verbs.md")]
pub mod verbs {}

#[doc = include_str!("guide/files.md")]
pub mod files {}

#[doc = include_str!("guide/scene.md")]
pub mod scene {}

#[doc = include_str!("guide/hits.md")]
pub mod hits {}

#[doc = include_str!("guide/comparison.md")]
pub mod comparison {}

#[doc = include_str!("guide/updating.md")]
pub mod updating {}

#[doc = include_str!("guide/report.md")]
pub mod report {}

#[doc = include_str!("guide/gallery.md")]
pub mod gallery {}

#[doc = include_str!("guide/methods.md")]
pub mod methods {}

#[doc = include_str!("guide/studies.md")]
pub mod studies {}

#[doc = include_str!("guide/gate.md")]
pub mod gate {}

#[doc = include_str!("guide/faq.md")]
pub mod faq {}

#[doc = include_str!("guide/dependencies.md")]
pub mod dependencies {}
