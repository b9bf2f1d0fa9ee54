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
    /// Continue with the good part of a partly bad file of the scene.
    #[arg(long, global = true)]
    pub partial: bool,
}

/// The studies.
#[derive(Debug, Subcommand)]
pub enum Study {
    /// Time and error of every method, order, FRF estimator and length of record, on a scene's data
    /// and on their synthetic twins.
    SpeedAccuracy(SpeedAccuracyArgs),
    /// Where every method fails: maps over noise, separation, damping, references and the like,
    /// with the contour of each method, the failure mode beyond it, and the modes of the scene.
    Breakdown(BreakdownArgs),
    /// The least effort that a scene needs: the modes that its data support, the lowest order of
    /// every method, where one mode at a time suffices, the simplest theory, the fewest parameters.
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
    /// A scene's folder, whose study.toml says what is varied if there is one, or a study.toml.
    #[arg(value_name = "SCENE|SPEC")]
    pub path: PathBuf,
    /// Write speed-accuracy.csv, speed-accuracy-times.csv, speed-accuracy.json and the figures into
    /// this folder; into that of `run -o`, and `modalign report` shows them.
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Write every figure as PNG, too, 300 dots to the inch (needs a build with `--features png`).
    #[arg(long, requires = "output")]
    pub png: bool,
    /// Draws of the noise at each level, instead of the spec's.
    #[arg(long, value_name = "N")]
    pub draws: Option<usize>,
}

/// `study breakdown`.
#[derive(Debug, Args)]
#[command(
    after_help = "Time: minutes to hours, nearly in proportion to --draws; with -o every finished slice is kept, and the same command continues with the others.\nExample:\n  modalign study breakdown measurements/free-free-beam -o fails --draws 4"
)]
pub struct BreakdownArgs {
    /// A study.toml, or a scene's folder: its study.toml, or without one the default slices. The
    /// maps show the modes of the scene.
    pub input: PathBuf,
    /// Write cells, tables and figures into this folder; slices that are finished there are not
    /// computed again. In the folder of `run -o`, `modalign report` shows them.
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Only these slices of a batch: part I of N, into a folder that --merge reads.
    #[arg(long, value_name = "I/N", value_parser = part, requires = "output")]
    pub cells: Option<Part>,
    /// Compute nothing: join the slices that the parts of a batch left in these folders.
    #[arg(long, value_name = "DIR", num_args = 1.., conflicts_with = "cells")]
    pub merge: Vec<PathBuf>,
    /// Draws for each cell, in place of those of the spec: few for a first look.
    #[arg(long, value_name = "N")]
    pub draws: Option<u32>,
    /// Figures as PNG, too.
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
    /// A scene's folder, whose study.toml says what counts as enough if there is one, or a
    /// study.toml.
    #[arg(value_name = "SCENE|SPEC")]
    pub path: PathBuf,
    /// Write order.md, order.csv, order.json and a figure for each test into this folder.
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Write every figure as PNG, too, 300 dots to the inch (needs a build with `--features png`).
    #[arg(long, requires = "output")]
    pub png: bool,
}
