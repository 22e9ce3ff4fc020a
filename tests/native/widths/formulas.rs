//! Boolean functions of many variables as reduced, ordered decision diagrams (Bryant 1986): equal functions are equal numbers.

use std::collections::HashMap;

/// A function: 0 is false, 1 is true, others are nodes.
pub(super) type Formula = u32;

pub(super) const FALSE: Formula = 0;
pub(super) const TRUE: Formula = 1;

/// All functions that were made.
#[derive(Default)]
pub(super) struct Formulas {
    /// Variable, the function where it is false, and where it is true; of node 2 on.
    nodes: Vec<[u32; 3]>,
    node_of: HashMap<[u32; 3], Formula>,
    chosen: HashMap<[Formula; 3], Formula>,
}

impl Formulas {
    pub(super) fn variable(&mut self, variable: u32) -> Formula {
        self.node(variable, FALSE, TRUE)
    }

    fn node(&mut self, variable: u32, no: Formula, yes: Formula) -> Formula {
        if no == yes {
            return no;
        }
        let nodes = &mut self.nodes;
        *self.node_of.entry([variable, no, yes]).or_insert_with(|| {
            nodes.push([variable, no, yes]);
            nodes.len() as u32 + 1
        })
    }

    fn first_variable(&self, formula: Formula) -> u32 {
        if formula <= TRUE { u32::MAX } else { self.nodes[formula as usize - 2][0] }
    }

    /// The function where a variable, none before its first, has a value.
    fn with(&self, formula: Formula, variable: u32, value: bool) -> Formula {
        if self.first_variable(formula) != variable {
            return formula;
        }
        self.nodes[formula as usize - 2][1 + usize::from(value)]
    }

    /// `yes` where a function is true, `no` elsewhere.
    pub(super) fn choose(&mut self, of: Formula, yes: Formula, no: Formula) -> Formula {
        match (of, yes, no) {
            (TRUE, ..) => return yes,
            (FALSE, ..) => return no,
            (_, TRUE, FALSE) => return of,
            _ if yes == no => return yes,
            _ => {}
        }
        if let Some(&known) = self.chosen.get(&[of, yes, no]) {
            return known;
        }
        let variable = [of, yes, no].map(|formula| self.first_variable(formula)).into_iter().min().expect("three");
        let [low, high] = [false, true].map(|value| {
            let [of, yes, no] = [of, yes, no].map(|formula| self.with(formula, variable, value));
            self.choose(of, yes, no)
        });
        let found = self.node(variable, low, high);
        self.chosen.insert([of, yes, no], found);
        found
    }

    pub(super) fn not(&mut self, a: Formula) -> Formula {
        self.choose(a, FALSE, TRUE)
    }

    pub(super) fn and(&mut self, a: Formula, b: Formula) -> Formula {
        self.choose(a, b, FALSE)
    }

    pub(super) fn or(&mut self, a: Formula, b: Formula) -> Formula {
        self.choose(a, TRUE, b)
    }

    pub(super) fn xor(&mut self, a: Formula, b: Formula) -> Formula {
        let not_b = self.not(b);
        self.choose(a, not_b, b)
    }
}
