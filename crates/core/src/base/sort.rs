//! Sorting: by small numbers, a counting sort; and with little code in wasm, for lists that are short or sorted rarely.
//!
//! The latter is natively the standard library's sort, which takes 3 kB of wasm for each type. There it is a heap sort (Williams 1964; Floyd
//! 1964), compiled once for all types, and some three times slower.

#[cfg(not(target_arch = "wasm32"))]
use crate::base::parallel::*;

/// Sorts items by numbers below `n`, each in the order that its items come in; `sorted` may be longer before and after. `firsts` gets the first
/// place of each number, then the end.
pub fn by_number<'a, T: Copy + Default>(
    items: impl Iterator<Item = (u32, T)> + Clone,
    n: usize,
    firsts: &mut Vec<u32>,
    sorted: &'a mut Vec<T>,
) -> &'a mut [T] {
    clear_counts(n, firsts);
    items.clone().for_each(|(number, _)| firsts[count_of(number)] += 1);
    by_counts(items, firsts, sorted)
}

/// Begins to count how many items each number below `n` has.
pub fn clear_counts(n: usize, counts: &mut Vec<u32>) {
    counts.clear();
    counts.resize(n + 2, 0);
}

/// Where a number's items are counted.
#[inline(always)]
pub fn count_of(number: u32) -> usize {
    number as usize + 2
}

/// The same as [`by_number`] where `firsts` has counted the items already.
pub fn by_counts<'a, T: Copy + Default>(
    items: impl Iterator<Item = (u32, T)>,
    firsts: &mut Vec<u32>,
    sorted: &'a mut Vec<T>,
) -> &'a mut [T] {
    for at in 2..firsts.len() {
        firsts[at] += firsts[at - 1];
    }
    let n_items = firsts[firsts.len() - 1] as usize;
    sorted.resize(sorted.len().max(n_items), T::default());
    for (number, item) in items {
        let next = &mut firsts[number as usize + 1];
        sorted[*next as usize] = item;
        *next += 1;
    }
    firsts.pop();
    &mut sorted[..n_items]
}

/// Sorts a list; equal elements in any order.
pub fn sort<T: Ord>(list: &mut [T]) {
    sort_by(list, |one, other| one < other);
}

/// Sorts a list by a key; elements of equal keys in any order.
pub fn sort_by_key<T, K: Ord>(list: &mut [T], key: impl Fn(&T) -> K) {
    #[cfg(not(target_arch = "wasm32"))]
    list.sort_unstable_by_key(key);
    #[cfg(target_arch = "wasm32")]
    sort_by(list, |one, other| key(one) < key(other));
}

/// Sorts a list that is nearly in order by a key, which all elements have for themselves.
pub fn sort_nearly_by_key<T, K: Ord>(list: &mut [T], key: impl Fn(&T) -> K) {
    #[cfg(not(target_arch = "wasm32"))]
    list.sort_by_key(key);
    #[cfg(target_arch = "wasm32")]
    sort_by_key(list, key);
}

/// Sorts a list on all cores.
#[cfg(not(target_arch = "wasm32"))]
pub fn par_sort<T: Ord + Send>(list: &mut [T]) {
    list.par_sort_unstable();
}

#[cfg(target_arch = "wasm32")]
pub fn par_sort<T: Ord>(list: &mut [T]) {
    sort(list);
}

/// Sorts a list by what comes before what.
pub fn sort_by<T>(list: &mut [T], is_before: impl Fn(&T, &T) -> bool) {
    #[cfg(not(target_arch = "wasm32"))]
    list.sort_unstable_by(|one, other| is_before(other, one).cmp(&is_before(one, other)));
    #[cfg(target_arch = "wasm32")]
    heap_sort(list.len(), &mut |step| step_of(list, &is_before, step));
}

/// What is done with two places of a list.
#[cfg(any(test, target_arch = "wasm32"))]
#[derive(Clone, Copy)]
enum Step {
    /// Asks whether the first comes before the second.
    Compare(usize, usize),
    Swap(usize, usize),
}

#[cfg(any(test, target_arch = "wasm32"))]
fn step_of<T>(list: &mut [T], is_before: impl Fn(&T, &T) -> bool, step: Step) -> bool {
    match step {
        Step::Compare(one, other) => is_before(&list[one], &list[other]),
        Step::Swap(one, other) => {
            list.swap(one, other);
            true
        }
    }
}

/// Sorts `n` places.
#[cfg(any(test, target_arch = "wasm32"))]
fn heap_sort(n: usize, step: &mut dyn FnMut(Step) -> bool) {
    for root in (0..n / 2).rev() {
        sift(root, n, step);
    }
    for end in (1..n).rev() {
        step(Step::Swap(0, end));
        sift(0, end, step);
    }
}

/// Moves the element of a place down until none below it, up to an end, comes after it.
#[cfg(any(test, target_arch = "wasm32"))]
fn sift(mut root: usize, end: usize, step: &mut dyn FnMut(Step) -> bool) {
    while 2 * root + 1 < end {
        let first = 2 * root + 1;
        let child = if first + 1 < end && step(Step::Compare(first, first + 1)) { first + 1 } else { first };
        if !step(Step::Compare(root, child)) {
            return;
        }
        step(Step::Swap(root, child));
        root = child;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_lists_of_few_and_some_of_many_are_sorted_as_by_the_library() {
        let mut state = 1u32;
        for n in (0..40).chain([1000, 4097]) {
            for _ in 0..20 {
                let mut random = || {
                    state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                    state >> 24
                };
                let list: Vec<u32> = (0..n).map(|_| random()).collect();
                let mut expected = list.clone();
                expected.sort_unstable();
                let mut heaped = list.clone();
                heap_sort(list.len(), &mut |step| step_of(&mut heaped, |one, other| one < other, step));
                assert_eq!(heaped, expected);
                let mut sorted = list.clone();
                sort(&mut sorted);
                assert_eq!(sorted, expected);
                let mut backward = list;
                sort_by_key(&mut backward, |number| u32::MAX - number);
                assert!(backward.iter().rev().eq(&expected));
            }
        }
    }
}
