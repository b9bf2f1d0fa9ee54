//! Populations: hammer tests drawn at random from stated ranges, each the same wherever and
//! whenever it is drawn.
//!
//! A [`PopulationSpec`] states kinds of structures, how many of each, and how they are tested; it
//! is written in TOML as schema [`SCHEMA`]. [`PopulationSpec::draw`] makes one [`Member`]: a
//! [`HammerTest`] with its truth and the facts for which its kind is in the population.
//!
//! | file | what it holds |
//! |---|---|
//! | `span` | [`Span`]: ranges, how they are drawn and checked |
//! | `structure` | a drawn structure: modes at all its points |
//! | `chain` | chains: plain, with a small appended mass, with dampers |
//! | `beam` | beams and plates |
//! | `pairs` | close pairs and repeated roots |
//! | `plan` | [`TestSpec`]: from a structure to its test |

mod beam;
mod chain;
mod error;
mod pairs;
mod plan;
pub mod span;
mod structure;

use std::collections::BTreeMap;

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use serde::Deserialize;

use modalign::dof::Dof;
use modalign::synth::HammerTest;

use structure::{DrawnMode, Structure};

use beam::{BeamSpec, NodesSpec, PlateSpec};
use chain::{ChainSpec, DampersSpec, LocalSpec};
pub use error::PopulationError;
use pairs::{CloseSpec, RepeatedSpec};
use plan::TestSpec;

/// The schema that this version reads.
pub const SCHEMA: &str = "modalign-population/1";

/// A family of synthetic hammer tests.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PopulationSpec {
    /// [`SCHEMA`].
    pub schema: String,
    /// Title.
    pub title: String,
    /// Seed of everything drawn.
    pub seed: u64,
    /// How every structure is tested.
    pub test: TestSpec,
    /// The kinds, in the order of their numbers.
    #[serde(rename = "member")]
    pub members: Vec<MemberSpec>,
}

/// One kind of structure and how many of it there are.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MemberSpec {
    /// Number of members.
    pub count: usize,
    /// The kind of structure.
    pub structure: StructureSpec,
}

/// The structure of a member, by its `kind` key.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
pub enum StructureSpec {
    /// Masses and springs in a row.
    Chain(ChainSpec),
    /// A uniform beam.
    Beam(BeamSpec),
    /// A simply supported rectangular plate.
    Plate(PlateSpec),
    /// A chain with a small appended mass.
    Local(LocalSpec),
    /// A chain with discrete dampers.
    Dampers(DampersSpec),
    /// Pairs of close modes.
    Close(CloseSpec),
    /// Exactly repeated roots.
    Repeated(RepeatedSpec),
    /// A reference on the node of a mode.
    Nodes(NodesSpec),
}

/// One drawn test.
#[derive(Clone, Debug, PartialEq)]
pub struct Member {
    /// `kind-kind number-member number`.
    pub name: String,
    /// The kind's name.
    pub kind: &'static str,
    /// The test with its truth.
    pub test: HammerTest,
    /// Properties of its truth.
    pub facts: Facts,
}

/// Properties of the truth of a member; modes by their index in
/// [`Truth::model`](modalign::synth::Truth::model), from 0.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Facts {
    /// The modes of each repeated root.
    pub repeated: Vec<Vec<usize>>,
    /// The two modes of each close pair, the lower first.
    pub close: Vec<Vec<usize>>,
    /// A mode and a reference that lies exactly on its node: all residues there are 0.
    pub nodes: Vec<(usize, Dof)>,
}

