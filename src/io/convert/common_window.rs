//! Windows that the functions of one set state, of which the set takes one that all state.

use crate::dof::Dof;
use crate::finding::{Code, Finding, Location, Severity};

use crate::io::Window;

/// Maximum number of functions that the finding names of each window: a line of text.
const MAX_NAMED: usize = 6;

/// The window that each function states, in their order.
#[derive(Default)]
pub(in crate::io) struct StatedWindows {
    functions: Vec<(Dof, Dof, Option<Window>)>,
}

impl StatedWindows {
    /// Adds a function by its response and reference.
    pub fn add(&mut self, response: &Dof, reference: &Dof, window: Option<Window>) {
        self.functions
            .push((response.clone(), reference.clone(), window));
    }

    /// The window that all functions state, Hann windows for narrow and broad bands being one;
    /// `None` where some state none or another.
    pub fn common(&self) -> Option<Window> {
        let first = self.functions.first()?.2;
        let line_shape = |window: Option<Window>| match window {
            Some(Window::HannNarrow) => Some(Window::HannBroad),
            other => other,
        };
        let mut others = self.functions.iter();
        let same = |window: Option<Window>| line_shape(window) == line_shape(first);
        first.filter(|_| others.all(|(.., window)| same(*window)))
    }

    /// The windows that functions state where they have none in common.
    pub fn mixed(&self) -> Vec<Window> {
        match self.common() {
            Some(_) => Vec::new(),
            None => self.different().into_iter().flatten().collect(),
        }
    }

    fn different(&self) -> Vec<Option<Window>> {
        let mut windows: Vec<Option<Window>> = Vec::new();
        for (.., window) in &self.functions {
            if !windows.contains(window) {
                windows.push(*window);
            }
        }
        windows
    }

    /// The finding of windows that only some functions state.
    pub fn finding(&self) -> Option<Finding> {
        let stating = self
            .functions
            .iter()
            .filter(|function| function.2.is_some())
            .count();
        if stating == 0 || self.common().is_some() {
            return None;
        }
        let windows = self.different();
        let named: Vec<String> = windows.iter().map(|window| self.named(*window)).collect();
        let finding = Finding::new(Severity::Warning, Code::WindowNotCommon, Location::Whole);
        let finding = finding.value(stating as f64, "functions");
        let finding = finding.limit(self.functions.len() as f64);
        Some(finding.detail(named.join("; ")))
    }

    /// The functions that state a window, `hann-narrow: 2:+Z|1:+Z, 3:+Z|1:+Z`.
    fn named(&self, window: Option<Window>) -> String {
        let stating = self
            .functions
            .iter()
            .filter(|function| function.2 == window);
        let all: Vec<String> = stating.map(|(a, b, _)| format!("{a}|{b}")).collect();
        let mut named = all.iter().take(MAX_NAMED).cloned().collect::<Vec<_>>();
        if all.len() > MAX_NAMED {
            named.push(format!("{} more", all.len() - MAX_NAMED));
        }
        let window = window.map_or("not stated", Window::name);
        format!("{window}: {}", named.join(", "))
    }
}
