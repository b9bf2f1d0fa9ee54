//! The arguments of `modalign study` name the study, its scene and its folder.

use std::path::PathBuf;

use clap::{Args, Subcommand};

use crate::study::breakdown::Part;

/// `study`.
#[derive(Debug, Args)]
#[command(
    after_help = "Time: order takes seconds to minutes, speed-accuracy minutes (fewer with --draws), breakdown minutes to hours (fewer with --draws, or in parts with --cells).\nExamples:\n  modalign study speed-accuracy measurements/free-free-beam -o speed\n  modalign study breakdown measurements/free-free-beam -o fails\n  modalign study order measurements/free-free-beam -o needs"
)]
pub struct StudyArgs {
    /// The study.
    #[command(subcommand)]
    pub study: Study,
    /// Use the intact part of a damaged file of the scene instead of stopping; the exit code is
    /// then 1.
    #[arg(long, global = true)]
    pub partial: bool,
}

/// The studies.
#[derive(Debug, Subcommand)]
pub enum Study {
    /// Compare time and error of all methods, on the data of a scene and on synthetic twins.
    SpeedAccuracy(SpeedAccuracyArgs),
    /// Find where each method fails: maps over noise, separation of modes, damping and the like.
    Breakdown(BreakdownArgs),
    /// Find the simplest analysis that a scene needs: number of modes, model order, method, theory.
    Order(OrderArgs),
}

impl Study {
    /// The scene or spec.
    pub fn path(&self) -> &PathBuf {
        match self {
            Study::SpeedAccuracy(args) => &args.path,
            Study::Breakdown(args) => &args.input,
            Study::Order(args) => &args.path,
        }
    }
}

/// `study speed-accuracy`.
#[derive(Debug, Args)]
#[command(
    after_help = "Time: minutes on an idle machine; fewer with --draws 1.\nExample:\n  modalign study speed-accuracy measurements/free-free-beam -o speed"
)]
pub struct SpeedAccuracyArgs {
    /// A scene, or a study.toml, which states what is varied; by default the one in the scene's
    /// folder.
    #[arg(value_name = "SCENE|SPEC")]
    pub path: PathBuf,
    /// Write tables (.csv .json) and figures into this folder. In the folder of `run -o`, `modalign
    /// report` includes them.
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Write each figure also as PNG at 300 dpi (needs a build with `--features png`).
    #[arg(long, requires = "output")]
    pub png: bool,
    /// Draws of the noise at each level, such as 1 for a first look; by default those of
    /// study.toml.
    #[arg(long, value_name = "N")]
    pub draws: Option<usize>,
}

/// `study breakdown`.
#[derive(Debug, Args)]
#[command(
    after_help = "Time: minutes to hours, nearly in proportion to --draws; with -o every finished slice is kept, and the same command continues with the others.\nExample:\n  modalign study breakdown measurements/free-free-beam -o fails --draws 4"
)]
pub struct BreakdownArgs {
    /// A scene, whose modes the maps show, or a study.toml, which states the maps; by default the
    /// one in the scene's folder.
    pub input: PathBuf,
    /// Write results and figures into this folder; finished maps there are not computed again. In
    /// the folder of `run -o`, `modalign report` includes them.
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Compute part I of N only, such as 1/4, into a folder for --merge: for several machines.
    #[arg(long, value_name = "I/N", value_parser = part, requires = "output")]
    pub cells: Option<Part>,
    /// Join the results of --cells in these folders instead of computing.
    #[arg(long, value_name = "DIR", num_args = 1.., conflicts_with = "cells")]
    pub merge: Vec<PathBuf>,
    /// Draws for each cell of a map, such as 4 for a first look; by default those of study.toml.
    #[arg(long, value_name = "N")]
    pub draws: Option<u32>,
    /// Write each figure also as PNG at 300 dpi (needs a build with `--features png`).
    #[arg(long)]
    pub png: bool,
}

fn part(text: &str) -> Result<Part, String> {
    let numbers = text.split_once('/');
    let numbers = numbers.and_then(|(a, b)| Some((a.parse().ok()?, b.parse().ok()?)));
    let part = numbers.map(|(number, count)| Part { number, count });
    part.filter(|part| part.number >= 1 && part.number <= part.count)
        .ok_or_else(|| format!("got {text}, expected I/N with I from 1 to N, as in 1/4"))
}

/// `study order`.
#[derive(Debug, Args)]
#[command(
    after_help = "Time: seconds to minutes.\nExample:\n  modalign study order measurements/free-free-beam -o needs"
)]
pub struct OrderArgs {
    /// A scene, or a study.toml, which states the tolerances; by default the one in the scene's
    /// folder.
    #[arg(value_name = "SCENE|SPEC")]
    pub path: PathBuf,
    /// Write tables (.md .csv .json) and a figure for each test into this folder.
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Write each figure also as PNG at 300 dpi (needs a build with `--features png`).
    #[arg(long, requires = "output")]
    pub png: bool,
}