impl StructureSpec {
    /// The kind's name.
    pub fn kind(&self) -> &'static str {
        match self {
            StructureSpec::Chain(_) => "chain",
            StructureSpec::Beam(_) => "beam",
            StructureSpec::Plate(_) => "plate",
            StructureSpec::Local(_) => "local",
            StructureSpec::Dampers(_) => "dampers",
            StructureSpec::Close(_) => "close",
            StructureSpec::Repeated(_) => "repeated",
            StructureSpec::Nodes(_) => "nodes",
        }
    }

    fn spans(&self) -> Vec<span::KeyedSpan> {
        match self {
            StructureSpec::Chain(spec) => spec.spans(),
            StructureSpec::Beam(spec) => spec.spans(),
            StructureSpec::Plate(spec) => spec.spans(),
            StructureSpec::Local(spec) => spec.spans(),
            StructureSpec::Dampers(spec) => spec.spans(),
            StructureSpec::Close(spec) => spec.spans(),
            StructureSpec::Repeated(spec) => spec.spans(),
            StructureSpec::Nodes(spec) => spec.spans(),
        }
    }

    fn draw(&self, random: &mut ChaCha8Rng) -> Result<Structure, PopulationError> {
        match self {
            StructureSpec::Chain(spec) => spec.draw(random),
            StructureSpec::Beam(spec) => spec.draw(random),
            StructureSpec::Plate(spec) => Ok(spec.draw(random)),
            StructureSpec::Local(spec) => spec.draw(random),
            StructureSpec::Dampers(spec) => spec.draw(random),
            StructureSpec::Close(spec) => spec.draw(random),
            StructureSpec::Repeated(spec) => spec.draw(random),
            StructureSpec::Nodes(spec) => Ok(spec.draw(random)),
        }
    }
}

impl PopulationSpec {
    /// Checks the schema and every range.
    ///
    /// # Errors
    /// [`PopulationError::Schema`], [`PopulationError::Range`].
    pub fn validate(&self) -> Result<(), PopulationError> {
        if self.schema != SCHEMA {
            return Err(PopulationError::Schema {
                got: self.schema.clone(),
                expected: SCHEMA,
            });
        }
        span::check("test", &self.test.spans())?;
        for (i, member) in self.members.iter().enumerate() {
            let part = format!("member {} ({})", i + 1, member.structure.kind());
            span::check(&part, &member.structure.spans())?;
        }
        Ok(())
    }

    /// Member `number` of kind `kind`, both from 0.
    ///
    /// Everything comes from one generator whose key is (seed, kind, number), so that a member
    /// depends neither on the others nor on the order in which they are drawn.
    ///
    /// # Errors
    /// Those of [`PopulationSpec::validate`]; [`PopulationError::NoSuchMember`];
    /// [`PopulationError::Theory`] where the ranges allow an impossible structure;
    /// [`PopulationError::RecordTooLong`]; those of [`HammerTest::validate`].
    pub fn draw(&self, kind: usize, number: usize) -> Result<Member, PopulationError> {
        self.validate()?;
        let known = self.members.get(kind).filter(|m| number < m.count);
        let member = known.ok_or_else(|| PopulationError::NoSuchMember {
            got_kind: kind,
            got_number: number,
            counts: self.members.iter().map(|m| m.count).collect(),
        })?;
        let mut random = self.random(kind, number);
        let structure = member.structure.draw(&mut random)?;
        let (test, modes) = self.test.plan(&structure, &mut random)?;
        let name = member.structure.kind();
        Ok(Member {
            name: format!("{name}-{kind}-{number}"),
            kind: name,
            facts: facts(&test, &modes),
            test,
        })
    }

    fn random(&self, kind: usize, number: usize) -> ChaCha8Rng {
        let mut key = [0; 32];
        let words = [self.seed, kind as u64, number as u64];
        for (bytes, word) in key.chunks_exact_mut(8).zip(words) {
            bytes.copy_from_slice(&word.to_le_bytes());
        }
        ChaCha8Rng::from_seed(key)
    }
}

fn facts(test: &HammerTest, modes: &[DrawnMode]) -> Facts {
    let elastic = modes.iter().filter(|mode| mode.damping_ratio.is_some());
    let (mut repeated, mut close) = (BTreeMap::new(), BTreeMap::new());
    for (j, mode) in elastic.enumerate() {
        for (number, list) in [(mode.group, &mut repeated), (mode.pair, &mut close)] {
            let Some(number) = number else { continue };
            list.entry(number).or_insert_with(Vec::new).push(j);
        }
    }
    let mut nodes = Vec::new();
    for (j, mode) in test.truth.model.modes.iter().enumerate() {
        for hit in test.hits.iter().map(|plan| &plan.hit) {
            let mut here = mode.residues.iter().filter(|((_, h), _)| h == hit);
            if here.all(|(_, residue)| residue.norm() <= 0.0) {
                nodes.push((j, hit.clone()));
            }
        }
    }
    Facts {
        repeated: repeated.into_values().collect(),
        close: close.into_values().filter(|pair| pair.len() == 2).collect(),
        nodes,
    }
}
