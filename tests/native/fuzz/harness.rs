//! The harness: a corpus, changed at random, given to a check again and again.
//!
//! Inputs whose result is of a new kind join the corpus of the run: there is no coverage of code to follow, but the message of
//! an error says how far a reader came.

use std::collections::BTreeSet;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use super::mutate::{Random, mutated};

/// Inputs of a run, besides those of the corpus.
const MAX_FOUND: usize = 2000;

/// What is fuzzed.
pub(super) struct Target<'a> {
    /// Its folder in `tests/corpus`, and the name in messages.
    pub(super) name: &'a str,
    /// Files of `tests/fixtures` that belong to the corpus, too.
    pub(super) fixtures: &'a [&'a str],
    /// Words that are inserted.
    pub(super) dictionary: &'a [&'a str],
    /// Most bytes of an input.
    pub(super) max_bytes: usize,
    /// Executions where no time is given.
    pub(super) executions: u64,
}

impl Target<'_> {
    /// The files of the corpus, in the order of their names.
    pub(super) fn corpus(&self) -> Vec<(PathBuf, Vec<u8>)> {
        let tests = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests");
        let folder = tests.join("corpus").join(self.name);
        let entries = std::fs::read_dir(&folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
        let mut paths: Vec<PathBuf> = entries.map(|entry| entry.expect("an entry").path()).collect();
        paths.extend(self.fixtures.iter().map(|name| tests.join("fixtures").join(name)));
        paths.sort();
        assert!(!paths.is_empty(), "{}: no corpus", folder.display());
        paths.into_iter().map(|path| (path.clone(), std::fs::read(path).expect("a file of the corpus"))).collect()
    }

    /// Checks the files of the corpus and then changed ones. `repair` makes a changed input plausible again, such as by new
    /// checksums. `check` panics where a property does not hold, and returns the kind of the result.
    pub(super) fn fuzz(&self, repair: impl Fn(&mut Vec<u8>, &mut Random), check: impl Fn(&[u8]) -> String) {
        let number = |name| std::env::var(name).ok().and_then(|text| text.parse::<u64>().ok());
        let seed = number("HEXCAST_FUZZ_SEED").unwrap_or(1);
        let time = number("HEXCAST_FUZZ_SECONDS").map(Duration::from_secs);
        let mut kinds = BTreeSet::new();
        let run = |input: &[u8], origin: &str| match catch_unwind(AssertUnwindSafe(|| check(input))) {
            Ok(kind) => kind,
            Err(panic) => {
                let file = format!("{}-{}.fuzz", self.name, origin.replace(|c: char| !c.is_alphanumeric(), "-"));
                let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(file);
                std::fs::write(&path, input).expect("the input is written");
                eprintln!("{}: {origin} fails; the input is {}", self.name, path.display());
                resume_unwind(panic)
            }
        };
        let mut pool = Vec::new();
        for (path, bytes) in self.corpus() {
            kinds.insert(run(&bytes, &path.file_name().unwrap_or_default().to_string_lossy()));
            pool.push(bytes);
        }
        let (n_corpus, n_kinds) = (pool.len(), kinds.len());
        let (start, mut n) = (Instant::now(), 0);
        while time.map_or(n < self.executions, |time| start.elapsed() < time) {
            let mut random = Random::new(seed << 40 ^ n);
            let mut input = mutated(&pool, self.dictionary, self.max_bytes, &mut random);
            repair(&mut input, &mut random);
            n += 1;
            if kinds.insert(run(&input, &format!("seed {seed}, execution {n}"))) && pool.len() < n_corpus + MAX_FOUND {
                pool.push(input);
            }
        }
        println!(
            "fuzz {}: {n_corpus} files of {n_kinds} kinds, {n} executions in {:.1} s, {} kinds",
            self.name,
            start.elapsed().as_secs_f64(),
            kinds.len()
        );
    }
}
